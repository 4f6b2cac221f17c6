# SPDX-License-Identifier: BSD-3-Clause
"""Clutches and brakes: dry friction that an input engages, compared with closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from models.drive_line import ENGAGEMENT, ENGINE, LOAD, SLIDING, STATIC, drive_line
from models.running import assert_close

import gelenk

from .test_joint_friction import FOUR_BAR_PHI, FOUR_BAR_TIMES, FOUR_BAR_W, four_bar_with_friction

INTEGRATORS = ("erk", "cvode", "cvode-adams", "ida", "dirk")
# Exact derivatives: some tens of operations on numbers about 1.
ROUNDING = 1e-13


def lift() -> Scene:
    """A mass of 3 kg that falls along a guide with a brake."""
    return scene(
        {"mass": body(3)},
        {
            "guide": joint(
                "prismatic",
                frame("ground"),
                frame("mass"),
                friction={"coulomb": 60.0, "input": "engagement"},
            )
        },
        gravity=[0, 0, -GRAVITY],
    )


def plant(
    source: Scene, integrator: str = "auto", tolerance: float = 1e-8, **inputs: float
) -> gelenk.Simulation:
    """Return a simulation at its start; `torque__tau` stands for torque.tau."""
    solver = {"integrator": integrator} | ({"step": 1e-3} if integrator == "moreau-jean" else {})
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": solver}))
    for name, value in inputs.items():
        simulation.set_input(name.replace("__", "."), value)
    simulation.initialize(0.0, tolerance)
    return simulation


def engage(simulation: gelenk.Simulation, stop: float) -> None:
    """Run with the clutch released up to 0.1 s, then half engaged."""
    simulation.step_to(0.1)
    simulation.set_input(ENGAGEMENT, 0.5)
    simulation.step_to(stop)


@warned.TIGHT
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_two_shafts_come_to_the_same_speed(integrator: str, tolerance: float) -> None:
    """From -50 rad/s, the slip ends at a constant rate; then both turn with their common momentum."""
    simulation = plant(drive_line(-50), integrator, tolerance)
    rate = 0.5 * SLIDING * (1 / ENGINE + 1 / LOAD)
    locked = 0.1 + 50 / rate
    engage(simulation, 0.1 + 20 / rate)
    assert simulation.output("clutch.friction.mode") == -1
    assert simulation.output("clutch.friction.tau") == pytest.approx(5.0, rel=1e-14)
    assert_close("slip", simulation.output("clutch.w"), -30, 100 * tolerance, "the tolerance")
    simulation.step_to(locked + 1.0)
    assert simulation.output("clutch.friction.mode") == 0
    assert simulation.output("clutch.w") == 0
    common = ENGINE * 50 / (ENGINE + LOAD)
    slid = -50 * 0.1 - 50**2 / (2 * rate)
    assert_close("speed", simulation.output("shaft.w"), common, 100 * tolerance, "the tolerance")
    assert_close("slid", simulation.output("clutch.phi"), slid, 1e4 * tolerance, "of 4600 rad")
    assert simulation.diagnostic("solver.events") == 1


@pytest.mark.parametrize("engagement", [0.3, 1.0, 1.7])
@pytest.mark.parametrize("share", [1 - 1e-6, 1 + 1e-6])
def test_a_locked_clutch_breaks_away_at_its_static_limit(engagement: float, share: float) -> None:
    """The clutch carries LOAD / (ENGINE + LOAD) of the motor's torque."""
    torque = share * engagement * STATIC * (ENGINE + LOAD) / LOAD
    simulation = plant(drive_line(), clutch__friction__engagement=engagement, torque__tau=torque)
    simulation.step_to(0.01)
    carried = simulation.output("clutch.friction.tau")
    if share < 1:
        assert simulation.output("clutch.friction.mode") == 0
        assert simulation.output("clutch.w") == 0
        assert carried == pytest.approx(share * engagement * STATIC, rel=1e-12)
    else:
        assert simulation.output("clutch.friction.mode") == -1
        assert carried == pytest.approx(engagement * SLIDING, rel=1e-12)


@pytest.mark.parametrize("integrator", ["erk", "cvode", "ida", "dirk"])
def test_a_locked_clutch_breaks_away_while_it_is_released(integrator: str) -> None:
    """The engagement falls in proportion to time: slip begins within the communication step."""
    torque = 0.5 * STATIC * (ENGINE + LOAD) / LOAD
    simulation = plant(drive_line(), integrator, 1e-9, clutch__friction__engagement=1.0, torque__tau=torque)
    simulation.set_input_derivative(ENGAGEMENT, 1, -2.0)  # 1 - 2 t
    simulation.step_to(0.4)
    # It slips from 0.25 s on: d slip / dt = friction (1 / ENGINE + 1 / LOAD) - torque / ENGINE.
    t = 0.4 - 0.25
    impulse = SLIDING * (0.5 * t - t**2)
    slip = impulse * (1 / ENGINE + 1 / LOAD) - torque * t / ENGINE
    assert_close("slip", simulation.output("clutch.w"), slip, 1e-7, "100 times the tolerance")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_brake_catches_a_falling_mass(integrator: str) -> None:
    """It falls freely for 0.2 s, brakes, and is held by as much as its weight."""
    simulation = plant(lift(), integrator)
    simulation.step_to(0.2)
    simulation.set_input("guide.friction.engagement", 1.0)
    simulation.step_to(1.0)
    fallen = GRAVITY * 0.2**2 / 2
    braked = (GRAVITY * 0.2) ** 2 / (2 * (60 / 3 - GRAVITY))
    assert_close("s", simulation.output("guide.s"), -(fallen + braked), 1e-6, "100 times the tolerance")
    assert simulation.output("guide.v") == 0
    assert simulation.output("guide.friction.f") == pytest.approx(3 * GRAVITY, rel=1e-12)
    simulation.set_input("guide.friction.engagement", 3 * GRAVITY / 60 * (1 - 1e-9))
    simulation.step_to(1.1)
    assert simulation.output("guide.friction.mode") == -1
    simulation.set_input("guide.friction.engagement", -1.0)  # released: counts as 0
    assert simulation.output("guide.friction.f") == 0
    before = simulation.output("guide.v")
    simulation.step_to(1.3)
    assert_close("v", simulation.output("guide.v") - before, -GRAVITY * 0.2, 1e-7, "the tolerance")


def test_time_stepping_engages_them_too() -> None:
    """Where a constant friction ends within a step, the error of the common speed is that of rounding."""
    slow = plant(drive_line(-50), "moreau-jean")
    engage(slow, 5.0)
    common = ENGINE * 50 / (ENGINE + LOAD)
    assert_close("speed", slow.output("shaft.w"), common, 1e-9, "the residual of impulses")
    assert abs(slow.output("clutch.w")) < 1e-9
    angle = -50 * 0.1 - 50**2 / (2 * 0.5 * SLIDING * (1 / ENGINE + 1 / LOAD))
    # One step of 1 ms in which the slip ends.
    assert_close("slid", slow.output("clutch.phi"), angle, 1e-3 * 50 * 1e-3, "one step")


def test_a_slipping_clutch_has_a_linear_model_with_its_engagement() -> None:
    """Its torque does not depend on the slip, and is proportional to the engagement."""
    found = gelenk.linear.linear_model(gelenk.load(drive_line(-50)), input_values={ENGAGEMENT: 0.5})
    assert found.inputs == ("torque.tau", ENGAGEMENT)
    assert found.states == ("shaft.phi", "clutch.phi", "shaft.w", "clutch.w")
    slopes = np.array([1 / ENGINE, -1 / ENGINE])
    by_clutch = SLIDING * np.array([-1 / ENGINE, 1 / ENGINE + 1 / LOAD])
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1
    B = np.vstack([np.zeros((2, 2)), np.column_stack([slopes, by_clutch])])
    assert_close("A", found.A, A, ROUNDING, "rounding")
    assert_close("B", found.B, B, ROUNDING * 100, "rounding")
    row = found.outputs.index("clutch.friction.tau")
    assert_close("D", found.D[row], [0, SLIDING], ROUNDING * 100, "rounding")


def test_a_locked_clutch_joins_two_inertias() -> None:
    """As long as it is locked, the engagement has no effect."""
    found = gelenk.linear.linear_model(
        gelenk.load(drive_line()), input_values={ENGAGEMENT: 0.5, "torque.tau": 2.0}
    )
    assert found.states == ("shaft.phi", "shaft.w")
    assert_close("B", found.B, [[0, 0], [1 / (ENGINE + LOAD), 0]], ROUNDING, "rounding")


def braked_four_bar() -> Scene:
    """The four-bar with a known solution, with brakes of twice the friction in all joints."""
    source = four_bar_with_friction()
    for each in source["joints"].values():
        each["friction"] = {"coulomb": 2 * each["friction"]["coulomb"], "input": "engagement"}
    return source


@pytest.mark.parametrize("integrator", ["auto", "erk", "ida"])
def test_brakes_in_a_loop_that_are_half_engaged(integrator: str) -> None:
    """One of these joints is cut where the loop is opened."""
    half = {f"{name}__friction__engagement": 0.5 for name in "ABCD"}
    simulation = plant(braked_four_bar(), integrator, 1e-8, **half)
    for time, phi, w in zip(FOUR_BAR_TIMES, FOUR_BAR_PHI, FOUR_BAR_W, strict=True):
        simulation.step_to(time)
        assert_close("A.phi", simulation.output("A.phi"), phi, 1e-6, "100 times the tolerance")
        assert_close("A.w", simulation.output("A.w"), w, 1e-5, "of some 10 rad/s")


def test_brakes_in_a_loop_have_the_derivatives_of_their_engagements() -> None:
    """Accelerations are linear in the engagements, so that their differences are exact up to rounding."""
    source = braked_four_bar()
    names = [f"{name}.friction.engagement" for name in "ABCD"]
    found = gelenk.linear.linear_model(gelenk.load(source), input_values=dict.fromkeys(names, 0.5))
    assert found.inputs == tuple(names)
    row = found.outputs.index("A.a")
    for name, slope in zip(names, found.D[row], strict=True):
        ends = []
        for engagement in (0.25, 0.75):
            values = {key.replace(".", "__"): engagement if key == name else 0.5 for key in names}
            ends.append(plant(source, "erk", 1e-8, **values).output("A.a"))
        assert abs(slope) > 1e-3
        assert_close(name, slope, (ends[1] - ends[0]) / 0.5, 1e-10, "rounding of accelerations of some 100")


def test_engagement_is_the_only_input() -> None:
    source = lift()
    source["joints"]["guide"]["friction"]["input"] = "torque"
    with pytest.raises(
        gelenk.SceneError, match=r"joints\.guide\.friction\.input: found .torque., expected engagement"
    ):
        gelenk.load(source)
