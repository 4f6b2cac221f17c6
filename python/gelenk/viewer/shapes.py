# SPDX-License-Identifier: BSD-3-Clause
"""Shapes that represent the bodies and joints of a scene: links between joints, plates, blocks and wheels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.model.scene import load
from gelenk.model.skeleton import (
    GROUND,
    axis_of,
    constraining_joints,
    joint_ends,
    joint_kind,
    loop_joints,
    point,
    springs,
    wheel_axes,
    wheels,
)
from gelenk.viewer.distinct_points import SAME, DistinctPoints

type Array = NDArray[np.float64]

ALIKE = 0.02  # relative difference of moments of inertia given with two digits
IN_LINE = 1e-3  # width of points in line, relative to their distance
LINK_RADIUS = 0.012  # relative to the size of the mechanism, like the following
PLATE_THICKNESS = 0.012
SMALLEST_BLOCK, LARGEST_BLOCK, LARGEST_END = 0.03, 0.5, 0.15
LARGEST_DISK = 2.0  # a disk hides less than a block
JOINT_RADIUS, JOINT_LENGTH = 1.5, 4.0  # in radii of links


@dataclass
class Shapes:
    """Shapes fixed in the frame of one body [m], as the viewer reads them."""

    tubes: list[dict[str, Any]] = field(default_factory=list)
    balls: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[tuple[Array, NDArray[np.uint32]]] = field(default_factory=list)

    def add_tube(self, a: Array, b: Array, radius: float, role: str = "") -> None:
        """Add a cylinder from a to b; `role` is "joint" or "loop" for the symbol of a joint."""
        self.tubes.append({"a": a.tolist(), "b": b.tolist(), "r": radius, "role": role})

    def add_ball(self, p: Array, radius: float, role: str = "") -> None:
        """Add a sphere; `role` is "joint" or "loop" for the symbol of a joint."""
        self.balls.append({"p": p.tolist(), "r": radius, "role": role})

    def add_hull(self, points: Array) -> None:
        """Add the convex hull of points that are not in one plane, shape (points, 3)."""
        from scipy.spatial import ConvexHull

        hull = ConvexHull(points)
        triangles = hull.simplices.copy()
        for row, outward in zip(triangles, hull.equations[:, :3], strict=True):
            a, b, c = points[row]
            if np.cross(b - a, c - a) @ outward < 0:
                row[1:] = row[:0:-1]
        self.meshes.append((points, triangles.astype(np.uint32)))

    def add_prism(self, outline: Array, height: Array) -> None:
        """Add a prism.

        Args:
            outline: corners of its base, convex, counterclockwise about `height`, shape (corners, 3).
            height: from the base to the other face.
        """
        n = len(outline)
        triangles = [(0, k + 1, k) for k in range(1, n - 1)] + [
            (n, n + k, n + k + 1) for k in range(1, n - 1)
        ]
        for k in range(n):
            after = (k + 1) % n
            triangles += [(k, after, n + after), (k, n + after, n + k)]
        self.meshes.append((np.vstack([outline, outline + height]), np.array(triangles, np.uint32)))


def shapes_of(data: Mapping[str, Any], size: float) -> dict[str, Shapes]:
    """Return the shapes of all bodies and of the ground.

    Args:
        data: the scene as plain data.
        size: of the mechanism [m], to which the thickness of links is relative.
    """
    out = {name: Shapes() for name in (GROUND, *data["bodies"])}
    marks = marks_of(data)
    rolling = wheels(data)
    for name, solids in _solids(data, size).items():
        for balls, tubes, vertices, triangles in solids:
            for center, radius in balls:
                out[name].add_ball(np.array(center), radius)
            for a, b, radius in tubes:
                out[name].add_tube(np.array(a), np.array(b), radius)
            if vertices:
                out[name].meshes.append((np.array(vertices), np.array(triangles, np.uint32)))
    for name, body in data["bodies"].items():
        if body.get("shapes"):
            continue
        if name in rolling:
            _add_wheel(out[name], rolling[name], size)
        _add_body(out[name], body, marks[name], size, is_wheel=name in rolling)
    for p in marks[GROUND]:
        out[GROUND].add_ball(p, 1.5 * LINK_RADIUS * size)
    loops = loop_joints(data)
    for name, joint in constraining_joints(data).items():
        _add_joint(out, joint, LINK_RADIUS * size, "loop" if name in loops else "joint")
    return out


def _solids(data: Mapping[str, Any], size: float) -> dict[str, list[tuple[Any, Any, Any, Any]]]:
    """Return what the shapes of each body and of the ground say of themselves (`_core.drawings`)."""
    owners = [*data["bodies"].values(), data.get("ground", {})]
    if not any(owner.get("shapes") for owner in owners):
        return {}
    return _core.drawings(load(data)._core, size)


def marks_of(data: Mapping[str, Any]) -> dict[str, list[Array]]:
    """Return the distinct points of bodies and of the ground at which joints and springs act [m]."""
    out = {name: DistinctPoints() for name in (GROUND, *data["bodies"])}
    for pair in (*joint_ends(data), *springs(data)):
        for body, p in map(point, pair):
            out[body].add(p)
    return {body: points.all for body, points in out.items()}


def has_axis(joint: Mapping[str, Any]) -> bool:
    """Return whether a joint permits motions along and about one axis only."""
    kind = joint_kind(joint)
    return bool(kind["axes"] == 1 and kind["nv"] <= 2)


def slides(joint: Mapping[str, Any]) -> bool:
    """Return whether a joint has a coordinate along its axis."""
    return has_axis(joint) and "m" in joint_kind(joint)["q_units"]


def _add_body(
    out: Shapes, body: Mapping[str, Any], marks: Sequence[Array], size: float, *, is_wheel: bool
) -> None:
    com = np.array(body["com"], float)
    radius = LINK_RADIUS * size
    if len(marks) > 2:
        _add_plate(out, np.array(marks), size)
    elif len(marks) == 2:
        out.add_tube(marks[0], marks[1], radius)
    foot = _foot(np.array(marks), com) if len(marks) > 0 else None
    far = SAME if len(marks) == 1 else LARGEST_END * size
    if foot is not None and np.linalg.norm(com - foot) > far:
        out.add_tube(foot, com, radius)
        if not is_wheel:
            _add_block(out, body, com, size, LARGEST_END)
    elif len(marks) < 2 and not is_wheel:
        _add_block(out, body, com, size, LARGEST_BLOCK)


def _foot(marks: Array, com: Array) -> Array | None:
    """Return the point below the center of mass on the line of the marks, or None if they are not in line."""
    middle: Array = marks.mean(axis=0)
    if len(marks) == 1:
        return middle
    _, extent, V = np.linalg.svd(marks - middle)
    if extent[1] > IN_LINE * extent[0]:
        return None
    out: Array = middle + V[0] * ((com - middle) @ V[0])
    return out


def _add_plate(out: Shapes, marks: Array, size: float) -> None:
    """Add the hull of three or more points, or a link between the outermost of points in line."""
    middle = marks.mean(axis=0)
    _, extent, V = np.linalg.svd(marks - middle, full_matrices=True)
    thin = IN_LINE * extent[0]
    if extent[1] <= thin:
        along = (marks - middle) @ V[0]
        out.add_tube(marks[along.argmin()], marks[along.argmax()], LINK_RADIUS * size)
        return
    if len(extent) < 3 or extent[2] <= thin:
        height = np.cross(V[0], V[1]) * PLATE_THICKNESS * size
        corners = _outline((marks - middle) @ V[:2].T)
        out.add_prism(middle + corners @ V[:2] - height / 2, height)
    else:
        out.add_hull(marks)


def _outline(points: Array) -> Array:
    """Return the corners of the convex hull of points in a plane, counterclockwise (Andrew 1979)."""
    # Without rounding, points in line above each other would be in the order of their rounding errors.
    grain = 1e-9 * float(np.ptp(points, axis=0).max())
    ordered = sorted(map(tuple, ((points / grain).round() * grain).tolist()))

    def half(points: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
        chain: list[tuple[float, ...]] = []
        for p in points:
            while len(chain) > 1 and _area(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return np.array([*half(ordered), *half(ordered[::-1])])


def _area(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    """Return twice the area of a triangle, positive if its corners are counterclockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _add_block(out: Shapes, body: Mapping[str, Any], com: Array, size: float, largest: float) -> None:
    """Add the homogeneous cylinder or block with the mass and the inertia of a body; no edge, and no length
    of a cylinder, exceeds `largest` sizes.
    """
    xx, yy, zz, xy, xz, yz = body["inertia"]
    inertia, V = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    if np.linalg.det(V) < 0:
        V[:, 2] = -V[:, 2]
    mass = body["mass"] or 1.0
    axis = _axis_of_symmetry(inertia)
    if axis is not None:
        square = 2 * inertia[axis] / mass
        length = 12 * np.delete(inertia, axis).mean() / mass - 3 * square
        bounds = np.array([[SMALLEST_BLOCK, LARGEST_DISK], [SMALLEST_BLOCK, largest]]) * size
        diameter, height = np.clip(np.sqrt([4 * square, max(0.0, length)]), *bounds.T)
        _add_disk(out, com, V[:, axis], V[:, axis - 1], float(diameter / 2), float(height), size)
        return
    squares = 12 * (inertia.sum() / 2 - inertia) / mass
    edges = np.clip(np.sqrt(squares.clip(0)), SMALLEST_BLOCK * size, largest * size)
    base = np.array([[-0.5, -0.5, -0.5], [0.5, -0.5, -0.5], [0.5, 0.5, -0.5], [-0.5, 0.5, -0.5]])
    out.add_prism(com + base * edges @ V.T, edges[2] * V[:, 2])


def _axis_of_symmetry(inertia: Array) -> int | None:
    """Return the principal axis about which a body is a cylinder: moments about the others are equal."""
    same = ALIKE * inertia[2]
    if inertia[1] - inertia[0] <= same < inertia[2] - inertia[1]:
        return 2
    return 0 if inertia[2] - inertia[1] <= same < inertia[1] - inertia[0] else None


def _add_disk(
    out: Shapes, center: Array, axis: Array, across: Array, radius: float, height: float, size: float
) -> None:
    """Add a cylinder; if it is flat, a spoke on either face makes the rotation visible."""
    half, spoke = axis * height / 2, across * radius
    out.add_tube(center - half, center + half, radius)
    for face in (center - half, center + half) if height < 2 * radius else ():
        out.add_tube(face - spoke, face + spoke, LINK_RADIUS * size / 2, "joint")


def _add_wheel(out: Shapes, row: Mapping[str, Any], size: float) -> None:
    center, axis, across = wheel_axes(row)
    half = axis * LINK_RADIUS * size / 2
    out.add_tube(center - half, center + half, float(row["radius"]))
    # A spoke, beyond both faces, makes the rotation visible.
    spoke = across[0] * float(row["radius"])
    out.add_tube(center - spoke, center + spoke, LINK_RADIUS * size, "joint")


def _add_joint(out: Mapping[str, Shapes], joint: Mapping[str, Any], radius: float, role: str) -> None:
    """Add the symbol of a joint: pins about its axes, a ball, or a block that slides."""
    (parent, p_F), (child, p_M) = point(joint["parent"]), point(joint["child"])
    kind = joint_kind(joint)
    if kind["quaternion"]:
        out[child].add_ball(p_M, 2 * radius, role)
    elif kind["axes"] == 2 or (has_axis(joint) and "rad" in kind["q_units"]):
        _add_pin(out[parent], p_F, axis_of(joint), radius, role)
    if kind["axes"] == 2:
        _add_pin(out[child], p_M, axis_of(joint, 1), radius, role)
    if slides(joint):
        half = axis_of(joint, 1) * 2.5 * radius
        out[child].add_tube(p_M - half, p_M + half, 2 * radius, role)


def _add_pin(out: Shapes, p: Array, axis: Array, radius: float, role: str) -> None:
    half = axis * JOINT_LENGTH / 2 * radius
    out.add_tube(p - half, p + half, JOINT_RADIUS * radius, role)
