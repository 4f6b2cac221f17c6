# SPDX-License-Identifier: BSD-3-Clause
"""Reference: linkages built with compasses, pin by pin, from the distances between their pins."""

from __future__ import annotations

import math

import numpy as np
from mechanisms import Array, Numbers, rotation


def meet(A: Array, a: float, B: Array, b: float, side: int) -> Array:
    """Return the point of a plane at the distances a and b [m] from A and B; to the left of the way from A to
    B (side 1) or to the right (-1).
    """
    way = B - A
    d = math.hypot(*way)
    along = (d * d + a * a - b * b) / (2 * d)
    across = side * math.sqrt(a * a - along * along)
    out: Array = A + (along * way + across * np.array([-way[1], way[0]])) / d
    return out


def angle_to_distance(p: Array, at: Array, axis: Numbers, other: Array, distance: float) -> float:
    """Return the smallest rotation [rad] of p about an axis through `at` after which p has this distance [m]
    from another point: a cos x + b sin x = c.
    """
    n = np.asarray(axis, float) / np.linalg.norm(axis)
    arm, to_other = p - at, other - at
    along = (n @ arm) * n
    u, v = arm - along, np.cross(n, arm)
    a, b = u @ to_other, v @ to_other
    c = 0.5 * (arm @ arm + to_other @ to_other - distance**2) - along @ to_other
    middle, half = math.atan2(b, a), math.acos(c / math.hypot(a, b))
    return min((middle + half, middle - half), key=lambda x: abs(math.remainder(x, math.tau)))


def turned(p: Array, at: Array, axis: Numbers, angle: float) -> Array:
    """Return a point rotated about an axis through `at`."""
    out: Array = at + rotation(axis, angle) @ (p - at)
    return out
