# SPDX-License-Identifier: BSD-3-Clause
"""Friction as an expression of the speed: closed forms, Stribeck's curve, brakes, where it can stand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, four_bar, frame, joint, rod, scene

import gelenk

MASS = 2.0  # kg
EVENT_DRIVEN = ["auto", "erk", "dirk", "cvode", "ida"]


def slide(
    friction: dict[str, Any],
    start: dict[str, Any],
    constants: dict[str, float] | None = None,
    **joint_fields: Any,
) -> dict[str, Any]:
    """A mass on a horizontal slide."""
    guide = joint(
        "prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0],
        start={**start, "fixed": True}, friction=friction, **joint_fields,
    )  # fmt: skip
    return scene({"mass": body(MASS)}, {"S": guide}, gravity=[0, 0, 0]) | {"constants": constants or {}}


def final(of: dict[str, Any], stop: float, step: float = 0.5, **options: Any) -> gelenk.Result:
    return gelenk.simulate(of, stop=stop, step=step, **{"tolerance": 1e-9, **options})


def stopping(constant: float, linear: float, speed: float) -> tuple[float, float]:
    """Time and distance in which constant + linear*v stops MASS: m v' = -(c + d v)."""
    time = MASS / linear * math.log1p(linear * speed / constant)
    decay = math.expm1(-linear * time / MASS)
    return time, -(speed + constant / linear) * MASS / linear * decay - constant / linear * time


@pytest.mark.parametrize("integrator", EVENT_DRIVEN)
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_a_law_of_the_speed_stops_what_slides(integrator: str, speed: float) -> None:
    """In both directions, since the law is one of the size of the speed; one event, ten tolerances."""
    time, distance = stopping(1.0, 0.5, 3.0)
    assert time < 4
    result = final(slide({"law": "1 + 0.5*v"}, {"s": 0.2, "v": speed}), 4.0, integrator=integrator)
    assert abs(result["S.s"][-1] - 0.2 - math.copysign(distance, speed)) < 1e-8
    assert result["S.v"][-1] == 0
    force = -math.copysign(1 + 0.5 * abs(result["S.v"][1]), speed)
    assert result["S.friction.f"][1] == pytest.approx(force, rel=1e-12)
    simulation = gelenk.Simulation(slide({"law": "1 + 0.5*v"}, {"s": 0.2, "v": speed}))
    simulation.initialize(0.0, 1e-9)
    simulation.step_to(4.0)
    assert simulation.diagnostic("solver.events") == 1


@pytest.mark.parametrize("integrator", [*EVENT_DRIVEN, "rk4", "generalized-alpha", "moreau-jean"])
def test_it_is_the_stribeck_element_where_it_says_the_same(integrator: str) -> None:
    """Also at rest, where `peak` is static by sliding friction at 0, under a force that turns twice."""
    load = {"law": {"effort": "5*sin(2*t)"}}
    element = slide({"coulomb": 1.5, "static": 3.0, "stribeck": 0.4}, {"v": 1.0}, **load)
    law = slide({"law": "1.5 + 1.5*exp(-(v/0.4)^2)"}, {"v": 1.0}, **load)
    options = {"integrator": integrator, "tolerance": 1e-9}
    expected = final(element, 5.0, 0.05, **options)
    result = final(law, 5.0, 0.05, **options)
    for name in ("S.s", "S.v", "S.friction.f", "S.friction.mode"):
        np.testing.assert_allclose(result[name], expected[name], rtol=0, atol=2e-8)
    assert {0.0, 1.0, -1.0} == set(result["S.friction.mode"])


@pytest.mark.parametrize("integrator", EVENT_DRIVEN)
def test_peak_is_the_static_friction_by_that_at_zero_speed(integrator: str) -> None:
    """A ramp of 1 N/s breaks away at 1.4 x 2 N; then 2 N resist: x = tau^2 (0.8/2 + tau/6)/m from there."""
    result = final(slide({"law": "2", "peak": 1.4}, {}, law={"effort": "t"}), 5.0, 0.1, integrator=integrator)
    assert np.all(result["S.s"][:28] == 0)
    since = 5.0 - 2.8
    assert abs(result["S.s"][-1] - since**2 * (0.8 / 2 + since / 6) / MASS) < 1e-8


@pytest.mark.parametrize("integrator", [*EVENT_DRIVEN, "rk4"])
def test_a_brake_is_a_law_of_an_input(integrator: str) -> None:
    """Pressed until it holds, released, and below 0 it does nothing: x' = v, m v' = 3 - 4 brake."""
    of = slide({"law": "4*brake"}, {"v": 1.5}, law={"effort": "3"}) | {"inputs": {"brake": {}}}
    pressed = [(0.0, 2.0), (2.0, -1.0), (3.0, 1.0)]
    result = gelenk.simulate(
        of, stop=4.0, step=0.25, tolerance=1e-9, integrator=integrator,
        inputs={"brake": lambda t: [b for at, b in pressed if t >= at - 1e-12][-1]}, hold=True,
    )  # fmt: skip
    at = dict(zip(np.round(result.time, 6), range(len(result.time)), strict=True))
    stopped = 1.5**2 * MASS / (2 * 5.0)
    assert result["S.v"][at[1.0]] == 0 == result["S.v"][at[2.0]]
    assert abs(result["S.s"][at[2.0]] - stopped) < 1e-8
    assert result["S.friction.f"][at[1.5]] == pytest.approx(-3, rel=1e-12)
    assert abs(result["S.v"][at[3.0]] - 1.5) < 1e-8
    assert abs(result["S.v"][-1] - (1.5 - 0.5)) < 1e-8


def test_limits_that_grow_with_a_state_of_an_element() -> None:
    """A brake that fills as p' = (8 - p)/0.5 holds at 5 N, where p = 8 (1 - exp(-2 t))."""
    of = slide({"law": "p"}, {"v": 4.0}, law={"effort": "5"}) | {"states": {"p": "(8 - p)/0.5"}}
    result = final(of, 6.0, 0.01, tolerance=1e-10)
    # m v' = 5 - 8 + 8 exp(-2 t)
    speed = 4 - 1.5 * result.time + 2 * (1 - np.exp(-2 * result.time))
    moving = result.time < result.time[np.argmax(result["S.v"] == 0)]
    np.testing.assert_allclose(result["S.v"][moving], speed[moving], atol=1e-8)
    assert np.all(result["S.v"][~moving] == 0)
    assert result["S.friction.f"][-1] == pytest.approx(-5, rel=1e-12)


@pytest.mark.parametrize("integrator", EVENT_DRIVEN)
def test_kinks_of_the_law_are_events(integrator: str) -> None:
    """2 N above 1 m/s, 1 N below: 1.5 m/s to 1 m/s at -1, then to rest at -1/2 m/s2."""
    result = final(slide({"law": "if(v > 1, 2, 1)"}, {"v": 1.5}), 4.0, 4.0, integrator=integrator)
    assert abs(result["S.s"][-1] - ((1.5**2 - 1) / 2 + 1)) < 1e-8
    table = {"tables": {"curve": {"x": [0, 0.5, 2], "values": [3, 1, 4], "interpolation": "linear"}}}
    by_table = slide({"law": "table(curve, v)"}, {"v": 2.0}) | table
    by_hand = slide({"law": "if(v < 0.5, 3 - 4*v, 2*v)"}, {"v": 2.0})
    ends = [final(of, 4.0, 4.0, integrator=integrator)["S.s"][-1] for of in (by_table, by_hand)]
    # From 2 to 1/2 m/s the friction is 2 v: x = m (2 - 1/2)/2; then v dv = -(3 - 4 v) dx/m from 1/2 to 0.
    exact = MASS * 1.5 / 2 + MASS * (-0.5 / 4 + 3 / 16 * math.log(3 / (3 - 4 * 0.5)))
    np.testing.assert_allclose(ends, exact, atol=1e-8)


def test_friction_may_depend_on_the_position() -> None:
    """(1 + s^2) N over the way takes all of the energy: m v^2/2 = s + s^3/3."""
    result = final(slide({"law": "1 + s^2"}, {"v": 2.0}), 10.0)
    s = result["S.s"][-1]
    assert abs(s + s**3 / 3 - MASS * 2.0**2 / 2) < 1e-8


@pytest.mark.parametrize("closes", ["A", "C"])
def test_any_joint_of_a_loop(closes: str) -> None:
    """Of the joint that closes the loop as of one of the tree, and equal to the element."""

    def run(friction: dict[str, Any]) -> gelenk.Result:
        of = four_bar()
        of["joints"][closes]["friction"] = friction
        return gelenk.simulate(of, stop=2.0, step=0.05, tolerance=1e-10)

    by_element = run({"coulomb": 0.02, "static": 0.05, "stribeck": 0.5, "exponent": 1})
    by_law = run({"law": "0.02 + 0.03*exp(-w/0.5)"})
    for name in ("A.phi", "A.w", f"{closes}.friction.tau"):
        np.testing.assert_allclose(by_law[name], by_element[name], rtol=0, atol=1e-7)


@pytest.mark.parametrize("integrator", ["auto", "rk4", "moreau-jean", "dirk"])
def test_a_state_that_is_saved_leads_on_to_the_bit(integrator: str) -> None:
    of = slide({"law": "0.5 + p*(1 + v)"}, {"v": 1.0}, law={"effort": "4*sin(3*t)"})
    of |= {"states": {"p": "(1 - p)/0.2"}, "solver": {"integrator": integrator}}
    simulation = gelenk.Simulation(of)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.37)
    saved = simulation.save()
    ends = []
    for _ in range(2):
        simulation.restore(saved)
        for k in range(40):
            simulation.step_to(0.37 + 0.05 * (k + 1))
        ends.append(simulation.values())
    np.testing.assert_array_equal(ends[0], ends[1])


def test_the_linear_model_has_the_slope_of_the_law() -> None:
    """In motion with v = 2 under a law 1 + v^2: dv'/dv = -2 v/m, dv'/dp = -1/m with an input in it."""
    of = slide({"law": "1 + v^2 + u"}, {"v": 2.0}) | {"inputs": {"u": {}}}
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(of, friction="present")
    assert model.A[1, 1] == pytest.approx(-4 / MASS, rel=1e-12)
    assert model.B[1, 0] == pytest.approx(-1 / MASS, rel=1e-12)


def test_several_frictions_of_a_coordinate_add_up() -> None:
    """A bearing beside the law: a pendulum without gravity, whose bearing carries m r w^2."""
    arm = joint(
        "revolute", frame("ground"), frame("arm"), start={"w": 3.0, "fixed": True},
        friction={"law": "0.1*w", "bearing": {"coefficient": 0.2, "radius": 0.05}},
    )  # fmt: skip
    of = scene({"arm": rod(1.5, 0.8)}, {"A": arm}, gravity=[0, 0, 0])
    result = gelenk.simulate(of, stop=1.0, step=0.1, tolerance=1e-10)
    inertia, across = 1.5 * 0.8**2 / 3, 1.5 * 0.4
    # w' = -(0.1 w + 0.01 |R|)/I, R from the acceleration of the center: normal m r w^2, tangential m r w'.
    speed = result["A.w"]
    acceleration = result["A.a"]
    bearing = 0.01 * across * np.hypot(speed**2, acceleration)
    np.testing.assert_allclose(inertia * acceleration, -(0.1 * speed + bearing), rtol=1e-9)


@pytest.mark.parametrize(
    ("friction", "message"),
    [
        ({"law": "-2*v"}, "friction above 0: v is the size of the speed"),
        ({"law": "1", "static": 2.0}, "static"),
        ({"law": "1", "peak": 0.5}, "1 or more"),
        ({"law": "1", "coulomb": 1.0}, "found coulomb, law together"),
        ({"law": "u", "input": "engagement"}, "u"),
        ({"law": "1 + w"}, "w"),
        ({"static": 1.0}, "none of coulomb, law"),
        ({"coulomb": 1.0, "peak": 2.0}, "with coulomb, static is the static friction"),
    ],
)
def test_mistakes_are_answered_in_words(friction: dict[str, Any], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.Simulation(slide(friction, {}))
