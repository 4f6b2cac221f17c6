# SPDX-License-Identifier: BSD-3-Clause
"""The study of docs/nonsmooth-measurements.md: bearings, gears with losses, clutches and freewheels."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from benchmarks.nonsmooth import (
    exact_bearings,
    exact_drives,
    judge,
    laws,
    loaded_problems,
    loaded_trials,
)
from test_nonsmooth_study import run_of_auto


def test_exact_motion_of_a_gear_with_losses() -> None:
    """2.5 N m on the first shaft: raised by 5 N m at the efficiency 0.5, held by 2.5, let down by less."""
    gear = exact_drives.Gear((0.1, 1.6), 4.0, 0.5, 0.5, -10.0)
    found, events = exact_drives.gear_course(gear, 0.0, [1.0, 3.0, 4.0, 5.0], [8.0, 2.5, 2.5, 0.25])
    w = (8.0 - 5.0) / (0.1 + 2 * 0.1)  # 1.6 / 16 kg m2, of which twice the power has to be fed in
    assert found[0] == pytest.approx((w / 2, w))
    assert found[1][1] == 0.0
    assert found[2] == found[1]
    # It goes down at -1.25 + 0.25 N m: the load drives.
    assert found[3][1] == pytest.approx((0.25 - 1.25) / (0.1 + 0.5 * 0.1))
    assert events == 2


def test_exact_motion_of_a_clutch_in_ramps() -> None:
    """Momentum is conserved; a ramp from 0 to 1 within 2 s has taken half of the slip at the square root."""
    clutch = exact_drives.Clutch((1.0, 1.0), 0.0, 4.0, 4.0, (2.0, 0.0))
    found, events = clutch.course([0.5, 2.0], [0.0, 0.25], [0.5, 0.5])
    # The slip 2 - 4 t^2 / 2 ... with 8 rad/s2 fully engaged: 2 - 8 * 0.5 t^2 / 2.
    assert found[0][2] - found[0][3] == pytest.approx(2 - 2 * 0.25)
    assert found[1][2:] == pytest.approx((1.0, 1.0))
    assert events == 1


def test_exact_motion_of_a_freewheel() -> None:
    found, events = exact_drives.freewheel_course((1.0, 2.0), 0.0, [1.0, 2.0, 3.0], [3.0, -1.0, 3.0])
    assert found == [(1.0, 1.0), (0.0, 1.0), pytest.approx((1.0 + 2 / 3, 1.0 + 2 / 3))]
    assert events == 2


def test_exact_motion_of_a_slider_crank_with_friction_of_its_guide() -> None:
    """Problem N07: event-driven extrapolation in 80-bit arithmetic."""
    machine = exact_bearings.SliderCrank((0.15, 0.56), (0.5, 0.8, 1.5), 0.3)
    found, events = exact_bearings.reversing(machine, 0.6, 12.0, [0.1, 0.5, 1.0, 1.5])
    assert [phi for phi, _ in found] == pytest.approx(
        [1.4240335139300109, 5.165350031841773, 5.293286931392428, 5.0772583747202775], abs=1e-11
    )
    assert found[-1][1] == 0.0
    assert events == 3


def test_exact_accelerations_of_an_eccentric_wheel() -> None:
    """Without speed and gravity, friction grows with the acceleration; beyond 1, none of them brakes."""
    for coupling in (0.0, 0.5, 0.999):
        machine = exact_bearings.Eccentric(2.0, 0.1, 0.2, coupling, 0.0, 3.0)
        assert machine.acceleration(0.0, 0.0, 1.0) == pytest.approx(3.0 / (0.2 * (1 + coupling)))
    with pytest.raises(exact_bearings.ParadoxError):
        exact_bearings.Eccentric(2.0, 0.1, 0.2, 1.001, 0.0).acceleration(0.0, 5.0, 1.0)


@pytest.mark.thorough
@pytest.mark.parametrize("family", loaded_trials.FAMILIES, ids=lambda family: family.__name__)
def test_a_sample_of_trials_is_right(family: loaded_trials.Family) -> None:
    for trial in list(family())[::5]:
        verdict = judge.judged(trial, "auto")
        assert verdict.outcome == "right", f"{trial.name}: {verdict}"


@pytest.mark.thorough
def test_what_is_to_be_refused_is_not_right_if_it_runs() -> None:
    refused = [trial for trial in loaded_trials.eccentric_wheels() if trial.refused]
    assert len(refused) > 5
    loose = {
        **refused[0].scene,
        "joints": {"J": {**refused[0].scene["joints"]["J"], "friction": {"coulomb": 0}}},
    }
    assert judge.judged(replace(refused[0], scene=loose), "auto").outcome == "wrong"


def test_gelenk_solves_the_problems() -> None:
    """Bounds: 100 times the tolerance of the largest angle; the four-bar turns four times."""
    for problem in loaded_problems.loaded_problems():
        found = run_of_auto(problem)
        largest = max(abs(x) for values in problem.positions.values() for x in values)
        assert found.error < 1e-5 * max(1.0, largest)
        assert found.events == problem.events


def test_the_regularized_hoist_converges() -> None:
    problem = loaded_problems.hoist()
    wide, narrow = (laws.smooth_run(problem, "tanh", width, 1e-9) for width in (1e-2, 1e-3))
    assert narrow.error < wide.error / 5
    assert math.isfinite(narrow.evaluations)
