# SPDX-License-Identifier: BSD-3-Clause
"""The references of the charts of laws and states: each satisfies its equations, integrated independently."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gelenk.chart import laws
from gelenk.chart.case import Array, Case
from gelenk.chart.measure import Reference, Task, measured
from gelenk.chart.methods import AUTO
from gelenk.chart.outcome import Outcome
from gelenk.chart.reference import closed, main_recording

TIMES = np.linspace(0.05, 1.0, 20)
TIGHT = {"method": "DOP853", "rtol": 3e-14, "atol": 1e-15}


def integrated(rates: Callable[[float, Array], list[float]], start: list[float]) -> Array:
    found: Array = solve_ivp(rates, (0, 1), start, t_eval=TIMES, **TIGHT).y
    return found


def test_duffing() -> None:
    expected = integrated(lambda _, y: [y[1], -100 * y[0] - 1000 * y[0] ** 3], [0.5, 0])
    found = laws.duffing_truth(TIMES)
    np.testing.assert_allclose([found["S.s"], found["S.v"]], expected, rtol=0, atol=1e-11)


def test_gas_spring() -> None:
    """Also at the start, a turning point, where the slowness is a limit."""
    expected = integrated(lambda _, y: [y[1], 100 * ((0.1 / (0.1 + y[0])) ** 1.4 - 1)], [-0.08, 0])
    found = laws.gas_spring_truth(TIMES)
    np.testing.assert_allclose([found["rod.s"], found["rod.v"]], expected, rtol=0, atol=1e-11)
    begun = laws.gas_spring_truth(np.array([0.0, 1e-9]))
    np.testing.assert_allclose(begun["rod.s"], -0.08, rtol=0, atol=1e-14)


def test_speed_drive() -> None:
    """From limit to limit, as the kinks would cost an integration its accuracy."""

    def rates(t: float, y: Array) -> list[float]:
        _, w, total, i = y
        target = 8 * np.sin(3 * t)
        wanted = 4 * (target - w) + 8 * total
        u = float(np.clip(wanted, -24, 24))
        return [
            w,
            (0.4 * i - 0.02 * w) / 0.5,
            target - w + (u - wanted) / 0.1,
            (u - 1.2 * i - 0.4 * w) / 0.05,
        ]

    pieces = list(laws.drive_pieces(5.0))
    assert [side for *_, side in pieces] == [0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0]
    found = laws.speed_drive_truth(np.array([end for _, end, *_ in pieces]))
    y = np.zeros(4)
    for row, (begin, end, *_) in enumerate(pieces):
        y = solve_ivp(rates, (begin, end), y, **TIGHT).y[:, -1]
        reached = [found[name][row] for name in ("axle.phi", "axle.w", "sum", "i")]
        np.testing.assert_allclose(reached, y, rtol=0, atol=1e-11)


@pytest.mark.parametrize("case", laws.law_cases(), ids=lambda case: case.name)
def test_runs_are_judged_by_motion_and_states(case: Case) -> None:
    """`auto` at 1e-8: below 10 tolerances; a run without states of elements would have fewer columns."""
    found = closed(case, [main_recording(case)])
    assert isinstance(found, Reference)
    assert found.words.startswith("closed form; projection+erk at 1e-13 agrees to ")
    assert found.states.shape == (20, 4 if case.name == "speed-drive" else 2)
    run = measured(Task(case, AUTO, 1e-8), found)
    assert run.outcome == Outcome.GOOD
    assert run.error < 1e-7
