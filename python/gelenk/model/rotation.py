# SPDX-License-Identifier: BSD-3-Clause
"""Rotations of quaternions with components in the order (x, y, z, scalar)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]


def rotated(Q: Array, theta: Array) -> Array:
    """Return Q o exp(theta / 2): the quaternion after a rotation about the frame's own axes.

    Args:
        Q: unit quaternion (x, y, z, scalar), shape (4,).
        theta: rotation vector [rad], shape (3,).
    """
    angle = float(np.linalg.norm(theta))
    v, s = 0.5 * np.sinc(angle / 2 / np.pi) * theta, np.cos(angle / 2)
    out: Array = np.append(Q[3] * v + s * Q[:3] + np.cross(Q[:3], v), Q[3] * s - Q[:3] @ v)
    return out


def small_rotation(Q: Array, dQ: Array, in_world: bool) -> Array:
    """Return the small rotation that corresponds to a change of a quaternion: 2 dQ o Q* or 2 Q* o dQ.

    Args:
        Q: unit quaternion (x, y, z, scalar), shape (4,).
        dQ: changes, shape (4, n).
        in_world: whether the rotation is expressed in the world frame, otherwise in the rotated frame.

    Returns:
        Array: rotation vectors [rad], shape (3, n).
    """
    v, scalar = Q[:3], Q[3]
    across = np.cross(v, dQ[:3], axisb=0).T
    out: Array = 2 * (scalar * dQ[:3] + (across if in_world else -across) - np.outer(v, dQ[3]))
    return out
