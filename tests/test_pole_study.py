# SPDX-License-Identifier: BSD-3-Clause
"""The maps of stiff poles in docs/stability.md: closed forms, outcomes, pictures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks import draw_poles, poles
from scipy.integrate import solve_ivp

from gelenk.chart.draw_stability import FILL
from gelenk.chart.methods import AUTO, Method
from gelenk.chart.outcome import Outcome

RK4, ERK = Method("projection", "rk4"), Method("projection", "erk")


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> poles.PoleMap:
    """Two poles, two tolerances and two steps; the explicit method of fixed steps diverges."""
    monkeypatch.setattr(poles, "methods", lambda: [AUTO, ERK, RK4])
    return poles.pole_map(poles.QUICK)


@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("time_constant", [1.0, 0.01, 1e-6])
def test_closed_form_satisfies_the_equations(time_constant: float, jumps: bool) -> None:
    """Complex and real poles; a stiff one integrated by an implicit method, whose tolerance is 1e-10."""
    case = replace(poles.case_of(time_constant, jumps), stop=0.3)
    y, found = np.zeros(3), [np.zeros(3)]
    for k, (begin, end) in enumerate(zip(case.grid[:-1], case.grid[1:], strict=True)):
        u = poles.VOLTAGES.at(k) if jumps else poles.VOLTAGE
        A = np.array([[0, 1, 0], [0, 0, 8], [0, -0.4 / 1.2 / time_constant, -1 / time_constant]])
        b = np.array([0, 0, u / 1.2 / time_constant])
        run = solve_ivp(
            lambda _, x, A=A, b=b: A @ x + b, (begin, end), y, method="Radau", jac=A, rtol=1e-10, atol=1e-12
        )
        y = run.y[:, -1]
        found.append(y)
    expected = np.array(found)[case.samples()]
    np.testing.assert_allclose(poles.motor_truth(time_constant, case), expected, rtol=0, atol=1e-7)


def test_map_tells_outcomes_and_costs(few: poles.PoleMap, tmp_path: Path) -> None:
    assert len(few.runs) == 2 * 3 * 2
    for time_constant in (1.0, 1e-3):
        for tolerance in (1e-4, 1e-6):
            assert few.cell(AUTO, time_constant, tolerance).error < tolerance
    assert few.cell(RK4, 1.0, 0.01).outcome == Outcome.GOOD
    assert few.cell(RK4, 1e-3, 0.1).outcome == Outcome.WRONG  # 1e66: a step of a hundred time constants
    assert draw_poles.fill_of(few, RK4, 1e-3, 0.1) == FILL[Outcome.WRONG]
    assert draw_poles.fill_of(few, AUTO, 1.0, 1e-6) == FILL[Outcome.GOOD]
    draw_poles.draw(few, tmp_path / "poles.png")
    assert 5_000 < (tmp_path / "poles.png").stat().st_size < 150_000


def test_cells_of_loose_and_of_costly_runs_are_distinguished(few: poles.PoleMap) -> None:
    def changed(**fields: float) -> poles.PoleMap:
        dear = few.cell(ERK, 1.0, 1e-6)
        return replace(few, runs=[replace(r, **fields) if r is dear else r for r in few.runs])  # type: ignore[arg-type]

    fewest = few.cell(AUTO, 1.0, 1e-6).evaluations
    for fields, fill in (
        ({"error": 1.1e-5}, draw_poles.LOOSE_FILL),
        ({"error": 0.9e-5}, FILL[Outcome.GOOD]),
        ({"evaluations": 10.1 * fewest}, draw_poles.COSTLY_FILL),
        ({"evaluations": 9.9 * fewest}, FILL[Outcome.GOOD]),
    ):
        assert draw_poles.fill_of(changed(**fields), ERK, 1.0, 1e-6) == fill


def test_steps_do_not_exceed_the_communication_step() -> None:
    assert poles.asked(RK4, poles.Settings(False))[0] == 0.1
    assert poles.asked(RK4, poles.Settings(True))[0] == 0.01
    assert poles.asked(AUTO, poles.Settings(True)) == poles.TOLERANCES


@pytest.mark.parametrize(
    ("value", "text"),
    [(463, "463"), (999.4, "999"), (1000, "1.0k"), (9960, "10k"), (999_600, "1.0M"), (2_286_560, "2.3M")],
)
def test_counts_are_short(value: float, text: str) -> None:
    assert draw_poles.count(value) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(3e-3, "3e-3"), (0.28, "0.28"), (1.66, "1.7"), (17.2, "17"), (172.3, "172"), (3e4, "3e4")],
)
def test_ratios_are_short(value: float, text: str) -> None:
    assert draw_poles.ratio(value) == text
