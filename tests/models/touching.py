# SPDX-License-Identifier: BSD-3-Clause
"""Bodies with shapes that touch a plane or each other."""

from collections.abc import Mapping, Sequence
from typing import Any

SceneData = dict[str, Any]


def inertia_of_box(mass: float, size: Sequence[float]) -> list[float]:
    """Principal moments of a homogeneous box about its center [kg m2]; size [m]."""
    x, y, z = (length * length for length in size)
    return [mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y)]


def on_plane(
    shape: Mapping[str, Any],
    mass: float,
    inertia: Sequence[float],
    start: Mapping[str, Sequence[float]],
    law: Mapping[str, Any],
    *,
    normal: Sequence[float] = (0, 0, 1),
    step: float = 1e-3,
) -> SceneData:
    """Return a free body `body` (joint `J`) above a half-space; the contact is called `floor`.

    Args:
        shape: its shape, about the center of mass.
        mass: of the body [kg].
        inertia: principal moments [kg m2].
        start: of the free joint: r [m], Q, v [m/s], w [rad/s].
        law: fields of the contact.
        normal: of the plane through the origin.
        step: of time stepping [s].
    """
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "body": {
                "mass": mass,
                "inertia": list(inertia),
                "shapes": {"hull": {**shape, "surface": "wood"}},
            }
        },
        "ground": {"shapes": {"plane": {"plane": list(normal), "surface": "concrete"}}},
        "joints": {
            "J": {"type": "free", "parent": "ground", "child": "body", "start": {**start, "fixed": True}}
        },
        "contacts": {"floor": {"between": ["wood", "concrete"], **law}},
        "experiment": {"step": step},
    }


def stack(boxes: int, *, edge: float = 0.1, mass: float = 1.0, friction: float = 0.5) -> SceneData:
    """Return cubes that rest on each other and on the ground, all with one surface."""
    moments = inertia_of_box(mass, [edge] * 3)
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            f"b{i}": {
                "mass": mass,
                "inertia": moments,
                "shapes": {"cube": {"box": [edge] * 3, "surface": "wood"}},
            }
            for i in range(boxes)
        },
        "ground": {"shapes": {"plane": {"plane": [0, 0, 1], "surface": "wood"}}},
        "joints": {
            f"j{i}": {
                "type": "free",
                "parent": "ground",
                "child": f"b{i}",
                "start": {"r": [0, 0, edge * (i + 0.5)]},
            }
            for i in range(boxes)
        },
        "contacts": {"wooden": {"between": ["wood", "wood"], "friction": friction}},
        "experiment": {"step": 1e-3},
    }
