# SPDX-License-Identifier: BSD-3-Clause
"""Limited forces and the motions that they prevent, against their conditions and bounded least squares."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from scipy.optimize import lsq_linear

# Of numbers about 1, after some ten operations on each.
ROUNDING = 1e-11


def solved(units: Any, W: Any, b: Any, lower: Any, upper: Any) -> tuple[Array, Array, bool]:
    W = np.asarray(W, float)
    (x, r), found = units.solve_in_box(W.tolist(), list(b), list(lower), list(upper))
    return np.array(x), np.array(r), found


def check(W: Array, b: Array, lower: Array, upper: Array, x: Array, r: Array) -> None:
    """The conditions of complementarity, each in the unit of its row."""
    unit = np.sqrt(np.diag(W))
    zero = ROUNDING * unit * (1 + np.abs(b / unit).max())
    assert (np.abs(r - (b - W @ x)) <= zero).all()
    assert (x >= lower).all()
    assert (x <= upper).all()
    assert (r <= zero)[x < upper].all()
    assert (r >= -zero)[x > lower].all()


def test_one_body_sticks_up_to_its_limit(units: Any) -> None:
    for load, expected in [(0.5, 0.5), (1.0, 1.0), (-0.99, -0.99), (3.0, 1.0), (-3.0, -1.0)]:
        x, r, found = solved(units, [[2.0]], [2 * load], [-1], [1])
        assert found
        assert x == pytest.approx([expected], rel=1e-15)
        assert r == pytest.approx([2 * (load - expected)], abs=1e-15)


def test_a_unilateral_force_does_not_pull(units: Any) -> None:
    inf = np.inf
    assert solved(units, [[2.0]], [-1], [0], [inf])[0] == [0]
    assert solved(units, [[2.0]], [1], [0], [inf])[0] == pytest.approx([0.5], rel=1e-15)


@pytest.mark.parametrize("w", [0.0, 1e-3, 2.0])
@pytest.mark.parametrize("bounds", [(-1, 1), (0, 1), (-1, 0), (0, 0), (0, np.inf), (-np.inf, np.inf)])
def test_one_unknown_is_solved_as_beside_another(units: Any, w: float, bounds: tuple[float, float]) -> None:
    """In closed form alone, by the general method with one that has no part in it."""
    lower, upper = bounds
    for b in (-3.0, -2 * w, -w, 0.0, w / 2, w, 3.0):
        x, r, found = solved(units, [[w]], [b], [lower], [upper])
        others, rests, found_beside = solved(units, [[w, 0], [0, 1]], [b, 0], [lower, -1], [upper, 1])
        assert found == found_beside
        if found:
            assert x[0] == pytest.approx(others[0], rel=1e-14, abs=1e-14)
            assert r[0] == pytest.approx(rests[0], rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("rank", [1, 3, 6, 9])
@pytest.mark.parametrize("seed", range(8))
def test_random_problems_meet_the_conditions(units: Any, rank: int, seed: int) -> None:
    """Definite and singular W, units that differ by a thousand, loads in the range of W as in loops."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(rank, 6)) * 10.0 ** rng.uniform(-1.5, 1.5, 6)
    W, c = A.T @ A, rng.normal(size=rank)
    b = A.T @ c
    upper = rng.uniform(0.01, 1, 6) / np.abs(A).max(axis=0)
    lower = -upper * rng.integers(0, 2, 6)
    x, r, found = solved(units, W, b, lower, upper)
    assert found
    check(W, b, lower, upper, x, r)
    scale = np.abs(A).max(axis=0)
    truth = lsq_linear(A, c, (lower - 1e-300, upper), method="bvls", tol=1e-15)
    assert r / scale == pytest.approx((b - W @ truth.x) / scale, abs=1e-9)  # bvls stops at about that


@pytest.mark.parametrize("rank", [20, 40, 60, 90])
def test_many_limits_at_once(units: Any, rank: int) -> None:
    """As where a robot with all its joints at limits falls: 60 impulses that push, half of them needed."""
    rng = np.random.default_rng(rank)
    A = rng.normal(size=(rank, 60))
    W, b = A.T @ A, A.T @ rng.normal(size=rank)
    upper = np.full(60, np.inf)
    lower = np.zeros(60)
    x, r, found = solved(units, W, b, lower, upper)
    assert found
    check(W, b, lower, upper, x, r)
    assert 0 < np.count_nonzero(x) < 60


@pytest.mark.parametrize("spread", [1e-3, 1e-6, 1e-12])
def test_nearly_redundant_forces(units: Any, spread: float) -> None:
    """Two rows that differ by about the rounding at which pivots are dropped, and by more and less."""
    A = np.array([[1.0, 1.0, 0.5], [0.0, spread, 0.3]])
    W, b = A.T @ A, A.T @ np.array([1.0, 2.0])
    x, r, found = solved(units, W, b, np.zeros(3), np.full(3, np.inf))
    assert found
    check(W, b, np.zeros(3), np.full(3, np.inf), x, r)


@pytest.mark.parametrize("digits", range(1, 11))
def test_nearly_equal_rows_have_large_forces(units: Any, digits: int) -> None:
    """As of a lock and a limit at the ends of a short link. Errors of W x are relative to its terms."""
    c = 1 - 10.0**-digits
    truth = np.array([c, 1]) / ((1 - c) * (1 + c))
    for scale in (1.0, 1e3, 1182.51):
        unit = np.array([np.sqrt(scale), 1.0])
        W = np.array([[1, -c], [-c, 1]]) * np.outer(unit, unit)
        x, _, found = solved(units, W, [0, 0.838], [-np.inf, 0], [np.inf, np.inf])
        assert found
        assert x * unit == pytest.approx(0.838 * truth, rel=1e-15 * 10**digits + 1e-14)


def test_equal_forces_share_what_one_would_do(units: Any) -> None:
    """Four joints hold a loop with one degree of freedom: their torques are those of least norm."""
    a = np.array([1.0, -1.0, 0.5, 2.0])
    W = np.outer(a, a)
    x, r, found = solved(units, W, 0.3 * a, -np.ones(4), np.ones(4))
    assert found
    assert r == pytest.approx(np.zeros(4), abs=1e-15)
    assert x == pytest.approx(0.3 / 4 / a, rel=1e-12)  # in units in which each diagonal entry is 1


def test_what_slips_at_its_limit_is_no_longer_shared(units: Any) -> None:
    a = np.ones(3)
    x, r, found = solved(units, np.outer(a, a), a, [-0.1, -1, -1], [0.1, 1, 1])
    assert found
    assert r == pytest.approx(np.zeros(3), abs=1e-15)
    assert x.sum() == pytest.approx(1, rel=1e-14)
    assert abs(x[0]) <= 0.1


def test_loads_beyond_all_limits_move(units: Any) -> None:
    a = np.array([1.0, 2.0])
    x, r, found = solved(units, np.outer(a, a), 5 * a, [-1, -1], [1, 1])
    assert found
    assert (x == [1, 1]).all()
    assert r == pytest.approx(2 * a)


def test_at_the_limit_exactly_nothing_moves(units: Any) -> None:
    a = np.array([1.0, 2.0])
    x, r, found = solved(units, np.outer(a, a), 3 * a, [-1, -1], [1, 1])
    assert found
    assert x == pytest.approx([1, 1], rel=1e-14)
    assert r == pytest.approx([0, 0], abs=1e-14)


def test_a_load_that_no_force_can_hold_is_not_solved(units: Any) -> None:
    """Infinite bounds, and a motion that they do not touch."""
    inf = np.inf
    assert not solved(units, [[1.0, 0.0], [0.0, 0.0]], [0.0, 1.0], [-inf, -inf], [inf, inf])[2]


def test_nothing_is_solved_by_nothing(units: Any) -> None:
    assert solved(units, np.zeros((0, 0)), [], [], [])[2]
