# SPDX-License-Identifier: BSD-3-Clause
"""One-way clutches, gears with losses, clutches and brakes, as in examples of the Modelica Standard Library.

Rotational.Examples: OneWayClutch, OneWayClutchDisengaged, LossyGearDemo1, LossyGearDemo2, LossyGearDemo3,
Friction; with their numbers, but inputs that are linear within segments.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from mechanisms import Array, Scene, frame, joint
from models.drive_cases import INTEGRATORS, Case, backstop, different, run, shafts, truth_of, turning
from models.drive_elements import Friction, LossyGear, OneWay
from models.drive_trains import DriveTrain
from models.running import assert_close

import gelenk


def freewheel(friction: dict[str, Any] | None = None, load: float = 0.0) -> Scene:
    clutch: dict[str, Any] = {"one_way": {"free": "positive"}}
    if friction:
        clutch["friction"] = friction
    return shafts(
        {"first": 1.0, "second": 1.0},
        {"first": turning("ground", "first", -0.5), "clutch": turning("first", "second", 0.5, **clutch)},
        motors={"torque": {"joint": "first"}},
        forces={"load": {"type": "wrench", "body": "second", "torque": [0.0, 0.0, load]}},
    )


def one_way_case(*, engages: bool) -> Case:
    def given(t: float) -> Array:
        pulse = 1.0 if (t - 0.3) % 1.3 < 0.65 and t > 0.29 else 0.0
        if engages:
            return np.array([10 * math.sin(2 * math.pi * 3 * t), 0.0, pulse])
        return np.array([10 * math.sin(2 * math.pi * 2 * t) + 0.3, -0.3, 0.0])

    relative = np.array([-1.0, 1.0])
    clutch = OneWay(relative, lambda u: 1.5 * u[2], lambda u: 37.5 * u[2])
    inputs = {"torque.tau": 0}
    friction = {"coulomb": 1.5, "static": 37.5, "input": "engagement"} if engages else None
    if engages:
        inputs["clutch.friction.engagement"] = 2
    return Case(
        freewheel(friction, 0.0 if engages else -0.3),
        inputs,
        given,
        0.05,
        40,
        np.array([-0.5, 0.0]),
        lambda: DriveTrain(np.array([1.0, 1.0]), lambda u, _phi, _w: u[:2], [clutch]),
        lambda s: np.array([s.output("first.w"), s.output("first.w") + s.output("clutch.w")]),
    )


def geared(J1: float, J2: float, ratio: float, w: float, bearing: float, **mesh: float) -> Scene:
    return shafts(
        {"first": J1, "second": J2},
        {
            "first": turning("ground", "first", w, friction={"coulomb": bearing}),
            "second": turning("ground", "second", w / ratio),
        },
        constraints={"mesh": {"type": "gear", "joint": "first", "with": "second", "ratio": ratio, **mesh}},
        motors={"drive": {"joint": "first"}, "load": {"joint": "second"}},
    )


def gear_case(
    J1: float, J2: float, ratio: float, w: float, bearing: float, given: Callable[[float], Array]
) -> Callable[[float, float], Case]:
    def case(driving: float, driven: float) -> Case:
        return Case(
            geared(J1, J2, ratio, w, bearing, efficiency=driving, backdriving=driven),
            {"drive.tau": 0, "load.tau": 1},
            given,
            0.02,
            25,
            np.array([w, w / ratio]),
            lambda: DriveTrain(
                np.array([J1, J2]),
                lambda u, _phi, _w: u[:2],
                [LossyGear(0, 1, ratio, driving, driven, bearing)],
            ),
            lambda s: np.array([s.output("first.w"), s.output("second.w")]),
        )

    return case


def sine_against_ramp(t: float) -> Array:
    return np.array([10 * math.sin(2 * math.pi * t), -10 + 2.5 * t])


def step_at_half(t: float) -> Array:
    return np.array([0.0, 1.0 if t > 0.25 else 0.0])


def brake_case() -> Case:
    """Rotational.Examples.Friction: a clutch, a spring and a brake in a row."""
    source = shafts(
        {"motor": 1.0, "middle": 0.05, "wheel": 1.0},
        {
            "motor": turning("ground", "motor", 100.0),
            "clutch": turning("motor", "middle", -10.0, friction={"coulomb": 80.0}),
            "wheel": turning("ground", "wheel", 90.0, friction={"coulomb": 800.0, "input": "engagement"}),
            "spring": joint("revolute", frame("middle"), frame("wheel"), stiffness=160.0, damping=1.0),
        },
        motors={"drive": {"joint": "motor"}},
    )

    def given(t: float) -> Array:
        return np.array([200 * math.sin(100 * t) if t < 0.5 else 0.0, 1.0 if t >= 0.5 else 0.0])

    def torques(u: Array, phi: Array, w: Array) -> Array:
        spring = 160 * (phi[1] - phi[2]) + (w[1] - w[2])
        return np.array([u[0], -spring, spring])

    return Case(
        source,
        {"drive.tau": 0, "wheel.friction.engagement": 1},
        given,
        0.01,
        100,
        np.array([100.0, 90.0, 90.0]),
        lambda: DriveTrain(
            np.array([1.0, 0.05, 1.0]),
            torques,
            [
                Friction(np.array([-1.0, 1.0, 0.0]), lambda _u: 80.0, lambda _u: 80.0),
                Friction(np.array([0.0, 0.0, 1.0]), lambda u: 800 * u[1], lambda u: 800 * u[1]),
            ],
        ),
        lambda s: np.array([
            s.output("motor.w"),
            s.output("motor.w") + s.output("clutch.w"),
            s.output("wheel.w"),
        ]),
    )  # fmt: skip


CASES: dict[str, Callable[[], Case]] = {
    "OneWayClutch": lambda: one_way_case(engages=True),
    "OneWayClutchDisengaged": lambda: one_way_case(engages=False),
    "LossyGearDemo1": lambda: gear_case(1.0, 1.5, 2.0, 0.0, 0.0, sine_against_ramp)(0.5, 0.5),
    "LossyGearDemo2": lambda: gear_case(1.0, 1.5, 2.0, 0.0, 0.5, sine_against_ramp)(0.5, 0.5),
    "LossyGearDemo3": lambda: gear_case(0.001, 0.001, 1.0, 10.0, 0.625, step_at_half)(0.25, 0.25),
    "self-locking": lambda: gear_case(1.0, 1.5, 2.0, 0.0, 0.1, sine_against_ramp)(0.4, -0.2),
    "Friction": brake_case,
}


@cache
def truth(name: str) -> tuple[Array, list[float]]:
    """Return the speeds at the ends of the segments, and the times at which modes change."""
    case = CASES[name]()
    found, train = truth_of(case)
    return found[:, len(case.start) :], train.instants


@pytest.mark.filterwarnings("ignore:solver.tolerance")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", CASES)
def test_speeds_agree_with_a_search_through_all_modes(name: str, integrator: str, tolerance: float) -> None:
    expected, _ = truth(name)
    found, _ = run(CASES[name](), integrator, tolerance)
    size = max(1.0, np.abs(expected).max())
    assert_close("speeds", found, expected, 100 * tolerance * size, "100 times the tolerance of the speeds")


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", CASES)
def test_events_are_those_of_the_exact_solution(name: str, integrator: str) -> None:
    _, instants = truth(name)
    _, times = run(CASES[name](), integrator, 1e-8)
    expected, found = different(instants), different(times)
    assert len(found) == len(expected)
    assert_close("times", [0.0, *found], [0.0, *expected], 1e-6, "100 times the tolerance")


def test_a_gear_stalls_between_its_limits() -> None:
    """At rest the mesh holds loads between what either side could move."""
    for drive, moves in ((9.9, 0), (10.1, 1), (2.6, 0), (2.4, -1)):
        plant = gelenk.Simulation(
            gelenk.load(geared(1.0, 1.5, 2.0, 0.0, 0.0, efficiency=0.5, backdriving=0.5))
        )
        plant.initialize(0.0, 1e-8)
        # A load of 10 N m is 5 N m on the first shaft: it takes 10 N m to raise it, and 2.5 N m to hold it.
        plant.set_input("load.tau", -10.0)
        plant.set_input("drive.tau", drive)
        plant.step_to(0.1)
        assert np.sign(plant.output("first.w")) == moves
        assert plant.output("first.friction.mode") == moves


def test_power_is_lost_by_the_efficiency() -> None:
    plant = gelenk.Simulation(gelenk.load(geared(1.0, 1.5, 2.0, 3.0, 0.0, efficiency=0.8)))
    plant.initialize(0.0, 1e-8)
    plant.set_input("drive.tau", 12.0)
    plant.set_input("load.tau", -10.0)
    w = plant.output("first.w")
    into = (12.0 - 1.0 * plant.output("first.a")) * w
    out_of = (10.0 + 1.5 * plant.output("second.a")) * w / 2.0
    assert into > 0
    assert out_of == pytest.approx(0.8 * into, rel=1e-13)
    lost = -plant.output("first.friction.tau") * w
    assert lost == pytest.approx(0.2 * into, rel=1e-13)


@pytest.mark.parametrize(("drive", "load"), [(12.0, -10.0), (-1.0, 10.0), (12.0, 10.0)])
@pytest.mark.parametrize("w", [3.0, -3.0])
def test_linear_models_of_gears_with_losses(drive: float, load: float, w: float) -> None:
    """Torques count by the efficiency of the present direction of power."""
    source = gelenk.load(geared(1.0, 1.5, 2.0, w, 0.0, efficiency=0.8, backdriving=0.7))
    given = {"drive.tau": drive, "load.tau": load}
    found = gelenk.linear.linear_model(source, input_values=given)
    h = 1e-3  # accelerations are piecewise linear in torques
    for k, name in enumerate(given):
        a = []
        for shift in (h, -h):
            plant = gelenk.Simulation(source)
            plant.initialize(0.0, 1e-8)
            for other, value in given.items():
                plant.set_input(other, value + (shift if other == name else 0.0))
            a.append(plant.output("first.a"))
        row = found.states.index("first.w")
        assert_close("B", found.B[row, k], (a[0] - a[1]) / (2 * h), 1e-11, "rounding over h")
    assert_close("A", found.A[row], np.zeros(found.A.shape[1]), 1e-12, "no dependence on speed")


@pytest.mark.parametrize("w", [0.0, 3.0])
def test_an_unloaded_gear_has_no_linear_model(w: float) -> None:
    """Its losses depend on the sign that the slightest torque gives to the load; a loaded one has a model."""
    with pytest.raises(gelenk.UsageError, match=r"joints\.first\.friction is between two modes, or a load"):
        gelenk.linear.linear_model(gelenk.load(geared(1.0, 1.5, 2.0, w, 0.0, efficiency=0.8)))
    loaded = gelenk.load(geared(1.0, 1.5, 2.0, 3.0, 0.0, efficiency=0.8))
    gelenk.linear.linear_model(loaded, input_values={"drive.tau": 1e-6})


@pytest.mark.parametrize("free", ["positive", "negative"])
def test_a_backstop_holds_a_load_and_lets_it_be_raised(free: str) -> None:
    """A mass on a guide that moves up freely, also where the coordinate points down."""
    up = 1 if free == "positive" else -1
    source = backstop(free)
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, 1e-9)
    plant.step_to(0.5)
    assert plant.output("guide.s") == 0
    assert plant.output("guide.one_way.mode") == -up
    assert plant.output("guide.one_way.f") == pytest.approx(up * 2 * 9.81, rel=1e-14)
    plant.set_input("lift.f", up * 30.0)
    plant.step_to(1.0)
    rate = 30 / 2 - 9.81
    assert_close("s", up * plant.output("guide.s"), rate * 0.125, 1e-9, "the tolerance")
    assert plant.output("guide.one_way.mode") == 0
    assert plant.output("guide.one_way.f") == 0
    plant.set_input("lift.f", 0.0)
    plant.step_to(2.0)
    height = rate * 0.125 + (rate * 0.5) ** 2 / (2 * 9.81)
    assert_close("s", up * plant.output("guide.s"), height, 1e-9, "the tolerance")
    assert plant.output("guide.v") == 0
    assert plant.diagnostic("solver.events") == 2
    assert plant.diagnostic("solver.impacts") == 0


def test_a_speed_in_the_blocked_direction_ends_at_once() -> None:
    """Both shafts get their common momentum; then they overrun or not, as torques demand."""
    source = freewheel()
    source["joints"]["clutch"]["start"]["w"] = -2.0
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, 1e-9)
    plant.step_to(0.1)
    assert plant.output("clutch.w") == 0
    assert_close("w", plant.output("first.w"), (-0.5 - 2.5) / 2, 1e-14, "momentum")
    assert plant.diagnostic("solver.impacts") == 1


def test_a_one_way_clutch_acts_in_the_impact_of_another_joint() -> None:
    """A shaft with a freewheel ahead of it strikes a stop: the wheel runs on, or is stopped with it."""
    for free, after in (("positive", 4.0), ("negative", 0.0)):
        source = shafts(
            {"shaft": 1.0, "wheel": 3.0},
            {
                "shaft": turning("ground", "shaft", 4.0, limit={"upper": 0.2}),
                "freewheel": turning("shaft", "wheel", 0.0, one_way={"free": free}),
            },
        )
        plant = gelenk.Simulation(gelenk.load(source))
        plant.initialize(0.0, 1e-9)
        plant.step_to(0.3)
        assert plant.output("shaft.w") == 0
        wheel = plant.output("freewheel.w")
        assert_close("wheel", wheel, after, 1e-9, f"the tolerance, free: {free}")


@pytest.mark.parametrize("name", ["OneWayClutch", "LossyGearDemo2", "Friction"])
def test_saved_states_continue_to_the_same_bits(name: str) -> None:
    case = CASES[name]()
    plant = gelenk.Simulation(gelenk.load(case.source))
    plant.initialize(0.0, 1e-8)
    for k in range(1, 12):
        for of, i in case.inputs.items():
            plant.set_input(of, float(case.given(k * case.segment)[i]))
        state = plant.save()
        plant.step_to(k * case.segment)
        once = case.speeds(plant)
        plant.restore(state)
        plant.step_to(k * case.segment)
        assert (case.speeds(plant) == once).all()


def test_time_stepping_knows_one_way_clutches() -> None:
    source = freewheel()
    slow = {**source, "solver": {"integrator": "moreau-jean", "step": 1e-3}}
    found = []
    for of in (source, slow):
        plant = gelenk.Simulation(gelenk.load(of))
        plant.initialize(0.0, 1e-8)
        plant.set_input("torque.tau", 2.0)
        plant.step_to(1.0)
        plant.set_input("torque.tau", -2.0)
        plant.step_to(1.5)
        found.append([plant.output("first.w"), plant.output("clutch.w")])
    # Steps of 1 ms, at 2 rad/s2.
    assert_close("speeds", found[1], found[0], 4e-3, "two steps")
