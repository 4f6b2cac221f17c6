# SPDX-License-Identifier: BSD-3-Clause
"""Small turns of quaternions (x, y, z, scalar)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]


def turned(Q: Array, theta: Array) -> Array:
    """Q o exp(theta / 2): the quaternion (x, y, z, scalar) after a turn about the frame's own axes."""
    angle = float(np.linalg.norm(theta))
    v, s = 0.5 * np.sinc(angle / 2 / np.pi) * theta, np.cos(angle / 2)
    out: Array = np.append(Q[3] * v + s * Q[:3] + np.cross(Q[:3], v), Q[3] * s - Q[:3] @ v)
    return out


def small_turn(Q: Array, dQ: Array, in_world: bool) -> Array:
    """The small turn for dQ, along the world's axes or the frame's own: 2 dQ o Q*, or 2 Q* o dQ."""
    v, scalar = Q[:3], Q[3]
    across = np.cross(v, dQ[:3], axisb=0).T
    out: Array = 2 * (scalar * dQ[:3] + (across if in_world else -across) - np.outer(v, dQ[3]))
    return out
