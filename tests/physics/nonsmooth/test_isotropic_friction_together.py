# SPDX-License-Identifier: BSD-3-Clause
"""Friction along several velocities together beside loops, limits, contacts, impacts and other friction."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import warned

import gelenk

from .test_isotropic_friction import (
    FORCE,
    INERTIA,
    MASS,
    MOMENT,
    Source,
    ball,
    columns,
    puck,
    run,
    wrench,
)

pytestmark = [warned.GUESSES, warned.TIGHT, warned.STILL, warned.GYRATION]
G = 9.81


@pytest.mark.parametrize("reversed_joint", [False, True])
def test_reversed_and_turned_in_space(reversed_joint: bool) -> None:
    """Parent and child exchanged, in frames turned by any rotation: it stops at the same instant."""
    w0 = np.array([0.3, -0.2, 0.25])
    source = ball({"coulomb": MOMENT, "static": 2 * MOMENT}, w=list(w0))
    joint = source["joints"]["J"]
    on_ground = {"body": "ground", "rotation": {"rpy": [0.4, -1.1, 2.0]}}
    on_ball = {"body": "ball", "rotation": {"rpy": [1.3, 0.2, -0.7]}}
    joint["parent"], joint["child"] = (on_ball, on_ground) if reversed_joint else (on_ground, on_ball)
    found = run(source)
    stops = INERTIA * np.linalg.norm(w0) / MOMENT
    speed = np.linalg.norm(columns(found, "J.w"), axis=1)
    assert np.abs(speed - np.linalg.norm(w0) * np.maximum(0, 1 - found.time / stops)).max() < 1e-9
    moving = found.time < stops - 0.01
    tau, w = columns(found, "J.friction.tau")[moving], columns(found, "J.w")[moving]
    along = (tau * w).sum(axis=1) / np.linalg.norm(w, axis=1)
    assert np.abs(along + MOMENT).max() < 1e-12


@pytest.mark.parametrize("axis", [[0, 0, 1], [1, 0, 0], [0.6, 0, 0.8]])
def test_disc_on_a_turned_plane(axis: list[float]) -> None:
    """On a slope, weight below the static friction is held, and above it moves the puck down."""
    n = np.array(axis)
    down = np.array([0, 0, -G]) - n * (n @ [0, 0, -G])
    pull = MASS * np.linalg.norm(down)
    for part in (1 - 1e-9, 1.2):
        limit = pull / part if pull > 0 else FORCE
        source = puck({"translation": {"coulomb": 0.5 * limit, "static": limit}})
        source["gravity"] = [0, 0, -G]
        source["joints"]["P"]["axis"] = axis
        found = run(source, stop=0.5)
        speed = np.hypot(found["P.v_x"], found["P.v_y"])
        if part < 1 or pull == 0:
            assert speed.max() < 1e-14
        else:
            expected = (pull - 0.5 * limit) / MASS * found.time
            assert np.abs(speed - expected).max() < 1e-9
            force = columns(found, "P.friction.translation.f", 2)[1:]
            power = force[:, 0] * found["P.v_x"][1:] + force[:, 1] * found["P.v_y"][1:]
            assert np.abs(power + 0.5 * limit * speed[1:]).max() < 1e-9


def test_a_planar_joint_that_closes_a_loop() -> None:
    """Two planar joints between the same bodies, of which the one with friction may close the loop."""
    v0 = np.array([0.7, -1.1])
    for with_friction in ("P", "Q"):
        source = puck({"translation": {"coulomb": FORCE}}, v=list(v0))
        joint = source["joints"]["P"]
        source["joints"]["Q"] = {key: joint[key] for key in ("type", "parent", "child", "friction")}
        del source["joints"]["Q" if with_friction == "P" else "P"]["friction"]
        found = run(source)
        stops = MASS * np.linalg.norm(v0) / FORCE
        left = np.maximum(0, 1 - found.time / stops)
        assert np.abs(found["P.v_x"] - left * v0[0]).max() < 1e-9
        assert np.abs(found["Q.v_y"] - left * v0[1]).max() < 1e-9


def between_two_ball_joints(first: Source | None, second: Source | None, torque: float, w: float) -> Source:
    """A rod that can turn about its axis alone; one of its joints closes the loop."""
    axis = np.array([0.36, 0.48, 0.8])
    a = {
        "type": "spherical",
        "parent": "ground",
        "child": "rod",
        "start": {"w": list(w * axis), "fixed": True},
    }
    b = {
        "type": "spherical",
        "parent": {"body": "ground", "position": list(axis)},
        "child": {"body": "rod", "position": list(axis)},
    }
    if first:
        a["friction"] = first
    if second:
        b["friction"] = second
    return {
        "gelenk": 1,
        "gravity": [0, 0, 0],
        "bodies": {"rod": {"mass": 2, "com": list(axis / 2), "inertia": [INERTIA] * 3}},
        "joints": {"A": a, "B": b},
        "forces": {"F": wrench("rod", torque=list(torque * axis))},
    }


BOTH = [
    ({"coulomb": MOMENT}, None),
    (None, {"coulomb": MOMENT}),
    ({"coulomb": 0.4 * MOMENT}, {"coulomb": 0.6 * MOMENT}),
]


@pytest.mark.parametrize(("first", "second"), BOTH)
@pytest.mark.parametrize("integrator", ["erk", "ida"])
def test_in_a_loop(first: Source | None, second: Source | None, integrator: str) -> None:
    """Friction of the joint of the tree, of the one that closes the loop, and of both together."""
    for part in (1 - 1e-9, 1 + 1e-4):
        found = run(between_two_ball_joints(first, second, part * MOMENT, 0.0), integrator, stop=0.2)
        speed = np.linalg.norm(columns(found, "A.w"), axis=1)
        assert np.abs(speed - max(0, part - 1) * MOMENT / INERTIA * found.time).max() < 1e-9
        if part < 1:
            assert speed.max() < 1e-15
    found = run(between_two_ball_joints(first, second, 0.0, 0.4), integrator)
    stops = INERTIA * 0.4 / MOMENT
    speed = np.linalg.norm(columns(found, "A.w"), axis=1)
    assert np.abs(speed - 0.4 * np.maximum(0, 1 - found.time / stops)).max() < 1e-9
    assert np.all(speed[found.time > stops] < 1e-15)


def test_a_parallelogram_with_a_ball_joint() -> None:
    """The coupler does not turn: friction of a ball joint of the loop is that of the crank."""

    def loop(in_ball: bool) -> Source:
        crank = {"mass": 0.8, "com": [0, 0, -0.2], "inertia": [0.01, 0.01, 0.001]}
        revolute = {"type": "revolute", "axis": [0, 1, 0]}
        joints: Source = {
            "A": {
                **revolute,
                "parent": "ground",
                "child": "left",
                "start": {"phi": 0.9, "w": -1.0, "fixed": True},
            },
            "B": {**revolute, "parent": {"body": "left", "position": [0, 0, -0.4]}, "child": "coupler"},
            "D": {**revolute, "parent": {"body": "ground", "position": [0.5, 0, 0]}, "child": "right"},
            "C": {
                "type": "spherical",
                "parent": {"body": "coupler", "position": [0.5, 0, 0]},
                "child": {"body": "right", "position": [0, 0, -0.4]},
            },
        }
        joints["C" if in_ball else "A"]["friction"] = {"coulomb": 1.5, "static": 2.5}
        return {
            "gelenk": 1,
            "gravity": [0, 0, -G],
            "bodies": {"left": crank, "right": crank, "coupler": {"mass": 1, "inertia": [0.01, 0.02, 0.02]}},
            "joints": joints,
        }

    found, expected = run(loop(True), stop=3.0), run(loop(False), stop=3.0)
    assert expected["A.w"][-1] == 0
    assert expected["A.phi"][-1] != 0
    assert np.abs(found["A.phi"] - expected["A.phi"]).max() < 1e-9
    assert abs(found["A.w"][-1]) < 1e-14


def test_energy_of_two_ball_joints_in_series_beside_limits() -> None:
    """A double pendulum of ball joints with elastic limits loses what both frictions dissipate."""

    def moments(name: str) -> str:
        return f"sqrt({name}.w[1]^2 + {name}.w[2]^2 + {name}.w[3]^2)"

    rod = {"mass": 1.1, "com": [0, 0, -0.3], "inertia": [0.04, 0.05, 0.02]}
    limit = {"swing": 1.1, "restitution": 1.0}
    source: Source = {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {"upper": rod, "lower": rod},
        "joints": {
            "A": {
                "type": "spherical",
                "parent": "ground",
                "child": "upper",
                "friction": {"coulomb": 0.3, "static": 0.4},
                "limit": limit,
                "start": {"w": [1.0, 2.5, 0.5], "fixed": True},
            },
            "B": {
                "type": "spherical",
                "parent": {"body": "upper", "position": [0, 0, -0.6]},
                "child": "lower",
                "friction": {"coulomb": 0.2},
                "limit": limit,
                "start": {"w": [2.0, -2.5, 1.5], "fixed": True},
            },
        },
        "states": {"a": {"rate": moments("A")}, "b": {"rate": moments("B")}},
        "sensors": {"E": {"type": "energy"}},
    }
    found = run(source, stop=3.0)
    energy = found["E.kinetic"] + found["E.potential"]
    left = energy + 0.3 * found["a"] + 0.2 * found["b"]
    assert np.abs(left - left[0]).max() < 2e-8
    assert energy[0] - energy[-1] > 1
    assert len(found.events) > 3


def test_an_impact_is_without_friction() -> None:
    """A puck that friction holds is struck: the friction has no impulse, and slows it down afterwards."""
    m, v, e = 0.6, 1.4, 0.5
    static = 40.0
    source = puck({"translation": {"coulomb": FORCE, "static": static}})
    sphere = {"ball": {"sphere": 0.1, "surface": "steel"}}
    source["bodies"]["puck"]["shapes"] = sphere
    source["bodies"]["hammer"] = {"mass": m, "com": [0, 0, 0], "inertia": [0.01] * 3, "shapes": sphere}
    c, s = math.cos(0.3), math.sin(0.3)
    source["joints"]["S"] = {
        "type": "prismatic",
        "axis": [c, s, 0],
        "parent": {"body": "ground", "position": [-0.5 * c, -0.5 * s, 0]},
        "child": "hammer",
        "start": {"v": v, "fixed": True},
    }
    source["contacts"] = {"hit": {"between": ["steel", "steel"], "restitution": e}}
    found = run(source, stop=1.0)
    struck = 0.3 / v
    after = m * (1 + e) * v / (m + MASS)
    t = found.time
    speed = c * found["P.v_x"] + s * found["P.v_y"]
    expected = np.where(t < struck, 0, np.maximum(0, after - FORCE / MASS * (t - struck)))
    assert np.abs(speed - expected).max() < 1e-9
    assert np.abs(s * found["P.v_x"] - c * found["P.v_y"]).max() < 1e-12
    assert found["S.v"][-1] == pytest.approx((m - e * MASS) / (m + MASS) * v, rel=1e-12)


def test_beside_a_contact_with_friction() -> None:
    """A block lies on a driven sled: both frictions hold, then the sled slides with the block on it."""
    m, mu = 0.8, 0.4
    source = puck({"translation": {"coulomb": FORCE, "static": FORCE}})
    source["gravity"] = [0, 0, -G]
    source["bodies"]["puck"]["shapes"] = {
        "top": {"box": [0.6, 0.6, 0.1], "position": [0, 0, -0.05], "surface": "wood"}
    }
    source["bodies"]["block"] = {
        "mass": m,
        "com": [0, 0, 0],
        "inertia": [0.01] * 3,
        "shapes": {"b": {"sphere": 0.1, "surface": "stone"}},
    }
    source["joints"]["B"] = {
        "type": "free",
        "parent": "ground",
        "child": "block",
        "start": {"r": [0, 0, 0.1], "fixed": True},
    }
    source["contacts"] = {"on": {"between": ["wood", "stone"], "friction": mu}}
    d = np.array([0.8, -0.6, 0])
    source["forces"] = {"F": wrench("puck", force=list((1 - 1e-9) * FORCE * d))}
    held = run(source, stop=0.3)
    assert np.hypot(held["P.v_x"], held["P.v_y"]).max() < 1e-13
    pull = FORCE + 1.0
    source["forces"] = {"F": wrench("puck", force=list(pull * d))}
    found = run(source, stop=0.3)
    # A sphere that rolls on the sled: its contact force is 2/7 m a of a solid one; here from its inertia.
    part = 1 / (1 + m * 0.1**2 / 0.01)
    a = 1.0 / (MASS + m * part)
    speed = d[0] * found["P.v_x"] + d[1] * found["P.v_y"]
    assert np.abs(speed - a * found.time).max() < 1e-9


def test_time_steps_converge_to_located_events() -> None:
    source = puck({"translation": {"coulomb": FORCE, "static": 1.2 * FORCE}}, v=[0.9, -0.4], w=0.5)
    source["joints"]["P"]["stiffness"] = [20, 35, 0]
    source["joints"]["P"]["start"]["s_x"] = 0.3
    exact = run(source, stop=2.0)
    errors = []
    for h in (4e-3, 1e-3):
        found = run(source, "moreau-jean", stop=2.0, step=h, cone_tolerance=1e-12)
        errors.append(np.abs(found["P.s_x"] - exact["P.s_x"]).max())
        assert found["P.v_x"][-1] == pytest.approx(0, abs=1e-9)
    assert errors[1] < errors[0] / 3
    assert errors[1] < 1e-3


@pytest.mark.parametrize("of_ball", [True, False])
def test_model_exchange(tmp_path: Path, of_ball: bool) -> None:
    source = (
        ball({"coulomb": MOMENT}, w=[0.4, -0.9, 0.3], inertia=[0.2, 0.4, 0.35])
        if of_ball
        else puck({"translation": {"coulomb": FORCE}}, v=[0.9, -0.4], w=0.5)
    )
    fmu = gelenk.export_fmu(gelenk.load(source), tmp_path / "x.fmu", view=False)
    names = ["J.w[1]", "J.w[2]"] if of_ball else ["P.v_x", "P.v_y"]
    inside, outside = (
        gelenk.simulate(fmu, stop=2.0, step=0.01, tolerance=1e-8, outputs=names, kind=kind)
        for kind in ("cs", "me")
    )
    for name in names:
        assert np.abs(inside[name] - outside[name]).max() < 1e-6
        assert abs(outside[name][-1]) < 1e-12
