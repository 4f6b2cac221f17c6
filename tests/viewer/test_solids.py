# SPDX-License-Identifier: BSD-3-Clause
"""Shapes that a scene gives are drawn with their dimensions, at their place."""

from typing import Any

import numpy as np
import pytest
from models import polyhedra

import gelenk
from gelenk.viewer.shapes import Shapes, shapes_of

TURN = {"axis": [1, 2, 3], "angle": 0.7}
CORNERS = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = {"points": CORNERS, "triangles": [[a, *pair] for a, b, c, d in SIDES for pair in ((b, c), (c, d))]}


def extent(shapes: Shapes) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of the box around all parts."""
    points = [np.array(ball["p"]) + sign * ball["r"] for ball in shapes.balls for sign in (-1, 1)]
    for tube in shapes.tubes:
        a, b = (np.array(tube[end]) for end in "ab")
        around = tube["r"] * np.sqrt(1 - ((b - a) / np.linalg.norm(b - a)) ** 2)  # the reach of a disk
        points += [end + sign * around for end in (a, b) for sign in (-1, 1)]
    points += [p for vertices, _ in shapes.meshes for p in vertices]
    return np.min(points, axis=0), np.max(points, axis=0)


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        ({"sphere": 0.2}, [0.2, 0.2, 0.2]),
        ({"box": [0.1, 0.2, 0.3]}, [0.05, 0.1, 0.15]),
        ({"capsule": {"radius": 0.1, "length": 0.4}}, [0.1, 0.1, 0.3]),
        ({"cylinder": {"radius": 0.1, "length": 0.4}}, [0.1, 0.1, 0.2]),
        ({"wheel": {"radius": 0.3, "crown": 0.1}}, [0.3, 0.3, 0.1]),
        ({"wheel": {"radius": 0.3}}, [0.3, 0.3, 0.006]),
        ({"hull": [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, 1]]}, [1, 1, 1]),
        ({"mesh": CUBE}, [1, 1, 1]),
    ],
)
def test_shapes_are_drawn_with_their_dimensions(shape: dict[str, Any], half: list[float]) -> None:
    scene = gelenk.load(
        {
            "gelenk": 1,
            "bodies": {
                "b": {"mass": 1, "inertia": [1] * 3, "shapes": {"s": {**shape, "position": [1, 2, 3]}}}
            },
            "joints": {"j": {"type": "free", "parent": "ground", "child": "b"}},
        }
    )
    lower, upper = extent(shapes_of(scene.to_dict(), 1.0)["b"])
    assert lower == pytest.approx(np.array([1, 2, 3]) - half)
    assert upper == pytest.approx(np.array([1, 2, 3]) + half)


def test_half_spaces_are_drawn_below_their_surface() -> None:
    scene = gelenk.load(
        {
            "gelenk": 1,
            "bodies": {"b": {"mass": 1, "inertia": [1] * 3}},
            "ground": {"shapes": {"wall": {"plane": [1, 0, 0], "position": [-0.5, 0, 0]}}},
            "joints": {"j": {"type": "free", "parent": "ground", "child": "b"}},
        }
    )
    vertices, _ = shapes_of(scene.to_dict(), 2.0)["ground"].meshes[0]
    assert vertices[:, 0].max() == pytest.approx(-0.5)
    assert vertices[:, 0].min() == pytest.approx(-0.52)
    assert np.ptp(vertices[:, 1:], axis=0) == pytest.approx([2, 2])


def test_a_mesh_is_drawn_as_it_is_not_as_its_hull() -> None:
    """All triangles of an L, in their orientation: they enclose its volume."""
    part = polyhedra.l_shape()
    scene = gelenk.load(
        {
            "gelenk": 1,
            "bodies": {"b": {"mass": {"density": 1}, "shapes": {"s": {"mesh": part, "rotation": TURN}}}},
            "joints": {"j": {"type": "free", "parent": "ground", "child": "b"}},
        }
    )
    [(vertices, triangles)] = shapes_of(scene.to_dict(), 1.0)["b"].meshes
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(polyhedra.of_boxes(polyhedra.L_BOXES)[0], rel=1e-12)
