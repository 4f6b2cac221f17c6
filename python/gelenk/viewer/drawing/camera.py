# SPDX-License-Identifier: BSD-3-Clause
"""The camera of the viewer: on a sphere around its target, with the world's up on top of the picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError

type Array = NDArray[np.float64]

HALF_ANGLE = np.deg2rad(15.0)  # of the field of view, vertically
MARGIN, FOLLOWING_MARGIN = 1.08, 1.3  # bodies turn while the camera follows
VIEWS = {"front": (-90.0, 0.0), "side": (0.0, 0.0), "top": (-90.0, 90.0)}  # azimuth, elevation [deg]
VERTICAL = 1e-6  # length of the horizontal part of a unit vector; below, its azimuth is rounding


class Camera:
    """A camera; the directions of its picture are those of the viewer's page."""

    def __init__(
        self, up: Sequence[float], towards: Sequence[float], *, flat: bool, size: tuple[int, int]
    ) -> None:
        """Make a camera.

        Args:
            up: direction of the world that is upwards in the picture.
            towards: direction from the mechanism to the viewer.
            flat: whether the picture has no perspective.
            size: width and height of the picture [pixels].
        """
        self.flat = flat
        self.width, self.height = size
        self.up = np.array(up, float) / np.linalg.norm(up)
        # Horizontal directions: the first is right in the front view, the second points away.
        x = np.eye(3)[1 if abs(self.up[0]) > 0.9 else 0]
        x = x - (x @ self.up) * self.up
        self.horizontal = x / np.linalg.norm(x)
        self.away = np.cross(self.up, self.horizontal)
        self.target = np.zeros(3)
        self.distance = 1.0
        self.axes = np.eye(3)
        self._look_from(np.array(towards, float))

    def _look_from(self, direction: Array) -> None:
        if not np.linalg.norm(direction) > 0:
            direction = -self.away
        direction = direction / np.linalg.norm(direction)
        x, y = direction @ self.horizontal, direction @ self.away
        azimuth = -np.pi / 2 if np.hypot(x, y) < VERTICAL else np.arctan2(y, x)
        self._turn(float(azimuth), float(np.arcsin(np.clip(direction @ self.up, -1, 1))))

    def _turn(self, azimuth: float, elevation: float) -> None:
        """Set the directions to the right, upwards and towards the viewer: the rows of `axes`."""
        c, s = np.cos(azimuth), np.sin(azimuth)
        right = -s * self.horizontal + c * self.away
        back = np.cos(elevation) * (c * self.horizontal + s * self.away) + np.sin(elevation) * self.up
        self.axes = np.array([right, np.cross(back, right), back])

    def set_view(self, view: str | Sequence[float]) -> None:
        """Choose a direction: "start", "front", "side", "top", or azimuth and elevation [deg].

        An azimuth of -90 is the front view, 0 the view from the right.

        Raises:
            UsageError: the view is none of these.
        """
        if view == "start":
            return
        angles = VIEWS.get(view) if isinstance(view, str) else view
        if angles is None or len(angles) != 2 or not np.isfinite(angles).all() or abs(angles[1]) > 90:
            raise UsageError(
                f"camera: found {view}, expected start, {', '.join(VIEWS)}, or azimuth and elevation [deg]"
            )
        self._turn(float(np.deg2rad(angles[0])), float(np.deg2rad(angles[1])))

    def fit(self, cloud: Array, margin: float = MARGIN) -> None:
        """Move target and distance so that all points just fill the picture.

        Args:
            cloud: shape (points, 3) [m].
            margin: width and height of the picture relative to those of the points.
        """
        center = (cloud.min(axis=0) + cloud.max(axis=0)) / 2
        radius = float(np.linalg.norm(np.ptp(cloud, axis=0))) / 2 or 1.0
        tangents = np.tan(HALF_ANGLE) / margin * np.array([self.width / self.height, 1.0])
        local = (cloud - center) @ self.axes.T
        depth = np.zeros(len(local)) if self.flat else local[:, 2]
        middle = np.zeros(2)
        # Perspective shifts the middle of the picture with the distance, so it takes a few rounds.
        for _ in range(4):
            needed = depth + (np.abs(local[:, :2] - middle) / tangents).max(axis=1)
            self.distance = max(0.05 * radius, float(needed.max()))
            scale = self.distance / np.maximum(1e-3 * self.distance, self.distance - depth)
            seen = (local[:, :2] - middle) * scale[:, None]
            self.target = center + middle @ self.axes[:2]
            middle = middle + (seen.min(axis=0) + seen.max(axis=0)) / 2

    @property
    def pixel(self) -> float:
        """Length of a pixel at the distance of the target [m]."""
        return float(2 * self.distance * np.tan(HALF_ANGLE) / self.height)

    def project(self, points: Array) -> Array:
        """Return pixels and closeness of points.

        Args:
            points: shape (points, 3) [m].

        Returns:
            Array: x to the right and y downwards from the upper left corner of the picture [pixels], and a
                closeness that is linear in them and larger for nearer points; NaN behind the camera; shape
                (points, 3).
        """
        local = (points - self.target) @ self.axes.T
        scale = np.full(len(local), 1 / self.pixel)
        if not self.flat:
            ahead = self.distance - local[:, 2]
            scale = scale * self.distance / np.where(ahead > 1e-3 * self.distance, ahead, np.nan)
        closeness = local[:, 2] if self.flat else scale
        return np.column_stack(
            [self.width / 2 + local[:, 0] * scale, self.height / 2 - local[:, 1] * scale, closeness]
        )
