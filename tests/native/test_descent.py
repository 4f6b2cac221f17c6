# SPDX-License-Identifier: BSD-3-Clause
"""The iteration that closes loops, on functions of plain numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mechanisms import Array

Function = Callable[[Array], Any]


class Problem:
    """Residuals and their Jacobian, with a record of the evaluations."""

    def __init__(self, r: Function, J: Function) -> None:
        self.r, self.J = r, J
        self.seen: list[Array] = []
        self.dampings: list[float] = []

    def residual(self, x: list[float]) -> list[float]:
        self.seen.append(np.array(x))
        return [float(v) for v in np.atleast_1d(self.r(np.array(x)))]

    def step(self, x: list[float], r: list[float], damping: float) -> list[float]:
        self.dampings.append(damping)
        J = np.atleast_2d(self.J(np.array(x)))
        if damping == 0:
            return [float(v) for v in -np.linalg.pinv(J) @ r]
        scale = (J**2).sum() / len(J)
        return [float(v) for v in -J.T @ np.linalg.solve(J @ J.T + damping * scale * np.eye(len(J)), r)]

    def solve(self, units: Any, x: list[float], **how: Any) -> tuple[Array, Array]:
        found, left = units.descend(x, self.residual, self.step, **how)
        return np.array(found), np.array(left)


def banana() -> Problem:
    """Rosenbrock's function, with its only zero at (1, 1)."""
    return Problem(
        lambda x: [10 * (x[1] - x[0] ** 2), 1 - x[0]], lambda x: np.array([[-20 * x[0], 10], [-1, 0]])
    )


def test_a_curved_valley_is_followed_to_its_zero(units: Any) -> None:
    problem = banana()
    x, left = problem.solve(units, [-1.2, 1.0], rounding=1e-15)
    assert x == pytest.approx([1, 1], abs=1e-14)
    assert np.abs(left).max() <= 1e-15
    assert max(problem.dampings) > 0  # Newton's step from the start increases the residual
    assert problem.dampings[-1] == 0


def test_contradicting_equations_end_at_the_least_residual(units: Any) -> None:
    """One unknown, x = 0 and x + x^3 = 2: the residual does not vanish, and the remainder is returned."""
    problem = Problem(
        lambda x: [x[0], x[0] - 2 + x[0] ** 3], lambda x: np.array([[1.0], [1 + 3 * x[0] ** 2]])
    )

    def least_squares(x: list[float], r: list[float], damping: float) -> list[float]:
        J = problem.J(np.array(x))
        return [float(v) for v in -np.linalg.solve(J.T @ J * (1 + damping), J.T @ r)]

    x, left = units.descend([5.0], problem.residual, least_squares, min_progress=1e-9)
    gradient = problem.J(np.array(x)).T @ np.array(left)
    assert float(gradient[0]) == pytest.approx(0, abs=1e-3)  # |r| decreases by less than 1e-9 of itself there
    assert np.abs(left).max() > 0.5


def test_steps_are_no_longer_than_specified(units: Any) -> None:
    problem = Problem(lambda x: x - 10, lambda _x: np.eye(1))
    x, _ = problem.solve(units, [0.0], max_step=3.0)
    assert [float(at[0]) for at in problem.seen] == [0, 3, 6, 9, 10]
    assert x == [10]


@pytest.mark.parametrize("rounding", [1e-6, 1e-18, 1e-30])
def test_iterations_below_the_tolerance_continue_to_rounding(units: Any, rounding: float) -> None:
    """x^2 = 0: each Newton step quarters the residual; iterations continue while it is at least halved."""
    problem = Problem(lambda x: x**2, lambda x: np.diag(2 * x))
    _, left = problem.solve(units, [1.0], tolerance=1e-3, rounding=rounding, max_steps=2000)
    assert rounding / 4.01 < left[0] <= rounding


def test_iterations_below_the_tolerance_stop_if_steps_gain_too_little(units: Any) -> None:
    """With a derivative five times too large steps gain a fifth: enough above the tolerance."""
    slow = Problem(lambda x: x, lambda _x: 5 * np.eye(1))
    _, left = slow.solve(units, [1.0], tolerance=2e-3, min_progress=0.1)
    assert 0.8 * 2e-3 < left[0] <= 2e-3
    assert set(slow.dampings) == {0.0}  # no step is damped to continue from there
    stuck = Problem(lambda x: x, lambda _x: 5 * np.eye(1))
    _, left = stuck.solve(units, [1.0], tolerance=2e-3, min_progress=0.3)
    assert left[0] == 1
    assert max(stuck.dampings) > 1e5  # all dampings were tried


def test_steps_are_damped_until_they_succeed_and_then_released(units: Any) -> None:
    """atan: from 3 the undamped step overshoots to a larger residual."""
    problem = Problem(np.arctan, lambda x: np.diag(1 / (1 + x**2)))
    x, _ = problem.solve(units, [3.0], rounding=1e-15)
    assert x == pytest.approx([0], abs=1e-15)
    assert problem.dampings[:2] == [0, 1e-4]
    assert problem.dampings[-1] < max(problem.dampings) / 100


def test_the_least_damping_is_kept(units: Any) -> None:
    problem = banana()
    x, _ = problem.solve(units, [-1.2, 1.0], rounding=1e-13, min_damping=1e-10)
    assert x == pytest.approx([1, 1], abs=1e-12)
    assert min(problem.dampings) == 1e-10


def test_nan_is_not_progress(units: Any) -> None:
    problem = Problem(
        lambda x: np.sqrt(x) - 2 if x[0] >= 0 else [np.nan], lambda x: np.diag(0.5 / np.sqrt(x))
    )
    x, _ = problem.solve(units, [25.0], rounding=1e-15)  # the first step leads to -5
    assert x == pytest.approx([4], abs=1e-13)
    assert any(at[0] < 0 for at in problem.seen)


def test_without_unknowns_nothing_changes(units: Any) -> None:
    x, left = units.descend([1.0], lambda _x: [3.0], lambda _x, _r, _d: [])
    assert (x, left) == ([1.0], [3.0])


def test_steps_are_counted(units: Any) -> None:
    problem = Problem(lambda x: x**2, lambda x: np.diag(2 * x))
    problem.solve(units, [1.0], max_steps=7)
    assert len(problem.seen) == 1 + 7
