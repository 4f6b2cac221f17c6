# SPDX-License-Identifier: BSD-3-Clause
"""Motors: gear ratio, rotor inertia, and inputs that change during a simulation."""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene
from models.running import assert_close, record, run

import gelenk


def wheel(ratio: float, rotor: float) -> Scene:
    """A wheel of 0.7 kg m2 about a vertical axis, without gravity."""
    return scene(
        {"wheel": body(2.0, (0, 0, 0.3), (0.4, 0.5, 0.7))},
        {"J": joint("revolute", frame("ground"), frame("wheel"), axis=[0, 0, 1])},
        motors={"drive": {"joint": "J", "gear_ratio": ratio, "rotor_inertia": rotor}},
    )


@pytest.mark.parametrize(("ratio", "rotor"), [(1.0, 0.0), (-3.7, 0.0), (12.0, 0.004), (0.5, 0.2)])
def test_geared_motor_accelerates_wheel_and_rotor(ratio: float, rotor: float) -> None:
    """N tau = (I + n^2 I_r) w': the angle is a parabola."""
    found = run(wheel(ratio, rotor), np.linspace(0, 2, 11), tolerance=1e-10, inputs={"drive.tau": 1.3})
    a = ratio * 1.3 / (0.7 + ratio**2 * rotor)
    scale = abs(a)
    assert_close("J.a", found["J.a"], a, 1e-13 * scale, "round-off, some 100 eps")
    assert_close("J.w", found["J.w"], a * found.time, 1e-9 * scale, "rtol; a polynomial of the second degree")
    assert_close("J.phi", found["J.phi"], 0.5 * a * found.time**2, 1e-9 * scale, "as above")


def test_geared_motor_on_a_slider_in_gravity() -> None:
    """N f - m g = (m + n^2 m_r) s''; gravity does not act on the rotor."""
    mass, ratio, rotor, f = 1.9, 6.0, 0.03, 4.4
    source = scene(
        {"b": body(mass, (0.1, 0.2, 0.3), (0.1, 0.1, 0.1))},
        {"J": joint("prismatic", frame("ground"), frame("b"), axis=[0, 0, 1])},
        motors={"drive": {"joint": "J", "gear_ratio": ratio, "rotor_inertia": rotor}},
        gravity=[0, 0, -GRAVITY],
    )
    found = run(source, np.linspace(0, 1, 6), inputs={"drive.f": f})
    a = (ratio * f - mass * GRAVITY) / (mass + ratio**2 * rotor)
    assert_close("J.s", found["J.s"], 0.5 * a * found.time**2, 1e-9, "10 rtol")


@warned.TIGHT
@pytest.mark.parametrize("integrator", ["ida", "erk", "rk4"])
def test_input_may_jump_between_steps(integrator: str) -> None:
    """Torques of +1, -2, +0.5 N m on the wheel alone: w and phi by exact summation."""
    simulation = gelenk.Simulation(gelenk.load({**wheel(1.0, 0.0), "solver": {"integrator": integrator}}))
    simulation.initialize(0.0, 1e-10)
    w = phi = t = 0.0
    for torque, dt in ((1.0, 0.3), (-2.0, 0.5), (0.5, 0.21), (0.0, 1.0)):
        simulation.set_input("drive.tau", torque)
        a = torque / 0.7
        t, phi, w = t + dt, phi + w * dt + 0.5 * a * dt * dt, w + a * dt
        simulation.step_to(t)
        assert_close(
            f"J.w({t:g} s)", simulation.output("J.w"), w, 1e-8, "100 rtol: a jump restarts the integrator"
        )
        assert_close(f"J.phi({t:g} s)", simulation.output("J.phi"), phi, 1e-8, "100 rtol")
        assert_close("J.a", simulation.output("J.a"), a, 1e-12, "round-off; the input of the last step")


def test_accelerations_follow_the_input_immediately() -> None:
    """Outputs read after set_input and before a step reflect the new torque (direct feedthrough)."""
    simulation = gelenk.Simulation(gelenk.load(wheel(2.0, 0.01)))
    simulation.initialize()
    for torque in (3.0, -1.5):
        simulation.set_input("drive.tau", torque)
        assert_close("J.a", simulation.output("J.a"), 2 * torque / 0.74, 1e-13, "round-off")


def test_motor_in_a_loop_equals_a_torque_on_the_crank() -> None:
    """The ground carries the reaction torque, so a motor at the ground pin is a pure torque on the crank."""
    times = np.linspace(0, 2, 21)
    by_motor = run(four_bar(), times, tolerance=1e-11, inputs={"drive.tau": 3.0})
    by_wrench = run(four_bar(torque=3.0), times, tolerance=1e-11)
    for name in ("A.phi", "B.phi", "C.phi", "D.phi", "A.a"):
        assert_close(
            name, by_motor[name], by_wrench[name], 1e-8 if name != "A.a" else 1e-6, "two runs at 1e-11"
        )


def test_motor_between_two_bodies_accelerates_both() -> None:
    """Between two wheels on one axle, with no reaction torque on the ground: I1 w1 + I2 w2 remains zero."""
    source = scene(
        {"a": body(1.0, (0, 0, 0), (0.3, 0.3, 0.5)), "b": body(1.0, (0, 0, 0), (0.2, 0.2, 0.3))},
        {
            "A": joint("revolute", frame("ground"), frame("a"), axis=[0, 0, 1]),
            "B": joint("revolute", frame("a"), frame("b"), axis=[0, 0, 1]),
        },
        motors={"drive": {"joint": "B"}},
    )
    found = run(source, np.linspace(0, 2, 11), inputs={"drive.tau": 0.6})
    wa, wb = found["A.w"], found["A.w"] + found["B.w"]
    assert_close("momentum", 0.5 * wa + 0.3 * wb, 0, 1e-9, "10 rtol")
    assert_close("B.w", found["B.w"], 0.6 * (1 / 0.5 + 1 / 0.3) * found.time, 1e-8, "10 rtol of 6.4 rad/s")


def test_reading_outputs_between_steps_does_not_change_the_run() -> None:
    """Continuing from the current state gives the same result as one run, for any outputs read in between."""
    simulation = gelenk.Simulation(gelenk.load(four_bar()))
    simulation.initialize(0.0, 1e-11)
    simulation.set_input("drive.tau", 3.0)
    found = record(simulation, np.linspace(0, 1, 11))
    coarse = run(four_bar(), [0.0, 1.0], tolerance=1e-11, inputs={"drive.tau": 3.0})
    assert_close("A.phi", found["A.phi"][-1], coarse["A.phi"][-1], 1e-9, "100 rtol")
