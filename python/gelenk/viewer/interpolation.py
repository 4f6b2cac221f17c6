# SPDX-License-Identifier: BSD-3-Clause
"""Poses between frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

SMALL = 1e-6  # rad; the chord of a smaller rotation is its arc


def interpolated(a: Array, b: Array, share: float | Array) -> Array:
    """Return poses between two, on straight lines and the shortest rotations.

    Args:
        a: positions and quaternions (x, y, z, w), shape (poses, 7).
        b: others of the same bodies, shape (poses, 7).
        share: of the way from a to b; shape (poses, 1) if it differs.
    """
    out: Array = a + share * (b - a)
    p, q = a[:, 3:], b[:, 3:]
    cosine = np.einsum("ij,ij->i", p, q)[:, None]
    angle = np.arccos(np.abs(cosine).clip(0, 1))
    near = angle < SMALL
    sine = np.where(near, 1.0, np.sin(angle))
    first = np.where(near, 1 - share, np.sin((1 - share) * angle) / sine)
    second = np.where(near, share, np.sin(share * angle) / sine)
    out[:, 3:] = first * p + second * np.where(cosine < 0, -q, q)
    out[:, 3:] /= np.linalg.norm(out[:, 3:], axis=1, keepdims=True)
    return out


def resampled(time: Array, poses: Array, at: Array) -> Array:
    """Return the poses of bodies at other times; before the first frame and after the last they rest.

    Args:
        time: of the frames [s], shape (frames,).
        poses: shape (frames, bodies, 7).
        at: shape (times,) [s].

    Returns:
        Array: shape (times, bodies, 7).
    """
    bodies = poses.shape[1]
    if len(time) == 1 or not bodies:
        return np.repeat(poses[:1], len(at), axis=0)
    k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    share = np.clip((at - time[k]) / (time[k + 1] - time[k]), 0, 1)
    a, b = (poses[n].reshape(-1, 7) for n in (k, k + 1))
    return interpolated(a, b, np.repeat(share, bodies)[:, None]).reshape(-1, bodies, 7)
