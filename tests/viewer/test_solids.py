# SPDX-License-Identifier: BSD-3-Clause
"""Shapes that a scene gives are drawn with their dimensions, at their place."""

from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.viewer.shapes import Shapes, shapes_of


def extent(shapes: Shapes) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of the box around all parts; of tubes without their radius."""
    points = [np.array(ball["p"]) + sign * ball["r"] for ball in shapes.balls for sign in (-1, 1)]
    points += [np.array(tube[end]) for tube in shapes.tubes for end in "ab"]
    points += [p for vertices, _ in shapes.meshes for p in vertices]
    return np.min(points, axis=0), np.max(points, axis=0)


@pytest.mark.parametrize(
    ("shape", "half"),
    [
        ({"sphere": 0.2}, [0.2, 0.2, 0.2]),
        ({"box": [0.1, 0.2, 0.3]}, [0.05, 0.1, 0.15]),
        ({"capsule": {"radius": 0.1, "length": 0.4}}, [0.1, 0.1, 0.3]),
        ({"cylinder": {"radius": 0.1, "length": 0.4}}, [0, 0, 0.2]),
        ({"hull": [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, 1]]}, [1, 1, 1]),
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
