# SPDX-License-Identifier: BSD-3-Clause
"""A limit that is struck beside a one-way clutch: the clutch holds in both phases of Poisson's impact.

In both schemes, with joints of one coordinate and of several, beside friction and stops.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene
from models.both_schemes import Case, assert_steps_converge
from models.running import assert_close

import gelenk

MASS, INERTIA, SLIDER = 1.0, 0.05, 0.2  # kg, kg m2, kg
LOWER = -0.4  # rad
W = -6.0  # rad/s
TOLERANCE = 1e-9  # m/s
GRID = 5e-5  # s: communication steps
WITHIN_GRID = 40 * GRID  # rad/s, m/s: forces change velocities by less than 40 times its length


def crank_on_a_slider(kind: str, com: float, free: str, law: str, restitution: float) -> Scene:
    """A crank without forces, whose shaft slides freely in one direction along y."""
    limit = {"lower": LOWER, "restitution": restitution, "law": law}
    crank = body(MASS, (com, 0, 0), (INERTIA, INERTIA, INERTIA))
    if kind == "planar":
        start = {"phi": -0.3, "w": W, "s_x": 0.0, "s_y": 0.0, "v_x": 0.0, "v_y": 0.0, "fixed": True}
        J = joint(
            "planar",
            frame("ground"),
            frame("crank"),
            start=start,
            limit={"phi": limit},
            one_way={"s_y": {"free": free}},
        )
        return scene({"crank": crank}, {"J": J})
    Y = joint(
        "prismatic",
        frame("ground"),
        frame("slider"),
        axis=[0, 1, 0],
        one_way={"free": free},
        start={"s": 0.0, "v": 0.0, "fixed": True},
    )
    R = joint(
        "revolute",
        frame("slider"),
        frame("crank"),
        axis=[0, 0, 1],
        limit=limit,
        start={"phi": -0.3, "w": W, "fixed": True},
    )
    return scene({"slider": body(SLIDER), "crank": crank}, {"Y": Y, "R": R})


@pytest.mark.parametrize(("integrator", "step"), [("erk", 1e-3), ("dirk", 1e-3), ("moreau-jean", 1e-5)])
@pytest.mark.parametrize(("law", "restitution"), [("poisson", 0.5), ("poisson", 0.9), ("newton", 0.5)])
@pytest.mark.parametrize("com", [0.3, -0.3])
@pytest.mark.parametrize("free", ["negative", "positive"])
@pytest.mark.parametrize("kind", ["separate", "planar"])
def test_a_limit_throws_back_beside_a_clutch(
    kind: str, free: str, com: float, law: str, restitution: float, integrator: str, step: float
) -> None:
    """Closed form: e w where the impulse presses the clutch, which holds; else it is thrown off.

    Without friction, the momentum along y is that of before; before, the clutch may hold or not.
    """
    source = crank_on_a_slider(kind, com, free, law, restitution)
    simulation = gelenk.Simulation({**source, "solver": {"integrator": integrator, "step": step}})
    simulation.initialize(tolerance=1e-10)
    w, v = ("J.w", "J.v_y") if kind == "planar" else ("R.w", "Y.v")
    now = [float(simulation.output(name)) for name in (w, v)]
    for k in range(1000):
        before = now
        simulation.step_to((k + 1) * GRID)
        now = [float(simulation.output(name)) for name in (w, v)]
        if now[0] > 0:
            break
    assert_close("w", now[0], -restitution * before[0], WITHIN_GRID, "of the scheme and in a grid interval")
    mass = MASS if kind == "planar" else MASS + SLIDER
    thrown = -MASS * com * np.cos(LOWER) * (now[0] - before[0]) / mass
    is_pressed = (thrown < 0) == (free == "positive") and abs(before[1]) < TOLERANCE
    expected = 0.0 if is_pressed else before[1] + thrown
    assert_close("v", now[1], expected, WITHIN_GRID, "of the scheme and in a grid interval")


def wrist(kind: str, com: float, law: str) -> Case:
    """A crank between two limits on two slides: a stop, a one-way clutch, and friction in all."""
    limit = {"lower": LOWER, "upper": 0.3, "restitution": 0.5, "law": law}
    stop = {"lower": -0.02, "upper": 0.02, "stiffness": 300.0, "damping": 2.0}
    friction = {"coulomb": 0.2, "static": 0.3}
    clutch = {"free": "negative"}
    bodies: dict[str, Any] = {"crank": body(MASS, (com, 0.02, 0), (INERTIA, INERTIA, INERTIA))}
    if kind == "planar":
        start = {"phi": -0.05, "w": W, "s_x": 0.0, "s_y": 0.0, "v_x": 0.0, "v_y": 0.0, "fixed": True}
        J = joint("planar", frame("ground"), frame("crank"), start=start, limit={"phi": limit},
                  stop={"s_x": stop}, one_way={"s_y": clutch},
                  friction={"phi": friction, "s_x": friction, "s_y": friction})  # fmt: skip
        return Case(scene(bodies, {"J": J}), 0.25, {}, error=0.1)
    at_rest = {"s": 0.0, "v": 0.0, "fixed": True}
    bodies |= {"x": body(0.1), "y": body(SLIDER)}
    joints = {
        "X": joint("prismatic", frame("ground"), frame("x"), axis=[1, 0, 0], start=at_rest,
                   stop=stop, friction=friction),
        "Y": joint("prismatic", frame("x"), frame("y"), axis=[0, 1, 0], start=at_rest,
                   one_way=clutch, friction=friction),
        "R": joint("revolute", frame("y"), frame("crank"), axis=[0, 0, 1], limit=limit, friction=friction,
                   start={"phi": -0.05, "w": W, "fixed": True}),
    }  # fmt: skip
    return Case(scene(bodies, joints), 0.25, {}, error=0.1)


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("com", [0.3, -0.3])
@pytest.mark.parametrize("kind", ["separate", "planar"])
def test_steps_converge_beside_friction_and_stops(kind: str, com: float, law: str) -> None:
    assert_steps_converge(wrist(kind, com, law))
