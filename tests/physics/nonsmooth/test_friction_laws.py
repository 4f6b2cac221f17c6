# SPDX-License-Identifier: BSD-3-Clause
"""Friction as an expression of the speed: closed forms, Stribeck's curve, brakes, where it can stand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, four_bar, frame, joint, rod, scene
from models.running import assert_continues_to_the_bit

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
    load: dict[str, Any] = {"law": {"effort": "5*sin(2*t)"}}
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
    assert_continues_to_the_bit(of, 0.37, 0.37 + 0.05 * np.arange(1, 41), 1e-8)


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


def two_rotors(law: str, **fields: Any) -> dict[str, Any]:
    """A turns freely with 1 rad/s; B rests under 0.5 N m, with friction that the motion of A decides on."""
    free = joint("revolute", frame("ground"), frame("a"), start={"w": 1.0, "fixed": True})
    held = joint(
        "revolute", frame("ground"), frame("b"), start={"fixed": True},
        friction={"law": law, **fields}, law={"effort": "0.5"},
    )  # fmt: skip
    return scene(
        {"a": body(0, inertia=(0, 0, 0.4)), "b": body(0, inertia=(0, 0, 0.3))},
        {"A": free, "B": held}, gravity=[0, 0, 0],
        sensors={"tip": {"type": "frame", "body": "a", "position": [0, 0.4, 0]}},
    )  # fmt: skip


@pytest.mark.parametrize("integrator", [*EVENT_DRIVEN, "rk4", "moreau-jean"])
@pytest.mark.parametrize("law", ["0.3*A.w", "0.3*A.w + 0*A.phi", "-0.75*tip.v[1]", "speed"])
def test_what_is_held_by_the_motion_of_others_rests_from_the_start(integrator: str, law: str) -> None:
    """Static friction is 0.9 N m. It was once decided before the motion was known: B slid away."""
    of = two_rotors(law, peak=3.0) | {"expressions": {"speed": "0.3*A.w"}}
    result = final(of, 0.1, 0.05, integrator=integrator)
    if law.startswith("-"):
        assert result["tip.v[1]"][0] == pytest.approx(-0.4)
    np.testing.assert_allclose(result["B.phi"], 0, atol=1e-15)


def test_derivatives_of_friction_by_the_motion_of_others() -> None:
    """d(B.friction.tau)/d(A.w) = -2 w and d/d(B.w) = -1, of a law w + A.w^2 in motion. It once crashed."""
    of = two_rotors("w + A.w^2")
    of["joints"]["B"]["start"] = {"w": 2.0, "fixed": True}
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(of, friction="present", outputs=["B.friction.tau"])
    row = dict(zip(model.state_labels, model.C[0], strict=True))
    assert row == pytest.approx({"A_phi": 0, "A_w": -2, "B_phi": 0, "B_w": -1}, abs=1e-12)


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode"])
def test_friction_of_what_moves_may_exceed_that_at_rest(integrator: str) -> None:
    """Beside a joint that rests: forces were once held against the limits at rest, and the run refused."""
    a = joint("revolute", frame("ground"), frame("a"), friction={"law": "0.8 + 0.2*w"},
              law={"effort": "4*sin(2.6*t)"})  # fmt: skip
    b = joint("revolute", frame("a"), frame("b"), friction={"coulomb": 0.1})
    of = scene({"a": body(0, inertia=(0, 0, 0.3)), "b": body(0, inertia=(0, 0, 0.04))}, {"A": a, "B": b},
               gravity=[0, 0, 0])  # fmt: skip
    element = {"friction": {"coulomb": 0.8}, "damping": 0.2}
    by_elements = of | {"joints": {"A": {k: v for k, v in a.items() if k != "friction"} | element, "B": b}}
    found, expected = (final(x, 2.0, 0.1, integrator=integrator) for x in (of, by_elements))
    np.testing.assert_allclose(found["A.w"], expected["A.w"], atol=1e-7)
    np.testing.assert_allclose(found["B.w"], expected["B.w"], atol=1e-7)


@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "moreau-jean"])
def test_a_law_that_is_no_number_ends_the_run(integrator: str) -> None:
    """Not as if there was no friction."""
    with pytest.raises(gelenk.StepError):
        final(slide({"law": "1.5 + sqrt(-s - 0.1)"}, {"v": 1.0}), 1.0, integrator=integrator)


@pytest.mark.parametrize("integrator", EVENT_DRIVEN)
def test_a_steep_law_beyond_rest_does_no_harm(integrator: str) -> None:
    """Steps that end at rest try speeds beyond it, where exp(-v/0.01) is huge."""
    of = slide({"law": "0.3 + 0.4*exp(-v/0.01)", "peak": 4.0}, {"v": 2.0}, law={"effort": "0.2*sin(t)"})
    result = final(of, 20.0, 20.0, integrator=integrator)
    assert result["S.v"][-1] == 0
    assert result["S.friction.f"][-1] == pytest.approx(-0.2 * math.sin(20.0), rel=1e-9)
