# SPDX-License-Identifier: BSD-3-Clause
"""Dry friction in joints: sticking, slipping and reversals,
compared with closed forms and with a published problem.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, rod, scene
from models.running import assert_close

import gelenk

INTEGRATORS = ("auto", "erk", "cvode", "cvode-adams", "ida", "dirk")


def plant(
    source: Scene, tolerance: float = 1e-8, integrator: str = "auto", **inputs: float
) -> gelenk.Simulation:
    """Return a simulation at its start; `drive__tau` stands for drive.tau."""
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": {"integrator": integrator}}))
    for name, value in inputs.items():
        simulation.set_input(name.replace("__", "."), value)
    simulation.initialize(0.0, tolerance)
    return simulation


def read(simulation: gelenk.Simulation, name: str) -> float:
    """Return the present value of an output."""
    return float(simulation.output(name))


def wheel(friction: dict[str, float], inertia: float = 0.5, **start: float) -> Scene:
    """A wheel with a motor about a fixed axis."""
    return scene(
        {"wheel": body(1.0, inertia=(0, 0, inertia))},
        {
            "J": joint(
                "revolute", frame("ground"), frame("wheel"), friction=friction, start={**start, "fixed": True}
            )
        },
        motors={"drive": {"joint": "J"}},
    )


def test_wheel_sticks_breaks_away_and_stops() -> None:
    """Closed form: at rest up to 2 N m; then 1.5 N m against the motion."""
    source = wheel({"coulomb": 1.5, "static": 2.0}, phi=0.3, w=0.0)
    simulation = plant(source, drive__tau=1.99)
    for k in range(100):
        simulation.step_to(0.01 * (k + 1))
    assert read(simulation, "J.phi") == 0.3
    assert read(simulation, "J.w") == 0  # exactly: no creep
    simulation.set_input("drive.tau", 2.01)
    assert_close("J.a", read(simulation, "J.a"), 0.51 / 0.5, 1e-12, "one division")
    simulation.step_to(2.0)
    assert_close("J.w", read(simulation, "J.w"), 0.51 / 0.5, 1e-7, "10 times the tolerance")
    simulation.set_input("drive.tau", 1.0)  # slower by 1 rad/s2: at rest after 1.02 s
    simulation.step_to(3.01)
    assert_close("J.w", read(simulation, "J.w"), 0.01, 1e-7, "10 times the tolerance")
    simulation.step_to(4.0)
    assert read(simulation, "J.w") == 0
    assert_close("J.phi", read(simulation, "J.phi"), 0.3 + 0.51 + 1.02**2 / 2, 1e-7, "10 times the tolerance")
    assert simulation.diagnostic("solver.events") == 2


@warned.TIGHT
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_clutch_locks_and_breaks_away(integrator: str, tolerance: float) -> None:
    """Two inertias and friction between them: it slips, locks, and breaks away
    when the torque that it would have to carry exceeds its static limit.
    """
    inertia_1, inertia_2, load, sliding, static = 0.5, 2.0, -10.0, 80.0, 96.0
    axis = [0, 0, 1]
    source = scene(
        {"one": body(1, inertia=(0, 0, inertia_1)), "two": body(1, inertia=(0, 0, inertia_2))},
        {
            "one": joint(
                "revolute", frame("ground"), frame("one"), start={"w": 120.0, "fixed": True}, axis=axis
            ),
            "clutch": joint(
                "revolute",
                frame("one"),
                frame("two"),
                start={"w": -122.5, "fixed": True},
                friction={"coulomb": sliding, "static": static},
                axis=axis,
            ),
        },
        motors={"engine": {"joint": "one"}},
        forces={"load": {"type": "wrench", "body": "two", "torque": [0, 0, load]}},
        sensors={"S": {"type": "frame", "body": "two"}},
    )
    simulation = plant(source, tolerance, integrator, engine__tau=20.0)
    lock = 122.5 / (sliding / inertia_1 - 20 / inertia_1 + (sliding + load) / inertia_2)
    simulation.step_to(lock - 0.01)
    assert read(simulation, "clutch.w") < 0
    simulation.step_to(2.5)
    assert read(simulation, "clutch.w") == 0
    both = -2.5 + (sliding + load) / inertia_2 * lock + (20 + load) / (inertia_1 + inertia_2) * (2.5 - lock)
    # in multiples of the tolerance; speeds of 100 rad/s, whose errors are relative
    assert_close("one.w", read(simulation, "one.w"), both, 100 * 100 * tolerance, "100 times the tolerance")
    simulation.set_input("engine.tau", 130.0)
    simulation.step_to(3.5)
    slip = (130 - sliding) / inertia_1 - (sliding + load) / inertia_2
    assert_close(
        "clutch.w", read(simulation, "clutch.w"), -slip, 100 * 100 * tolerance, "100 times the tolerance"
    )
    assert simulation.diagnostic("solver.events") == 2


def four_bar_with_friction() -> Scene:
    """Slender bars of 2 kg/m in the vertical plane, dry friction in all joints, at rest but for the crank."""

    def turning(
        parent: dict[str, Any], child: dict[str, Any], coulomb: float, **fields: Any
    ) -> dict[str, Any]:
        return joint("revolute", parent, child, axis=[0, -1, 0], friction={"coulomb": coulomb}, **fields)

    start = {"phi": math.pi / 2, "w": 8.0, "fixed": True}
    return scene(
        {"crank": rod(1, 0.5), "coupler": rod(3.5, 1.75), "rocker": rod(3, 1.5)},
        {
            "A": turning(frame("ground"), frame("crank"), 0.4, start=start),
            "B": turning(frame("crank", (0.5, 0, 0)), frame("coupler"), 0.3),
            "C": turning(frame("coupler", (1.75, 0, 0)), frame("rocker", (1.5, 0, 0)), 0.5),
            "D": turning(frame("ground", (2, 0, 0)), frame("rocker"), 0.2, start={"phi": 1.9}),
        },
        gravity=[0, 0, -GRAVITY],
    )


# Crank angle and speed by event-driven extrapolation in 80-bit arithmetic, with the energy balanced to
# 2e-14 J and checked by another integrator; their own error is below 2e-13.
FOUR_BAR_TIMES = (0.5, 1.0, 2.0, 4.0, 6.0)
FOUR_BAR_PHI = (
    6.974484436417667,
    12.097955627078191,
    20.79950242974041,
    34.95853316514847,
    33.61464192001791,
)
FOUR_BAR_W = (
    12.783665850683787,
    7.750889264557118,
    5.6443741983266325,
    11.881762550552065,
    -1.9157133271062738,
)
FOUR_BAR_REVERSALS = 32  # of single joints, four of them at one instant, when the whole four-bar stops


@warned.TIGHT
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_four_bar_with_friction_in_all_joints(integrator: str, tolerance: float) -> None:
    simulation = plant(four_bar_with_friction(), tolerance, integrator)
    found = []
    for t in FOUR_BAR_TIMES:
        simulation.step_to(t)
        found.append((read(simulation, "A.phi"), read(simulation, "A.w")))
    phi, w = np.array(found).T
    # Multiples of the tolerance: 1 to 75 measured for phi, 8 to 520 for w (up to 18 rad/s), which grow
    # sevenfold over the 6 s; ida at 1e-10 is limited by rounding.
    assert_close("A.phi", phi, FOUR_BAR_PHI, 300 * tolerance, "see above")
    assert_close("A.w", w, FOUR_BAR_W, 2000 * tolerance, "see above")
    assert simulation.diagnostic("solver.events") == FOUR_BAR_REVERSALS


@pytest.mark.parametrize("time", [0.05, 0.5, 1.6])
def test_restored_run_continues_with_the_same_bits(time: float) -> None:
    """In mid-slip, just after it begins, and at rest."""
    first = plant(wheel({"coulomb": 1.0, "static": 1.2, "stribeck": 0.1}, w=1.0), drive__tau=0.0)
    first.step_to(time)
    saved = first.save()
    second = plant(wheel({"coulomb": 1.0, "static": 1.2, "stribeck": 0.1}, w=1.0), drive__tau=0.0)
    second.restore(saved)
    for simulation in (first, second):
        simulation.set_input("drive.tau", 1.1)
        simulation.step_to(time + 0.3)
        simulation.set_input("drive.tau", -1.3)
        simulation.step_to(time + 1.0)
    assert list(first.values()) == list(second.values())


def test_reading_outputs_does_not_change_the_run() -> None:
    """A torque that would break the wheel away is set, outputs are read, and it is removed again."""
    first, second = (plant(wheel({"coulomb": 1.0}, phi=0.0, w=0.0), drive__tau=0.0) for _ in range(2))
    first.set_input("drive.tau", 5.0)
    assert read(first, "J.a") == pytest.approx(8.0, abs=1e-12)
    first.set_input("drive.tau", 0.5)
    second.set_input("drive.tau", 0.5)
    for simulation in (first, second):
        simulation.step_to(1.0)
    assert list(first.values()) == list(second.values())
    assert read(first, "J.w") == 0


def test_other_formulations_refuse() -> None:
    source = {**wheel({"coulomb": 1.0}), "solver": {"formulation": "index3", "integrator": "ida"}}
    with pytest.raises(
        gelenk.SceneError, match=r"solver.formulation: found 'index3' with joints.J.friction, expected"
    ):
        gelenk.load(source)


def test_static_friction_below_sliding_friction_is_refused() -> None:
    with pytest.raises(
        gelenk.SceneError, match=r"joints.J.friction.static: found 0.5 N m, expected at least coulomb"
    ):
        gelenk.load(wheel({"coulomb": 1.0, "static": 0.5}))


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("static", "speed"), [(1.0, -0.1), (2.0, 0.0)])
def test_speed_that_is_zero_at_a_communication_point(integrator: str, static: float, speed: float) -> None:
    """The wheel stops at 0.2 s, where a step ends; it turns back, or static friction holds it."""
    source = wheel({"coulomb": 1.0, "static": static}, phi=0.3, w=1.0)
    simulation = plant(source, 1e-8, integrator, drive__tau=-1.5)
    for t in (0.1, 0.2, 0.3):
        simulation.step_to(t)
    assert_close("J.w", read(simulation, "J.w"), speed, 1e-8, "the tolerance")
    assert simulation.diagnostic("solver.events") == 1


def test_stopped_slowly_it_does_not_creep() -> None:
    """Rest is exact, even if it is found from a speed of rounding at a change of the torque."""
    simulation = plant(wheel({"coulomb": 1.0}, phi=0.0, w=5e-13), drive__tau=0.1)
    simulation.step_to(0.1)
    simulation.set_input("drive.tau", 0.2)
    simulation.step_to(0.2)
    position = read(simulation, "J.phi")
    simulation.step_to(3600.0)
    assert read(simulation, "J.w") == 0
    assert read(simulation, "J.phi") == position


@pytest.mark.parametrize("integrator", ["auto", "cvode", "ida", "erk", "rk4"])
def test_inputs_set_to_other_values_and_back_have_not_jumped(integrator: str) -> None:
    """A master tries other inputs, reads outputs, and goes on with the former ones: every bit is the same."""
    source = wheel({"coulomb": 1.0, "stribeck": 0.1, "static": 1.5}, phi=0.0, w=2.0)
    source["joints"]["J"] |= {"stiffness": 3.0}
    first, second = (plant(source, 1e-8, integrator, drive__tau=0.5) for _ in range(2))
    for k in range(1, 41):
        for simulation in (first, second):
            simulation.step_to(0.05 * k)
        first.set_input("drive.tau", 50.0)
        assert read(first, "J.a") > 10
        first.set_input("drive.tau", 0.5)
    assert list(first.values()) == list(second.values())
    assert first.diagnostic("solver.steps") == second.diagnostic("solver.steps")
