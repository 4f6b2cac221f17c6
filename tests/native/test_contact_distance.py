# SPDX-License-Identifier: BSD-3-Clause
"""Smallest gaps against coal, another collision library, and the definition of the signed distance."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pytest
from mechanisms import Array
from scipy.spatial import ConvexHull

from native.contact_pairs import (
    PAIRS,
    SHAPES,
    made,
    random_poses,
    separation,
    special_poses,
    support_function,
)

POSES = 2000  # of each kind for each of 27 pairs: 1e5 in all
# coal iterates on some pairs and ends at about 4e-11; in closed form it is exact to 1e-15.
COAL = 1e-9
NO_ANSWER = -1e300


def convex(points: Array) -> Any:
    vertices, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for x in points:
        vertices.append(x)
    hull = ConvexHull(points)
    for (a, b, c), plane in zip(hull.simplices.tolist(), hull.equations, strict=True):
        outward = np.cross(points[b] - points[a], points[c] - points[a]) @ plane[:3] > 0
        triangles.append(coal.Triangle(a, b, c) if outward else coal.Triangle(a, c, b))
    return coal.Convex(vertices, triangles)


def coal_shape(name: str) -> Any:
    kind, dimensions, points = SHAPES[name]
    if kind == "plane":
        return coal.Halfspace(0, 0, 1.0, 0)
    if kind == "hull":
        return convex(points)
    return {"sphere": coal.Sphere, "capsule": coal.Capsule, "box": coal.Box, "cylinder": coal.Cylinder}[kind](
        *dimensions
    )


def coal_distances(a: str, b: str, poses: Array) -> Array:
    """Distances; negative: depths of penetration."""
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-12
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    A, B = coal_shape(a), coal_shape(b)
    out = []
    for row in poses:
        X_A = coal.Transform3s(row[:9].reshape(3, 3), row[9:12])
        X_B = coal.Transform3s(row[12:21].reshape(3, 3), row[21:])
        out.append(coal.distance(A, X_A, B, X_B, request, coal.DistanceResult()))
    return np.array(out)


def gaps(units: Any, a: str, b: str, poses: Array) -> Array:
    return np.array(units.gaps(made(units, a), made(units, b), poses, 1e9))


@pytest.mark.parametrize("poses", [random_poses, special_poses])
@pytest.mark.parametrize(("a", "b"), [pair for pair in PAIRS if "cylinder" not in pair])
def test_distances_and_depths_are_those_of_coal(units: Any, a: str, b: str, poses: Any) -> None:
    rows = poses(np.random.default_rng(1), POSES)
    found, expected = gaps(units, a, b, rows), coal_distances(a, b, rows)
    assert (expected < 0).sum() > 50
    assert (expected > 0).sum() > 50
    known = expected > NO_ANSWER
    assert known.mean() > 0.99
    assert found[known] == pytest.approx(expected[known], abs=COAL)


@pytest.mark.parametrize("poses", [random_poses, special_poses])
@pytest.mark.parametrize(("a", "b"), [pair for pair in PAIRS if "cylinder" in pair])
def test_cylinders_agree_with_coal_where_it_is_right(units: Any, a: str, b: str, poses: Any) -> None:
    """In a few cases of a hundred coal finds another depth, up to centimeters away, or none.

    It replaces curved surfaces by facets. The next test shows who is right.
    """
    rows = poses(np.random.default_rng(2), POSES)
    found, expected = gaps(units, a, b, rows), coal_distances(a, b, rows)
    known = expected > NO_ANSWER
    apart = (found > 1e-6) & known
    assert known.mean() > 0.8
    assert apart.sum() > 100
    near = np.abs(found - expected) <= 1e-5
    assert near[apart].mean() > 0.99
    assert near.mean() > 0.75
    if "plane" in (a, b):
        assert found == pytest.approx(expected, abs=COAL)


def local_maximum(s: Any, n: Array) -> float:
    """Climbs from a direction by steps in a shrinking pattern."""
    best, size = float(s(n)), 0.02
    angle = np.arange(16) * np.pi / 8
    for _ in range(60):
        u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
        u /= np.linalg.norm(u)
        around = n + size * (np.outer(np.cos(angle), u) + np.outer(np.sin(angle), np.cross(n, u)))
        around /= np.linalg.norm(around, axis=1)[:, None]
        values = s(around)
        if values.max() > best:
            best, n = float(values.max()), around[values.argmax()]
        else:
            size /= 3
    return best


@pytest.mark.parametrize("poses", [random_poses, special_poses])
@pytest.mark.parametrize(("a", "b"), [pair for pair in PAIRS if "plane" not in pair])
def test_no_direction_separates_the_bodies_farther(units: Any, a: str, b: str, poses: Any) -> None:
    """The signed distance is the largest separation along any direction: of thousands, and around the best.

    The normal of the smallest gap attains it: along it, support functions show the same separation.
    """
    rng = np.random.default_rng(3)
    A, B = made(units, a), made(units, b)
    directions = rng.normal(size=(1000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for row in poses(rng, 25):
        s = separation(support_function(a), support_function(b), row)
        contacts = units.contacts(A, row[:12].tolist(), B, row[12:].tolist(), 1e9)
        _, n, gap, _ = min(contacts, key=lambda c: c[2])
        assert s(np.array(n)) == pytest.approx(gap, abs=1e-12)
        values = s(directions)
        best = max(local_maximum(s, directions[k]) for k in np.argsort(values)[-3:])
        assert best <= gap + 1e-12
