# SPDX-License-Identifier: BSD-3-Clause
"""Small scenes in which a run has something to remember: smooth, with friction, limits, stops, contacts."""

from __future__ import annotations

import copy
import math
from typing import Any

import gelenk

type SceneData = dict[str, Any]

ADAPTIVE = ("auto", "erk", "cvode", "ida", "dirk")
INTEGRATORS = (*ADAPTIVE, "cvode-adams", "rk4", "euler", "generalized-alpha", "hht")
STEP = 0.01  # s, between communication points
DRIVE = "drive.tau"


def wheel(**joint: Any) -> SceneData:
    """A wheel on a torsion spring, driven by a motor."""
    turns = {"type": "revolute", "parent": "ground", "child": "wheel", "stiffness": 3.0,
             "start": {"phi": 0.1, "w": 0.0, "fixed": True}}  # fmt: skip
    return {
        "gelenk": 1,
        "name": "Wheel",
        "bodies": {"wheel": {"mass": 1, "inertia": [0.2, 0.2, 0.2]}},
        "joints": {"A": turns | joint},
        "motors": {"drive": {"joint": "A"}},
    }


def carried_ball() -> SceneData:
    """A wheel beside a ball that bounces, and one that slides on a floor until it rolls."""
    scene = wheel()
    ball = {"mass": 1.0, "inertia": [4e-3] * 3, "shapes": {"skin": {"sphere": 0.1, "surface": "rubber"}}}
    scene["bodies"] |= {"bouncing": ball, "rolling": copy.deepcopy(ball)}
    scene["joints"] |= {
        "B": {"type": "free", "parent": "ground", "child": "bouncing", "start": {"r": [2.0, 0, 0.104]}},
        "C": {"type": "free", "parent": "ground", "child": "rolling",
              "start": {"r": [0, 0, 0.1], "v": [0.3, 0, 0]}},
    }  # fmt: skip
    scene["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "stone"}}}
    scene["contacts"] = {"floor": {"between": ["rubber", "stone"], "friction": 0.3, "restitution": 0.5}}
    # The drive turns the rolling ball, too: contact and input act in the same island.
    scene["joints"]["A"]["parent"] = {"body": "rolling"}
    return scene


def four_bar_with_friction() -> SceneData:
    from mechanisms import four_bar

    scene = four_bar()
    scene["motors"] = {"drive": {"joint": "A"}}
    scene["joints"]["A"]["friction"] = {"coulomb": 0.2}
    return scene


SCENES: dict[str, SceneData] = {
    "smooth": wheel(),
    "friction": wheel(friction={"coulomb": 0.5}),
    "limit": wheel(limit={"lower": 0.0, "restitution": 0.5}),
    "stop": wheel(stop={"lower": 0.0, "stiffness": 1000.0}),
    "contact": carried_ball(),
    "loop": four_bar_with_friction(),
}


def plant_of(kind: str, integrator: str, tolerance: float = 1e-6, **solver: Any) -> gelenk.Simulation:
    plant = gelenk.Simulation(SCENES[kind] | {"solver": {"integrator": integrator} | solver})
    drive(plant, 0, moving=False)
    plant.initialize(tolerance=tolerance)
    return plant


def drive(plant: gelenk.Simulation, k: int, moving: bool) -> None:
    """Set the torque from the k-th step on, with its time derivatives if it moves."""
    for order in range(6 if moving else 1):
        value = 2 * 4**order * math.sin(4 * STEP * k + order * math.pi / 2)
        if order == 0:
            plant.set_input(DRIVE, value)
        else:
            plant.set_input_derivative(DRIVE, order, value)


def rows(plant: gelenk.Simulation, first: int, count: int, moving: bool) -> list[list[float]]:
    """Outputs and diagnostics after each of some steps."""
    out = []
    for k in range(first, first + count):
        drive(plant, k, moving)
        plant.step_to((k + 1) * STEP)
        out.append([*plant.values().tolist(), *plant.diagnostics.values()])
    return out
