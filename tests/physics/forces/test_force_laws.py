# SPDX-License-Identifier: BSD-3-Clause
"""Forces between points and on bodies by expressions: elements that they repeat, Kepler's orbits, ropes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, body, frame, joint, rod, scene

import gelenk

ADAPTIVE = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]
TURNED = {"axis": [1, 2, 2], "angle": 1.1}  # of the whole mechanism in space


def pair(forces: dict[str, Any], planar: bool, **solver: Any) -> dict[str, Any]:
    """Two bodies: a pendulum, and a body that it pulls; in a plane, or free in space."""
    if planar:
        joints = {
            "A": joint("revolute", frame("ground"), frame("rod"), axis=[0, 0, 1], start={"phi": 0.4}),
            "B": joint(
                "planar",
                frame("ground"),
                frame("plate"),
                start={"s_x": 0.9, "s_y": -0.4, "phi": 0.3, "v_x": 0.5, "w": -1.0},
            ),
        }
    else:
        joints = {
            "A": joint("spherical", frame("ground"), frame("rod"), start={"w": [0.3, -0.2, 0.5]}),
            "B": joint(
                "free",
                frame("ground"),
                frame("plate"),
                start={"r": [0.9, -0.4, 0.2], "v": [0.5, 0, 0.2], "w": [1.0, 0.4, -0.3]},
            ),
        }
    bodies = {
        "rod": body(0.8, com=(0.25, 0, 0), inertia=(0.01, 0.03, 0.03)),
        "plate": body(0.5, com=(0, 0, 0), inertia=(0.004, 0.005, 0.008)),
    }
    out = scene(bodies, joints, gravity=[0, -GRAVITY, 0], solver=solver)
    out["forces"] = forces
    return out


ENDS: dict[str, Any] = {
    "from": {"body": "rod", "position": [0.5, 0.02, 0]},
    "to": {"body": "plate", "position": [0.1, -0.05, 0.0]},
}
HOOK: dict[str, Any] = {"body": "ground", "position": [0.2, 0.1, 0.0]}
AT: dict[str, Any] = {"body": "plate", "position": [0.1, -0.05, 0.0]}

# What an element says, and the same by expressions.
SAME: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "spring_damper": (
        {"type": "spring_damper", **ENDS, "stiffness": 80.0, "damping": 0.7, "length": 0.3},
        {"type": "line_force", **ENDS, "tension": "80*(length - 0.3) + 0.7*rate"},
    ),
    "wrench in the world": (
        {"type": "wrench", **AT, "force": [0.3, 2.0, 0.0], "torque": [0, 0, 0.02]},
        {"type": "body_force", **AT, "force": [0.3, 2, 0], "torque": [0, 0, 0.02]},
    ),
    "wrench in the body": (
        {"type": "wrench", **AT, "force": [0.3, 2.0, 0.0], "torque": [0, 0, 0.02], "frame": "body"},
        {"type": "body_force", **AT, "force": [0.3, 2, 0], "torque": [0, 0, 0.02], "frame": "body"},
    ),
    "spring to the ground": (
        {"type": "spring_damper", "from": HOOK, "to": AT, "stiffness": 80.0},
        {"type": "body_force", **AT, "force": ["-80*(x - 0.2)", "-80*(y - 0.1)", "-80*z"]},
    ),
    "drag": (
        {"type": "drag", "body": "plate", "position": [0.1, -0.05, 0.0], "coefficient": 0.3},
        {
            "type": "body_force", **AT,
            "force": [f"-0.3*sqrt(vx^2 + vy^2 + vz^2)*{v}" for v in ("vx", "vy", "vz")],
        },
    ),
}  # fmt: skip


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("name", SAME)
@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida", "dirk", "generalized-alpha"])
def test_expressions_are_the_elements_that_they_repeat(name: str, planar: bool, integrator: str) -> None:
    """Also their linear models, to rounding."""
    found = []
    models = []
    for element in SAME[name]:
        source = pair({"F": element}, planar, integrator=integrator, step=1e-3)
        simulation = gelenk.Simulation(source)
        simulation.initialize(0.0, 1e-9)
        for k in range(1, 11):
            simulation.step_to(0.03 * k)
        found.append(simulation.values())
        with pytest.warns(gelenk.OperatingPointWarning):
            models.append(gelenk.linearize(source))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(models[0].A, models[1].A, rtol=1e-11, atol=1e-10)


@pytest.mark.parametrize("tolerance", [1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode-adams"])
def test_kepler_orbit(integrator: str, tolerance: float) -> None:
    """A satellite about a center of attraction, eccentricity 0.3: after ten periods it is where it was."""
    mu, a, e = 1.0, 1.0, 0.3
    law = [f"-{mu}*{x}/(x^2 + y^2 + z^2)^1.5" for x in ("x", "y", "z")]
    speed = math.sqrt(mu / a * (1 + e) / (1 - e))
    satellite = scene(
        {"S": body(1.0, com=(0, 0, 0), inertia=(0.1, 0.1, 0.1))},
        {
            "F": joint(
                "free", frame("ground"), frame("S"), start={"r": [a * (1 - e), 0, 0], "v": [0, speed, 0]}
            )
        },
        gravity=[0, 0, 0],
        solver={"integrator": integrator},
    )
    satellite["forces"] = {"G": {"type": "body_force", "body": "S", "force": law}}
    simulation = gelenk.Simulation(satellite)
    simulation.initialize(0.0, tolerance)
    period = 2 * math.pi
    for k in range(1, 101):
        simulation.step_to(0.1 * k * period)
    error = abs(simulation.output("F.r[2]"))  # along the orbit, which grows with the square of time
    assert error < 4000 * tolerance
    assert simulation.output("F.r[1]") == pytest.approx(a * (1 - e), abs=1000 * tolerance)


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_rope_that_only_pulls(integrator: str) -> None:
    """A weight falls into a rope of 1 m, k = 400 N/m, and out of it again: the time of a cycle."""
    k, m, L, s = 400.0, 1.0, 1.0, 0.6  # thrown from 0.6 m below the hook
    weight = scene(
        {"weight": body(m, com=(0, 0, 0))},
        {"S": joint("prismatic", frame("ground"), frame("weight"), axis=[0, -1, 0], start={"s": s})},
        gravity=[0, -GRAVITY, 0],
        solver={"integrator": integrator},
    )
    weight["forces"] = {
        "rope": {
            "type": "line_force",
            "from": "ground",
            "to": "weight",
            "tension": f"{k}*max(0, length - {L})",
        }
    }
    fall = math.sqrt(2 * (L - s) / GRAVITY)
    v = GRAVITY * fall
    omega = math.sqrt(k / m)
    rest = m * GRAVITY / k
    # In the rope x = rest + A sin(omega t - p), from x = 0 with v to x = 0 with -v.
    half = (math.pi + 2 * math.atan2(rest, v / omega)) / omega
    cycle = 2 * fall + half
    simulation = gelenk.Simulation(weight)
    simulation.initialize(0.0, 1e-9)
    for n in range(1, 6):
        simulation.step_to(n * cycle)
        assert simulation.output("S.s") == pytest.approx(s, abs=2e-7)
        assert simulation.output("S.v") == pytest.approx(0, abs=2e-6)
    assert simulation.diagnostic("solver.events") == 10


def test_forces_read_inputs_and_time() -> None:
    """A force of an input and of the time: momentum is its integral; B of the linear model is 1/m."""
    cart = scene(
        {"cart": body(2.0, com=(0, 0, 0))},
        {"S": joint("prismatic", frame("ground"), frame("cart"), axis=[1, 0, 0])},
        gravity=[0, 0, 0],
    )
    cart["inputs"] = {"push": {"unit": "N"}}
    cart["constants"] = {"gain": 3.0}
    cart["forces"] = {"P": {"type": "body_force", "body": "cart", "force": ["gain*push + 4*t", 0, 0]}}
    simulation = gelenk.Simulation(cart)
    simulation.initialize(0.0, 1e-10)
    simulation.set_input("push", 2.0)
    simulation.step_to(1.5)
    assert simulation.output("S.v") == pytest.approx((3 * 2 * 1.5 + 2 * 1.5**2) / 2, abs=1e-9)
    model = gelenk.linearize(cart, states=["S.s", "S.v"], inputs=["push"])
    np.testing.assert_allclose(np.asarray(model.B), np.array([[0.0], [1.5]]), rtol=1e-13)


@pytest.mark.parametrize("planar", [True, False])
def test_linear_model_of_inputs_that_multiply_velocities(planar: bool) -> None:
    """B by differences of the accelerations, for a damper and a drag whose coefficients are inputs."""
    forces = {
        "L": {"type": "line_force", **ENDS, "tension": "c*rate"},
        "D": {"type": "body_force", **AT, "force": ["-d*vx", "-d*vy", "0"], "torque": [0, 0, "-d*wz"]},
    }
    source = pair(forces, planar)
    source["inputs"] = {"c": {"start": 0.7}, "d": {"start": 0.4}}
    names = [signal.name for signal in gelenk.Simulation(source).outputs]
    accelerations = [name for name in names if name.split(".")[1].startswith(("a", "wd"))]
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(source, inputs=["c", "d"], outputs=accelerations)
    for k, name in enumerate(("c", "d")):
        ends = []
        for change in (-1e-3, 1e-3):
            simulation = gelenk.Simulation(source)
            simulation.initialize(0.0, 1e-8)
            simulation.set_input(name, source["inputs"][name]["start"] + change)
            ends.append(np.array([simulation.output(a) for a in accelerations]))
        difference = (ends[1] - ends[0]) / 2e-3
        np.testing.assert_allclose(np.asarray(model.D)[:, k], difference, rtol=0, atol=1e-9)


def test_two_mechanisms_share_an_input() -> None:
    """A jump of it restarts both, also those that nothing else connects."""
    two = scene(
        {"a": rod(1.0, 0.5), "b": rod(1.0, 0.5)},
        {
            name: joint(
                "revolute", frame("ground"), frame(on), axis=[0, 0, 1], law={"effort": f"{gain}*u"},
            )
            for name, on, gain in (("A", "a", 1.0), ("B", "b", -2.0))
        },
        gravity=[0, 0, 0],
    )  # fmt: skip
    two["inputs"] = {"u": {}}
    simulation = gelenk.Simulation(two)
    simulation.initialize(0.0, 1e-10)
    momentum = 0.0
    for k in range(20):
        u = 1.0 if k % 3 else -0.5
        simulation.set_input("u", u)
        simulation.step_to(0.1 * (k + 1))
        momentum += 0.1 * u
        inertia = 1.0 * 0.5**2 / 3
        assert simulation.output("A.w") == pytest.approx(momentum / inertia, abs=1e-8)
        assert simulation.output("B.w") == pytest.approx(-2 * momentum / inertia, abs=1e-8)


@pytest.mark.parametrize(
    ("force", "message"),
    [
        (
            {"type": "line_force", **ENDS},
            "tension.*an expression of length, rate, t, inputs, states, coordinates of joints in N",
        ),
        ({"type": "line_force", **ENDS, "tension": "80*L"}, r"tension.*column 4: found 'L'"),
        ({"type": "body_force", **AT, "force": "x"}, r"force.*a list of 3"),
        ({"type": "body_force", **AT, "force": [0, "2*q", 0]}, r"force\[2\].*column 3: found 'q'"),
    ],
)
def test_mistakes_are_errors_of_the_scene(force: dict[str, Any], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=r"(?s)forces\.F\." + message):
        gelenk.load(pair({"F": force}, True))


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ({"constants": {"w": 1.0}}, r"constants\.w: found the name 'w', which has a meaning of its own"),
        ({"constants": {"sin": 1.0}}, r"constants\.sin"),
        ({"constants": {"k": "3"}}, r"constants\.k"),
        ({"inputs": {"A": {}}}, r"inputs\.A: found the name of joints\.A"),
        ({"constants": {"u": 1}, "inputs": {"u": {}}}, r"inputs\.u: found the name of constants\.u"),
        ({"inputs": {"u": {"unit": "volt"}}}, r"inputs\.u\.unit: found 'volt', expected a unit of SI"),
        ({"inputs": {"u": 3}}, r"inputs\.u: .*a mapping with unit, start, text"),
    ],
)
def test_names_of_constants_and_inputs(names: dict[str, Any], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(pair({}, True) | names)
