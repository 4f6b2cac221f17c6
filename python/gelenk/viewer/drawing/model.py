# SPDX-License-Identifier: BSD-3-Clause
"""A mechanism as triangles and lines in the world, at any time of its run."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.model.skeleton import placed, turned
from gelenk.viewer.drawing.colors import SPRING_COLOR, Color, color_of, readable
from gelenk.viewer.drawing.solids import Array, Indices, Solid, basis, coil, solid_of
from gelenk.viewer.interpolation import interpolated

FAR_AWAY = 4.0  # size of the run, in sizes of the mechanism, from which the camera follows
SAMPLED_POSES = 20_000  # poses that the box around a run is computed from
TRAIL_POINTS_APART = 1 / 300  # in sizes of the mechanism
SPRING_RADIUS, LARGEST_SPRING_RADIUS = 0.12, 0.035  # in lengths of the spring, and in sizes of the mechanism
DIRECTIONS = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if any(d)], float)
AT_REST = np.array([0.0, 0, 0, 0, 0, 0, 1])


@dataclass(frozen=True)
class Part:
    """A solid with its color, in the frame of a body; the ground is body -1."""

    solid: Solid
    color: Color
    body: int


class Model:
    """A mechanism with the poses of its run."""

    def __init__(self, data: Mapping[str, Any], background: Color) -> None:
        """Make a model of `gelenk.viewer.data.page_data`."""
        self.data = data
        self._background = background
        #: Times of the frames [s], shape (frames,).
        self.time: Array = np.asarray(data["time"], float)
        self._poses = np.asarray(data["poses"], float).reshape(len(self.time), len(data["bodies"]), 7)
        rows = [data["ground"], *data["bodies"]]
        roles = {"": None, **data["colors"]}
        #: The ground and the bodies, and the symbols of joints on them, in their own frames.
        self.parts = [
            Part(solid, readable(color_of(color or row["color"]), background), number - 1)
            for number, row in enumerate(rows)
            for role, color in roles.items()
            if len((solid := solid_of(row, role)).points)
        ]
        own: list[list[Array]] = [[] for _ in rows]
        for part in self.parts:
            own[part.body + 1].append(part.solid.points)
        self._outlines = [_outline(np.vstack([*points, np.empty((0, 3))])) for points in own]
        #: Points that the mechanism reaches during the run, shape (points, 3) [m].
        self.cloud = self._cloud()
        #: Half the diagonal of the box around these points [m].
        self.radius = _radius(self.cloud)
        self._spring_color = readable(color_of(SPRING_COLOR), background)
        #: Springs: their ends, their coil, and its length at the start [m].
        self.springs = [self._spring(row) for row in data["springs"]]

    @property
    def travels(self) -> bool:
        """Whether the run reaches so far that the mechanism would be a dot in a picture of all of it."""
        return len(self.time) > 1 and self.radius > FAR_AWAY * _radius(self.reached_at(self._poses[0]))

    def poses(self, time: float) -> Array:
        """Return the poses at a time, interpolated between frames, shape (bodies, 7)."""
        k = int(np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 1))
        if k == len(self.time) - 1 or time <= self.time[k]:
            frame: Array = self._poses[k]
            return frame
        share = (time - self.time[k]) / (self.time[k + 1] - self.time[k])
        return interpolated(self._poses[k], self._poses[k + 1], share)

    def reached_at(self, poses: Array) -> Array:
        """Return points on the bodies that reach farthest, shape (points, 3) [m]."""
        own = zip(poses, self._outlines[1:], strict=True)
        return np.vstack([placed(pose[None], outline) for pose, outline in own])

    def world_point(self, end: Mapping[str, Any], poses: Array) -> Array:
        """Return a point that is fixed in a body, {"body", "p"}, in the world [m]."""
        pose = AT_REST if end["body"] < 0 else poses[end["body"]]
        out: Array = placed(pose[None], np.array(end["p"], float))[0]
        return out

    def solids(self, poses: Array) -> tuple[Array, Array, Indices, Array]:
        """Return all triangles: points [m], normals, rows of points, and the colors of the triangles."""
        parts = [(_moved(part.solid, poses, part.body), part.color) for part in self.parts]
        for row, shape, length in self.springs:
            a, b = (self.world_point(row[side], poses) for side in ("from", "to"))
            parts += [(solid, self._spring_color) for solid in _stretched(shape, a, b, length)]
        solid = Solid.joined([part for part, _ in parts])
        counts = [len(part.triangles) for part, _ in parts]
        colors = np.array([color for _, color in parts]).reshape(-1, 3)
        return solid.points, solid.normals, solid.triangles, np.repeat(colors, counts, axis=0)

    def trails(self) -> list[tuple[Array, Color]]:
        """Return the paths of the frame origin and of the farthest point of each body, with its color."""
        out = []
        for body, (row, outline) in enumerate(zip(self.data["bodies"], self._outlines[1:], strict=True)):
            color = readable(color_of(row["color"]), self._background)
            farthest = outline[np.argmax(np.linalg.norm(outline, axis=1))]
            points = (
                [np.zeros(3), farthest] if np.linalg.norm(farthest) > 1e-6 * self.radius else [np.zeros(3)]
            )
            for point in points:
                path = placed(self._poses[:, body], point)
                path = path[np.isfinite(path).all(axis=1)]
                if len(path) > 1 and _radius(path) > 1e-4 * self.radius:
                    out.append((_thinned(path, TRAIL_POINTS_APART * self.radius), color))
        return out

    def _cloud(self) -> Array:
        stride = max(1, -(-self._poses.shape[0] * self._poses.shape[1] // SAMPLED_POSES))
        frames = np.unique([*range(0, len(self._poses), stride), len(self._poses) - 1])
        points = [self._outlines[0]] if any(part.body < 0 for part in self.parts) else []
        for body, outline in enumerate(self._outlines[1:]):
            points += [placed(self._poses[frames, body], p) for p in outline]
        ends = [row[side] for row in self.data["springs"] for side in ("from", "to")]
        points += [np.array([end["p"]], float) for end in ends if end["body"] < 0]
        cloud = np.vstack([*points, np.empty((0, 3))])
        cloud = cloud[np.isfinite(cloud).all(axis=1)]
        return cloud if len(cloud) else np.zeros((1, 3))

    def _spring(self, row: Mapping[str, Any]) -> tuple[Mapping[str, Any], Solid, float]:
        start = self._poses[0]
        distance = float(
            np.linalg.norm(self.world_point(row["to"], start) - self.world_point(row["from"], start))
        )
        length = max(distance, 0.05 * self.radius)
        radius = min(LARGEST_SPRING_RADIUS * self.radius, SPRING_RADIUS * length)
        return row, coil(radius / length), length


def _moved(solid: Solid, poses: Array, body: int) -> Solid:
    if body < 0:
        return solid
    pose = poses[body : body + 1]
    return Solid(placed(pose, solid.points), turned(pose, solid.normals), solid.triangles)


def _stretched(shape: Solid, a: Array, b: Array, length: float) -> list[Solid]:
    """Lengthen a coil along its axis only, so that its radius stays as it is."""
    distance = float(np.linalg.norm(b - a))
    if not distance > 1e-6 * length:
        return []
    R = np.roll(basis((b - a) / distance), 1, axis=1)
    scale = np.array([distance, length, length])
    normals = shape.normals / scale
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return [Solid(a + shape.points * scale @ R.T, normals @ R.T, shape.triangles)]


def _outline(points: Array) -> Array:
    """Return the points that reach farthest in 26 directions."""
    if not len(points):
        return np.zeros((1, 3))
    return points[np.unique(np.argmax(points @ DIRECTIONS.T, axis=0))]


def _radius(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0))) / 2 or 1.0


def _thinned(path: Array, apart: float) -> Array:
    """Return the points of a path without those that are too close to be distinguished."""
    kept: list[NDArray[np.float64]] = []
    for point in path[:-1]:
        if not kept or np.linalg.norm(point - kept[-1]) >= apart:
            kept.append(point)
    return np.array([*kept, path[-1]])
