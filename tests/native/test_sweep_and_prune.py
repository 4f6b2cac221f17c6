# SPDX-License-Identifier: BSD-3-Clause
"""The broad phase against all pairs, and the growth of its cost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array

Pairs = list[tuple[int, int]]


def every_pair(boxes: Array) -> Pairs:
    lower, upper = boxes[:, None, :3], boxes[None, :, 3:]
    meets = (lower <= upper).all(axis=2)
    return [(int(i), int(j)) for i, j in np.argwhere(np.triu(meets & meets.T, 1))]


def spheres(rng: np.random.Generator, n: int, sizes: str = "equal") -> Array:
    """Boxes of n balls with one ball per unit of volume."""
    r = np.full(n, 0.5)
    if sizes == "decade":
        r *= 10 ** -rng.uniform(size=n)
    if sizes == "many decades":
        r = 0.25 * rng.uniform(1e-9, 1, size=n) ** (-1 / 3)
    center = rng.uniform(0, np.cbrt(n), (n, 3))
    return np.hstack([center - r[:, None], center + r[:, None]])


@pytest.mark.parametrize("sizes", ["equal", "decade", "many decades"])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("n", [0, 1, 2, 3, 17, 700])
def test_all_overlapping_pairs_are_found_in_order(units: Any, n: int, scale: float, sizes: str) -> None:
    boxes = scale * spheres(np.random.default_rng(n), n, sizes)
    assert units.SweepAndPrune().pairs(boxes) == every_pair(boxes)


def test_half_spaces_meet_all_that_is_below_their_surface(units: Any) -> None:
    boxes = spheres(np.random.default_rng(1), 500)
    inf = np.inf
    floor = [[-inf, -inf, -inf, inf, inf, 1.0], [-inf] * 3 + [inf] * 3]
    boxes = np.vstack([boxes[:250], floor[:1], boxes[250:], floor[1:]])
    search = units.SweepAndPrune()
    assert search.pairs(boxes) == every_pair(boxes)
    assert search.comparisons() < 40 * len(boxes)


def test_one_huge_and_one_distant_body_cost_one_comparison_with_each_other_one(units: Any) -> None:
    boxes = spheres(np.random.default_rng(2), 2000)
    alone = units.SweepAndPrune()
    alone.pairs(boxes)
    both = np.vstack([boxes, [[-1e9] * 3 + [1e9] * 3, [1e12] * 3 + [1e12 + 1] * 3]])
    search = units.SweepAndPrune()
    assert search.pairs(both) == every_pair(both)
    assert search.comparisons() <= 1.2 * alone.comparisons() + len(both)


def test_bodies_that_touch_and_bodies_in_the_same_place_overlap(units: Any) -> None:
    cube = [0.0, 0, 0, 1, 1, 1]
    shifts: list[tuple[list[float], bool]] = [
        ([1, 0, 0], True),
        ([1, 1, 1], True),
        ([0, 0, 0], True),
        ([1 + 1e-15, 0, 0], False),
    ]
    for shift, expected in shifts:
        boxes = np.array([cube, np.add(cube, np.tile(shift, 2))])
        assert (len(units.SweepAndPrune().pairs(boxes)) == 1) == expected
    points = np.zeros((5, 6))
    assert len(units.SweepAndPrune().pairs(points)) == 10


def test_a_box_that_is_not_a_number_meets_nothing(units: Any) -> None:
    boxes = spheres(np.random.default_rng(3), 100)
    rest = every_pair(boxes)
    boxes[7, 2] = boxes[30, 4] = np.nan
    assert units.SweepAndPrune().pairs(boxes) == [p for p in rest if not {7, 30} & set(p)]


def test_pairs_of_one_group_are_left_out(units: Any) -> None:
    boxes = spheres(np.random.default_rng(4), 300)
    groups = [i % 3 for i in range(300)]
    expected = [(i, j) for i, j in every_pair(boxes) if groups[i] == 0 or groups[i] != groups[j]]
    assert units.SweepAndPrune().pairs(boxes, groups) == expected
    assert 0 < len(expected) < len(every_pair(boxes))


def test_earlier_calls_do_not_change_the_result(units: Any) -> None:
    """Small moves, a jump, another number of bodies."""
    rng = np.random.default_rng(5)
    search = units.SweepAndPrune()
    boxes = spheres(rng, 400)
    for step in range(12):
        boxes = boxes + 0.02 * np.tile(rng.normal(size=(len(boxes), 3)), 2)
        if step == 5:
            boxes = boxes[::-1].copy()
        if step == 8:
            boxes = boxes[:250].copy()
        assert search.pairs(boxes) == every_pair(boxes)


def heap(rng: np.random.Generator, n: int) -> Array:
    """Balls stacked in a pile on a floor, about to touch."""
    width = int(np.cbrt(n / 2))
    i = np.arange(n)
    center = np.stack([i % width, i // width % width, i // width**2], axis=1) + rng.uniform(0, 0.05, (n, 3))
    inf = np.inf
    return np.vstack([np.hstack([center - 0.5, center + 0.5]), [[-inf, -inf, -inf, inf, inf, 0]]])


@pytest.mark.parametrize("scene", ["equal", "decade", "many decades", "heap"])
def test_comparisons_grow_in_proportion_to_the_number_of_bodies(units: Any, scene: str) -> None:
    """Counted, not timed. A sweep along one axis alone has the exponent 5/3."""
    counts = []
    for n in (1000, 100_000):
        rng = np.random.default_rng(6)
        search = units.SweepAndPrune()
        search.pairs(heap(rng, n) if scene == "heap" else spheres(rng, n, scene))
        counts.append(search.comparisons())
    assert np.log10(counts[1] / counts[0]) / 2 < 1.1
