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
THIN_WHEEL = 0.02  # half width of a wheel without a crown, relative to its radius
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
        elif "wheel" in shape:
            out.add_hull(p + _wheel(shape["wheel"]) @ R.T)
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


def _wheel(wheel: Mapping[str, float]) -> Array:
    """Return points of the tread of a wheel about z [m], shape (points, 3); of a thin disk two circles."""
    radius, crown = wheel["radius"], wheel.get("crown", 0.0)
    across = np.linspace(-np.pi / 2, np.pi / 2, 7 if crown > 0 else 2)
    rho = radius - crown + crown * np.cos(across)
    z = max(crown, THIN_WHEEL * radius) * np.sin(across)
    around = np.linspace(0, 2 * np.pi, 49)[:-1]
    return np.array([[r * np.cos(t), r * np.sin(t), h] for t in around for r, h in zip(rho, z, strict=True)])
