# SPDX-License-Identifier: BSD-3-Clause
"""The values of a motion from which its derivatives are estimated belong to the state of a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import warned
from models.driven_mass import driven_mass, follow, start_of, swing, swing_rate

import gelenk


def random_calls(rng: np.random.Generator, plant: gelenk.Simulation) -> Iterator[list[float]]:
    """Steps of random lengths in which the motion jumps, is not set, is set twice, or has derivatives."""
    t = plant.time
    while True:
        kind = rng.integers(8)
        if kind == 0:
            plant.set_input("pos.s_ref", rng.uniform(-1, 1))
        if kind != 1:
            plant.set_input("pos.s_ref", swing(t))
        if kind == 2:
            plant.set_input_derivative("pos.s_ref", 1, swing_rate(t))
        if kind == 3:
            plant.set_input("pos.s_ref", swing(t) + 0.05)
        t += 10.0 ** rng.uniform(-4, -2)
        plant.step_to(t)
        yield [*plant.values(), plant.input("pos.s_ref")]


@warned.TIGHT
@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "ida", "rk4", "dirk"])
def test_a_run_goes_on_from_a_saved_state_to_the_bit(integrator: str) -> None:
    for before in (0, 1, 2, 3, 17):
        plant = start_of(driven_mass(integrator), value=swing(0.0))
        calls = random_calls(np.random.default_rng(7), plant)
        for _ in range(before):
            next(calls)
        plant.set_input("pos.s_ref", 0.2)  # replaced below: between the steps, too
        saved = plant.save()
        runs = []
        for other in (plant, plant, start_of(driven_mass(integrator), value=swing(0.0))):
            other.restore(saved)
            calls = random_calls(np.random.default_rng(8), other)
            runs.append([next(calls) for _ in range(12)])
        assert runs[0] == runs[1] == runs[2], before


@warned.TIGHT
def test_saving_changes_nothing() -> None:
    runs = []
    for saves in (False, True):
        plant = start_of(driven_mass("cvode"), value=swing(0.0))
        calls = random_calls(np.random.default_rng(9), plant)
        rows = []
        for _ in range(30):
            if saves:
                plant.save()
            rows.append(next(calls))
        runs.append(rows)
    assert runs[0] == runs[1]


def test_a_repeated_step_is_as_the_first() -> None:
    """After a step that fails, because the input is not finite at its end, with the same value or another."""
    plant, other = (start_of(driven_mass("erk"), value=swing(0.0)) for _ in range(2))
    times = [0.01 * k for k in range(8)]
    for p in (plant, other):
        follow(p, times, swing)
    plant.set_input("pos.s_ref", 1e308)
    for k in range(3):
        plant.set_input("pos.s_ref", -1e308 if k == 1 else 1e308)
        with pytest.raises(gelenk.StepError):
            plant.step_to(0.08)
    for p in (plant, other):
        p.set_input("pos.s_ref", swing(0.07))
        p.step_to(0.08)
    assert plant.values().tolist() == other.values().tolist()


def reach(plant: gelenk.Simulation, end: float, again: float | None = None) -> int:
    """Step to `end` in as many parts as it takes; return their number; `again` is set before each."""
    parts = 0
    while plant.time < end:
        parts += 1
        try:
            plant.step_to(end)
        except gelenk.StepBudgetError:
            if again is not None:
                plant.set_input("pos.s_ref", again)
    return parts


def test_a_step_that_ends_early_goes_on_along_the_parabola() -> None:
    """The same value set again for its rest says nothing new; another one is a value at that time."""
    source = driven_mass("erk")
    source["solver"]["max_evaluations"] = 100
    source["joints"]["y"]["start"] = {"s": 0.1, "fixed": True}
    rows = []
    for again in (None, 0.03):
        plant = start_of(source, value=0.0)
        for k in range(2):
            plant.set_input("pos.s_ref", 0.015 * k)
            reach(plant, 0.01 * (k + 1))
        plant.set_input("pos.s_ref", 0.03)
        assert reach(plant, 0.5, again) > 1
        assert plant.values(["x.s", "x.v"]) == pytest.approx([0.75, 1.5], abs=1e-9)
        rows.append(plant.values().tolist())
    assert rows[0] == rows[1]
    plant.set_input("pos.s_ref", 0.75)
    with pytest.raises(gelenk.StepBudgetError):
        plant.step_to(1.0)
    cut = plant.time
    plant.set_input("pos.s_ref", 0.75 + 1.2 * (cut - 0.5))
    curvature = (1.2 - 1.5) / (cut - 0.02)
    expected = [1.2 + curvature * (cut - 0.5), 2 * curvature]
    found = [plant.input_derivative("pos.s_ref", order) for order in (1, 2)]
    assert found == pytest.approx(expected, rel=1e-6)
