# SPDX-License-Identifier: BSD-3-Clause
"""Friction, limits and one-way clutches that keep a wheel from turning while it skids: against closed forms.

A car of which the wheel is kept from turning skids on a road, which drives the wheel by mu N R = 15 N m. What
keeps it exerts no more than its law permits: beyond that, the wheel spins up, long before it rolls.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import pytest

import gelenk

EVENTS = ["auto", "erk", "cvode", "ida", "dirk"]
ALL = [*EVENTS, "moreau-jean"]
G, MU, R, I = 10.0, 0.5, 0.3, 0.1  # m/s2, 1, m, kg m2  # noqa: E741
MASS = 10.0  # kg, of car and wheel
GROUND = MU * MASS * G * R  # N m, 15
WARM = 0.05  # s


def car(integrator: str, joint: dict[str, Any]) -> gelenk.Simulation:
    return gelenk.Simulation(skid(integrator, joint))


def skid(integrator: str, joint: dict[str, Any]) -> dict[str, Any]:
    """The car at 20 m/s; joint: what keeps its wheel from turning."""
    wheel = {
        "mass": 1.0,
        "inertia": [I] * 3,
        "shapes": {
            "tread": {
                "wheel": {"radius": R},
                "rotation": {"axis": [1, 0, 0], "angle": pi / 2},
                "surface": "rubber",
            }
        },
    }
    start = {"fixed": True}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {"frame": {"mass": 0}, "car": {"mass": MASS - 1}, "wheel": wheel},
        "joints": {
            "x": {
                "type": "prismatic",
                "axis": [1, 0, 0],
                "parent": "ground",
                "child": "frame",
                "start": {"s": 0, "v": 20, **start},
            },
            "z": {
                "type": "prismatic",
                "axis": [0, 0, 1],
                "parent": "frame",
                "child": "car",
                "start": {"s": R, "v": 0, **start},
            },
            "hub": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": "car",
                "child": "wheel",
                "start": {"phi": 0, "w": 0, **start},
                **joint,
            },
        },
        "motors": {"motor": {"joint": "hub"}},
        "ground": {"shapes": {"road": {"plane": [0, 0, 1], "surface": "road"}}},
        "contacts": {"road": {"between": ["rubber", "road"], "friction": MU}},
        "solver": {"integrator": integrator},
    }


def held(plant: gelenk.Simulation) -> gelenk.Simulation:
    """The plant after WARM seconds, in which nothing has turned."""
    plant.initialize(tolerance=1e-8)
    plant.step_to(WARM)
    assert plant.output("hub.w") == pytest.approx(0, abs=1e-9)
    return plant


def tolerance(integrator: str) -> float:
    """Of speeds of 10 rad/s: of steps of 1 ms, one of which an event takes, and of located events."""
    return 0.2 if integrator == "moreau-jean" else 1e-5


BRAKE = {"friction": {"coulomb": 100.0, "input": "engagement"}}


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize("capacity", [15.1, 14.9, 5.0, 0.0])
def test_a_brake_that_is_let_go_holds_no_more_than_it_can(integrator: str, capacity: float) -> None:
    plant = car(integrator, BRAKE)
    plant.set_input("hub.friction.engagement", 1.0)
    held(plant)
    plant.set_input("hub.friction.engagement", capacity / 100)
    plant.step_to(WARM + 0.1)
    expected = max(0.0, GROUND - capacity) / I * 0.1
    assert plant.output("hub.w") == pytest.approx(expected, abs=tolerance(integrator))
    assert abs(plant.output("hub.friction.tau")) == pytest.approx(min(capacity, GROUND), abs=1e-6)
    assert plant.output("hub.friction.mode") == (1 if capacity < GROUND else 0)


@pytest.mark.parametrize("integrator", ALL)
def test_a_brake_that_is_engaged_stops_the_wheel_and_holds_it(integrator: str) -> None:
    """From 5 to 40 N m: 100 rad/s2 faster for 0.1 s, then 250 rad/s2 slower for 0.04 s."""
    plant = car(integrator, BRAKE)
    plant.set_input("hub.friction.engagement", 1.0)
    held(plant)
    plant.set_input("hub.friction.engagement", 0.05)
    plant.step_to(WARM + 0.1)
    plant.set_input("hub.friction.engagement", 0.4)
    plant.step_to(WARM + 0.13)
    assert plant.output("hub.w") == pytest.approx(10 - 250 * 0.03, abs=tolerance(integrator))
    plant.step_to(WARM + 0.2)
    assert plant.output("hub.w") == pytest.approx(0, abs=1e-9)
    assert plant.output("hub.friction.tau") == pytest.approx(-GROUND, abs=1e-6)
    turned = 10 * 0.1 / 2 + 10 * 0.04 / 2
    assert plant.output("hub.phi") == pytest.approx(turned, abs=tolerance(integrator) / 10)


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize("h", [0.1, 0.01], ids=["in one step", "in ten"])
def test_a_brake_that_is_let_go_gradually_breaks_away_at_its_limit(integrator: str, h: float) -> None:
    """The capacity falls by 400 N m/s. At t* it is that of the ground; then w = 400 (t - t*)^2 / (2 I)."""
    plant = car(integrator, BRAKE)
    plant.set_input("hub.friction.engagement", 0.5)
    held(plant)
    rate = 400.0
    for k in range(round(0.12 / h) if h < 0.1 else 1):
        if k * h < 0.12:
            plant.set_input("hub.friction.engagement", 0.5 - rate / 100 * k * h)
            plant.set_input_derivative("hub.friction.engagement", 1, -rate / 100)
        plant.step_to(WARM + (k + 1) * h)
    after = plant.time - WARM - (50 - GROUND) / rate
    assert after > 0
    assert plant.output("hub.w") == pytest.approx(
        rate * after**2 / (2 * I), abs=tolerance(integrator) / (10 if integrator in EVENTS else 1)
    )


@pytest.mark.parametrize("integrator", ALL)
def test_friction_beside_a_contact_breaks_away_where_a_motor_grows(integrator: str) -> None:
    """20 N m hold the ground's 15; a motor adds 100 t: at 0.05 s the wheel breaks away, within a step."""
    plant = held(car(integrator, {"friction": {"coulomb": 20.0}}))
    plant.set_input_derivative("motor.tau", 1, 100.0)
    plant.step_to(WARM + 0.2)
    assert plant.output("hub.w") == pytest.approx(100 * 0.15**2 / (2 * I), abs=tolerance(integrator))
    assert plant.output("hub.friction.tau") == pytest.approx(-20, abs=1e-6)


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize("parameter", [16.0, 14.0])
def test_a_parameter_that_lowers_friction_lets_the_wheel_go(integrator: str, parameter: float) -> None:
    plant = held(car(integrator, {"friction": {"coulomb": 100.0}}))
    changed = gelenk.load(skid(integrator, {"friction": {"coulomb": parameter}}))
    plant._core.tune(changed._core)
    plant.step_to(WARM + 0.1)
    assert plant.output("hub.w") == pytest.approx(
        max(0.0, GROUND - parameter) / I * 0.1, abs=tolerance(integrator)
    )


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize("law", ["limit", "one_way"])
@pytest.mark.parametrize(
    ("side", "before", "motor"),
    [
        (1, 0.0, -14.9),
        (1, 0.0, -15.1),
        (1, 0.0, -20.0),
        (-1, -20.0, -15.1),
        (-1, -20.0, -14.9),
        (-1, -20.0, -10.0),
    ],
)
def test_limits_and_one_way_clutches_do_not_pull(
    integrator: str, law: str, side: int, before: float, motor: float
) -> None:
    """The ground presses the wheel against what blocks it until the motor turns it back, or the motor does
    until the ground does.
    """
    bound, free = ("upper", "negative") if side > 0 else ("lower", "positive")
    plant = car(integrator, {"limit": {bound: 0.0}} if law == "limit" else {"one_way": {"free": free}})
    plant.set_input("motor.tau", before)
    held(plant)
    output = f"hub.{law}"
    assert plant.output(f"{output}.tau") == pytest.approx(-GROUND - before, abs=1e-6)
    plant.set_input("motor.tau", motor)
    plant.step_to(WARM + 0.1)
    net = GROUND + motor
    leaves = side * net < 0
    assert plant.output("hub.w") == pytest.approx(net / I * 0.1 if leaves else 0, abs=tolerance(integrator))
    assert plant.output(f"{output}.tau") == pytest.approx(0 if leaves else -net, abs=1e-6)
    assert plant.output(f"{output}.mode") == (0 if leaves else side)


@pytest.mark.parametrize("integrator", EVENTS)
def test_a_limit_is_left_where_a_motor_grows_within_a_step(integrator: str) -> None:
    plant = held(car(integrator, {"limit": {"upper": 0.0}}))
    plant.set_input_derivative("motor.tau", 1, -200.0)
    plant.step_to(WARM + 0.2)
    after = 0.2 - GROUND / 200
    assert plant.output("hub.w") == pytest.approx(-200 * after**2 / (2 * I), abs=1e-5)
    assert plant.events[0][0] == pytest.approx(WARM + GROUND / 200, abs=1e-7)


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize(("motor", "holds"), [(-20.0, True), (-24.9, True), (-25.1, False)])
def test_static_friction_holds_what_it_can_with_the_ground(
    integrator: str, motor: float, holds: bool
) -> None:
    """A motor that alone would break the wheel away: with the ground against it, 10 N m of static friction
    hold it, although the 4 N m of sliding friction would not.
    """
    plant = car(integrator, {"friction": {"coulomb": 4.0, "static": 10.0}})
    plant.set_input("motor.tau", motor)
    plant.initialize(tolerance=1e-8)
    plant.step_to(0.1)
    expected = 0.0 if holds else (GROUND + motor + 4.0) / I * 0.1
    assert plant.output("hub.w") == pytest.approx(expected, abs=tolerance(integrator))
    assert plant.output("hub.friction.mode") == (0 if holds else -1)


@pytest.mark.parametrize("integrator", ["erk", "cvode"])
def test_a_car_whose_brake_is_released_rolls_at_last(integrator: str) -> None:
    """Released, the wheel spins up by 150 rad/s2 and the car slows down by mu g until w R = v; then the
    ground exerts nothing, as the brake does not.
    """
    plant = car(integrator, BRAKE)
    plant.set_input("hub.friction.engagement", 1.0)
    held(plant)
    plant.set_input("hub.friction.engagement", 0.0)
    speed = 20 - MU * G * WARM
    rolls = speed / (GROUND / I * R + MU * G)
    plant.step_to(WARM + rolls + 0.1)
    assert plant.output("x.v") == pytest.approx(speed - MU * G * rolls, abs=1e-6)
    assert plant.output("hub.w") * R == pytest.approx(plant.output("x.v"), abs=1e-9)
    # The brake engaged gently: it slows the rolling car down, with I / R^2 beside its mass.
    plant.set_input("hub.friction.engagement", 0.03)
    before = plant.output("x.v")
    plant.step_to(WARM + rolls + 0.2)
    assert plant.output("x.v") == pytest.approx(before - 3.0 / R / (MASS + I / R**2) * 0.1, abs=1e-6)
    assert sqrt(plant.output("hub.w") ** 2) * R == pytest.approx(plant.output("x.v"), abs=1e-9)


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize("radius", [0.122, 0.3, 0.359])
def test_a_wheel_that_the_ground_holds_at_its_limit_costs_no_steps(integrator: str, radius: float) -> None:
    """A car is locked as the wheel, which rolls, meets its limit; a motor presses the wheel against it.

    The ground's friction holds the wheel at its limit, beyond it by rounding: steps became as short as that.
    """
    scene = skid(integrator, {"limit": {"lower": -0.1, "upper": 0.0}})
    scene["bodies"]["wheel"]["shapes"]["tread"]["wheel"]["radius"] = radius
    scene["joints"]["z"]["start"]["s"] = radius
    scene["joints"]["hub"]["start"]["w"] = 20 / radius
    scene["joints"]["x"]["lock"] = {"engaged": True, "input": "engagement"}
    plant = gelenk.Simulation(scene)
    plant.set_input("x.lock.engagement", 1.0)
    plant.set_input("motor.tau", 0.5 * MU * MASS * G * radius)
    plant.set_input_derivative("motor.tau", 1, 0.03)
    plant.initialize(tolerance=1e-8)
    plant.step_to(0.1)
    assert plant.output("hub.phi") == pytest.approx(0, abs=1e-9)
    assert plant.output("hub.w") == pytest.approx(0, abs=1e-9)
    assert plant.diagnostics["solver.evaluations"] < 3000
