# SPDX-License-Identifier: BSD-3-Clause
"""Symbols of the ground in drawings of planar mechanisms: hatched lines where something is attached to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.model.skeleton import GROUND, axis_of, constraining_joints, joint_kind, point
from gelenk.viewer.distinct_points import SAME, DistinctPoints
from gelenk.viewer.shapes import Shapes, slides

type Array = NDArray[np.float64]
type Line = tuple[Array, Array]

# In radii of links: of the triangle below a pin, of the line below it, and of the strokes of any line.
PIN_HEIGHT, PIN_HALF_WIDTH, HALF_LINE = 4.5, 3.0, 4.5
STROKE, STROKES_APART, WIRE = 1.5, 1.5, 0.2
BEHIND = 3.0  # the mechanism: links have a radius of 1, blocks on rails one of 2
MOST_STROKES = 60  # of a line
PARALLEL = 1e-6  # of unit vectors: the axis of a pin and the line of sight


def add_hatching(
    out: Shapes,
    scene: Mapping[str, Any],
    axes: Array,
    radius: float,
    rails: Sequence[Line],
    springs: Sequence[Line],
) -> None:
    """Add the symbols of the ground to its shapes, behind the mechanism.

    Args:
        out: the shapes of the ground.
        scene: the scene as plain data.
        axes: directions of the picture: to the right, upwards, towards the viewer, shape (3, 3).
        radius: of links [m].
        rails: both ends of the rails on the ground [m].
        springs: the end on the ground of each spring, and its other end at the start [m].
    """
    right, up, towards = axes
    hatching = _Hatching(out, axes, radius)
    for rail in rails:
        hatching.add_line(*rail)
    seen = DistinctPoints()
    for joint in constraining_joints(scene).values():
        kind = joint_kind(joint)
        is_pin = kind["axes"] == 1 and kind["nv"] == 1 and not slides(joint)
        if not (kind["nv"] == 0 or (is_pin and abs(axis_of(joint) @ towards) > 1 - PARALLEL)):
            continue
        for body, p in map(point, (joint["parent"], joint["child"])):
            if body != GROUND or not seen.add(p):
                continue
            foot = p - PIN_HEIGHT * radius * up if is_pin else p
            hatching.add_line(*(foot + sign * HALF_LINE * radius * right for sign in (-1, 1)))
            for sign in (-1, 1) if is_pin else ():
                hatching.add_wire(p, foot + sign * PIN_HALF_WIDTH * radius * right)
    for end, other in springs:
        along = other - end
        along = along - (along @ towards) * towards
        if np.linalg.norm(along) > SAME and seen.add(end):
            half = HALF_LINE * radius * np.cross(towards, along / np.linalg.norm(along))
            hatching.add_line(end - half, end + half, -along)


class _Hatching:
    """Lines in the plane of a picture, as thin tubes behind the mechanism."""

    def __init__(self, out: Shapes, axes: Array, radius: float) -> None:
        self._out, self._axes, self._radius = out, axes, radius

    def add_wire(self, a: Array, b: Array) -> None:
        behind = -BEHIND * self._radius * self._axes[2]
        self._out.add_tube(a + behind, b + behind, WIRE * self._radius)

    def add_line(self, a: Array, b: Array, side: Array | None = None) -> None:
        """Add a line with strokes on the side of a direction, by default below, of a vertical one left."""
        length = float(np.linalg.norm(b - a))
        right, up, towards = self._axes
        if length <= SAME or abs((b - a) @ towards) > PARALLEL * length:
            return
        along = (b - a) / length
        away = np.cross(towards, along)
        if away @ (side if side is not None else -(up + 1e-3 * right)) < 0:
            away = -away
        self.add_wire(a, b)
        count = min(MOST_STROKES, int(length / (STROKES_APART * self._radius)))
        stroke = STROKE * self._radius * (away - along)
        for share in (np.arange(count) + 1) / max(count, 1):
            start = a + share * (b - a)
            self.add_wire(start, start + stroke)
