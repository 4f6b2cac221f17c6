# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms defined by the world positions of all parts at one position,
where loops are closed by construction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mechanisms import Array, Numbers, Scene, joint, matrix, rotation, scene

Z = np.array([0.0, 0.0, 1.0])
Pose = tuple[Array, Array]  # rotation, position in the world


def point(x: Numbers) -> Array:
    """A point in space; two numbers are in the x-y plane."""
    out = np.zeros(3)
    out[: len(x)] = x
    return out


def snapped(x: Array) -> Array:
    """Numbers that differ from a round one only by round-off are replaced by it:
    what a user would have entered.
    """
    near = np.round(x, 6)
    return np.where(np.abs(x - near) < 4e-15, near, x) + 0.0


def quaternion(R: Array) -> Array:
    """X, y, z and the scalar part, which is nonnegative."""
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
            [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
            [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]],
        ]
    )
    Q: Array = np.linalg.eigh(K, UPLO="L")[1][:, -1]
    return Q if Q[3] >= 0 else -Q


def displacement(kind: str, axes: Sequence[Array], q: Sequence[float]) -> Pose:
    """The pose of M in F at the coordinates q, a quaternion being three numbers: axis times angle."""
    R, p = np.eye(3), np.zeros(3)
    if kind == "revolute":
        R = rotation(axes[0], q[0])
    elif kind == "prismatic":
        p = q[0] * axes[0]
    elif kind == "cylindrical":
        R, p = rotation(axes[0], q[1]), q[0] * axes[0]
    elif kind == "universal":
        R = rotation(axes[0], q[0]) @ rotation(axes[1], q[1])
    elif kind == "planar":
        R, p = rotation(Z, q[2]), np.array([q[0], q[1], 0.0])
    elif kind == "spherical" and any(q):
        R = rotation(q, float(np.linalg.norm(q)))
    return R, p


COORDINATES: dict[str, tuple[str, ...]] = {
    "revolute": ("phi",),
    "prismatic": ("s",),
    "cylindrical": ("s", "phi"),
    "universal": ("phi_a", "phi_b"),
    "planar": ("s_x", "s_y", "phi"),
    "spherical": ("Q[1]", "Q[2]", "Q[3]"),
    "weld": (),
}


@dataclass
class Sketch:
    """Bodies and joints at their positions; `scene` converts them to the scene
    format with all coordinates as start values.

    natural: body frames are aligned with the links and joint frames with those, so that a planar joint's
    coordinate is the angle between links; otherwise bodies are aligned with the world and all coordinates are
    as specified.
    """

    natural: bool = True
    poses: dict[str, Pose] = field(default_factory=lambda: {"ground": (np.eye(3), np.zeros(3))})
    bodies: dict[str, Any] = field(default_factory=dict)
    joints: dict[str, Any] = field(default_factory=dict)
    extra: dict[str, Any] = field(default_factory=dict)  # other sections

    def body(
        self, name: str, at: Numbers, along: Numbers | None = None, mass: float = 1.0, thick: float = 0.1
    ) -> None:
        """A body whose frame is at `at`; with `along` it is a rod to that point with
        the moments of a bar `thick` m across.
        """
        p = point(at)
        span = np.zeros(3) if along is None else point(along) - p
        length = float(np.linalg.norm(span))
        R = np.eye(3)
        if self.natural and length > 0:
            x = span / length
            y = np.cross(Z, x) if abs(x[2]) < 0.9 else np.cross([0, 1, 0], x)
            y /= np.linalg.norm(y)
            R = snapped(np.column_stack([x, y, np.cross(x, y)]))
        self.poses[name] = (R, p)
        if mass == 0:
            self.bodies[name] = {"mass": 0.0}
            return
        x = span / length if length > 0 else Z
        axial, across = mass * thick**2 / 6, mass * (length**2 + thick**2) / 12
        J = R.T @ (across * np.eye(3) + (axial - across) * np.outer(x, x)) @ R
        moments = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        self.bodies[name] = {
            "mass": mass,
            "com": snapped(R.T @ span / 2).tolist(),
            "inertia": snapped(np.array(moments)).tolist(),
        }

    def joint(
        self,
        name: str,
        kind: str,
        parent: str,
        child: str,
        at: Numbers,
        axes: Sequence[Numbers] = (Z,),
        q: Sequence[float] | None = None,
        **fields: Any,
    ) -> None:
        """A joint whose frame M is at `at`, its axes given in the world in the present position.

        q: its coordinates; None: the angle between the bodies if they differ only by a rotation about the
        joint axis, otherwise zeros.
        """
        R_P, p_P = self.poses[parent]
        R_C, p_C = self.poses[child]
        p_M = point(at)
        in_world = [np.asarray(a, float) / np.linalg.norm(np.asarray(a, float)) for a in axes]
        R_F = R_P
        if kind == "planar":  # its normal is z of F
            x = np.cross([0.3, 0.5, 0.8], in_world[0])
            if abs(in_world[0][2]) >= 0.999:  # most parents rotate about the world's z
                level = R_P - np.outer(in_world[0], in_world[0] @ R_P)
                x = level[:, 0] if np.linalg.norm(level[:, 0]) > 0.1 else level[:, 1]
            x = x / np.linalg.norm(x)
            R_F = np.column_stack([x, np.cross(in_world[0], x), in_world[0]])
        if q is None:
            q = [self._between(R_P.T @ R_C, R_P.T @ in_world[0])] if kind == "revolute" else []
        q = [*q, *[0.0] * (len(COORDINATES[kind]) - len(q))]
        # The second axis of a universal joint is fixed in M and moves with the first angle.
        in_F = [R_F.T @ a for a in in_world]
        if kind == "universal":
            in_F[1] = rotation(in_F[0], -q[0]) @ in_F[1]
        R_FM, p_FM = displacement(kind, in_F, q)
        R_M = R_F @ R_FM
        p_F = p_M - R_F @ p_FM
        halves = [
            _frame(parent, R_P.T @ (p_F - p_P), R_P.T @ R_F),
            _frame(child, R_C.T @ (p_M - p_C), R_C.T @ R_M),
        ]
        if kind == "universal":
            fields = {"axes": [snapped(a).tolist() for a in in_F], **fields}
        elif kind in ("revolute", "prismatic", "cylindrical"):
            fields = {"axis": snapped(in_F[0]).tolist(), **fields}
        start: dict[str, Any] = dict(zip(COORDINATES[kind], map(float, q), strict=True))
        if kind == "spherical":
            start = {"Q": quaternion(R_FM).tolist()}
        self.joints[name] = joint(kind, halves[0], halves[1], **({"start": start} if start else {}), **fields)

    def hinge(self, name: str, parent: str, child: str, at: Numbers, **fields: Any) -> None:
        """A revolute joint about z."""
        self.joint(name, "revolute", parent, child, at, **fields)

    def slide(self, name: str, parent: str, child: str, at: Numbers, along: Numbers, **fields: Any) -> None:
        self.joint(name, "prismatic", parent, child, at, [point(along)], **fields)

    def scene(self, **fields: Any) -> Scene:
        return scene(self.bodies, self.joints, **self.extra, **fields)

    def _between(self, R: Array, axis: Array) -> float:
        """The angle of R, if it is a rotation about the axis and this sketch is a natural one; else 0."""
        if not self.natural or np.abs(R @ axis - axis).max() > 1e-12:
            return 0.0
        across = np.cross(axis, [0.3, 0.5, 0.8])
        across /= np.linalg.norm(across)
        turned = R @ across
        return float(snapped(np.arctan2(np.cross(across, turned) @ axis, across @ turned)))


def _frame(body: str, p: Array, R: Array) -> dict[str, Any]:
    out: dict[str, Any] = {"body": body, "position": snapped(p).tolist()}
    if np.abs(R - np.eye(3)).max() > 1e-15:
        out["rotation"] = matrix(R)
    return out


def meeting(a: Numbers, r: float, b: Numbers, s: float, branch: int = 1) -> Array | None:
    """Intersection of circles of radius r about a and s about b, left (1)
    or right (-1) of the line from a to b.
    """
    A, B = np.asarray(a, float), np.asarray(b, float)
    d = float(np.linalg.norm(B - A))
    if d == 0:
        return None
    x = (d * d + r * r - s * s) / (2 * d)
    y2 = r * r - x * x
    if y2 < -1e-12:
        return None
    along = (B - A) / d
    out: Array = A + x * along + branch * np.sqrt(max(y2, 0.0)) * np.array([-along[1], along[0]])
    return snapped(out)
