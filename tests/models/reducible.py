# SPDX-License-Identifier: BSD-3-Clause
"""Scenes that are larger than necessary, or seem to be, for the tests of the reductions."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from mechanisms import (
    GRAVITY,
    Array,
    Scene,
    body,
    four_bar,
    frame,
    joint,
    matrix,
    placed,
    rod,
    rotation,
    scene,
)

ABOUT_Z: dict[str, Any] = {"axis": [0, 0, 1]}
DOWN_Y = [0, -GRAVITY, 0]
TILT = rotation([0.3, -0.7, 0.5], 1.3)


def without(source: Scene, *names: str) -> Scene:
    """The same scene with these reductions off; "all" for every one."""
    out = copy.deepcopy(source)
    out.setdefault("solver", {}).setdefault("reductions", {}).update(dict.fromkeys(names, False))
    return out


def joined(first: Scene, second: Scene) -> Scene:
    """Both mechanisms in one scene; their names must differ."""
    out = copy.deepcopy(first)
    for section in ("bodies", "joints", "motors", "forces", "sensors"):
        entries = copy.deepcopy(second.get(section, {}))
        assert not set(entries) & set(out.get(section, {}))
        if entries:
            out.setdefault(section, {}).update(entries)
    return out


def tilted_four_bar(torque: float | None = 3.0) -> Scene:
    """A planar four-bar in an oblique plane, with gravity rotated accordingly."""
    return placed(four_bar(1.1, torque=torque), TILT, (0.3, -0.2, 0.7))


def ball_four_bar() -> Scene:
    """Revolute joint C is replaced by a ball joint with oblique frames that differ in coupler and rocker, so
    that the redundant constraint is a combination of the equations with arbitrary constant factors.
    """
    out = tilted_four_bar()
    C = out["joints"]["C"]
    out["joints"]["C"] = joint(
        "spherical",
        {**C["parent"], "rotation": matrix(rotation([1, 2, -1], 0.8))},
        {**C["child"], "rotation": matrix(rotation([-1, 0.3, 2], 2.1))},
    )
    # The angle from F to M: the rocker relative to the coupler.
    R_FM = rotation([1, 2, -1], 0.8).T @ rotation([0, 0, 1], C["start"]["phi"]) @ rotation([-1, 0.3, 2], 2.1)
    out["joints"]["C"]["start"] = {"rotation": matrix(R_FM)}
    return out


def triple_crank(coupler_is_parent: bool, rate: float = 9.0) -> Scene:
    """One coupler on three parallel cranks of 0.4 m at x = 0, 0.5 and 1.2 m, making full turns at about
    `rate` [rad/s]: it only translates, and crosses two change points per turn.
    """
    places = (0.0, 0.5, 1.2)
    bodies = {f"crank{i}": rod(0.5 + 0.1 * i, 0.4) for i in range(3)}
    bodies["coupler"] = body(1.1, (0.6, 0.05, 0), (0.01, 0.2, 0.21))
    start = 0.7
    joints = {}
    for i, x in enumerate(places):
        fixed = {"fixed": True} if i == 0 else {}
        joints[f"A{i}"] = joint(
            "revolute",
            frame("ground", (x, 0, 0)),
            frame(f"crank{i}"),
            **ABOUT_Z,
            start={"phi": start, "w": rate, **fixed},
        )
    for i, x in enumerate(places):
        sides = [frame("coupler", (x, 0, 0)), frame(f"crank{i}", (0.4, 0, 0))]
        sign = 1 if coupler_is_parent else -1
        joints[f"B{i}"] = joint(
            "revolute",
            *(sides if coupler_is_parent else reversed(sides)),
            **ABOUT_Z,
            start={"phi": sign * start, "w": sign * rate},
        )
    return scene(bodies, joints, gravity=DOWN_Y, sensors={"E": {"type": "energy"}})


def door() -> Scene:
    """A door on two coaxial revolute joints, with an axis inclined by 0.2 rad so that it swings."""
    R = rotation([1, 0, 0], 0.2)
    upper = R @ np.array([0, 0, 1.6])
    return scene(
        {"door": body(25, (0.4, 0, 0.8), (5.4, 6.7, 1.4))},
        {
            "lower": joint(
                "revolute",
                frame("ground", R=R),
                frame("door"),
                **ABOUT_Z,
                start={"phi": 0.6, "fixed": True},
                damping=1.0,
            ),
            "upper": joint(
                "revolute",
                frame("ground", upper, R),
                frame("door", (0, 0, 1.6)),
                **ABOUT_Z,
                start={"phi": 0.6},
                damping=0.5,
            ),
        },
        gravity=[0, 0, -GRAVITY],
    )


def guided() -> Scene:
    """A carriage on two parallel inclined rails, with a spring at one of them."""
    along = [0.8, 0.0, 0.6]
    rails = {"left": (0.0, -0.2, 0.0), "right": (0.1, 0.2, 0.05)}
    joints = {}
    for name, place in rails.items():
        joints[name] = joint("prismatic", frame("ground", place), frame("carriage", place), axis=along)
    joints["left"].update(start={"s": 0.1, "v": 0.3, "fixed": True}, stiffness=80.0)
    joints["right"].update(start={"s": 0.1}, damping=0.7)
    return scene({"carriage": body(2, (0.05, 0, 0.1), (0.02, 0.03, 0.04))}, joints, gravity=[0, 0, -GRAVITY])


def held_twice(kind: str, seed: int) -> Scene:
    """A body on two coaxial revolute joints, or on two rails, along a random axis."""
    rng = np.random.default_rng(seed)
    axis, place = rng.normal(size=3), rng.normal(size=3)
    along = axis / np.linalg.norm(axis)
    R = rotation(rng.normal(size=3), 1.0)
    start = {"phi": 0.3, "w": 0.7} if kind == "revolute" else {"s": 0.1, "v": 0.7}
    fields = {"axis": axis.tolist(), "start": start}
    return scene(
        {"door": body(25, (0.4, 0.1, 0.8), (5.4, 6.7, 1.4))},
        {
            "lower": joint(kind, frame("ground", place, R), frame("door"), **fields),
            "upper": joint(
                kind, frame("ground", place + R @ (1.6 * along), R), frame("door", 1.6 * along), **fields
            ),
        },
        gravity=[0.5, -0.7, -GRAVITY],
    )


def welded_chain(n: int = 12) -> Scene:
    """A pendulum of n boxes welded end to end, each rotated relative to the previous one."""
    R = rotation([0.2, 1, 0.4], 0.3)
    bodies = {f"piece{i}": body(0.2 + 0.01 * i, (0.05, 0.01, 0), (1e-4, 2e-4, 2.5e-4)) for i in range(n)}
    joints = {
        "pin": joint(
            "universal",
            frame("ground"),
            frame("piece0"),
            axes=[[0, 0, 1], [0, 1, 0]],
            start={"phi_a": 0.3, "phi_b": 0.4, "w_a": 0.5, "fixed": True},
        )
    }
    for i in range(n - 1):
        joints[f"seam{i}"] = joint("weld", frame(f"piece{i}", (0.1, 0, 0), R), frame(f"piece{i + 1}"))
    sensors = {"end": {"type": "frame", **frame(f"piece{n - 1}", (0.1, 0, 0))}, "E": {"type": "energy"}}
    return scene(bodies, joints, gravity=[0, 0, -GRAVITY], sensors=sensors)


def triangle(base: float = 1.2, left: float = 1.0, right: float = 0.8) -> Scene:
    """Two rods pinned to the ground `base` [m] apart and to each other: a truss in the x-y plane.
    Springs on its joints store constant energy.
    """
    c = (base**2 + left**2 - right**2) / (2 * base * left)
    phi_left = math.acos(c)
    apex = left * np.array([c, math.sin(phi_left)])
    phi_right = math.atan2(apex[1], apex[0] - base)
    joints = {
        "L": joint(
            "revolute",
            frame("ground"),
            frame("left"),
            **ABOUT_Z,
            start={"phi": phi_left + 0.05},
            stiffness=40.0,
            spring_reference=0.2,
        ),
        "R": joint(
            "revolute",
            frame("ground", (base, 0, 0)),
            frame("right"),
            **ABOUT_Z,
            start={"phi": phi_right - 0.1},
        ),
        "T": joint(
            "revolute",
            frame("left", (left, 0, 0)),
            frame("right", (right, 0, 0)),
            **ABOUT_Z,
            start={"phi": phi_right - phi_left},
            stiffness=25.0,
        ),
    }
    sensors: dict[str, Any] = {
        "apex": {"type": "frame", **frame("left", (left, 0, 0))},
        "E": {"type": "energy"},
    }
    return scene({"left": rod(2.0, left), "right": rod(1.5, right)}, joints, gravity=DOWN_Y, sensors=sensors)


APEX = np.array([0.3, 0.2, 0.9])
FEET = np.array([(0.0, 0.0, 0.0), (1.0, 0.1, 0.0), (0.2, 0.9, 0.1)])


def tripod(foot: str) -> Scene:
    """Three rods from the ground, connected by ball joints at their top. On universal joints the tripod is
    rigid, on ball joints each rod can spin about its own axis.
    """
    bodies, joints = {}, {}
    for i, start in enumerate(FEET):
        span = APEX - start
        length = float(np.linalg.norm(span))
        x = span / length
        y = np.cross([0.3, -0.5, 0.2], x)
        y /= np.linalg.norm(y)
        R = np.column_stack([x, y, np.cross(x, y)])  # of the rod in the world
        bodies[f"rod{i}"] = body(1.0 + i, (length / 2, 0, 0), (0.002, 0.1 * (1 + i), 0.1 * (1 + i)))
        # All frames are aligned with the rods in their position, so that all coordinates are zero.
        fields = {"axes": [[0, 1, 0], [0, 0, 1]]} if foot == "universal" else {}
        joints[f"foot{i}"] = joint(foot, frame("ground", start, R), frame(f"rod{i}"), **fields)
        if i > 0:
            R_0 = np.array(joints["foot0"]["parent"]["rotation"]["matrix"])
            first = frame("rod0", (float(np.linalg.norm(APEX - FEET[0])), 0, 0))
            joints[f"top{i}"] = joint("spherical", first, frame(f"rod{i}", (length, 0, 0), R.T @ R_0))
    sensors: dict[str, Any] = {
        "middle": {"type": "frame", **frame("rod1", (0.3, 0, 0))},
        "E": {"type": "energy"},
    }
    return scene(bodies, joints, gravity=[0, 0, -GRAVITY], sensors=sensors)


def pendulum_on(foot: dict[str, Any]) -> Scene:
    """A double pendulum in space, suspended at the frame `foot`."""
    return scene(
        {
            "upper": body(0.8, (0, 0, -0.2), (0.01, 0.012, 0.003)),
            "lower": body(0.5, (0, 0.02, -0.15), (0.006, 0.005, 0.002)),
        },
        {
            "shoulder": joint(
                "universal",
                foot,
                frame("upper"),
                axes=[[1, 0, 0], [0, 1, 0]],
                start={"phi_a": 0.4, "phi_b": -0.3, "w_a": 0.5, "w_b": 0.2, "fixed": True},
            ),
            "elbow": joint(
                "revolute",
                frame("upper", (0, 0, -0.4)),
                frame("lower"),
                axis=[0.6, 0.8, 0],
                start={"phi": 0.5, "w": -0.4, "fixed": True},
            ),
        },
        gravity=DOWN_Y,
        motors={"arm": {"joint": "elbow"}},
    )


def two_mechanisms() -> Scene:
    """A planar four-bar and a separate double pendulum in space."""
    return joined(four_bar(1.1), pendulum_on(frame("ground", (5, 0, 1))))


def platform_on_balls() -> Scene:
    """Six legs with ball joint, prismatic joint and universal joint carry a platform, with the ball joints on
    the ground and listed first: if cut in the order of the file, there are six quaternions and 20 constraint
    equations.
    """
    bodies: dict[str, Any] = {"platform": body(20, (0, 0, 0.05), (1.3, 1.2, 2.5))}
    balls, slides, crosses = {}, {}, {}
    for i in range(6):
        low = 2 * math.pi / 6 * (i + (0.2 if i % 2 else -0.2))
        high = 2 * math.pi / 6 * (i + (-0.25 if i % 2 else 0.25))
        bottom = np.array([math.cos(low), math.sin(low), 0.0])
        top = np.array([0.5 * math.cos(high), 0.5 * math.sin(high), 1.1])
        z = (top - bottom) / np.linalg.norm(top - bottom)
        x = np.cross([0, 0, 1], z)
        x /= np.linalg.norm(x)
        R = np.column_stack([x, np.cross(z, x), z])
        length = float(np.linalg.norm(top - bottom))
        bodies[f"lower{i}"] = body(5, (0, 0, 0.3), (0.15, 0.15, 0.005))
        bodies[f"upper{i}"] = body(3, (0, 0, length - 0.3), (0.09, 0.09, 0.002))
        balls[f"ball{i}"] = joint("spherical", frame("ground", bottom, R), frame(f"lower{i}"))
        fixed = {"s": 0.0, "v": 0.05 if i == 2 else 0.0, "fixed": True}
        slides[f"leg{i}"] = joint(
            "prismatic", frame(f"lower{i}"), frame(f"upper{i}"), **ABOUT_Z, start=fixed, damping=200.0
        )
        crosses[f"cross{i}"] = joint(
            "universal",
            frame(f"upper{i}", (0, 0, length)),
            frame("platform", top - np.array([0, 0, 1.1]), R),
            axes=[[1, 0, 0], [0, 1, 0]],
        )
    return scene(bodies, {**balls, **slides, **crosses}, gravity=[0, 0, -GRAVITY])


def in_line(n: int, places: Sequence[float] | Array) -> Scene:
    """Separate pendulums, the i-th at x = places[i] [m]."""
    return scene(
        {f"rod{i}": rod(1, 0.5) for i in range(n)},
        {
            f"pin{i}": joint("revolute", frame("ground", (places[i], 0, 0)), frame(f"rod{i}"), **ABOUT_Z)
            for i in range(n)
        },
        gravity=DOWN_Y,
    )
