# SPDX-License-Identifier: BSD-3-Clause
"""Motions of which a master sets the values alone: their derivatives are estimated from these."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene, body, frame, joint, scene
from models.driven_mass import (
    END,
    TOLERANCE,
    driven_mass,
    equal_steps,
    follow,
    place_of_mass,
    start_of,
    swing,
    swing_rate,
    unequal_steps,
)

import gelenk


@warned.TIGHT
@pytest.mark.parametrize("steps", [equal_steps, unequal_steps])
@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "ida", "rk4"])
def test_error_of_a_driven_mass_is_of_second_order(
    integrator: str, steps: Callable[[float], list[float]]
) -> None:
    """A tenth of the step gives a hundredth of the error. With derivatives of 0 it is 0.2 m for any step."""
    truth = place_of_mass(swing, swing_rate)
    errors = []
    for h in (1e-2, 1e-3):
        plant = start_of(driven_mass(integrator), value=swing(0.0))
        follow(plant, steps(h), swing)
        errors.append(abs(plant.output("x.s") + plant.output("y.s") - truth))
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] > 50, errors


def test_reaction_of_the_drive_has_the_inertia_forces() -> None:
    """Of a sled, m u'': at the end of a step, 2 h after its middle value, the parabola lacks 2 h u'''."""
    x = joint("prismatic", frame("ground"), frame("sled"), axis=[1, 0, 0])
    source = scene({"sled": body(3.0)}, {"x": x})
    source["constraints"] = {"pos": {"type": "motion", "joint": "x", "input": "position"}}
    errors = []
    for h in (1e-2, 1e-3):
        plant = start_of(source, value=swing(0.0))
        follow(plant, equal_steps(h), swing)
        errors.append(abs(plant.output("pos.f") + 3.0 * 16.0 * swing(END)))
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.15), errors


def test_impulses_of_a_driven_pivot_are_its_inertia_forces() -> None:
    """A pendulum on a moved pivot, against the same motion as a law of the scene."""

    def pendulum(motion: dict[str, Any]) -> Scene:
        out = scene(
            {"sled": body(0.7), "bob": body(1.3, com=[0, 0, -0.4], inertia=[0.02, 0.02, 0.02])},
            {
                "x": joint("prismatic", frame("ground"), frame("sled"), axis=[1, 0, 0]),
                "hinge": joint("revolute", frame("sled"), frame("bob"), axis=[0, 1, 0], start={"phi": 0.3}),
            },
        )
        out["constraints"] = {"pos": {"type": "motion", "joint": "x"} | motion}
        return out

    sine = {"amplitude": 0.3, "frequency": 2 / math.pi, "phase": 0.4}
    exact = gelenk.Simulation(gelenk.load(pendulum({"sine": sine})))
    exact.initialize(0.0, TOLERANCE)
    exact.step_to(END)
    errors = []
    for h in (1e-2, 1e-3):
        plant = start_of(pendulum({"input": "position"}), value=swing(0.0))
        follow(plant, equal_steps(h), swing)
        errors.append(np.abs(plant.values(["hinge.phi", "x.s"]) - exact.values(["hinge.phi", "x.s"])).max())
    assert errors[0] / errors[1] > 50, errors


def test_the_motion_is_at_the_value_that_is_set_and_follows_a_parabola() -> None:
    """Three values determine a parabola; steps of 10, 30 and 5 ms."""

    def parabola(t: float) -> float:
        return 0.1 + 0.7 * t - 3.0 * t * t

    plant = start_of(driven_mass("erk"), value=parabola(0.0))
    times = [0.0, 0.01, 0.04, 0.045, 0.06]
    for k, (t, later) in enumerate(itertools.pairwise(times)):
        plant.set_input("pos.s_ref", parabola(t))
        assert plant.input("pos.s_ref") == parabola(t)
        found = [plant.input_derivative("pos.s_ref", order) for order in (1, 2)]
        assert found == pytest.approx([0.7 - 6.0 * t, -6.0] if k >= 2 else [0, 0], abs=1e-11)
        plant.step_to(later)
        expected = [parabola(later), 0.7 - 6.0 * later] if k >= 2 else [parabola(t), 0.0]
        assert plant.values(["x.s", "x.v"]) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("short", [1e-14, 1e-11, 1e-9])
def test_very_short_steps_give_no_slopes_of_rounding(short: float) -> None:
    """At 10 s, times are rounded to 2e-15 s, and so are the lengths of steps."""
    plant = gelenk.Simulation(gelenk.load(driven_mass("erk")))
    plant.initialize(10.0, TOLERANCE)
    times = [10.0, 10.01, 10.02, 10.02 + short, 10.03, 10.03 + short, 10.03 + 2 * short, 10.04]
    for t, later in itertools.pairwise(times):
        plant.set_input("pos.s_ref", 1.5 * (t - 10.0))
        plant.step_to(later)
        if t > 10.015:
            assert plant.values(["x.v", "x.s"]) == pytest.approx([1.5, 1.5 * (later - 10.0)], rel=1e-5)


def test_start_velocity_is_that_of_the_first_values() -> None:
    """Of a motion at constant speed: the mass rests relative to the driven end, as the scene starts it."""
    plant = start_of(driven_mass("erk"))
    times = [0.0, 0.01, 0.02, 0.03]
    follow(plant, times, lambda t: 1.5 * t)
    assert plant.values(["x.s", "x.v", "y.s", "y.v"]) == pytest.approx([0.045, 1.5, 0, 0], abs=1e-12)


@pytest.mark.parametrize("first", [0.05, 0.01, 0.02])
def test_a_jump_displaces_and_gives_no_velocity(first: float) -> None:
    """A jump of 0.1 m after rest, before the second step of the run, before the third one, or later."""
    plant = start_of(driven_mass("erk"))
    times = [0.01 * k for k in range(9)]
    texts = []
    for t, later in itertools.pairwise(times):
        plant.set_input("pos.s_ref", 0.0 if t < first - 1e-3 else 0.1)
        plant.step_to(later)
        assert plant.output("x.v") == pytest.approx(0.0, abs=1e-12)
        texts += [(time, text) for time, text in plant.events if "jumped" in text]
    assert plant.output("x.s") == pytest.approx(0.1, abs=1e-15)
    [(time, text)] = texts
    assert time == pytest.approx(first, abs=1e-15)
    assert text.startswith("pos.s_ref has jumped by 0.1 m: ")


def test_a_jump_of_a_moving_drive_leaves_its_velocity() -> None:
    plant = start_of(driven_mass("erk"))
    times = [0.01 * k for k in range(12)]
    speeds = []
    for t, later in itertools.pairwise(times):
        plant.set_input("pos.s_ref", 0.5 * t + (0.2 if t > 0.055 else 0.0))
        plant.step_to(later)
        speeds.append(plant.output("x.v"))
    assert speeds[2:] == pytest.approx([0.5] * len(speeds[2:]), abs=1e-9)


@pytest.mark.parametrize(("ratio", "is_motion"), [(2.99, True), (3.01, False)])
def test_slopes_of_similar_size_are_of_one_motion(ratio: float, is_motion: bool) -> None:
    plant = start_of(driven_mass("erk"))
    values = [0.0, 0.0, 0.01, 0.01 + 0.01 * ratio]
    for k, value in enumerate(values):
        plant.set_input("pos.s_ref", value)
        if k + 1 < len(values):
            plant.step_to(0.1 * (k + 1))
    expected = (3 * ratio - 1) / 2 * 0.1 if is_motion else 0.1
    assert plant.input_derivative("pos.s_ref", 1) == pytest.approx(expected, rel=1e-9)


def test_a_motion_that_begins_stops_and_turns_never_exceeds_its_speed() -> None:
    """Kinks at communication points. Positions are those that were set, speeds between -0.8 and 0.8 m/s."""

    def zigzag(t: float) -> float:
        return float(np.interp(t, [0.05, 0.1, 0.15, 0.2], [0.0, 0.04, 0.0, 0.0]))

    plant = start_of(driven_mass("erk"))
    times = [0.01 * k for k in range(26)]
    for t, later in itertools.pairwise(times):
        plant.set_input("pos.s_ref", zigzag(t))
        plant.step_to(later)
        assert abs(plant.output("x.v")) < 0.8 + 1e-9
    assert not [text for _, text in plant.events if "jumped" in text]


def test_a_value_that_is_not_set_again_stays() -> None:
    """The motion stops at the value set last, whatever the step before has reached."""
    plant = start_of(driven_mass("erk"))
    follow(plant, [0.0, 0.01, 0.02, 0.03], lambda t: 1.5 * t)
    assert plant.output("x.s") == pytest.approx(0.045, abs=1e-12)
    assert plant.input("pos.s_ref") == 0.03
    plant.step_to(0.04)
    assert plant.values(["x.s", "x.v"]) == pytest.approx([0.03, 0.0], abs=1e-15)


def test_derivatives_that_are_set_are_not_estimated() -> None:
    """Also if they are 0, in this step and in those after it in which nothing is set."""
    plant = start_of(driven_mass("erk"))
    follow(plant, [0.0, 0.01, 0.02, 0.03], lambda t: 1.5 * t)
    plant.set_input("pos.s_ref", 0.045)
    plant.set_input_derivative("pos.s_ref", 1, 0.0)
    assert [plant.input_derivative("pos.s_ref", order) for order in range(1, 6)] == [0.0] * 5
    plant.step_to(0.04)
    plant.step_to(0.05)
    assert plant.values(["x.s", "x.v"]) == pytest.approx([0.045, 0.0], abs=1e-15)
    plant.set_input_derivative("pos.s_ref", 1, 2.0)
    plant.set_input("pos.s_ref", 0.05)  # in either order
    plant.step_to(0.06)
    plant.step_to(0.07)  # at the value reached
    assert plant.values(["x.s", "x.v"]) == pytest.approx([0.07, 0.0], abs=1e-15)


def test_a_derivative_at_the_start_is_the_first_slope() -> None:
    """It is known: the motion needs no steps to begin."""
    plant = gelenk.Simulation(gelenk.load(driven_mass("erk")))
    plant.set_input_derivative("pos.s_ref", 1, 1.5)
    plant.initialize(0.0, TOLERANCE)
    for k in range(5):
        plant.set_input("pos.s_ref", 1.5 * 0.01 * k)
        plant.step_to(0.01 * (k + 1))
        found = plant.values(["x.s", "x.v", "y.s", "y.v"])
        assert found == pytest.approx([0.015 * (k + 1), 1.5, 0, 0], abs=1e-12)


def test_speeds_have_accelerations() -> None:
    """Of a prescribed speed, values alone are known. Held speeds err by h in the position of the mass."""
    truth = place_of_mass(swing, swing_rate)
    errors = []
    for h in (1e-2, 1e-3):
        source = driven_mass("erk", input="speed")
        source["joints"]["x"]["start"] = {"s": swing(0.0), "fixed": ["s"]}
        plant = start_of(source, "pos.v_ref", swing_rate(0.0))
        follow(plant, equal_steps(h), swing_rate, "pos.v_ref")
        errors.append(abs(plant.output("x.s") + plant.output("y.s") - truth))
    assert errors[0] / errors[1] > 50, errors


def test_a_speed_that_jumps_is_held() -> None:
    """As a digital controller sets it: the position is the sum of speed times step."""
    plant = start_of(driven_mass("erk", input="speed"), "pos.v_ref")
    speeds = [0.0, 0.0, 0.7, 0.7, 0.7, -0.2, -0.2, 0.0, 0.0]
    for k, speed in enumerate(speeds):
        plant.set_input("pos.v_ref", speed)
        plant.step_to(0.01 * (k + 1))
        assert plant.output("x.v") == pytest.approx(speed, abs=1e-12)
    assert plant.output("x.s") == pytest.approx(0.01 * sum(speeds), abs=1e-12)
