# SPDX-License-Identifier: BSD-3-Clause
"""Wheels that skid on axles and arms, against closed forms and independent integration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from models.skidding import DISC, G, on_the_plane, scene_of
from scipy.integrate import solve_ivp

import gelenk

TOLERANCES = pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
L = 0.8  # m


def wheel_on_an_arm() -> dict[str, Any]:
    """A wheel on a massless arm that turns about the vertical axis and can rise."""
    scene = scene_of(DISC, on_the_plane(DISC, 0, (0, 0), (0, 0, 0)))
    scene["bodies"] |= {"post": {"mass": 0}, "arm": {"mass": 0}}
    scene["joints"] = {
        "turn": {
            "type": "revolute", "axis": [0, 0, 1], "parent": {"body": "ground", "position": [0, 0, 0.3]},
            "child": "post", "start": {"phi": 0, "w": 1, "fixed": True},
        },
        "height": {"type": "prismatic", "axis": [0, 0, 1], "parent": "post", "child": "arm"},
        "hub": {
            "type": "revolute", "axis": [0, 1, 0], "parent": {"body": "arm", "position": [0, L, 0]},
            "child": "wheel", "start": {"phi": 0, "w": 12, "fixed": True},
        },
    }  # fmt: skip
    scene["forces"] = {"rest": {"type": "wrench", "body": "wheel", "torque": [0, 0, 0], "frame": "body"}}
    return scene


@TOLERANCES
def test_a_wheel_on_a_turning_arm(tolerance: float) -> None:
    """As PlanarMechanics.TestDryFrictionWheel.

    With the axis along the arm, (m L^2 + A) dW/dt = -L F and I dw/dt = -r F for the angular velocities W of
    the arm and w about the axis; F = -mu m g sign u while the contact slides with u = -L W - r w.
    """
    m, (A, moment, _), r, mu = DISC.mass, DISC.moments, DISC.radius, DISC.friction
    about = m * L**2 + A

    def rates(_: float, y: Array) -> Array:
        phi_rate, w = y[2:]
        force = mu * m * G
        u = -L * phi_rate - r * w  # of the contact point along x, at phi = 0
        force *= -np.sign(u)
        return np.array([phi_rate, w, -L * force / about, -r * force / moment])

    def stops(_: float, y: Array) -> float:
        return float(L * y[2] + r * y[3])

    stops.terminal = True  # type: ignore[attr-defined]
    exact = solve_ivp(rates, (0, 5), [0, 0, 1, 12], method="DOP853", rtol=1e-12, atol=1e-13, events=stops)
    run = gelenk.simulate(wheel_on_an_arm(), stop=2, step=0.02, tolerance=tolerance, integrator="erk")
    (event,) = [t for t, text in run.events if "stops sliding" in text]
    assert event == pytest.approx(exact.t[-1], abs=100 * tolerance)
    after = run.time > event
    assert after.any()
    phi = exact.y[0, -1] + exact.y[2, -1] * (run.time[after] - exact.t[-1])
    assert np.abs(run["turn.phi"][after] - phi).max() <= 100 * tolerance
    assert np.abs(run["hub.w"][after] - exact.y[3, -1]).max() <= 1000 * tolerance


def wheel_set(pull: float = 0.0) -> dict[str, Any]:
    """Two wheels on an axle, as MultiBody's RollingWheelSet, which torques drive or a force pulls."""
    sides = {"left": 0.5, "right": -0.5}
    wheel = scene_of(DISC, on_the_plane(DISC, 0, (0, 0), (0, 0, 0)))
    body = wheel["bodies"]["wheel"]
    return {
        **wheel,
        "bodies": {
            "heading": {"mass": 0}, "level": {"mass": 0}, "axle": {"mass": 6.0, "inertia": [0.5, 0.1, 0.5]},
            "left": body, "right": body,
        },
        "joints": {
            "ride": {
                "type": "planar", "parent": "ground", "child": "heading",
                "start": {"s_x": 0, "s_y": 0, "phi": 0, "v_x": 0, "v_y": 0, "w": 0, "fixed": True},
            },
            "height": {"type": "prismatic", "axis": [0, 0, 1], "parent": "heading", "child": "level",
                       "start": {"s": 0.3, "v": 0, "fixed": True}},
            "roll": {"type": "revolute", "axis": [1, 0, 0], "parent": "level", "child": "axle",
                     "start": {"phi": 0, "w": 0, "fixed": True}},
            **{
                name: {
                    "type": "revolute", "axis": [0, 1, 0],
                    "parent": {"body": "axle", "position": [0, y, 0]}, "child": name,
                    "start": {"phi": 0, "w": 0, "fixed": True},
                }
                for name, y in sides.items()
            },
        },
        "motors": {f"drive_{name}": {"joint": name} for name in sides},
        "forces": {"pull": {"type": "wrench", "body": "axle", "force": [pull, 0, 0], "frame": "world"}},
    }  # fmt: skip


@pytest.mark.parametrize("factor", [0.9, 1.5])
def test_a_wheel_set_that_is_driven(factor: float) -> None:
    """It rolls with a = 2 T / (r (M + 2 I / r^2)) up to forces of mu N each, and slips beyond."""
    M, (_, moment, _), r, mu = 6.0 + 2 * DISC.mass, DISC.moments, DISC.radius, DISC.friction
    limit = mu * M * G / 2 * r * (1 + 2 * moment / (M * r**2))
    torque = factor * limit
    inputs = {f"drive_{name}.tau": torque for name in ("left", "right")}
    run = gelenk.simulate(wheel_set(), stop=1, step=0.25, tolerance=1e-9, integrator="erk", inputs=inputs)
    a = min(mu * G, 2 * torque / (r * (M + 2 * moment / r**2)))
    w = a / r if factor < 1 else (torque - mu * M * G / 2 * r) / moment
    assert run["ride.v_x"][-1] == pytest.approx(a, abs=1e-9)
    assert run["left.w"][-1] == pytest.approx(w, abs=1e-7)
    assert run["ride.s_x"][-1] == pytest.approx(a / 2, abs=1e-9)
    assert abs(run["ride.phi"][-1]) <= 1e-12


@pytest.mark.parametrize("factor", [0.9, 1.5])
def test_a_wheel_set_that_is_pulled(factor: float) -> None:
    """To turn along, the wheels need I a / r^2 each; beyond mu N they slip, and F - mu M g accelerates it."""
    M, (_, moment, _), r, mu = 6.0 + 2 * DISC.mass, DISC.moments, DISC.radius, DISC.friction
    rolling = M + 2 * moment / r**2
    limit = mu * M * G * rolling / (2 * moment / r**2)
    run = gelenk.simulate(wheel_set(factor * limit), stop=0.5, step=0.25, tolerance=1e-9, integrator="erk")
    a = factor * limit / rolling if factor < 1 else (factor * limit - mu * M * G) / M
    w = a / r if factor < 1 else mu * M * G / 2 * r / moment
    assert run["ride.v_x"][-1] == pytest.approx(a / 2, abs=1e-8)
    assert run["left.w"][-1] == pytest.approx(w / 2, abs=1e-7)
