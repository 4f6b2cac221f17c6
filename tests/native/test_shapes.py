# SPDX-License-Identifier: BSD-3-Clause
"""Shapes: masses against closed forms and integrals, supports and bounds against each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from mechanisms import Array
from scipy.spatial.transform import Rotation

PI = np.pi
# A few products and sums of rounded numbers.
ROUNDING = 1e-15
TETRAHEDRON: list[list[float]] = [[0, 0, 0], [0.3, 0.1, 0], [-0.1, 0.4, 0.05], [0.1, 0.1, 0.5]]
BOUNDED: list[tuple[str, list[float], list[list[float]]]] = [
    ("sphere", [0.3], []),
    ("capsule", [0.2, 0.5], []),
    ("box", [0.2, 0.3, 0.6], []),
    ("cylinder", [0.2, 0.7], []),
    ("wheel", [0.3, 0.1], []),
    ("wheel", [0.3, 0.0], []),
    ("hull", [], TETRAHEDRON),
]


def pose(rng: np.random.Generator) -> tuple[Array, Array, list[float]]:
    R = Rotation.random(random_state=rng).as_matrix()
    p = rng.normal(size=3)
    return R, p, [*R.ravel().tolist(), *p.tolist()]


def test_kinds_are_listed_with_their_fields(units: Any) -> None:
    kinds = {name: (bounded, of_points, fields) for name, bounded, of_points, fields in units.shape_kinds()}
    assert set(kinds) == {"sphere", "capsule", "box", "cylinder", "plane", "hull", "mesh", "wheel"}
    assert [name for name, (bounded, _, _) in kinds.items() if not bounded] == ["plane"]
    assert [name for name, (_, of_points, _) in kinds.items() if of_points] == ["hull", "mesh"]
    assert kinds["capsule"][2] == [("radius", "m"), ("length", "m")]
    assert kinds["box"][2] == [("size", "m")]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(
    ("kind", "dimensions", "volume", "moments"),
    [
        ("sphere", [0.3], 0.036 * PI, [0.036 * 0.036 * PI] * 3),
        ("box", [0.2, 0.3, 0.6], 0.036, [0.003 * 0.45, 0.003 * 0.4, 0.003 * 0.13]),
        ("cylinder", [0.2, 0.6], 0.024 * PI, [0.024 * PI * 0.04, 0.024 * PI * 0.04, 0.024 * PI * 0.02]),
        # Tube 0.024 pi and ball 0.032 pi / 3, moments by Steiner's theorem with hemispheres, whose moments
        # about a diameter of their plane are 2/5 m r^2 and whose centers of mass are 3/8 r from it.
        (
            "capsule",
            [0.2, 0.6],
            0.024 * PI + 0.032 * PI / 3,
            [0.024 * PI * 0.04 + 0.032 * PI / 3 * (0.016 + 0.09 + 0.045)] * 2
            + [0.024 * PI * 0.02 + 0.032 * PI / 3 * 0.016],
        ),
    ],
)
def test_masses_are_the_closed_forms(
    units: Any, scale: float, kind: str, dimensions: list[float], volume: float, moments: list[float]
) -> None:
    V, center, inertia = units.Shape(kind, [scale * x for x in dimensions]).mass()
    assert scale**-3 * V == pytest.approx(volume, rel=ROUNDING)
    assert center == [0, 0, 0]
    assert np.diag(inertia) * scale**-5 == pytest.approx(moments, rel=ROUNDING)
    assert (np.array(inertia) == np.diag(np.diag(inertia))).all()


def test_a_half_space_has_no_mass_and_no_farthest_point(units: Any) -> None:
    plane = units.Shape("plane")
    assert plane.mass() is None
    assert plane.support([0, 0, 1]) is None
    assert plane.size() == np.inf


@pytest.mark.parametrize(
    ("kind", "dimensions", "radius"),
    [("sphere", [0.3], 0.3), ("capsule", [0.2, 0.5], 0.2), ("cylinder", [0.2, 0.7], 0.2)],
)
def test_masses_of_round_shapes_are_sums_over_disks(
    units: Any, kind: str, dimensions: list[float], radius: float
) -> None:
    """Gauss's quadrature of pi rho^2, pi rho^4 / 2 and pi (rho^4 / 4 + rho^2 z^2), exact for polynomials."""
    half = dimensions[1] / 2 if len(dimensions) > 1 else 0.0
    x, w = np.polynomial.legendre.leggauss(6)
    pieces = [(half * x, half * w, np.full(6, radius))]
    if kind != "cylinder":
        z = radius * (x + 1) / 2
        rho = np.sqrt(radius**2 - z**2)
        pieces += [(half + z, radius * w / 2, rho), (-half - z, radius * w / 2, rho)]
    V = sum((w * PI * rho**2).sum() for _, w, rho in pieces)
    along = sum((w * PI * rho**4 / 2).sum() for _, w, rho in pieces)
    across = sum((w * PI * (rho**4 / 4 + rho**2 * z**2)).sum() for z, w, rho in pieces)
    found, _, inertia = units.Shape(kind, dimensions).mass()
    assert found == pytest.approx(V, rel=10 * ROUNDING)
    assert np.diag(inertia) == pytest.approx([across, across, along], rel=10 * ROUNDING)


def test_masses_of_a_wheel_are_sums_over_disks(units: Any) -> None:
    """At the height z = c sin b the radius is R + c cos b; Gauss's quadrature over b, to rounding."""
    radius, crown = 0.3, 0.1
    x, weights = np.polynomial.legendre.leggauss(40)
    b = np.pi / 2 * x
    dz = np.pi / 2 * weights * crown * np.cos(b)
    z, rho = crown * np.sin(b), radius - crown + crown * np.cos(b)
    V = (dz * PI * rho**2).sum()
    along = (dz * PI * rho**4 / 2).sum()
    across = (dz * PI * (rho**4 / 4 + rho**2 * z**2)).sum()
    found, center, inertia = units.Shape("wheel", [radius, crown]).mass()
    assert found == pytest.approx(V, rel=10 * ROUNDING)
    assert center == [0, 0, 0]
    assert np.diag(inertia) == pytest.approx([across, across, along], rel=10 * ROUNDING)


def test_a_wheel_whose_crown_is_its_radius_is_a_ball(units: Any) -> None:
    ball, wheel = units.Shape("sphere", [0.3]), units.Shape("wheel", [0.3, 0.3])
    assert wheel.mass()[0] == pytest.approx(ball.mass()[0], rel=ROUNDING)
    assert np.diag(wheel.mass()[2]) == pytest.approx(np.diag(ball.mass()[2]), rel=2 * ROUNDING)
    assert wheel.support([1, 2, -3]) == pytest.approx(ball.support([1, 2, -3]), rel=2 * ROUNDING)


def test_a_hull_has_the_mass_of_the_box_that_it_is(units: Any) -> None:
    """Also far from the origin, where products of coordinates are 1e8 times the moments."""
    size = np.array([0.25, 0.375, 0.75])
    corners = size * np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) / 2
    V, _, inertia = units.Shape("box", size.tolist()).mass()
    for offset, rounding in [([0.0, 0, 0], 4e-15), ([1024.0, -2048, 512], 4e-15)]:
        found, center, J = units.Shape("hull", [], (corners + offset).tolist()).mass()
        assert found == pytest.approx(V, rel=rounding)
        assert center == pytest.approx(offset, abs=1e-15 + 1e-15 * np.abs(offset).max())
        assert np.array(J) == pytest.approx(np.array(inertia), rel=rounding, abs=rounding * inertia[0][0])


@pytest.mark.parametrize(("kind", "dimensions", "points"), BOUNDED)
def test_bounds_touch_the_farthest_points(
    units: Any, kind: str, dimensions: list[float], points: list[list[float]]
) -> None:
    shape = units.Shape(kind, dimensions, points)
    rng = np.random.default_rng(1)
    for _ in range(20):
        R, p, X = pose(rng)
        lower, upper = shape.bounds(X)
        for i, axis in enumerate(np.eye(3)):
            assert upper[i] == pytest.approx((p + R @ shape.support((R.T @ axis).tolist()))[i], abs=2e-15)
            assert lower[i] == pytest.approx((p + R @ shape.support((-R.T @ axis).tolist()))[i], abs=2e-15)


@pytest.mark.parametrize(("kind", "dimensions", "points"), BOUNDED)
def test_no_point_is_farther_than_the_farthest(
    units: Any, kind: str, dimensions: list[float], points: list[list[float]]
) -> None:
    """Points of the surface are farthest in some direction; none of them is beyond that of another one."""
    shape = units.Shape(kind, dimensions, points)
    rng = np.random.default_rng(2)
    directions = [*rng.normal(size=(40, 3)), *np.eye(3), *-np.eye(3)]
    surface = np.array([shape.support(list(d)) for d in directions])
    for d, x in zip(directions, surface, strict=True):
        assert (surface @ d <= x @ d + 1e-15 * np.linalg.norm(d)).all()
    distances = np.linalg.norm(surface[:, None] - surface, axis=2)
    assert distances.max() <= shape.size() * (1 + ROUNDING)
    assert np.isfinite(shape.support([0, 0, 0])).all()


def test_a_half_space_ends_at_a_surface_along_an_axis(units: Any) -> None:
    inf = np.inf
    plane = units.Shape("plane")
    assert plane.bounds([1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 6, 7]) == ([-inf] * 3, [inf, inf, 7])
    assert plane.bounds([0, 0, -1, 0, 1, 0, 1, 0, 0, 5, 6, 7]) == ([5, -inf, -inf], [inf] * 3)
    X = pose(np.random.default_rng(3))[2]
    assert plane.bounds(X) == ([-inf] * 3, [inf] * 3)


def test_masses_of_meshes_agree_with_trimesh(units: Any) -> None:
    """A torus: not convex, with a hole. trimesh integrates over the same triangles by other formulas."""
    mesh = trimesh.creation.torus(0.5, 0.1, 24, 12)
    V, center, inertia = units.mesh_mass(mesh.vertices.tolist(), mesh.faces.tolist())
    assert pytest.approx(mesh.volume, rel=1e-14) == V
    assert center == pytest.approx([0, 0, 0], abs=1e-15)
    assert np.array(inertia) == pytest.approx(mesh.moment_inertia, rel=1e-13, abs=1e-15 * inertia[2][2])


def test_a_tetrahedron_has_the_moments_of_its_closed_form(units: Any) -> None:
    """Of the unit corner: V = 1/6, center at 1/4, products of inertia 1/480, moments 1/40 (unit density)."""
    points = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    V, center, inertia = units.mesh_mass(points, faces)
    assert pytest.approx(1 / 6, rel=ROUNDING) == V
    assert center == pytest.approx([0.25] * 3, rel=ROUNDING)
    expected = np.full((3, 3), 1 / 480) + np.diag([1 / 80 - 1 / 480] * 3)
    assert np.array(inertia) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("faces", "what"),
    [
        (
            [[0, 2, 1], [0, 1, 3], [0, 3, 2]],
            "not closed: the edge between vertices 1 and 3, from .1, 0, 0. to .0, 0, 1., belongs",
        ),
        ([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 3, 2]], "not oriented consistently"),
        ([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], "oriented inward .volume -0.166667 m3."),
        ([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4]], "refers to vertex 4, but there are 4"),
        ([[0, 1, 1]], "vertex 1 appears twice"),
        ([], "no triangles"),
        ([[0, 1, 2], [0, 2, 1]], "no volume"),
    ],
)
def test_faulty_meshes_are_refused(units: Any, faces: list[list[int]], what: str) -> None:
    points = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    with pytest.raises(ValueError, match=what):
        units.mesh_mass(points, faces)
