# SPDX-License-Identifier: BSD-3-Clause
"""What a picture of a mechanism shows of its scene: joints, springs and wheels, as plain data."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk import _core

type Array = NDArray[np.float64]
type Data = Mapping[str, Any]  # of a scene: Scene.to_dict()

GROUND = "ground"
DEFAULT_WHEEL_AXIS = (0.0, 1.0, 0.0)  # of rolling constraints
OBLIQUE = (0.5, -0.8, 0.45)  # towards the viewer of a mechanism in space: right, away from him, upwards
FLAT = 1e-6  # thickness of a planar mechanism, relative to its size


@functools.cache
def _joint_kinds() -> dict[str, Data]:
    return {kind["name"]: kind for kind in _core.joints.kinds()}


def joint_kind(joint: Data) -> Data:
    """Return what the registry of joints knows of the type of a joint: `nv`, `axes`, `q_units`, ..."""
    return _joint_kinds()[joint["type"]]


def constraining_joints(data: Data) -> dict[str, Data]:
    """Return the joints that constrain a motion, by name; those with six degrees of freedom do not."""
    return {name: joint for name, joint in data["joints"].items() if joint_kind(joint)["nv"] < 6}


def joint_ends(data: Data) -> list[tuple[Data, Data]]:
    """Return the frames in both bodies of the joints that constrain a motion."""
    return [(joint["parent"], joint["child"]) for joint in constraining_joints(data).values()]


def springs(data: Data) -> list[tuple[Data, Data]]:
    """Return the two ends of springs and all other forces between two points."""
    forces = data.get("forces", {}).values()
    return [(force["from"], force["to"]) for force in forces if {"from", "to"} <= {*force}]


def wheels(data: Data) -> dict[str, Data]:
    """Return the constraints and forces with an axis and a radius (rolling wheels, tires), by body."""
    rows = [*data.get("constraints", {}).values(), *data.get("forces", {}).values()]
    return {row["body"]: row for row in rows if {"body", "axis", "radius"} <= {*row}}


def wheel_axes(wheel: Data) -> tuple[Array, Array, Array]:
    """Return the center of a wheel [m], and as unit vectors its axis and two across it, shape (2, 3)."""
    axis = np.array(wheel.get("axis", DEFAULT_WHEEL_AXIS), float)
    center = np.array(wheel.get("position", (0.0, 0.0, 0.0)), float)
    return center, axis / np.linalg.norm(axis), np.linalg.svd(axis[None])[2][1:]


def point(end: Data) -> tuple[str, Array]:
    """Return the body of a joint frame, or of an end of a force, and its position in the body frame [m]."""
    return end["body"], np.array(end.get("position", (0.0, 0.0, 0.0)), float)


def frame_rotation(frame: Data) -> Array:
    """Return the rotation matrix of a frame in its body."""
    return np.array(frame.get("rotation", {}).get("matrix", np.eye(3)), float)


def axis_of(joint: Data, number: int = 0) -> Array:
    """Return an axis of a joint in the frame of the body that carries its frame F (number 0) or M (1)."""
    axes = joint.get("axes") or [joint.get("axis", (0.0, 0.0, 1.0))]
    axis = np.array(axes[min(number, len(axes) - 1)], float)
    out: Array = frame_rotation(joint["parent" if number == 0 else "child"]) @ axis / np.linalg.norm(axis)
    return out


def turned(poses: Array, v: Array) -> Array:
    """Return vectors of a body in the world frame.

    Args:
        poses: of the body: positions and quaternions (x, y, z, w), shape (frames, 7).
        v: the vectors in the body frame, shape (3,) or (frames, 3).

    Returns:
        Array: shape (frames, 3).
    """
    u, w = poses[:, 3:6], poses[:, 6:7]
    across = 2 * np.cross(u, v)
    out: Array = v + w * across + np.cross(u, across)
    return out


def placed(poses: Array, p: Array) -> Array:
    """Return points of a body in the world frame [m]; shapes as for `turned`."""
    out: Array = poses[:, :3] + turned(poses, p)
    return out


def loop_joints(data: Data) -> set[str]:
    """Return the joints that close loops: in the order of the scene, those between connected bodies."""
    group: dict[str, str] = {}

    def root(body: str) -> str:
        while body in group:
            body = group[body]
        return body

    out = set()
    for name, joint in constraining_joints(data).items():
        a, b = (root(point(joint[side])[0]) for side in ("parent", "child"))
        if a == b:
            out.add(name)
        else:
            group[a] = b
    return out


def uniform_gravity(scene: Data) -> Sequence[float]:
    """Return the gravitational acceleration [m/s2] of a scene's data that is the same everywhere."""
    gravity = scene.get("gravity", (0.0, 0.0, 0.0))
    if isinstance(gravity, Mapping):
        gravity = gravity.get("uniform", (0.0, 0.0, 0.0))
    return tuple(gravity)


def upwards(gravity: Sequence[float]) -> Array:
    """Return the unit vector against gravity; z where there is none."""
    up = -np.array(gravity, float)
    out: Array = up / np.linalg.norm(up) if up.any() else np.array([0.0, 0.0, 1.0])
    return out


def view_axes(points: Array, gravity: Sequence[float]) -> tuple[Array, bool]:
    """Return the axes of a picture, and whether it shows a planar mechanism.

    Args:
        points: positions of the mechanism's points in the world frame, shape (points, 3) [m].
        gravity: acceleration in the world frame.

    Returns:
        tuple[Array, bool]: unit vectors in the world frame to the right, upwards and towards the viewer,
            shape (3, 3); a planar mechanism is seen in its plane, others obliquely from above.
    """
    up = upwards(gravity)
    right = np.eye(3)[1 if abs(up[0]) > 0.9 else 0]
    right = right - (right @ up) * up
    right /= np.linalg.norm(right)
    oblique = np.array(OBLIQUE) @ [right, np.cross(up, right), up]
    # The factor R has at most three rows, however many points there are.
    _, extent, V = np.linalg.svd(np.linalg.qr(points - points.mean(axis=0), mode="r"))
    extent = np.pad(extent, (0, 3 - len(extent)))
    is_flat = bool(extent[2] < FLAT * max(extent[0], 1e-300))
    is_flat = is_flat and bool(extent[1] > FLAT * extent[0])
    toward = V[2] if is_flat else oblique
    if is_flat and toward @ oblique < 0:
        toward = -toward
    toward = toward / np.linalg.norm(toward)
    if abs(up @ toward) > 0.99:
        up = np.array([0.0, 1.0, 0.0]) if abs(toward[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    up = up - (up @ toward) * toward
    up /= np.linalg.norm(up)
    return np.array([np.cross(up, toward), up, toward]), is_flat
