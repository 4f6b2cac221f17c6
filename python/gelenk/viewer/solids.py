# SPDX-License-Identifier: BSD-3-Clause
"""The shapes that a scene gives to bodies and to the ground, as the viewer draws them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk.model.skeleton import frame_rotation

if TYPE_CHECKING:
    from gelenk.viewer.shapes import Shapes

type Array = NDArray[np.float64]

SLAB_THICKNESS = 0.01  # relative to its edge, of a piece of a half-space
CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def add_solids(out: Shapes, shapes: Mapping[str, Mapping[str, Any]], size: float) -> None:
    """Add the shapes of a body; of a half-space a square piece of its surface.

    Args:
        out: receives them, in the body's frame.
        shapes: by name, as in a scene.
        size: of the mechanism [m], the edge of pieces of half-spaces.
    """
    for shape in shapes.values():
        p = np.array(shape.get("position", (0, 0, 0)), float)
        R = frame_rotation(shape)
        x, y, z = R.T
        if "sphere" in shape:
            out.add_ball(p, shape["sphere"])
        elif "capsule" in shape or "cylinder" in shape:
            is_capsule = "capsule" in shape
            round_shape = shape["capsule" if is_capsule else "cylinder"]
            half = z * round_shape["length"] / 2
            out.add_tube(p - half, p + half, round_shape["radius"])
            for end in (p - half, p + half) if is_capsule else ():
                out.add_ball(end, round_shape["radius"])
        elif "box" in shape:
            a, b, c = shape["box"]
            base = p + CORNERS @ np.array([a * x, b * y]) - c / 2 * z
            out.add_prism(base, c * z)
        elif "hull" in shape:
            out.add_hull(p + np.array(shape["hull"], float) @ R.T)
        elif "mesh" in shape:
            points = np.array(shape["mesh"]["points"], float)
            out.meshes.append((p + points @ R.T, np.array(shape["mesh"]["triangles"], np.uint32)))
        elif "plane" in shape:
            base = p + size * CORNERS @ np.array([x, y]) - SLAB_THICKNESS * size * z
            out.add_prism(base, SLAB_THICKNESS * size * z)
