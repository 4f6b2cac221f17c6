# SPDX-License-Identifier: BSD-3-Clause
"""Outputs of friction and limits: their forces and modes, and what is counted."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from models.running import assert_close

import gelenk

from .test_joint_friction import four_bar_with_friction, plant, read, wheel

ROUNDING = 1e-12  # some hundred operations


def locked_four_bar() -> Scene:
    """The four-bar at rest without gravity, held by the friction of its joints, with a motor at the crank."""
    source = four_bar_with_friction()
    del source["gravity"]
    source["joints"]["A"]["start"]["w"] = 0.0
    source["motors"] = {"drive": {"joint": "A"}}
    return source


def virtual_speeds() -> np.ndarray:
    """Speeds of A, B, C, D when the crank of the four-bar turns at 1 rad/s."""
    source = four_bar_with_friction()
    source["joints"]["A"]["start"]["w"] = 1.0
    simulation = plant(source)
    return np.array([read(simulation, f"{name}.w") for name in "ABCD"])


@pytest.mark.parametrize("turned", [False, True], ids=["as drawn", "parent and child exchanged"])
def test_friction_of_a_wheel(turned: bool) -> None:
    """At rest it balances the motor; in motion it follows Stribeck's curve."""
    source = wheel({"coulomb": 1.5, "static": 2.0, "stribeck": 0.5}, phi=0.0, w=0.0)
    if turned:
        J = source["joints"]["J"]
        J["parent"], J["child"] = J["child"], J["parent"]
    simulation = plant(source, drive__tau=1.2)
    assert (read(simulation, "J.friction.tau"), read(simulation, "J.friction.mode")) == (-1.2, 0)
    simulation.set_input("drive.tau", -1.7)
    assert_close("tau", read(simulation, "J.friction.tau"), 1.7, ROUNDING, "rounding")
    simulation.set_input("drive.tau", -4.0)
    assert (read(simulation, "J.friction.tau"), read(simulation, "J.friction.mode")) == (2.0, -1)
    simulation.step_to(0.2)
    w = read(simulation, "J.w")
    assert w < -0.5
    expected = 1.5 + 0.5 * math.exp(-((w / 0.5) ** 2))
    assert_close("tau", read(simulation, "J.friction.tau"), expected, ROUNDING, "rounding")


def test_power_of_friction_in_all_joints_of_a_loop() -> None:
    """The rate of the energy is the power of friction, cut joints included."""
    source = four_bar_with_friction()
    simulation = plant(source, tolerance=1e-12)
    energy, h = {}, 1e-4
    for k in range(-1, 2):
        simulation.step_to(0.3 + k * h)
        energy[k] = simulation.diagnostic("energy.total")
        if k == 0:
            power = sum(read(simulation, f"{n}.friction.tau") * read(simulation, f"{n}.w") for n in "ABCD")
            modes = [read(simulation, f"{n}.friction.mode") * read(simulation, f"{n}.w") for n in "ABCD"]
    assert min(modes) > 0.1  # all slip, each in the direction of its speed
    # The central difference has an error of h^2 / 6 times the third derivative, some 1e4 J/s^3.
    assert_close("power", (energy[1] - energy[-1]) / (2 * h), power, 3e-5, "h^2 / 6 times 1e4")


@pytest.mark.parametrize("share", [0.3, -0.999])
def test_redundant_joints_share_the_load(share: float) -> None:
    """Of a loop that four joints hold, every one uses the same part of its limit."""
    speeds = virtual_speeds()
    limits = np.array([0.4, 0.3, 0.5, 0.2])
    capacity = limits @ np.abs(speeds)  # the largest torque that they hold: virtual work
    simulation = plant(locked_four_bar(), drive__tau=float(share * capacity))
    tau = np.array([read(simulation, f"{name}.friction.tau") for name in "ABCD"])
    assert_close("shares", np.abs(tau) / limits, abs(share), 1e-9, "bisection of the load factor")
    assert_close("virtual work", tau @ speeds, -share * capacity, 1e-9, "the same")
    assert all(read(simulation, f"{name}.friction.mode") == 0 for name in "ABCD")
    simulation.step_to(1.0)
    assert read(simulation, "A.w") == 0
    simulation.set_input("drive.tau", math.copysign(1.001 * capacity, share))
    assert read(simulation, "A.friction.mode") == math.copysign(1, share)


def with_reactions(source: Scene) -> Scene:
    """The same with the reactions of three joints as outputs; the fourth then has no friction."""
    del source["joints"]["D"]["friction"]
    source["sensors"] = {f"R{name}": {"type": "reaction", "joint": name} for name in "ABC"}
    return source


def test_reactions_contain_the_friction_that_is_shown() -> None:
    """Constraint forces follow the distribution among joints that hold redundantly."""
    speeds, limits = virtual_speeds()[:3], np.array([0.4, 0.3, 0.5])
    simulation = plant(with_reactions(locked_four_bar()), drive__tau=float(0.6 * (limits @ np.abs(speeds))))
    tau = np.array([read(simulation, f"{name}.friction.tau") for name in "ABC"])
    assert_close("shares", np.abs(tau) / limits, 0.6, 1e-9, "bisection of the load factor")
    about_axis = np.array([-read(simulation, f"R{name}.t[2]") for name in "ABC"])  # axes are -y of frame F
    about_axis[0] -= simulation.input("drive.tau")  # of the motor of A
    assert_close("reactions", about_axis, tau, 1e-9, "the same")


def test_force_of_a_limit() -> None:
    """A pendulum that rests on its limit; friction takes no part in what presses on it."""
    source = scene(
        {"arm": body(2.0, com=(0.5, 0, 0), inertia=(0, 0.1, 0.1))},
        {
            "J": joint(
                "revolute", frame("ground"), frame("arm"), axis=[0, 1, 0],
                friction={"coulomb": 3.0}, limit={"lower": -1.0, "upper": 0.3},
                start={"phi": 0.3, "w": 0.0, "fixed": True},
            )
        },
        motors={"drive": {"joint": "J"}},
        gravity=[0, 0, -GRAVITY],
    )  # fmt: skip
    weight = 2.0 * GRAVITY * 0.5 * math.cos(0.3)  # turns the arm in the positive direction
    simulation = plant(source)
    assert_close("tau", read(simulation, "J.limit.tau"), -weight, ROUNDING, "rounding")
    assert (read(simulation, "J.limit.mode"), read(simulation, "J.friction.tau")) == (1, 0)
    simulation.set_input("drive.tau", -weight - 1.0)  # pulled away by less than friction holds
    assert read(simulation, "J.limit.tau") == 0
    assert_close("tau", read(simulation, "J.friction.tau"), 1.0, ROUNDING * weight, "rounding")
    assert read(simulation, "J.friction.mode") == 0
    simulation.set_input("drive.tau", -weight - 4.0)
    simulation.step_to(0.01)
    assert (read(simulation, "J.limit.mode"), read(simulation, "J.limit.tau")) == (0, 0)
    assert (read(simulation, "J.friction.mode"), read(simulation, "J.friction.tau")) == (-1, 3.0)


def bouncing_ball() -> Scene:
    return scene(
        {"ball": body(1.0)},
        {
            "z": joint(
                "prismatic", frame("ground"), frame("ball"), axis=[0, 0, 1],
                limit={"lower": 0.0, "restitution": 0.5}, start={"s": 1.0, "v": 0.0, "fixed": True},
            )
        },
        gravity=[0, 0, -GRAVITY],
    )  # fmt: skip


def test_impacts_and_series_are_counted() -> None:
    """The ball rests after 3 fall times; the rebounds are lower by a factor 4 each, down to 2e-12 m."""
    simulation = plant(bouncing_ball())
    simulation.step_to(2.0)
    impacts = math.ceil(math.log(2e-12) / math.log(0.25))
    assert simulation.diagnostic("solver.impacts") == impacts
    assert simulation.diagnostic("solver.zeno") == 1
    assert simulation.diagnostic("solver.ambiguous") == 0
    assert_close("f", read(simulation, "z.limit.f"), GRAVITY, ROUNDING, "rounding")


def test_reading_does_not_change_the_run() -> None:
    states = []
    for reads in (False, True):
        simulation = plant(locked_four_bar())
        for k in range(1, 30):
            simulation.set_input("drive.tau", 3.0 * math.sin(k))
            if reads:
                [float(simulation.output(signal.name)) for signal in simulation.outputs]
            simulation.step_to(0.05 * k)
        states.append([read(simulation, "A.phi"), read(simulation, "A.w")])
    assert states[0] == states[1]


def difference(source: Scene, torque: float, names: tuple[str, ...]) -> list[float]:
    """Change of outputs per torque of the motor."""
    h = 1e-3
    ends = [plant(source, drive__tau=torque + sign * h) for sign in (1, -1)]
    above, below = (np.array([read(end, name) for name in names]) for end in ends)
    return list((above - below) / (2 * h))


def test_derivatives_of_forces() -> None:
    """At rest friction balances the motor; in motion it depends on the speed."""
    names = ("J.friction.tau", "J.friction.mode")
    source = wheel({"coulomb": 1.5, "static": 2.0, "stribeck": 0.5}, phi=0.0, w=0.0)
    at_rest = gelenk.linear.linear_model(
        gelenk.load(source), outputs=names, input_values={"drive.tau": 1.0}, states=["J.phi"]
    )
    assert_close("D", at_rest.D[:, 0], difference(source, 1.0, names), 1e-10, "rounding over h")
    assert_close("D", at_rest.D[:, 0], [-1.0, 0.0], ROUNDING, "rounding")
    source["joints"]["J"]["start"]["w"] = -0.4
    slipping = gelenk.linear.linear_model(gelenk.load(source), outputs=names)
    slope = 0.5 * 2 * 0.4 / 0.5**2 * math.exp(-((0.4 / 0.5) ** 2))
    assert_close("C", slipping.C, [[0, slope], [0, 0]], ROUNDING, "rounding")
    off = gelenk.linear.linear_model(gelenk.load(source), outputs=names, friction="off")
    assert not off.C.any()


def test_forces_that_hold_redundantly_have_no_derivatives(tmp_path: Path) -> None:
    """They are left out of linear models, and an FMU discards them, while others remain."""
    source = with_reactions(locked_four_bar())
    fmu = gelenk.export_fmu(gelenk.load(source), tmp_path / "Locked.fmu")
    for mechanism in (gelenk.load(source), fmu):
        found = gelenk.linear.linear_model(mechanism, input_values={"drive.tau": 0.5})
        assert "A.a" in found.outputs
        assert not {"A.friction.tau", "C.friction.tau", "RC.t[2]"} & set(found.outputs)
        with pytest.raises(gelenk.UsageError, match=r"A.friction.tau: found no derivatives, since friction"):
            gelenk.linear.linear_model(mechanism, outputs=["A.friction.tau"])


def test_an_fmu_shows_forces_and_modes(tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(gelenk.load(bouncing_ball()), tmp_path / "Ball.fmu")
    result = gelenk.simulate(fmu, stop=2.0, step=0.25)
    assert_close("f", result["z.limit.f"][-1], GRAVITY, ROUNDING, "rounding")
    assert result["z.limit.mode"].tolist() == [0] * 6 + [-1] * 3  # at rest from 3 sqrt(2 / g) = 1.35 s on
