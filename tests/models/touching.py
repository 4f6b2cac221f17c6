# SPDX-License-Identifier: BSD-3-Clause
"""Bodies with shapes that touch a plane or each other."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

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
        "solver": {"integrator": "moreau-jean"},
    }


def box_on_a_cart(thickness: float = 0.02, width: float = 1.0) -> SceneData:
    """Return a cube of 0.5 kg and 0.1 m on a cart of 1 kg with motor, damping of 1 N s/m and friction of 0.4.

    Args:
        thickness: of the plate that the cart is [m].
        width: of the plate [m].
    """
    cube = {"box": [0.1] * 3, "surface": "wood"}
    plate = {"box": [width, width, thickness], "surface": "steel"}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "cart": {"mass": 1.0, "inertia": [0.1] * 3, "shapes": {"plate": plate}},
            "box": {"mass": 0.5, "inertia": inertia_of_box(0.5, [0.1] * 3), "shapes": {"cube": cube}},
        },
        "joints": {
            "P": {
                "type": "prismatic",
                "parent": "ground",
                "child": "cart",
                "axis": [1, 0, 0],
                "damping": 1.0,
            },
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "box",
                "start": {"r": [0, 0, (thickness + 0.1) / 2]},
            },
        },
        "motors": {"drive": {"joint": "P"}},
        "contacts": {"hit": {"between": ["wood", "steel"], "friction": 0.4}},
        "experiment": {"step": 0.005},
    }


def free_cubes(
    starts: Sequence[SceneData], surfaces: Sequence[str], *, edge: float = 0.1, mass: float = 1.0
) -> SceneData:
    """Return a scene of nothing but cubes b0, b1, ... on free joints j0, j1, ... with these starts."""
    moments = inertia_of_box(mass, [edge] * 3)
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            f"b{i}": {
                "mass": mass,
                "inertia": moments,
                "shapes": {"cube": {"box": [edge] * 3, "surface": surface}},
            }
            for i, surface in enumerate(surfaces)
        },
        "joints": {
            f"j{i}": {"type": "free", "parent": "ground", "child": f"b{i}", "start": start}
            for i, start in enumerate(starts)
        },
        "experiment": {"step": 1e-3},
    }


def stack(boxes: int, *, edge: float = 0.1, mass: float = 1.0, friction: float = 0.5) -> SceneData:
    """Return cubes that rest on each other and on the ground, all with one surface."""
    starts = [{"r": [0, 0, edge * (i + 0.5)]} for i in range(boxes)]
    return {
        **free_cubes(starts, ["wood"] * boxes, edge=edge, mass=mass),
        "ground": {"shapes": {"plane": {"plane": [0, 0, 1], "surface": "wood"}}},
        "contacts": {"wooden": {"between": ["wood", "wood"], "friction": friction}},
        "solver": {"integrator": "moreau-jean"},
    }


def wall(
    columns: int,
    rows: int,
    *,
    size: Sequence[float] = (0.2, 0.1, 0.1),
    friction: float = 0.6,
    pitch: float = 1.001,
) -> SceneData:
    """Return bricks in running bond on the ground; joints are called j<row>_<column>.

    pitch: distance of the centers of two bricks of a layer, in lengths of a brick; at 1, their ends touch.
    """
    x, _, z = size
    places = [(row, column) for row in range(rows) for column in range(columns)]
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            f"b{row}_{column}": {
                "mass": {"density": 1000.0},
                "shapes": {"brick": {"box": list(size), "surface": "brick"}},
            }
            for row, column in places
        },
        "ground": {"shapes": {"plane": {"plane": [0, 0, 1], "surface": "brick"}}},
        "joints": {
            f"j{row}_{column}": {
                "type": "free",
                "parent": "ground",
                "child": f"b{row}_{column}",
                "start": {"r": [pitch * x * column + (row % 2) * x / 2, 0, z * (row + 0.5)]},
            }
            for row, column in places
        },
        "contacts": {"bricks": {"between": ["brick", "brick"], "friction": friction}},
        "experiment": {"step": 1e-3},
        "solver": {"integrator": "moreau-jean"},
    }


def heap(spheres: int, *, radius: float = 0.05, friction: float = 0.5) -> SceneData:
    """Return spheres above the floor between four walls, in layers with small gaps and offsets."""
    side = max(2, round(spheres ** (1 / 3)))
    pitch = 2.2 * radius
    half = side * pitch / 2

    def place(i: int) -> list[float]:
        layer, cell = divmod(i, side * side)
        offset = 0.05 * radius * np.random.default_rng(i).uniform(-1, 1, 2)
        x, y = ((k + 0.5) * pitch - half for k in divmod(cell, side))
        return [x + offset[0], y + offset[1], radius * 1.1 + layer * pitch]

    faces = {"floor": ([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])}
    for axis in range(2):
        for sign in (1, -1):
            direction = [0.0, 0.0, 0.0]
            direction[axis] = sign
            faces[f"wall{axis}{'ab'[sign > 0]}"] = (direction, [-half * n for n in direction])
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            f"s{i}": {"mass": {"density": 1000.0}, "shapes": {"ball": {"sphere": radius, "surface": "ball"}}}
            for i in range(spheres)
        },
        "ground": {
            "shapes": {
                name: {"plane": normal, "position": position, "surface": "wall"}
                for name, (normal, position) in faces.items()
            }
        },
        "joints": {
            f"j{i}": {"type": "free", "parent": "ground", "child": f"s{i}", "start": {"r": place(i)}}
            for i in range(spheres)
        },
        "contacts": {
            "balls": {"between": ["ball", "ball"], "friction": friction},
            "walls": {"between": ["wall", "ball"], "friction": friction},
        },
        "experiment": {"step": 1e-3},
        "solver": {"integrator": "moreau-jean"},
    }
