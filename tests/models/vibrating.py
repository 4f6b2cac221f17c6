# SPDX-License-Identifier: BSD-3-Clause
"""What vibrates beside contacts between shapes, with few or with many closed points of contact."""

from __future__ import annotations

import math
from typing import Any

from models.touching import inertia_of_box

SceneData = dict[str, Any]

# Of a box that rests on the floor; each has four points of contact.
SIDE, BOX_MASS = 0.1, 0.5  # m, kg
STEPPING_BOXES = 5  # with 20 points, more than the 16 of located events


def box() -> SceneData:
    """Return a body."""
    shapes = {"s": {"box": [SIDE] * 3, "surface": "wood"}}
    return {"mass": BOX_MASS, "inertia": inertia_of_box(BOX_MASS, [SIDE] * 3), "shapes": shapes}


def resting_boxes(count: int, y: float = 0.0) -> dict[str, SceneData]:
    """Return bodies and joints of boxes in a row on the floor z = 0, without a start velocity."""
    return {
        "bodies": {f"b{k}": box() for k in range(count)},
        "joints": {
            f"j{k}": {
                "type": "free", "parent": "ground", "child": f"b{k}",
                "start": {"r": [0, y + 0.3 * k, SIDE / 2], "fixed": True},
            }
            for k in range(count)
        },
    }  # fmt: skip


def vibration(frequency: float, amplitude: float, boxes: int, **solver: Any) -> SceneData:
    """Return a mass on a spring, `s.s` = amplitude cos(2 pi frequency t), 0.9 m above a floor.

    Boxes that rest on the floor are coupled to it by springs so weak that nothing comes of them.

    Args:
        frequency: [Hz].
        amplitude: [m].
        boxes: their number.
        solver: settings.
    """
    beside = resting_boxes(boxes, y=0.5)
    ball = {"mass": 1.0, "shapes": {"b": {"sphere": 0.1, "surface": "wood"}}}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {"m": ball, **beside["bodies"]},
        "joints": {
            "s": {
                "type": "prismatic", "axis": [1, 0, 0], "parent": {"body": "ground", "position": [0, 0, 1]},
                "child": "m", "stiffness": (2 * math.pi * frequency) ** 2,
                "start": {"s": amplitude, "v": 0, "fixed": True},
            },
            **beside["joints"],
        },
        "forces": {
            f"c{k}": {"type": "spring_damper", "from": "m", "to": f"b{k}", "stiffness": 1e-9, "length": 1.0}
            for k in range(boxes)
        },
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {"k": {"between": ["wood", "floor"], "friction": 0.5}},
        "experiment": {"stop": 1.0, "step": 0.01},
        "solver": solver,
    }  # fmt: skip


def conveyor(boxes: int, *, frequency: float = 40.0, **solver: Any) -> SceneData:
    """Return boxes on an inclined plate that is shaken along its slope, on which they slide down in jerks.

    Args:
        boxes: their number; they start alike, side by side, and do not touch each other.
        frequency: of the plate [Hz].
        solver: settings.
    """
    tilt = 0.1  # rad
    sine = {"amplitude": 1e-3, "frequency": frequency}  # m, Hz
    c, s = math.cos(tilt), math.sin(tilt)
    return {
        "gelenk": 1,
        "gravity": [9.81 * s, 0, -9.81 * c],
        "bodies": {
            "plate": {
                "mass": 2.0, "inertia": [0.1] * 3,
                "shapes": {"s": {"box": [4, 4, 0.1], "position": [0, 0, -0.05], "surface": "steel"}},
            },
            **{f"b{k}": box() for k in range(boxes)},
        },
        "joints": {
            "p": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "plate"},
            **{
                f"j{k}": {
                    "type": "free", "parent": "ground", "child": f"b{k}",
                    "start": {"r": [0, 0.3 * k, SIDE / 2], "fixed": True},
                }
                for k in range(boxes)
            },
        },
        "constraints": {"shake": {"type": "motion", "joint": "p", "sine": sine}},
        "contacts": {"k": {"between": ["wood", "steel"], "friction": 0.3}},
        "experiment": {"stop": 1.0, "step": 0.01},
        "solver": solver,
    }  # fmt: skip
