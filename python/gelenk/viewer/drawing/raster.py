# SPDX-License-Identifier: BSD-3-Clause
"""Triangles to pixels: a z-buffer whose loops are those of NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]
type Indices = NDArray[np.intp]

SLIVER = (
    1e-4  # twice the area [pixels^2]; smaller triangles cover no pixel but by chance, and vary by rounding
)


def counted(counts: Indices) -> tuple[Indices, Indices]:
    """Return for each of counts.sum() items its group, and its number within the group."""
    group = np.repeat(np.arange(len(counts)), counts)
    return group, np.arange(len(group)) - np.repeat(np.cumsum(counts) - counts, counts)


def fragments(corners: Array, width: int, height: int) -> tuple[Indices, Indices]:
    """Return the pixels whose centers are inside triangles.

    A center on the edge of two triangles belongs to one of them.

    Args:
        corners: positions to the right and downwards [pixels], shape (triangles, 3, 2).
        width: of the picture [pixels].
        height: of the picture [pixels].

    Returns:
        tuple: numbers of the triangles, and of the pixels, row by row from the upper left.
    """
    order = np.argsort(corners[:, :, 1], axis=1)
    x = np.take_along_axis(corners[:, :, 0], order, axis=1)
    y = np.take_along_axis(corners[:, :, 1], order, axis=1)
    first = np.ceil(np.clip(y[:, 0], 0, height) - 0.5).astype(np.intp)
    last = np.ceil(np.clip(y[:, 2], 0, height) - 0.5).astype(np.intp)
    triangle, k = counted(np.maximum(last - first, 0))
    row = first[triangle] + k
    # The long edge, and the one of the two others that has this row.
    upper = row + 0.5 < y[triangle, 1]
    a, b = np.where(upper, 0, 1), np.where(upper, 1, 2)
    ends = [_at(row + 0.5, x, y, triangle, i, j) for i, j in ((np.zeros_like(a), np.full_like(a, 2)), (a, b))]
    left = np.ceil(np.clip(np.minimum(*ends), 0, width) - 0.5).astype(np.intp)
    right = np.ceil(np.clip(np.maximum(*ends), 0, width) - 0.5).astype(np.intp)
    span, k = counted(np.maximum(right - left, 0))
    return triangle[span], row[span] * width + left[span] + k


def _at(center: NDArray[np.floating], x: Array, y: Array, triangle: Indices, a: Indices, b: Indices) -> Array:
    """Return where edges from corner a to b of triangles meet the centers of rows."""
    xa, xb, ya, yb = x[triangle, a], x[triangle, b], y[triangle, a], y[triangle, b]
    share = (center - ya) / np.where(yb > ya, yb - ya, 1.0)
    out: Array = xa + np.clip(share, 0, 1) * (xb - xa)
    return out


@dataclass(frozen=True)
class Line:
    """A line through points.

    Attributes:
        path: as of `Camera.project`, shape (points, 3).
        color: red, green, blue from 0 to 1.
        alpha: opacity of all, or of each segment.
    """

    path: Array
    color: Array
    alpha: float | Array = 1.0


class Raster:
    """A picture with its depth."""

    def __init__(self, colors: NDArray[np.uint8]) -> None:
        """Begin with a background, shape (height, width, 3), that is behind everything."""
        self.height, self.width = colors.shape[:2]
        #: Colors from 0 to 255, shape (height * width, 3).
        self.colors = colors.reshape(-1, 3).copy()
        #: The closeness of what is seen, shape (height * width,).
        self.closeness = np.full(len(self.colors), -np.inf, np.float32)

    def draw(self, corners: Array, light: Array, colors: Array, alpha: float | Array = 1.0) -> None:
        """Draw triangles over what is farther away than they are.

        Args:
            corners: as of `Camera.project`, shape (triangles, 3, 3).
            light: of the corners, shape (triangles, 3), by which colors are multiplied.
            colors: of the triangles from 0 to 1, shape (triangles, 3).
            alpha: opacity of all, or of each triangle; what is translucent must be drawn after what is not.
        """
        triangle, pixel = fragments(corners[:, :, :2], self.width, self.height)
        # Closeness and light are linear in the picture: value = c0 + cx x + cy y in each triangle.
        planes = _planes(corners[:, :, :2], np.stack([corners[:, :, 2], light], axis=-1))
        near = self._values(planes[:, :, 0], triangle, pixel).astype(np.float32)
        ahead = near > self.closeness[pixel]
        triangle, pixel, near = triangle[ahead], pixel[ahead], near[ahead]
        np.maximum.at(self.closeness, pixel, near)
        front = near == self.closeness[pixel]
        triangle, pixel = triangle[front], pixel[front]
        shade = self._values(planes[:, :, 1], triangle, pixel)
        color = 255 * (shade[:, None] * colors[triangle]).clip(0, 1)
        if not (np.ndim(alpha) == 0 and alpha == 1.0):
            opacity = np.broadcast_to(np.asarray(alpha), len(corners))[triangle, None]
            color = opacity * color + (1 - opacity) * self.colors[pixel]
        self.colors[pixel] = np.rint(color)

    def _values(self, planes: Array, triangle: Indices, pixel: Indices) -> Array:
        """Return linear functions of triangles at the centers of pixels."""
        y, x = np.divmod(pixel, self.width)
        c0, cx, cy = (column[triangle] for column in planes.T)
        out: Array = c0 + cx * (x + 0.5) + cy * (y + 0.5)
        return out

    def draw_lines(self, lines: Sequence[Line], width: float) -> None:
        """Draw lines of a constant width [pixels]."""
        if not lines:
            return
        corners, colors, alphas = zip(*(_ribbon(line, width / 2) for line in lines), strict=True)
        joined = np.concatenate(corners)
        light = np.ones((len(joined), 3))
        self.draw(joined, light, np.concatenate(colors), np.concatenate(alphas))


def _ribbon(line: Line, half: float) -> tuple[Array, Array, Array]:
    """Return the triangles of a line, and their colors and opacities."""
    a, b = line.path[:-1], line.path[1:]
    along = b[:, :2] - a[:, :2]
    length = np.linalg.norm(along, axis=1)
    drawn = length > 0  # and not NaN
    a, b, along = a[drawn], b[drawn], along[drawn] / length[drawn, None] * half
    across = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along))])
    quads = np.stack([a + across, a - across, b + across, b - across], axis=1)
    corners = np.vstack([quads[:, [0, 1, 2]], quads[:, [2, 1, 3]]])
    alphas = np.tile(np.broadcast_to(np.asarray(line.alpha), len(drawn))[drawn], 2)
    return corners, np.tile(line.color, (len(corners), 1)), alphas


def _planes(corners: Array, values: Array) -> Array:
    """Return the coefficients of the linear functions with these values at the corners.

    Args:
        corners: shape (triangles, 3, 2).
        values: shape (triangles, 3, functions).

    Returns:
        Array: c0, cx, cy of c0 + cx x + cy y, shape (triangles, 3, functions); constant where a triangle has
            no area.
    """
    (ax, ay), (bx, by) = ((corners[:, k] - corners[:, 0]).T for k in (1, 2))
    area = ax * by - ay * bx
    inverse = np.divide(1, area, out=np.zeros_like(area), where=np.abs(area) > SLIVER)[:, None]
    da, db = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    cx = (da * by[:, None] - db * ay[:, None]) * inverse
    cy = (db * ax[:, None] - da * bx[:, None]) * inverse
    c0 = values[:, 0] - cx * corners[:, 0, :1] - cy * corners[:, 0, 1:]
    return np.stack([c0, cx, cy], axis=1)
