# SPDX-License-Identifier: BSD-3-Clause
"""Triangles of the shapes that the viewer draws: tubes, balls, meshes, coils of springs, arrows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]
type Indices = NDArray[np.intp]

CREASE = np.cos(np.deg2rad(35.0))  # edges flatter than this look smooth
TUBE_SIDES, WHEEL_SIDES, BALL_AROUND, BALL_DOWN = 16, 64, 20, 14
COIL_TURNS, COIL_POINTS, COIL_SIDES = 9, 150, 5
COIL_ENDS = 0.1  # relative length of the straight ends of a spring
WIRE_RADIUS = 0.16  # relative to the radius of the coil
HEAD_LENGTH, HEAD_RADIUS, SHAFT_RADIUS = 4.0, 1.8, 0.6  # of arrows, in radii of links


@dataclass(frozen=True)
class Solid:
    """Triangles with a normal at each corner.

    Attributes:
        points: shape (points, 3) [m].
        normals: unit vectors, shape (points, 3).
        triangles: rows of points, counterclockwise seen from outside, shape (triangles, 3).
    """

    points: Array
    normals: Array
    triangles: Indices

    @classmethod
    def joined(cls, parts: Sequence[Solid]) -> Self:
        """Return all parts as one solid."""
        starts = np.cumsum([0, *(len(part.points) for part in parts)])
        return cls(
            np.vstack([np.empty((0, 3)), *(part.points for part in parts)]),
            np.vstack([np.empty((0, 3)), *(part.normals for part in parts)]),
            np.vstack([
                np.empty((0, 3), np.intp),
                *(part.triangles + start for part, start in zip(parts, starts, strict=False)),
            ]),
        )  # fmt: skip


def solid_of(shapes: Mapping[str, Any], role: str = "") -> Solid:
    """Return the triangles of a body's shapes that have a role, as in `gelenk.viewer.data.page_data`."""
    tubes = [
        tube(np.array(row["a"]), np.array(row["b"]), row["r"])
        for row in shapes["tubes"]
        if row["a"] != row["b"] and row["role"] == role
    ]
    balls = [ball(np.array(row["p"]), row["r"]) for row in shapes["balls"] if row["role"] == role]
    meshes = [
        mesh(np.array(row["vertices"], float), np.array(row["triangles"], np.intp))
        for row in shapes["meshes"]
        if role == row.get("role", "")
    ]
    return Solid.joined([*tubes, *balls, *meshes])


def basis(axis: Array) -> Array:
    """Return a right-handed orthonormal basis whose third column is a unit vector."""
    across = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(across, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def frustum(a: Array, b: Array, radii: tuple[float, float], sides: int) -> Solid:
    """Return a cone from a to b that is cut off, with flat ends; with equal radii, a cylinder."""
    length = float(np.linalg.norm(b - a))
    R = basis((b - a) / length)
    turn = 2 * np.pi * np.arange(sides) / sides
    around = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(sides)]) @ R.T
    taper = (radii[0] - radii[1]) / length
    side = (around + taper * R[:, 2]) / np.hypot(1, taper)
    rings = [a + radii[0] * around, b + radii[1] * around]
    k = np.arange(sides)
    after = (k + 1) % sides
    fan = np.column_stack([np.zeros(sides - 2, np.intp), np.arange(1, sides - 1), np.arange(2, sides)])
    return Solid(
        np.vstack([*rings, *rings]),
        np.vstack([side, side, np.tile(-R[:, 2], (sides, 1)), np.tile(R[:, 2], (sides, 1))]),
        np.vstack([
            np.column_stack([k, after, k + sides]), np.column_stack([k + sides, after, after + sides]),
            fan[:, ::-1] + 2 * sides, fan + 3 * sides,
        ]),
    )  # fmt: skip


def tube(a: Array, b: Array, radius: float) -> Solid:
    """Return a cylinder from a to b; flat ones are wheels, of which the corners would be seen."""
    is_wheel = radius > 2 * np.linalg.norm(b - a)
    return frustum(a, b, (radius, radius), WHEEL_SIDES if is_wheel else TUBE_SIDES)


def ball(center: Array, radius: float) -> Solid:
    """Return a sphere."""
    polar, turn = np.meshgrid(
        np.pi * np.arange(BALL_DOWN + 1) / BALL_DOWN,
        2 * np.pi * np.arange(BALL_AROUND + 1) / BALL_AROUND,
        indexing="ij",
    )
    out = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
    corner = np.arange(out.shape[0] * out.shape[1]).reshape(out.shape[:2])
    triangles = _quads(corner)
    normals = out.reshape(-1, 3)
    return Solid(center + radius * normals, normals, triangles)


def mesh(vertices: Array, triangles: Indices) -> Solid:
    """Return a mesh whose flat edges are smoothed, and whose sharp edges remain."""
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces /= np.maximum(np.linalg.norm(faces, axis=1, keepdims=True), 1e-300)
    # Files like STL repeat a corner in every triangle.
    _, number = np.unique(vertices, axis=0, return_inverse=True)
    number = number.ravel()[triangles].ravel()
    order = np.argsort(number, kind="stable")
    starts = np.flatnonzero(np.diff(number[order], prepend=-1))
    normals = np.empty((len(number), 3))
    for group in np.split(order, starts[1:]):
        own = faces[group // 3]
        near = (own @ own.T > CREASE) | np.eye(len(own), dtype=bool)
        normals[group] = near @ own
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return Solid(corners.reshape(-1, 3), normals, np.arange(len(number)).reshape(-1, 3))


def coil(radius: float) -> Solid:
    """Return a spring along x from 0 to 1, with straight ends on the axis."""
    t = np.linspace(0, 1, COIL_POINTS + 1)
    inside = np.clip((t - COIL_ENDS) / (1 - 2 * COIL_ENDS), 0, 1)
    opening = radius * np.minimum(1, np.minimum(12 * inside, 12 * (1 - inside)))
    turn = 2 * np.pi * COIL_TURNS * inside
    path = np.column_stack([t, opening * np.cos(turn), opening * np.sin(turn)])
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # The wire lies nearly across the axis, so that the direction away from it is never parallel to the wire.
    away = np.column_stack([np.zeros_like(t), np.cos(turn), np.sin(turn)])
    away -= np.einsum("ij,ij->i", away, along)[:, None] * along
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    across = np.cross(along, away)
    angle = 2 * np.pi * np.arange(COIL_SIDES + 1) / COIL_SIDES
    normals = np.cos(angle)[None, :, None] * away[:, None] + np.sin(angle)[None, :, None] * across[:, None]
    points = path[:, None] + WIRE_RADIUS * radius * normals
    corner = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    return Solid(points.reshape(-1, 3), normals.reshape(-1, 3), _quads(corner)[:, ::-1])


def _quads(corner: Indices) -> Indices:
    """Return two triangles for each cell of a grid of points."""
    a, b, c, d = (x.ravel() for x in (corner[:-1, :-1], corner[1:, :-1], corner[:-1, 1:], corner[1:, 1:]))
    return np.vstack([np.column_stack([a, b, c]), np.column_stack([c, b, d])])
