# SPDX-License-Identifier: BSD-3-Clause
"""Dry friction of a ball joint, a moment, and of the translation of a planar joint, a force in any direction,
compared with closed forms, with each other in other frames, and by all integrators.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import warned

import gelenk

pytestmark = [warned.GUESSES, warned.TIGHT, warned.STILL]

Source = dict[str, Any]
INTEGRATORS = ["auto", "erk", "dirk", "cvode", "ida", "rk4"]
INERTIA = 0.35  # of a ball, about any axis
MASS = 1.7
MOMENT, FORCE = 0.21, 2.9  # of friction


def ball(
    friction: Source, *, w: list[float] | None = None, inertia: list[float] | None = None, **more: Any
) -> Source:
    """A body on a ball joint, its center of mass in the joint."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, 0],
        "bodies": {"ball": {"mass": MASS, "com": [0, 0, 0], "inertia": inertia or [INERTIA] * 3}},
        "joints": {
            "J": {
                "type": "spherical",
                "parent": "ground",
                "child": "ball",
                "friction": friction,
                "start": {"w": w or [0, 0, 0], "fixed": True},
            }
        },
        **more,
    }


def puck(
    friction: Source, *, v: list[float] | None = None, phi: float = 0.0, w: float = 0.0, **more: Any
) -> Source:
    """A body on a planar joint, whose center of mass is the joint."""
    speeds = v or [0, 0]
    return {
        "gelenk": 1,
        "gravity": [0, 0, 0],
        "bodies": {"puck": {"mass": MASS, "com": [0, 0, 0], "inertia": [0.1, 0.2, 0.3]}},
        "joints": {
            "P": {
                "type": "planar",
                "parent": "ground",
                "child": "puck",
                "friction": friction,
                "start": {"phi": phi, "v_x": speeds[0], "v_y": speeds[1], "w": w, "fixed": True},
            }
        },
        **more,
    }


def run(
    source: Source, integrator: str = "erk", *, stop: float = 1.0, tolerance: float = 1e-10, **more: Any
) -> Any:
    solver = {"integrator": integrator, **more}
    return gelenk.simulate({**source, "solver": solver}, stop=stop, step=0.01, tolerance=tolerance)


def columns(result: Any, name: str, count: int = 3) -> np.ndarray:
    return np.stack([result[f"{name}[{k + 1}]"] for k in range(count)], axis=1)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_ball_slows_down_uniformly_and_stops(integrator: str) -> None:
    w0 = np.array([0.3, -0.2, 0.25])
    speed = np.linalg.norm(w0)
    stops = INERTIA * speed / MOMENT
    found = run(ball({"coulomb": MOMENT}, w=list(w0)), integrator)
    t = found.time
    expected = np.maximum(0, 1 - t / stops)[:, None] * w0
    assert np.abs(columns(found, "J.w") - expected).max() < 2e-9
    rest = t > stops
    assert np.all(columns(found, "J.w")[rest] == 0)
    turned = speed * np.where(rest, stops / 2, t - t**2 / 2 / stops)
    assert np.abs(found["J.Q[4]"] - np.cos(turned / 2)).max() < 2e-9
    moving = t < stops - 0.01
    left = (1 - t / stops)[moving]  # of the velocity, whose direction it has
    error = np.abs(columns(found, "J.friction.tau")[moving] + MOMENT * w0 / speed).max(axis=1)
    assert (left * error).max() < 2e-9
    assert np.all(columns(found, "J.friction.tau")[rest] == 0)
    assert set(found["J.friction.mode"][moving]) == {1}
    assert set(found["J.friction.mode"][rest]) == {0}


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_puck_slides_straight_and_stops(integrator: str) -> None:
    v0 = np.array([0.7, -1.1])
    speed = np.linalg.norm(v0)
    stops = MASS * speed / FORCE
    found = run(puck({"translation": {"coulomb": FORCE}}, v=list(v0), w=3.0), integrator)
    t = found.time
    v = np.stack([found["P.v_x"], found["P.v_y"]], axis=1)
    s = np.stack([found["P.s_x"], found["P.s_y"]], axis=1)
    assert np.abs(v - np.maximum(0, 1 - t / stops)[:, None] * v0).max() < 2e-9
    rest = t > stops
    assert rest.sum() > 10
    assert np.abs(v[rest]).max() < 1e-15
    way = np.where(rest, stops / 2, t - t**2 / 2 / stops)
    assert np.abs(s - way[:, None] * v0).max() < 2e-9
    assert np.abs(found["P.w"] - 3.0).max() < 1e-10
    moving = t < stops - 0.01
    force = columns(found, "P.friction.translation.f", 2)
    # Its direction is that of a velocity known to the tolerance, which vanishes.
    left = (1 - t / stops)[moving]
    assert (left * np.abs(force[moving] + FORCE * v0 / speed).max(axis=1)).max() < 2e-9


def wrench(body: str, **parts: list[float]) -> Source:
    return {"type": "wrench", "body": body, **parts}


DIRECTIONS = [[1, 0, 0], [0, 0, 1], [0.6, -0.8, 0], [0.48, 0.6, -0.64]]


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("integrator", ["auto", "ida", "moreau-jean"])
def test_the_threshold_of_a_moment_is_the_same_about_any_axis(
    integrator: str, direction: list[float]
) -> None:
    """At rest, a torque is held up to the static moment; one above it turns the ball."""
    d = np.array(direction)
    static = 1.25 * MOMENT
    # A step finds out that it slips by the speed that it gets.
    excess = 1e-4 if integrator == "moreau-jean" else 1e-9
    for part in (1 - 1e-9, 1 + excess):
        torque = part * static * d
        source = ball(
            {"coulomb": MOMENT, "static": static},
            inertia=[0.2, 0.4, 0.35],
            forces={"F": wrench("ball", torque=list(torque))},
        )
        more = {"step": 0.005, "cone_tolerance": 1e-12} if integrator == "moreau-jean" else {}
        found = run(source, integrator, stop=0.1, **more)
        speed = np.linalg.norm(columns(found, "J.w"), axis=1)
        if part < 1:
            assert speed.max() < 1e-15
            assert np.abs(columns(found, "J.friction.tau") + torque).max() < 1e-11
        else:
            assert speed[-1] > 0.01
            assert found["J.friction.mode"][-1] == 1


@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 2, 2.5])
def test_a_spring_is_held_in_any_direction(angle: float) -> None:
    """A puck on springs stays where they pull with less than the static friction, and slides beyond."""
    k, static = 40.0, 1.5 * FORCE
    d = np.array([math.cos(angle), math.sin(angle)])
    for part in (1 - 1e-9, 1 + 1e-9):
        source = puck({"translation": {"coulomb": FORCE, "static": static}}, phi=0.7)
        joint = source["joints"]["P"]
        joint["stiffness"] = [k, k, 0]
        joint["start"] |= {"s_x": part * static / k * d[0], "s_y": part * static / k * d[1]}
        found = run(source, stop=0.3)
        s = np.stack([found["P.s_x"], found["P.s_y"]], axis=1)
        if part < 1:
            assert np.abs(s - s[0]).max() < 1e-15
            force = columns(found, "P.friction.translation.f", 2)
            assert np.abs(force - k * s).max() < 1e-11
            continue
        # Against constant friction it oscillates about d FORCE / k, and comes to rest after half a period.
        omega = math.sqrt(k / MASS)
        start, middle = part * static / k, FORCE / k
        along = middle + (start - middle) * np.cos(omega * np.minimum(found.time, math.pi / omega))
        assert np.abs(s - along[:, None] * d).max() < 1e-9


def test_turned_in_the_plane_it_is_the_same() -> None:
    """A puck on unlike springs: with axes turned by any angle, the same curve."""

    def curve(angle: float) -> np.ndarray:
        c, s = math.cos(angle), math.sin(angle)
        R = np.array([[c, -s], [s, c]])
        x0, v0 = R @ [0.2, 0.05], R @ [-0.3, 0.9]
        source = puck({"translation": {"coulomb": 0.3 * FORCE, "static": 0.4 * FORCE}}, v=list(v0), w=0.4)
        source["joints"]["P"]["start"] |= {"s_x": x0[0], "s_y": x0[1]}
        turned = {"body": "ground", "rotation": {"axis": [0, 0, 1], "angle": angle}}
        source["forces"] = {
            "B": {"type": "bushing", "from": turned, "to": "puck", "stiffness": [40, 90, 0]},
        }
        found = run(source, stop=5.0)
        assert found["P.friction.translation.mode"][-1] == 0
        return np.asarray(np.stack([found["P.s_x"], found["P.s_y"]], axis=1) @ R)

    straight = curve(0.0)
    for angle in (0.3, math.pi / 2, -2.0):
        assert np.abs(curve(angle) - straight).max() < 2e-9


def test_along_an_axis_it_is_the_friction_of_one_coordinate() -> None:
    k = 40.0
    results = []
    for friction in (
        {"translation": {"coulomb": FORCE, "static": 1.2 * FORCE}},
        {"s_x": {"coulomb": FORCE, "static": 1.2 * FORCE}},
    ):
        source = puck(friction)
        source["joints"]["P"]["stiffness"] = [k, 0, 0]
        source["joints"]["P"]["start"]["s_x"] = 0.5
        results.append(run(source, stop=2.0))
    for name in ("P.s_x", "P.v_x"):
        assert np.abs(results[0][name] - results[1][name]).max() < 1e-9


def test_dissipated_energy() -> None:
    """What a tumbling body loses is the moment times the angle that it turns through."""
    source = ball({"coulomb": MOMENT}, w=[1.0, -2.0, 0.5], inertia=[0.2, 0.4, 0.5])
    found = run(source, stop=5.0)
    w = columns(found, "J.w")
    inertia = np.array([0.2, 0.4, 0.5])
    kinetic = (inertia * w**2).sum(axis=1) / 2
    power = (columns(found, "J.friction.tau") * w).sum(axis=1)
    assert np.abs(power + MOMENT * np.linalg.norm(w, axis=1)).max() < 1e-9
    moving = found["J.friction.mode"] == 1
    t = found.time
    # Simpson's rule over pairs of steps.
    n = (moving.sum() - 2) // 2 * 2
    lost = (t[2] - t[0]) / 6 * (power[0:n:2] + 4 * power[1 : n + 1 : 2] + power[2 : n + 2 : 2]).sum()
    assert kinetic[n] - kinetic[0] == pytest.approx(lost, abs=1e-8)
    assert np.all(w[-1] == 0)
