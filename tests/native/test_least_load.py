# SPDX-License-Identifier: BSD-3-Clause
"""Distributions of redundant forces: within their bounds if any is, and balanced in any case."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array

INF = np.inf
# Three coordinates that hold the same motion, and one that holds another, coupled with the first by inertia.
COUPLED = np.array([[0.47] * 3 + [-0.06]] * 3 + [[-0.06] * 3 + [0.31]])


def loads(units: Any, W: Array, b: Array, lower: list[float], upper: list[float]) -> Array:
    return np.array(units.least_load(W.tolist(), b.tolist(), lower, upper))


def test_limits_are_used_to_the_same_fraction(units: Any) -> None:
    """Two brakes on a shaft, of 1 and 3 N m, which hold 2 N m together."""
    W = np.full((2, 2), 0.5)
    assert loads(units, W, W @ [2.0, 0], [-1, -3], [1, 3]) == pytest.approx([0.5, 1.5], rel=1e-12)
    # Beyond their sum, both are overloaded alike.
    assert loads(units, W, W @ [8.0, 0], [-1, -3], [1, 3]) == pytest.approx([2, 6], rel=1e-12)


def test_contact_takes_over_what_friction_need_not_hold(units: Any) -> None:
    W = np.full((2, 2), 0.5)
    assert loads(units, W, W @ [2.0, 0], [0, -3], [INF, 3]) == pytest.approx([2, 0], abs=1e-12)
    assert loads(units, W, W @ [-2.0, 0], [0, -3], [INF, 3]) == pytest.approx([0, -2], abs=1e-12)


@pytest.mark.parametrize("rounding", [0.0, 1e-16, -1e-16])
@pytest.mark.parametrize("force", [2.5, 1e-6, -1e-6, -2.5])
def test_contact_that_would_have_to_pull_is_seen(units: Any, force: float, rounding: float) -> None:
    """Beside other forces that are redundant: the fourth force is unique, and negative if it pulls."""
    W = COUPLED + rounding * np.diag([1, -1, 1, -1])
    b = W @ [-36.0, -4.0, -42.0, force]
    x = loads(units, W, b, [-INF, -0.15, -0.295, 0], [0.17, 0.15, INF, INF])
    assert W @ x == pytest.approx(b, abs=1e-12)
    assert x[3] == pytest.approx(force, abs=1e-10)  # rounding of the others' 80 N


@pytest.mark.parametrize("seed", range(40))
def test_brakes_do_not_help_stops_that_hold_alone(units: Any, seed: int) -> None:
    """Two stops press against each other: the rounding of their effects is larger than that of the load."""
    rng = np.random.default_rng(seed)
    rows = np.array([[-0.06, 0.58], [11.57, 0.1], [2.17, -0.4], [-13.08, 0.14]]) + 0.02 * rng.normal(
        size=(4, 2)
    )
    W = rows @ rows.T
    b = W @ [0.0, 80.0, 0.0, 70.0]
    x = loads(units, W, b, [-6.1, 0, -0.47, 0], [6.1, INF, 0.47, INF])
    assert x[[0, 2]].tolist() == [0.0, 0.0]
    assert x[[1, 3]] == pytest.approx([80.0, 70.0], rel=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_brakes_are_within_their_limits_beside_large_loads(units: Any, seed: int) -> None:
    """Two brakes on one shaft; a stop elsewhere holds a million times as much, with its rounding."""
    rng = np.random.default_rng(seed)
    shaft = np.outer([1.56, 4.04], [1.56, 4.04])
    elsewhere = np.array([[2.07, 4.81], [4.81, 398.12]])
    W = np.zeros((4, 4))
    W[1:3, 1:3] = shaft
    W[np.ix_([0, 3], [0, 3])] = elsewhere * rng.uniform(0.5, 2)
    load = rng.uniform(0.3, 0.9)  # of what the brakes can hold
    brakes = np.array([2.883, 0.2667])
    b = W @ np.array([-626.13e3 * rng.uniform(0.5, 2), 0, 0, 0.69e3]) + W @ np.array([0, *(load * brakes), 0])
    x = loads(units, W, b, [-INF, *-brakes, 0], [1.5, *brakes, INF])
    assert x[1:3] == pytest.approx(load * brakes, rel=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_one_motion_is_resisted_by_the_same_fraction_of_all_limits(units: Any, seed: int) -> None:
    """In closed form where it is the only motion; the general way, beside another one, agrees."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))
    w, upper, lower = rng.normal(size=n), rng.uniform(0, 3, n), -rng.uniform(0, 3, n)
    if n > 1:
        w[0] *= 10.0 ** rng.uniform(-11, 0)  # of hardly an effect: on either side of what resists
        upper[-1] = 0.0 if n > 2 else upper[-1]
    push = float(rng.normal())  # along the motion
    bounds = np.where(w * push > 0, upper, lower)
    is_ignored = n > 1 and abs(w[0]) <= 1e-9 * np.abs(w).max()
    if is_ignored:
        bounds[0] = 0.0
    exact = bounds * abs(push) / (np.abs(w) @ np.abs(bounds))
    resists = bounds != 0
    x = loads(units, np.outer(w, w), w * push, list(lower), list(upper))
    assert x[resists] == pytest.approx(exact[resists], rel=2e-8 if is_ignored else 1e-10)
    W = np.zeros((n + 1, n + 1))
    W[:n, :n], W[n, n] = np.outer(w, w), 1.0
    beside = loads(units, W, np.append(w * push, 0.1), [*lower, -1.0], [*upper, 1.0])
    assert beside[:n][resists] == pytest.approx(exact[resists], rel=2e-8)
    assert beside[n] == pytest.approx(0.1)


@pytest.mark.parametrize("seed", range(40))
def test_random_distributions_are_balanced(units: Any, seed: int) -> None:
    """Friction and contacts on fewer motions than there are forces."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 6))
    W = A.T @ A
    b = W @ rng.normal(size=6)
    limits = rng.uniform(0.1, 2, 6)
    kinds = rng.integers(0, 3, 6)  # friction; pushes upwards; pushes downwards
    lower = np.where(kinds == 0, -limits, np.where(kinds == 1, 0, -INF))
    upper = np.where(kinds == 0, limits, np.where(kinds == 1, INF, 0))
    x = loads(units, W, b, lower.tolist(), upper.tolist())
    assert W @ x == pytest.approx(b, abs=1e-10 * np.abs(b).max())


def test_the_fraction_is_not_found_from_the_rounding_of_a_motion(units: Any) -> None:
    """Five joints of a planar loop at rest, two of them locked: three brakes hold the other two motions.

    Where the fraction is found to rounding, what is left of the motion has no direction. Of loads that differ
    in their last digits, one in fifty made a brake hold twice what it can.
    """
    rows = np.array(
        [
            [2.866239, 0.0, 0.0, 0.0],
            [3.925525, 5.819524, 0.0, 0.0],
            [1.621451, -13.599642, 14.158537, 0.0],
            [-1.185627, 0.348591, 0.504965, 0.668615],
            [-1.97969, 10.378532, -18.126089, 3.451912],
        ]
    )
    lower = [-2.36547292, -0.29846165, -0.02659427, -INF, -INF]
    upper = [2.36547292, 0.29846165, INF, INF, INF]
    load = np.array([-1.6093559, -0.20305919, 0.25528879, -10.4549366, 0.220121])
    rng = np.random.default_rng(3)
    for _ in range(500):
        W = rows @ rows.T * (1 + 1e-15 * rng.uniform(-1, 1, (5, 5)))
        W = (W + W.T) / 2
        x = loads(units, W, W @ load * (1 + 1e-14 * rng.uniform(-1, 1, 5)), lower, upper)
        assert (x >= np.array(lower) - 1e-8).all()
        assert (x <= np.array(upper) + 1e-8).all()


def test_forces_that_suffice_are_found(units: Any) -> None:
    """Random motions, often nearly the same ones, and loads that forces within their limits balance."""
    rng = np.random.default_rng(7)
    for _ in range(5000):
        n = int(rng.integers(2, 8))
        rows = rng.normal(size=(n, int(rng.integers(1, n + 1)))) * 10.0 ** rng.uniform(-1.5, 1.5, (n, 1))
        W = rows @ rows.T
        limits = 10.0 ** rng.uniform(-1, 1, n)
        kinds = rng.integers(5, size=n)  # brakes, stops and locks
        lower = np.where(kinds == 1, -INF, -limits)
        upper = np.where(kinds <= 1, INF, limits)
        load = 0.999 * rng.uniform(-1, 1, n) * limits
        x = loads(units, W, W @ load, lower.tolist(), upper.tolist())
        rounding = 1e-8 * np.abs(x).max()
        assert (x >= lower - rounding).all()
        assert (x <= upper + rounding).all()
        assert np.abs(W @ (x - load)).max() <= 1e-8 * (np.abs(W) @ (np.abs(x) + np.abs(load))).max()
