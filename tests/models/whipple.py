# SPDX-License-Identifier: BSD-3-Clause
"""The benchmark bicycle: four bodies, three revolute joints, two wheels that roll without slip.

Data and linear theory: Meijaard, Papadopoulos, Ruina & Schwab, Proc. R. Soc. A 463 (2007) 1955-1982,
tables 1 and 2. There x points forward, y to the right, z down; here z points up, y to the left.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from mechanisms import GRAVITY, Array, Numbers, Scene, body, frame, joint, numbers, scene

WHEELBASE, TRAIL, TILT = 1.02, 0.08, np.pi / 10  # m, m, of the steer axis from the vertical
REAR_RADIUS, FRONT_RADIUS = 0.3, 0.35  # m
REAR_WHEEL, FRONT_WHEEL = (
    body(2, (0, 0, 0), (0.0603, 0.12, 0.0603)),
    body(3, (0, 0, 0), (0.1405, 0.28, 0.1405)),
)

REAR_HUB, FRONT_HUB = np.array([0, 0, REAR_RADIUS]), np.array([WHEELBASE, 0, FRONT_RADIUS])
STEER_AXIS = np.array([-np.sin(TILT), 0, np.cos(TILT)])
HEAD = np.array([WHEELBASE + TRAIL, 0, 0]) + 0.9 * STEER_AXIS  # an arbitrary point on the axis
FRAME_COM, FORK_COM = np.array([0.3, 0, 0.9]), np.array([0.9, 0, 0.7])

# M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 for q = (lean to the right, steer to the right): table 2.
M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
C1 = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.6854039739756]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])


def linear_theory(v: float) -> Array:
    """A of dx/dt = A x for x = (lean, steer and their rates), both to the right, at the speed v [m/s]."""
    stiff, damped = -np.linalg.solve(M, GRAVITY * K0 + v**2 * K2), -np.linalg.solve(M, v * C1)
    return np.block([[np.zeros((2, 2)), np.eye(2)], [stiff, damped]])


def bicycle(v: float = 0.0, starts: dict[str, dict[str, Any]] | None = None, **fields: Any) -> Scene:
    """The bicycle moves along x at v [m/s], upright and straight unless joints start otherwise.

    The rear frame is supported by a chain of simple joints: yaw, the rear hub's height, lean and pitch.
    Lean, steer and the speed of the rear wheel have `fixed` start values; rolling determines the other
    velocities.
    """
    start = {
        "base": {"v_x": v, "phi": 0.0, "fixed": ["phi"]},
        "height": {"s": REAR_RADIUS},
        "lean": {"phi": 0.0, "w": 0.0, "fixed": True},
        "pitch": {},
        "hub": {"w": v / REAR_RADIUS, "fixed": ["w"]},
        "steer": {"phi": 0.0, "w": 0.0, "fixed": True},
        "front_hub": {"w": v / FRONT_RADIUS},
    } | (starts or {})
    hinge: dict[str, Numbers] = {
        "lean": [1, 0, 0],
        "pitch": [0, 1, 0],
        "hub": [0, 1, 0],
        "steer": STEER_AXIS,
        "front_hub": [0, 1, 0],
    }
    ends = {
        "lean": (frame("b"), frame("c")),
        "pitch": (frame("c"), frame("frame")),
        "hub": (frame("frame"), frame("rear")),
        "steer": (frame("frame", HEAD - REAR_HUB), frame("fork")),
        "front_hub": (frame("fork", FRONT_HUB - HEAD), frame("front")),
    }
    return scene(
        {
            "a": body(0),
            "b": body(0),
            "c": body(0),
            "frame": body(85, FRAME_COM - REAR_HUB, (9.2, 11, 2.8, 0, -2.4, 0)),
            "rear": REAR_WHEEL,
            "fork": body(4, FORK_COM - HEAD, (0.05892, 0.06, 0.00708, 0, 0.00756, 0)),
            "front": FRONT_WHEEL,
        },
        {
            "base": joint("planar", frame("ground"), frame("a"), start=start["base"]),
            "height": joint("prismatic", frame("a"), frame("b"), axis=[0, 0, 1], start=start["height"]),
        }
        | {
            name: joint("revolute", *ends[name], axis=numbers(axis), start=start[name])
            for name, axis in hinge.items()
        },
        name="Bicycle",
        gravity=[0, 0, -GRAVITY],
        constraints={
            "rear_tyre": {"type": "rolling", "body": "rear", "radius": REAR_RADIUS},
            "front_tyre": {"type": "rolling", "body": "front", "radius": FRONT_RADIUS},
        },
        experiment={"stop": 5, "step": 0.01, "tolerance": 1e-10},
        **fields,
    )
