# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that rest on each other touch with enough points, whose features do not change."""

from __future__ import annotations

import subprocess
from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from native.conftest import BUILD
from native.contact_pairs import numbers

Contact = tuple[list[float], list[float], float, int]
E3 = np.eye(3)


def turned(*vector: float) -> Array:
    return np.asarray(Rotation.from_rotvec(vector).as_matrix())


def contacts(units: Any, A: Any, B: Any, p: Any, R: Array = E3, margin: float = 1e-3) -> list[Contact]:
    """With A at the origin and B at p, turned by R."""
    return list(units.contacts(A, numbers(E3, np.zeros(3)), B, numbers(R, np.array(p, float)), margin))


def area(found: list[Contact]) -> float:
    """Of the polygon of contact points, seen from above."""
    return float(ConvexHull(np.array([c[0][:2] for c in found])).volume)


def test_a_box_on_a_plane_touches_with_the_corners_below(units: Any) -> None:
    plane, box = units.Shape("plane"), units.Shape("box", [0.4, 0.6, 0.2])
    found = contacts(units, plane, box, [1, 2, 0.1])
    assert [c[3] for c in found] == [0, 1, 2, 3]
    assert [c[2] for c in found] == pytest.approx([0] * 4, abs=1e-16)
    assert all(c[1] == [0, 0, 1] for c in found)
    assert sorted(c[0][:2] for c in found) == pytest.approx(
        np.array([[0.8, 1.7], [0.8, 2.3], [1.2, 1.7], [1.2, 2.3]]), abs=1e-15
    )


def test_corners_leave_one_by_one_as_a_box_tilts(units: Any) -> None:
    plane, box = units.Shape("plane"), units.Shape("box", [0.4, 0.6, 0.2])
    counts = []
    for tilt in (0.0, 1e-3, 2e-3, 1e-2):
        R = turned(tilt, -0.4 * tilt, 0)
        lowest = min(
            (R @ corner)[2] for corner in np.array([[x, y, -0.1] for x in (-0.2, 0.2) for y in (-0.3, 0.3)])
        )
        found = contacts(units, plane, box, [0, 0, -lowest], R, margin=7e-4)
        assert min(c[2] for c in found) == pytest.approx(0, abs=1e-15)
        counts.append(len(found))
    assert counts == [4, 3, 2, 1]


def test_a_thin_plate_rests_on_its_lower_corners(units: Any) -> None:
    """Thinner than the margin: all eight corners are near, the four lower ones support it."""
    plate = units.Shape("box", [1, 1, 1e-4])
    assert [c[3] for c in contacts(units, units.Shape("plane"), plate, [0, 0, 5e-5])] == [0, 1, 2, 3]


def test_a_cylinder_on_a_plane_has_four_points_or_two(units: Any) -> None:
    plane, cylinder = units.Shape("plane"), units.Shape("cylinder", [0.2, 0.5])
    upright = contacts(units, plane, cylinder, [0, 0, 0.25])
    assert len(upright) == 4
    assert area(upright) == pytest.approx(2 * 0.2**2, rel=1e-12)
    lying = contacts(units, plane, cylinder, [0, 0, 0.2], turned(np.pi / 2, 0, 0))
    assert [c[0][1] for c in lying] == pytest.approx([0.25, -0.25])
    rolled = contacts(units, plane, cylinder, [0, 0, 0.2], turned(0, 1.0, 0) @ turned(np.pi / 2, 0, 0))
    assert [c[3] for c in rolled] == [c[3] for c in lying]


def test_the_smallest_gap_of_a_cylinder_is_continuous_in_its_tilt(units: Any) -> None:
    """On either side of the tilts at which features change: 1e-8 and 0.3 (sines)."""
    plane, cylinder = units.Shape("plane"), units.Shape("cylinder", [0.2, 0.5])
    for tilt in (0.0, 0.99e-8, 1.01e-8, 1e-4, np.arcsin(0.3) - 1e-9, np.arcsin(0.3) + 1e-9, 1.0, np.pi / 2):
        for turn in (0.0, 0.3, np.pi / 4):
            R = turned(0, tilt, 0) @ turned(0, 0, turn)
            found = contacts(units, plane, cylinder, [0, 0, 1], R, margin=1e9)
            exact = 1 - 0.25 * np.cos(tilt) - 0.2 * np.sin(tilt)
            # Of a flat cap, fixed points are up to 45 degrees from the lowest one.
            assert min(c[2] for c in found) == pytest.approx(
                exact, abs=0.2 * 0.3e-8 if tilt < 1e-8 else 1e-15
            )


BASE = ("box", [1.0, 1.0, 0.2])
HULL_BASE = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.1, 0.1)]


def base(units: Any, kind: str) -> Any:
    if kind == "hull":
        return units.Shape("hull", [], HULL_BASE)
    return units.Shape("cylinder", [1.0, 0.2]) if kind == "cylinder" else units.Shape(*BASE)


PRISM = [[0.2 * np.cos(t), 0.2 * np.sin(t), z] for t in 2 * np.pi * np.arange(6) / 6 for z in (-0.1, 0.1)]


@pytest.mark.parametrize("tilt", [0.0, 1e-12, 1e-7])
@pytest.mark.parametrize("turn", [0.0, 1e-9, 0.4])
@pytest.mark.parametrize("below", ["box", "hull", "cylinder"])
@pytest.mark.parametrize(
    ("kind", "dimensions", "points", "least"),
    [
        ("box", [0.3, 0.4, 0.2], [], 0.12),
        # The lowest point of the rim replaces the nearest one of the square, up to 45 degrees away.
        ("cylinder", [0.2, 0.2], [], 1.7 * 0.2**2),
        ("hull", [], PRISM, 0.05),
    ],
)
def test_a_body_on_a_flat_one_is_supported_around_its_middle(
    units: Any,
    below: str,
    kind: str,
    dimensions: list[float],
    points: Any,
    least: float,
    turn: float,
    tilt: float,
) -> None:
    """The polygon of contact points spans the supported part, also of a body that overhangs by half."""
    B = units.Shape(kind, dimensions, points)
    R = turned(tilt, -0.5 * tilt, 0) @ turned(0, 0, turn)
    inside = contacts(units, base(units, below), B, [0.1, 0.05, 0.2], R)
    assert len(inside) == 4
    assert area(inside) >= least * (1 - 1e-6)
    assert all(c[1][2] > 1 - 1e-6 and abs(c[2]) < 1e-6 for c in inside)
    if below != "cylinder":
        overhanging = contacts(units, base(units, below), B, [0.5, 0.05, 0.2], R)
        assert area(overhanging) >= 0.45 * least
        assert all(c[0][0] <= 0.5 + 1e-5 for c in overhanging)


@pytest.mark.parametrize("noise", [0.0, 1e-15, 1e-10, 1e-8])
def test_features_of_a_stack_of_equal_boxes_do_not_depend_on_rounding_errors(
    units: Any, noise: float
) -> None:
    box = units.Shape(*BASE)
    rng = np.random.default_rng(1)
    expected = [c[3] for c in contacts(units, box, box, [0, 0, 0.2])]
    assert len(expected) == 4
    for _ in range(20):
        p = np.array([0, 0, 0.2]) + noise * rng.normal(size=3)
        found = contacts(units, box, box, p, turned(*(noise * rng.normal(size=3))))
        assert [c[3] for c in found] == expected


def test_bricks_overlapping_by_half_touch_at_the_corners_of_the_overlap(units: Any) -> None:
    brick = units.Shape("box", [0.2, 0.1, 0.05])
    found = contacts(units, brick, brick, [0.1, 0, 0.05])
    assert sorted(np.round(c[0][:2], 12).tolist() for c in found) == [
        [0, -0.05],
        [0, 0.05],
        [0.1, -0.05],
        [0.1, 0.05],
    ]


@pytest.mark.parametrize("below", ["box", "hull", "cylinder"])
def test_lying_capsules_and_cylinders_touch_at_both_ends(units: Any, below: str) -> None:
    for kind in ("capsule", "cylinder"):
        found = contacts(
            units, base(units, below), units.Shape(kind, [0.1, 0.6]), [0, 0, 0.2], turned(0, np.pi / 2, 0)
        )
        assert len(found) == 2
        assert sorted(c[0][0] for c in found) == pytest.approx([-0.3, 0.3], abs=1e-7)


@pytest.mark.parametrize("kind", ["capsule", "cylinder"])
def test_parallel_round_bodies_touch_at_the_ends_of_their_overlap(units: Any, kind: str) -> None:
    A, B = units.Shape(kind, [0.1, 0.6]), units.Shape(kind, [0.1, 0.6])
    for shift, ends in [(0.0, [-0.3, 0.3]), (0.2, [-0.1, 0.3])]:
        found = contacts(units, A, B, [0.2, 0, shift])
        assert sorted(c[0][2] for c in found) == pytest.approx(ends, abs=1e-9)
        assert [c[2] for c in found] == pytest.approx([0, 0], abs=1e-15)
    assert len(contacts(units, A, B, [0.2, 0, 0], turned(0.5, 0, 0))) == 1


def test_two_half_spaces_have_no_points(units: Any) -> None:
    plane = units.Shape("plane")
    assert contacts(units, plane, plane, [0, 0, 1]) == []


def test_nothing_is_allocated(units: Any) -> None:
    assert units is not None  # builds the program
    done = subprocess.run([BUILD / "no_allocation"], capture_output=True, text=True, check=True)
    allocations, points = map(int, done.stdout.split())
    assert allocations == 0
    assert points > 1000
