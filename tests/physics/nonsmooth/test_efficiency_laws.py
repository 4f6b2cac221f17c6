# SPDX-License-Identifier: BSD-3-Clause
"""Efficiencies as expressions of the speed: independent integration, and the same as constants."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gelenk

MOTOR, LOAD, RATIO = 0.4, 30.0, 5.0  # kg m2, kg m2
EVENT_DRIVEN = ["auto", "erk", "dirk", "cvode", "ida"]


def hoist(w: float, torque: str, weight: float, mesh: dict[str, Any], **sections: Any) -> dict[str, Any]:
    """A motor and a load on both sides of a gear; its losses are friction of the motor's shaft."""
    motor = joint(
        "revolute", frame("ground"), frame("motor"), start={"w": w, "fixed": True}, friction={"coulomb": 0.0},
        law={"effort": torque},
    )  # fmt: skip
    load = joint("revolute", frame("ground"), frame("load"), law={"effort": str(weight)})
    return (
        scene(
            {"motor": body(0, inertia=(0, 0, MOTOR)), "load": body(0, inertia=(0, 0, LOAD))},
            {"motor": motor, "load": load},
            constraints={"mesh": {"type": "gear", "joint": "motor", "with": "load", "ratio": RATIO, **mesh}},
            gravity=[0, 0, 0],
        )
        | sections
    )


@pytest.mark.parametrize("integrator", [*EVENT_DRIVEN, "rk4"])
@pytest.mark.parametrize(("w", "torque", "weight"), [(4.0, "9 + 6*sin(3*t)", -20.0), (-30.0, "-2", 40.0)])
def test_the_speed_decides_on_the_efficiency(w: float, torque: str, weight: float, integrator: str) -> None:
    """The motor drives: of its torque on the mesh, eta(w) arrives, 0.5 at rest and more with its speed."""
    eta = "0.9 - 0.4*exp(-w/8)"

    def rate(t: float, y: Any) -> list[float]:
        drive = eval(torque, {"sin": np.sin, "t": t})
        efficiency = 0.9 - 0.4 * np.exp(-abs(y[1]) / 8)
        # On the load: LOAD a/RATIO = weight + RATIO T; on the motor: MOTOR a = drive - T/eta.
        acceleration = (drive + weight / RATIO / efficiency) / (MOTOR + LOAD / RATIO**2 / efficiency)
        T = (LOAD * acceleration / RATIO - weight) / RATIO
        assert T * y[1] > 0
        return [y[1], acceleration]

    exact = solve_ivp(rate, (0, 2), [0, w], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    result = gelenk.simulate(
        hoist(w, torque, weight, {"efficiency": eta}),
        stop=2.0,
        step=0.1,
        tolerance=1e-9,
        integrator=integrator,
    )
    assert abs(result["motor.phi"][-1] - exact[0]) < 1e-7
    assert abs(result["motor.w"][-1] - exact[1]) < 1e-7
    T = (LOAD * result["load.a"] - weight) / RATIO
    np.testing.assert_allclose(result["mesh.tau"], -T, rtol=1e-9)
    loss = T * (1 / (0.9 - 0.4 * np.exp(-np.abs(result["motor.w"]) / 8)) - 1)
    np.testing.assert_allclose(result["motor.friction.tau"], -loss, rtol=1e-9)


def test_it_holds_at_rest_as_much_as_the_efficiency_there_leaves() -> None:
    """Self-locking at rest, with a backdriving of -0.2; in motion 0.3 of the torque T arrives."""
    mesh = {"efficiency": "0.6", "backdriving": "if(w < 0.1, -0.2, 0.3)"}
    held = gelenk.simulate(hoist(0.0, "0", -20.0, mesh), stop=1.0, step=0.1)
    assert np.all(held["motor.w"] == 0)
    moving = gelenk.simulate(hoist(-1.0, "0", -20.0, mesh), stop=1.0, step=0.1, tolerance=1e-9)
    # MOTOR a = -0.3 T, LOAD a/RATIO = -20 + RATIO T
    T = 20 / (RATIO + 0.3 * LOAD / (RATIO * MOTOR))
    assert moving["motor.w"][-1] == pytest.approx(-1 - 0.3 * T / MOTOR, abs=1e-8)


@pytest.mark.parametrize("integrator", [*EVENT_DRIVEN, "rk4", "moreau-jean"])
def test_expressions_of_one_value_are_numbers(integrator: str) -> None:
    """Whether it is folded when read, or first known in a run; through starts, rest and reversals."""
    torque = "12*sin(4*t)"
    options: dict[str, Any] = {"stop": 3.0, "step": 0.05, "tolerance": 1e-9, "integrator": integrator}
    number, folded, late = (
        gelenk.simulate(hoist(1.0, torque, -4.0, mesh, states={"one": {"rate": "0", "start": 1}}), **options)
        for mesh in (
            {"efficiency": 0.7, "backdriving": 0.4},
            {"efficiency": "0.35*2", "backdriving": "2/5"},
            {"efficiency": "0.7*one", "backdriving": "0.4*one"},
        )
    )
    for name in ("motor.phi", "motor.w", "mesh.tau", "motor.friction.tau"):
        np.testing.assert_allclose(folded[name], number[name], rtol=0, atol=1e-12)
        np.testing.assert_allclose(late[name], number[name], rtol=0, atol=1e-8)


@pytest.mark.parametrize("integrator", EVENT_DRIVEN)
def test_points_of_a_table_of_the_speed_are_no_loss_of_accuracy(integrator: str) -> None:
    table = {"tables": {"eta": {"x": [0, 3, 10], "values": [0.5, 0.8, 0.9], "interpolation": "linear"}}}
    by_table = hoist(1.0, "9", -20.0, {"efficiency": "table(eta, w)"}, **table)
    by_hand = hoist(1.0, "9", -20.0, {"efficiency": "if(w < 3, 0.5 + 0.1*w, min(0.9, 0.8 + (w - 3)/70))"})
    ends = [
        gelenk.simulate(of, stop=2.0, step=2.0, tolerance=1e-9, integrator=integrator)["motor.phi"][-1]
        for of in (by_table, by_hand)
    ]
    pieces = solve_pieces()
    np.testing.assert_allclose(ends, pieces, atol=2e-8)


def solve_pieces() -> float:
    """The same drive integrated from point to point of the table."""

    def rate(_: float, y: Any) -> list[float]:
        eta = float(np.interp(y[1], [0, 3, 10], [0.5, 0.8, 0.9]))
        return [y[1], (9 - 20 / RATIO / eta) / (MOTOR + LOAD / RATIO**2 / eta)]

    t, y = 0.0, [0.0, 1.0]
    for speed in (3.0, 10.0):

        def at_point(_: float, y: Any, speed: float = speed) -> float:
            return float(y[1] - speed)

        at_point.terminal = True  # type: ignore[attr-defined]
        piece = solve_ivp(rate, (t, 2.0), y, events=at_point, method="DOP853", rtol=1e-12, atol=1e-12)
        t, y = piece.t[-1], piece.y[:, -1]
        if t == 2.0:
            break
    return float(y[0])


def test_a_rack_takes_the_speed_of_its_pinion() -> None:
    """Raised by a pinion with 0.5 + 0.02 w: m a = r T..., against a gear of the same reduced load."""
    of = hoist(2.0, "6", -10.0, {"efficiency": "0.5 + 0.02*w"})
    gear = gelenk.simulate(of, stop=1.0, step=0.1, tolerance=1e-10)
    of["bodies"]["load"] = body(LOAD)
    of["joints"]["load"] = joint(
        "prismatic", frame("ground"), frame("load"), axis=[0, 0, 1], law={"effort": "-10"}
    )
    of["constraints"]["mesh"] = {
        "type": "rack", "rack": "load", "pinion": "motor", "radius": 1 / RATIO, "efficiency": "0.5 + 0.02*w"
    }  # fmt: skip
    rack = gelenk.simulate(of, stop=1.0, step=0.1, tolerance=1e-10)
    np.testing.assert_allclose(rack["motor.w"], gear["motor.w"], rtol=1e-9)


def test_the_linear_model_follows_the_slope_of_the_efficiency() -> None:
    """Of dw'/dw by central differences of the accelerations at speeds 1e-4 apart."""
    eta = {"efficiency": "0.9 - 0.4*exp(-w/8)"}
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(hoist(4.0, "9", -20.0, eta), friction="present")
    low, high = (
        gelenk.simulate(hoist(4.0 + d, "9", -20.0, eta), stop=1e-9, step=1e-9)["motor.a"][0]
        for d in (-1e-4, 1e-4)
    )
    i = model.state_labels.index("motor_w")
    assert model.A[i, i] == pytest.approx((high - low) / 2e-4, rel=1e-6)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        ({"efficiency": 1.2}, "efficiency: found 1.2, expected more than 0, and 1 or less"),
        ({"efficiency": 0}, "efficiency: found 0, expected more than 0"),
        ({"efficiency": 0.9, "backdriving": 1.5}, "backdriving: found 1.5, expected 1 or less"),
        ({"efficiency": "0.9 - v"}, "v"),
    ],
)
def test_mistakes_are_answered_in_words(mesh: dict[str, Any], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.Simulation(hoist(0.0, "0", 0.0, mesh))


@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "rk4"])
def test_an_efficiency_of_0_or_none_ends_the_run(integrator: str) -> None:
    """Not as if the gear had no losses."""
    for eta in ("0.6 - 0.5*t", "0.5 + 0.1*sqrt(1.2 - t)"):
        of = hoist(5.0, "9", -5.0, {"efficiency": eta, "backdriving": 0.3})
        with pytest.raises(gelenk.StepError):
            gelenk.simulate(of, stop=2.0, step=0.1, integrator=integrator)


@pytest.mark.parametrize("integrator", EVENT_DRIVEN)
def test_steps_may_pass_a_kink_towards_0(integrator: str) -> None:
    """A stage beyond the kink continues the branch that is held, down to 0."""
    of = hoist(5.0, "9", -5.0, {"efficiency": "max(0.05, 0.6 - 0.5*t)", "backdriving": 0.3})
    result = gelenk.simulate(of, stop=2.0, step=2.0, integrator=integrator, tolerance=1e-9)

    def rate(t: float, y: Any) -> list[float]:
        eta = max(0.05, 0.6 - 0.5 * t)
        return [y[1], (9 - 5 / RATIO / eta) / (MOTOR + LOAD / RATIO**2 / eta)]

    middle = solve_ivp(rate, (0, 1.1), [0, 5.0], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    end = solve_ivp(rate, (1.1, 2.0), middle, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    assert result["motor.phi"][-1] == pytest.approx(end[0], abs=2e-8)


def test_a_drag_is_an_efficiency_over_the_load() -> None:
    """tau/(tau + 2) takes 2 N m from what arrives, whatever that is: the same as Coulomb friction."""
    options: dict[str, Any] = {"stop": 2.0, "step": 0.1, "tolerance": 1e-9}
    by_load = gelenk.simulate(
        hoist(4.0, "9 + 3*sin(3*t)", -20.0, {"efficiency": "(tau + 1e-9)/(tau + 2)"}), **options
    )
    drag = hoist(4.0, "9 + 3*sin(3*t)", -20.0, {})
    drag["joints"]["motor"]["friction"] = {"coulomb": 2.0}
    expected = gelenk.simulate(drag, **options)
    for name in ("motor.phi", "motor.w", "motor.friction.tau"):
        np.testing.assert_allclose(by_load[name], expected[name], atol=1e-7)


@pytest.mark.parametrize("integrator", [*EVENT_DRIVEN, "rk4", "moreau-jean"])
@pytest.mark.parametrize(("w", "torque", "weight"), [(4.0, "9 + 6*sin(3*t)", -20.0), (-30.0, "-2", 40.0)])
@pytest.mark.parametrize("form", ["formula", "table"])
def test_the_load_decides_on_the_efficiency(
    w: float, torque: str, weight: float, integrator: str, form: str
) -> None:
    """Of the torque T on the mesh eta(w, T) arrives, T by a root at each instant. Or a bilinear map."""
    maps = {
        "formula": lambda w, T: (0.9 - 0.4 * np.exp(-w / 8)) * (0.5 + 0.5 * T / (T + 3)),
        "table": lambda w, T: 0.4 + 0.01 * min(w, 40.0) + 0.01 * min(T, 10.0),
    }
    tables = {
        "eta": {"x": [0, 40], "y": [0, 10], "values": [[0.4, 0.5], [0.8, 0.9]], "interpolation": "linear"}
    }
    law = {"formula": "(0.9 - 0.4*exp(-w/8))*(0.5 + 0.5*tau/(tau + 3))", "table": "table(eta, w, tau)"}[form]
    eta = maps[form]

    def balance(T: float, drive: float, speed: float) -> float:
        """Of the torque T that arrives: what is left of both equations of motion."""
        sign = np.sign(speed)
        acceleration = (drive - sign * T / eta(abs(speed), T)) / MOTOR
        return float(LOAD * acceleration / RATIO - weight - RATIO * sign * T)

    def rate(t: float, y: Any) -> list[float]:
        drive = eval(torque, {"sin": np.sin, "t": t})
        T = brentq(balance, 1e-9, 1e3, args=(drive, y[1]), xtol=1e-14, rtol=1e-14)
        return [y[1], (drive - np.sign(y[1]) * T / eta(abs(y[1]), T)) / MOTOR]

    exact = solve_ivp(rate, (0, 1), [0, w], method="DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    of = hoist(w, torque, weight, {"efficiency": law}, **({"tables": tables} if form == "table" else {}))
    steps = integrator == "moreau-jean"  # of second order where nothing sticks
    of["solver"] = {"step": 1e-3} if steps else {}
    result = gelenk.simulate(of, stop=1.0, step=0.1, tolerance=1e-9, integrator=integrator)
    end = [result["motor.phi"][-1], result["motor.w"][-1]]
    np.testing.assert_allclose(end, exact, atol=1e-5 if steps else 2e-7)


def test_linear_models_know_the_slope_of_losses_over_the_load() -> None:
    """Against differences of the acceleration; the friction is not in proportion to the load."""
    of = hoist(4.0, "u", -20.0, {"efficiency": "0.4 + 0.5*tau/(tau + 5)"}, inputs={"u": {"start": 9.0}})
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(of, friction="present", outputs=["motor.a"])
    plant = gelenk.Simulation(of)
    values = []
    for u in (9 - 1e-4, 9 + 1e-4):
        plant.initialize(0.0, 1e-9)
        plant.set_input("u", u)
        values.append(plant.output("motor.a"))
    assert model.D[0, 0] == pytest.approx((values[1] - values[0]) / 2e-4, rel=1e-7)
    assert model.D[0, 0] != pytest.approx(values[1] / 9, rel=0.1)
