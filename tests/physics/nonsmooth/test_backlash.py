# SPDX-License-Identifier: BSD-3-Clause
"""Backlash: the play of a gear wheel on its shaft, a joint with hard limits; closed forms."""

from __future__ import annotations

import math

import pytest
from mechanisms import Scene, body, frame, joint, scene
from models.running import assert_close

import gelenk

MOTOR, WHEEL, LOAD = 0.1, 0.02, 3.0  # kg m2
RATIO, PLAY, TORQUE = -0.25, 0.03, 2.0  # 1, rad, N m
REST = WHEEL + RATIO**2 * LOAD  # behind the play, seen at the wheel


def geared(restitution: float) -> Scene:
    """A motor, a wheel on its shaft with a play of +-PLAY, and a load that meshes with the wheel."""
    limit = {"lower": -PLAY, "upper": PLAY, "restitution": restitution}
    return scene(
        {
            "motor": body(1, inertia=(0, 0, MOTOR)),
            "wheel": body(1, inertia=(0, 0, WHEEL)),
            "load": body(1, inertia=(0, 0, LOAD)),
        },
        {
            "in": joint("revolute", frame("ground"), frame("motor"), start={"phi": 0.0, "w": 0.0}),
            "axle": joint("revolute", frame("ground"), frame("wheel"), start={"phi": 0.0, "w": 0.0}),
            "out": joint("revolute", frame("ground", (0.5, 0, 0)), frame("load"), start={"phi": 0.0}),
            "play": joint("revolute", frame("motor"), frame("wheel"), limit=limit),
        },
        motors={"drive": {"joint": "in"}},
        constraints={"mesh": {"type": "gear", "joint": "out", "with": "axle", "ratio": RATIO}},
    )


@pytest.mark.parametrize("integrator", ["erk", "cvode", "ida", "dirk"])
@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_the_play_is_taken_up(restitution: float, integrator: str) -> None:
    """The motor is alone until it strikes; momentum is conserved; impacts end after a geometric series."""
    simulation = gelenk.Simulation({**geared(restitution), "solver": {"integrator": integrator}})
    simulation.set_input("drive.tau", TORQUE)
    simulation.initialize(0.0, 1e-9)
    strikes = math.sqrt(2 * PLAY * MOTOR / TORQUE)
    simulation.step_to(0.9 * strikes)
    assert simulation.output("axle.w") == 0
    assert_close("in.w", simulation.output("in.w"), 0.9 * TORQUE / MOTOR * strikes, 1e-7, "the tolerance")
    before = TORQUE / MOTOR * strikes
    rate = TORQUE / MOTOR  # of the gap, between impacts: the wheel is not driven
    flights = 2 * before * restitution / rate / (1 - restitution)  # together
    simulation.step_to(strikes * 1.0001)
    # Just after the first impact.
    common = MOTOR * before / (MOTOR + REST)
    wheel = common * (1 + restitution)
    if restitution == 0:
        wheel += TORQUE / (MOTOR + REST) * 0.0001 * strikes  # in contact, the wheel is driven
    assert_close("axle.w", simulation.output("axle.w"), wheel, 1e-6, "the tolerance")
    end = strikes + flights + 0.5
    simulation.step_to(end)
    assert simulation.output("play.limit.mode") == -1
    total = TORQUE * end / (MOTOR + REST)
    assert_close("in.w", simulation.output("in.w"), total, 1e-7, "momentum is conserved")
    assert_close("out.w", simulation.output("out.w"), RATIO * total, 1e-7, "the gear")
    assert simulation.output("play.limit.tau") == pytest.approx(TORQUE * REST / (MOTOR + REST), rel=1e-9)


def test_without_torque_the_play_is_free() -> None:
    """Reversed, the motor turns through the whole play before it strikes on the other side."""
    simulation = gelenk.Simulation(geared(0.0))
    simulation.set_input("drive.tau", TORQUE)
    simulation.initialize(0.0, 1e-9)
    simulation.step_to(0.5)
    simulation.set_input("drive.tau", -TORQUE)
    crossing = math.sqrt(2 * 2 * PLAY * MOTOR / TORQUE)
    simulation.step_to(0.5 + 0.99 * crossing)
    assert simulation.output("play.limit.mode") == 0
    simulation.step_to(0.5 + 1.01 * crossing)
    assert simulation.output("play.limit.mode") == 1
