# SPDX-License-Identifier: BSD-3-Clause
"""The jobs: mechanisms of all sizes and shapes, each with the methods that show a kernel's cost."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mechanisms import Scene, body, four_bar, frame, joint, rod, scene
from models.touching import inertia_of_box, on_plane

import gelenk

SCENES = Path(__file__).parent.parent.parent / "scenes"
Y = (0.0, 1.0, 0.0)
Z = (0.0, 0.0, 1.0)


def chain(n: int) -> Scene:
    """A chain of n rods, each turning about an axis across the one before."""
    bodies = {f"b{i}": rod(0.5, 0.2) for i in range(n)}
    joints = {}
    for i in range(n):
        start = frame(f"b{i - 1}", (0.2, 0, 0)) if i else frame("ground")
        joints[f"j{i}"] = joint(
            "revolute", start, frame(f"b{i}"), axis=Y if i % 2 == 0 else Z, damping=0.01,
            start={"phi": 0.1, "w": 0, "fixed": True},
        )  # fmt: skip
    return scene(bodies, joints, name="Chain", motors={"drive": {"joint": "j0"}})


def arm() -> Scene:
    """Seven joints as industrial arms have them."""
    lengths = (0.3, 0.3, 0.25, 0.25, 0.2, 0.1, 0.1)
    bodies, joints = {}, {}
    for i, length in enumerate(lengths):
        mass = 5.0 - 0.6 * i
        size = mass * length**2 / 12
        bodies[f"b{i}"] = body(mass, (0.01, 0.005 * i, length / 2), (size, 1.1 * size, 0.3 * size))
        start = frame(f"b{i - 1}", (0, 0, lengths[i - 1])) if i else frame("ground")
        joints[f"j{i}"] = joint(
            "revolute", start, frame(f"b{i}"), axis=Z if i % 2 == 0 else Y, damping=0.05,
            start={"phi": 0.3 * math.cos(i), "w": 0, "fixed": True},
        )  # fmt: skip
    return scene(bodies, joints, name="Arm", motors={"drive": {"joint": "j1"}})


def windows(n: int) -> Scene:
    """A row of n parallelograms side by side: n + 1 standing rods, n lying ones, all of 1 m."""
    bodies: dict[str, Any] = {f"up{i}": rod(1.0, 1.0) for i in range(n + 1)}
    bodies |= {f"over{i}": rod(1.0, 1.0) for i in range(n)}
    joints: dict[str, Any] = {}
    angle = 1.0
    for i in range(n + 1):
        joints[f"foot{i}"] = joint(
            "revolute", frame("ground", (float(i), 0, 0)), frame(f"up{i}"), axis=Y,
            start={"phi": -angle, "w": 0, "fixed": i == 0},
        )  # fmt: skip
    for i in range(n):
        joints[f"left{i}"] = joint(
            "revolute", frame(f"up{i}", (1, 0, 0)), frame(f"over{i}"), axis=Y, start={"phi": angle}
        )
        joints[f"right{i}"] = joint(
            "revolute", frame(f"over{i}", (1, 0, 0)), frame(f"up{i + 1}", (1, 0, 0)), axis=Y
        )
    return scene(bodies, joints, name="Windows", motors={"drive": {"joint": "foot0"}})


def shipped(name: str) -> Callable[[], Scene]:
    return lambda: gelenk.load(SCENES / f"{name}.yaml").to_dict()


@dataclass(frozen=True)
class Job:
    """rounds of a torque set, a step of `step` seconds, all outputs read."""

    plant: Callable[[], Scene]
    rounds: int
    step: float = 1e-3
    solver: dict[str, Any] = field(default_factory=dict)


def planar_four_bar(friction: float = 0.0) -> Callable[[], Scene]:
    """The shipped four-bar without sensors; with dry friction in all joints [N m]."""

    def made() -> Scene:
        source = shipped("four_bar")()
        source.pop("sensors", None)
        for entry in source["joints"].values():
            if friction > 0:
                entry["friction"] = {"coulomb": friction}
        return source

    return made


def braked_arm() -> Scene:
    """The arm with friction that holds all joints but the first."""
    source = arm()
    for name, entry in source["joints"].items():
        if name != "j0":
            entry["start"]["w"] = 0.0
            entry["friction"] = {"coulomb": 1000.0}
    return source


def falling_on_a_limit() -> Scene:
    """A four-bar whose crank falls onto a limit and comes to rest on it in a series of impacts."""
    source = four_bar()
    source["motors"] = {"drive": {"joint": "A"}}
    source["joints"]["A"]["limit"] = {"lower": 0.9, "restitution": 0.5}
    return source


def cube_at_rest() -> Scene:
    """On a plane, beside a body with a motor."""
    edge, mass = 0.1, 0.5
    source = on_plane(
        {"box": [edge] * 3},
        mass,
        inertia_of_box(mass, [edge] * 3),
        {"r": [0, 0, edge / 2]},
        {"friction": 0.4},
    )
    source["bodies"]["disc"] = body(1.0, (0, 0, 0), (0.1, 0.1, 0.1))
    source["joints"]["M"] = joint("revolute", frame("ground"), frame("disc"), axis=Z)
    source["motors"] = {"drive": {"joint": "M"}}
    return source


RK4 = {"integrator": "rk4", "step": 1e-3}

# By the kernels: only they evaluate what has friction, and without it a program would.
KERNELS = {"equations": "general"}
METHODS: dict[str, dict[str, Any]] = {"rk4": RK4 | KERNELS, "auto": KERNELS}

# Pairs of jobs: with friction in motion, and without.
FRICTION = {
    name: tuple(Job(planar_four_bar(f), rounds, solver=METHODS[name]) for f in (0.01, 0.0))
    for name, rounds in (("rk4", 500), ("auto", 1000))
}

# The same with joints at rest.
AT_REST = tuple(Job(plant, 300, solver=RK4 | KERNELS) for plant in (braked_arm, arm))

# rk4: four evaluations and a projection a step, so that its instructions are those of the kernels.
# What happens between smooth steps: the same four-bar at rest, and one that falls onto a limit.
HELD = {
    name: tuple(Job(planar_four_bar(f), 60, solver=s) for f in (40.0, 0.0)) for name, s in METHODS.items()
}
FALLING = {name: Job(falling_on_a_limit, 600, solver=s) for name, s in METHODS.items()}
# A cube at rest on a plane beside a motor, by located contacts and by time steps.
RESTING = tuple(
    Job(cube_at_rest, 40, solver={"integrator": name, "step": 1e-3}) for name in ("rk4", "moreau-jean")
)

JOBS = {
    "four-bar, rk4": Job(shipped("four_bar"), 500, solver=RK4),
    "four-bar, auto": Job(shipped("four_bar"), 1000),
    "four-bar, rk4, by the kernels": Job(shipped("four_bar"), 500, solver=RK4 | KERNELS),
    "slider-crank, rk4": Job(shipped("slider_crank"), 500, solver=RK4),
    "arm, rk4": Job(arm, 300, solver=RK4),
    "arm, rk4, by the kernels": Job(arm, 300, solver=RK4 | KERNELS),
    "arm, auto": Job(arm, 500),
    "arm, dirk: Newton matrices": Job(arm, 20, 1e-2, {"integrator": "dirk"}),
    "chain of 32, rk4": Job(lambda: chain(32), 50, solver=RK4),
    "Stewart platform, rk4": Job(shipped("stewart"), 50, solver=RK4),
    "ten four-bars, rk4": Job(lambda: windows(10), 50, solver=RK4),
}
