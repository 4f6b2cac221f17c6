# SPDX-License-Identifier: BSD-3-Clause
"""Sliding that comes to rest under a load from the side, smaller than friction, by all integrators.

With the constant load F, friction c, speed v and angle a between load and velocity of a mass m,
m v' = F cos a - c and m v a' = -F sin a. Then v (c + F cos a) decreases uniformly, at the rate
(c^2 - F^2) / m, and v^2 sin a (2 c + F cos a) and v^2 (F + 2 c cos a + F cos^2 a) are in proportion to the
ways that are left, across the load and along it. The slower it slides, the faster friction turns it: steps
that do not follow pass by the stop, and creep on.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned

import gelenk

from .test_isotropic_friction import FORCE, INERTIA, MASS, MOMENT, Source, ball, columns, puck, run, wrench

pytestmark = [warned.GUESSES, warned.TIGHT, warned.STILL, warned.GYRATION, warned.MOVING]

# Errors of the place after the stop: of methods with fixed steps of 1 ms by their order.
ERRORS = {
    "erk": 1e-9,
    "auto": 1e-9,
    "dirk": 1e-9,
    "cvode": 1e-9,
    "cvode-adams": 1e-9,
    "ida": 1e-9,
    "rk4": 1e-8,
    "newmark": 1e-6,
    "hht": 1e-6,
    "generalized-alpha": 1e-6,
}
LOADS = [(0.5, 1.4), (0.58, 2.0), (0.1, 0.3), (0.9, 2.9)]  # of friction; rad to the velocity


def stop_of(
    mass: float, friction: float, part: float, angle: float, speed: float
) -> tuple[float, float, float]:
    """The time until rest, and the ways along the load and across it."""
    load = part * friction
    c = math.cos(angle)
    time = mass * speed * (friction + load * c) / (friction**2 - load**2)
    along = mass * speed**2 * (load + 2 * friction * c + load * c**2) / (4 * (friction**2 - load**2))
    across = mass * speed**2 * math.sin(angle) * (2 * friction + load * c) / (4 * friction**2 - load**2)
    return time, along, across


def pushed_puck(
    part: float, angle: float, speed: float, *, turned: float = 0.0, static: float = 1.0
) -> Source:
    d, e = turned, turned + angle
    friction = {"translation": {"coulomb": FORCE, "static": static * FORCE}}
    source = puck(friction, v=[speed * math.cos(e), speed * math.sin(e)])
    load = part * FORCE
    source["forces"] = {"F": wrench("puck", force=[load * math.cos(d), load * math.sin(d), 0])}
    return source


@pytest.mark.parametrize("integrator", ERRORS)
@pytest.mark.parametrize(("part", "angle"), LOADS)
def test_a_puck_pushed_across_stops(integrator: str, part: float, angle: float) -> None:
    speed, turned = 0.8, 0.4
    time, along, across = stop_of(MASS, FORCE, part, angle, speed)
    found = run(pushed_puck(part, angle, speed, turned=turned), integrator, stop=time + 0.5)
    assert len(found.events) >= 1
    assert found["P.friction.translation.mode"][-1] == 0
    stopped = found.time > time + 1e-3
    assert np.abs(found["P.v_x"][stopped]).max() < 1e-15
    assert np.abs(found["P.v_y"][stopped]).max() < 1e-15
    c, s = math.cos(turned), math.sin(turned)
    ways = np.array([c * along - s * across, s * along + c * across])
    error = np.array([found["P.s_x"][-1], found["P.s_y"][-1]]) - ways
    assert np.abs(error).max() < ERRORS[integrator]


@pytest.mark.parametrize("integrator", ["auto", "rk4", "cvode", "ida", "dirk", "erk"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_at_loose_tolerances(integrator: str, tolerance: float) -> None:
    """It stops, however loosely errors are controlled, and static friction keeps it there."""
    part, angle, speed = 0.58, 2.0, 0.8
    time, along, across = stop_of(MASS, FORCE, part, angle, speed)
    source = pushed_puck(part, angle, speed, static=1.3)
    found = run(source, integrator, stop=time + 0.5, tolerance=tolerance)
    assert found["P.friction.translation.mode"][-1] == 0
    assert np.hypot(found["P.v_x"], found["P.v_y"])[found.time > time + 0.02].max() < 1e-15
    error = np.hypot(found["P.s_x"][-1] - along, found["P.s_y"][-1] - across)
    assert error < 30 * tolerance


@pytest.mark.parametrize("integrator", ["auto", "rk4", "newmark", "ida"])
def test_a_ball_turned_across_stops(integrator: str) -> None:
    """The angular velocity of a ball with equal inertias stays in the plane that it has with the moment."""
    part, angle, speed = 0.6, 2.0, 0.9
    time, _, _ = stop_of(INERTIA, MOMENT, part, angle, speed)
    c, s = math.cos(angle), math.sin(angle)
    load, start = np.array([0.48, 0.6, -0.64]), np.array([0.8, 0, 0.6])
    assert load @ start == pytest.approx(0)
    source = ball({"coulomb": MOMENT}, w=list(speed * (c * load + s * start)))
    source["forces"] = {"F": wrench("ball", torque=list(part * MOMENT * load))}
    source["forces"]["F"]["frame"] = "world"
    found = run(source, integrator, stop=time + 0.3)
    assert np.abs(columns(found, "J.w")[found.time > time + 1e-3]).max() < 1e-15
    stop = next(at for at, text in found.events if text == "J sticks in its rotation")
    assert stop == pytest.approx(time, abs=1e-8 if integrator != "newmark" else 1e-5)


@pytest.mark.parametrize("integrator", ["auto", "erk", "rk4", "newmark", "moreau-jean"])
def test_a_box_on_the_ground_pushed_across_stops(integrator: str) -> None:
    """The same of contacts: the center of mass is where the box touches, so that its corners bear alike."""
    mu, gravity = 0.3, 9.81
    part, angle, speed = 0.58, 2.0, 0.8
    friction = mu * MASS * gravity
    time, along, across = stop_of(MASS, friction, part, angle, speed)
    source: Source = {
        "gelenk": 1,
        "gravity": [0, 0, -gravity],
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "bodies": {
            "box": {
                "mass": MASS,
                "com": [0, 0, 0],
                "inertia": [0.1, 0.1, 0.2],
                "shapes": {"b": {"box": [0.4, 0.4, 0.2], "position": [0, 0, 0.1], "surface": "box"}},
            }
        },
        "joints": {
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "box",
                "start": {
                    "v": [speed * math.cos(angle), speed * math.sin(angle), 0],
                    "fixed": True,
                },
            }
        },
        "contacts": {"c": {"between": ["floor", "box"], "friction": mu}},
        "forces": {"F": wrench("box", force=[part * friction, 0, 0])},
    }
    found = run(source, integrator, stop=time + 0.3, tolerance=1e-8)
    stopped = found.time > time + 5e-3
    assert np.abs(columns(found, "J.v")[stopped]).max() < 1e-12
    error = np.hypot(found["J.r[1]"][-1] - along, found["J.r[2]"][-1] - across)
    assert error < {"moreau-jean": 1e-3, "newmark": 1e-5}.get(integrator, 1e-7)


def tree(friction: Source, *, branches: bool, seed: int) -> Source:
    """Three rods on ball joints, one after the other, or two at the end of the first."""
    rng = np.random.default_rng(seed)
    source: Source = {"gelenk": 1, "gravity": [0, 0, -9.81], "bodies": {}, "joints": {}, "states": {}}
    for k in range(3):
        source["bodies"][f"b{k}"] = {"mass": 1.1, "com": [0, 0, -0.3], "inertia": [0.04, 0.05, 0.02]}
        before = {"body": f"b{0 if branches else k - 1}", "position": [0.1 * k if branches else 0, 0, -0.6]}
        source["joints"][f"J{k}"] = {
            "type": "spherical",
            "parent": before if k > 0 else "ground",
            "child": f"b{k}",
            "friction": friction,
            "start": {"w": list(rng.uniform(-2, 2, 3)), "fixed": True},
        }
        source["states"][f"turned{k}"] = {"rate": f"sqrt(J{k}.w[1]^2 + J{k}.w[2]^2 + J{k}.w[3]^2)"}
    source["sensors"] = {"E": {"type": "energy"}}
    return source


@pytest.mark.parametrize("integrator", ["auto", "dirk"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize(
    ("branches", "seed", "coulomb", "static"),
    [
        (False, 4, 0.3, 0.4),
        (False, 104, 0.6, 0.6),
        (True, 103, 0.6, 0.6),
        (True, 107, 0.6, 0.6),
        (True, 102, 0.3, 0.4),
    ],
)
def test_trees_of_ball_joints_lose_what_friction_dissipates(
    integrator: str, tolerance: float, branches: bool, seed: int, coulomb: float, static: float
) -> None:
    """Joints stick and slip again many times; each run takes a fraction of the work that a step may take."""
    source = tree({"coulomb": coulomb, "static": static}, branches=branches, seed=seed)
    source["solver"] = {"integrator": integrator, "max_evaluations": 100_000}
    found = gelenk.simulate(source, stop=3.0, step=0.01, tolerance=tolerance)
    energy = found["E.kinetic"] + found["E.potential"]
    left = energy + coulomb * sum(found[f"turned{k}"] for k in range(3))
    assert np.abs(left - left[0]).max() < 300 * tolerance
    assert energy[0] - energy[-1] > 0.5
    assert len(found.events) >= 3
