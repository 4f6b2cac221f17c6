# SPDX-License-Identifier: BSD-3-Clause
"""Convex hulls against Qhull, and of sets with many points on flat sides, edges and corners."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], float)


def hull(units: Any, points: Array) -> tuple[Array, list[list[int]], list[tuple[int, int]]]:
    vertices, faces, edges = units.hull(np.asarray(points, float).tolist())
    assert len(vertices) - len(edges) + len(faces) == 2
    return np.array(vertices), faces, edges


def height(vertices: Array, face: list[int], points: Array) -> Array:
    """Above the plane of a face, whose vertices are counterclockwise as seen from outside."""
    a, b, c = vertices[face[:3]]
    n = np.cross(b - a, c - a)
    heights: Array = (points - a) @ n / np.linalg.norm(n)
    return heights


@pytest.mark.parametrize("n", [4, 5, 10, 100, 1000])
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kind", ["ball", "sphere", "cube", "needle", "plate"])
def test_random_sets_have_the_hull_that_qhull_finds(units: Any, n: int, seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3))
    if kind == "sphere":
        points /= np.linalg.norm(points, axis=1)[:, None]
    if kind == "cube":
        points = rng.uniform(size=(n, 3))
    if kind == "needle":
        points *= [1, 1e-3, 1e-3]
    if kind == "plate":
        points *= [1, 1, 1e-3]
    points = points @ Rotation.random(random_state=rng).as_matrix() + rng.normal(size=3)
    vertices, faces, _ = hull(units, points)
    other = ConvexHull(points)
    # Points closer than 1e-7 of the extent to a face may be left out.
    extent = np.ptp(points, axis=0).max()
    assert units.Shape("hull", [], points.tolist()).mass()[0] == pytest.approx(
        other.volume, rel=1e-12, abs=2e-7 * extent * other.area
    )
    for face in faces:
        assert height(vertices, face, points).max() <= 1e-6 * extent
    if kind in ("ball", "sphere", "cube"):
        assert (vertices == points[np.sort(other.vertices)]).all()
        assert sum(len(face) - 2 for face in faces) == len(other.simplices)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("per_side", [0, 1, 30, 170])
def test_a_cube_has_six_faces_no_matter_how_many_points_are_on_them(
    units: Any, scale: float, turned: bool, single: bool, per_side: int
) -> None:
    """Points on the faces, edges and again at the corners; single: rounded as in a file of 32-bit numbers."""
    rng = np.random.default_rng(per_side)
    points = [*CORNERS]
    for axis in range(3):
        for side in (0, 1):
            on = rng.uniform(size=(per_side, 3)) if per_side != 30 else rng.integers(0, 5, (30, 3)) / 4
            on[:, axis] = side
            points += [*on]
    every = np.array(points)
    every = np.concatenate([rng.permutation(every), every[:9]])
    R = Rotation.random(random_state=rng).as_matrix() if turned else np.eye(3)
    every = scale * every @ R.T
    if single:
        every = every.astype(np.float32).astype(float)
    vertices, faces, edges = hull(units, every)
    assert len(vertices) == 8
    assert len(edges) == 12
    assert [len(face) for face in faces] == [4] * 6
    found = np.sort(np.round(vertices / scale @ R, 6), axis=0)
    assert found == pytest.approx(np.sort(CORNERS, axis=0), abs=1e-5)


def test_prisms_and_pyramids_have_their_faces(units: Any) -> None:
    for n in (3, 5, 12, 100):
        angle = 2 * np.pi * np.arange(n) / n
        ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        vertices, faces, edges = hull(units, np.concatenate([ring, ring + np.array([0, 0, 2])]))
        assert sorted(map(len, faces)) == sorted([n, n] + [4] * n)
        assert (len(vertices), len(edges)) == (2 * n, 3 * n)
        vertices, faces, edges = hull(units, np.concatenate([ring, [[0.1, 0.2, 3]]]))
        assert sorted(map(len, faces)) == sorted([n] + [3] * n)


def test_the_vertices_keep_their_order_and_copies_of_them_are_left_out(units: Any) -> None:
    vertices, _, _ = hull(units, np.concatenate([CORNERS[::-1], CORNERS, [[0.5, 0.5, 0.5]]]))
    assert (vertices == CORNERS[::-1]).all()


def test_every_edge_has_two_faces_in_opposite_directions(units: Any) -> None:
    rng = np.random.default_rng(5)
    _, faces, edges = hull(units, rng.normal(size=(60, 3)))
    sides = [(a, b) for face in faces for a, b in zip(face, [*face[1:], face[0]], strict=True)]
    assert sorted(sides) == sorted([*edges, *[(b, a) for a, b in edges]])


@pytest.mark.parametrize(
    ("points", "what"),
    [
        (CORNERS[:3], "needs 4 points or more that are not in one plane, found 3"),
        (CORNERS[:4], "the 4 points of the hull are in one plane or nearly so"),
        (np.zeros((9, 3)), "in one plane"),
        (np.outer(np.arange(9), [1, 2, 3]), "in one plane"),
        ([*CORNERS[:7], [0, np.nan, 0]], "point 8 of the hull is not finite"),
        (CORNERS * [1, 1, 1e-8], "in one plane or nearly so .extent 1.41 m"),
    ],
)
def test_sets_without_volume_are_refused(units: Any, points: Array, what: str) -> None:
    with pytest.raises(ValueError, match=what):
        hull(units, np.asarray(points))


def test_a_plate_well_above_the_tolerance_is_a_solid(units: Any) -> None:
    assert len(hull(units, CORNERS * [1, 1, 1e-5])[1]) == 6
