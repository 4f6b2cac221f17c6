# SPDX-License-Identifier: BSD-3-Clause
"""Shapes, poses and support functions with which contact points are tested."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from mechanisms import Array
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

HULL = np.random.default_rng(8).normal(size=(30, 3)) * [0.3, 0.4, 0.2]
HULL = HULL[ConvexHull(HULL).vertices]
PRISM = np.array([[x, y, z] for x, y in [(-0.3, -0.2), (0.3, -0.2), (0, 0.4)] for z in (-0.25, 0.25)])
# Kind, dimensions, points.
SHAPES: dict[str, tuple[str, list[float], Array]] = {
    "sphere": ("sphere", [0.3], np.zeros((0, 3))),
    "capsule": ("capsule", [0.2, 0.5], np.zeros((0, 3))),
    "box": ("box", [0.4, 0.6, 0.3], np.zeros((0, 3))),
    "cylinder": ("cylinder", [0.25, 0.5], np.zeros((0, 3))),
    "hull": ("hull", [], HULL),
    "prism": ("hull", [], PRISM),
    "plane": ("plane", [], np.zeros((0, 3))),
}
PAIRS = [pair for pair in combinations_with_replacement(SHAPES, 2) if pair != ("plane", "plane")]


def made(units: Any, name: str, scale: float = 1.0) -> Any:
    kind, dimensions, points = SHAPES[name]
    return units.Shape(kind, [scale * x for x in dimensions], (scale * points).tolist())


def numbers(R: Array, p: Array) -> list[float]:
    return [*R.ravel().tolist(), *p.tolist()]


def random_poses(rng: np.random.Generator, n: int) -> Array:
    """Rows of two poses, a third of them nearly concentric, about half of the pairs overlapping."""
    out = np.zeros((n, 24))
    for k in (0, 12):
        out[:, k : k + 9] = Rotation.random(n, random_state=rng).as_matrix().reshape(n, 9)
        out[:, k + 9 : k + 12] = rng.normal(size=(n, 3)) * np.where(np.arange(n) % 3, 0.4, 0.02)[:, None]
    return out


def special_poses(rng: np.random.Generator, n: int) -> Array:
    """Parallel and perpendicular axes at distances at which the shapes touch, are nested or concentric.

    Half of them are turned in space, so that coordinates are rounded.
    """
    group = Rotation.create_group("O").as_matrix()
    distances = np.array([0, 0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.7, 0.75])
    out = np.zeros((n, 24))
    for k, row in enumerate(out):
        common = Rotation.random(random_state=rng).as_matrix() if k % 2 else np.eye(3)
        for i in (0, 12):
            row[i : i + 9] = (common @ group[rng.integers(24)]).ravel()
            row[i + 9 : i + 12] = common @ (rng.choice(distances, 3) * rng.choice([-0.5, 0.5, 1], 3))
        if k % 10 == 0:
            row[21:] = row[9:12]
    return out


Support = Callable[[Array], Array]


def support_function(name: str) -> Support:
    """The largest n . x of all points x of a bounded shape, for rows n."""
    kind, dimensions, points = SHAPES[name]

    def value(n: Array) -> Array:
        length = np.linalg.norm(n, axis=-1)
        across = np.hypot(n[..., 0], n[..., 1])
        along = np.abs(n[..., 2])
        of: dict[str, Callable[[], Any]] = {
            "sphere": lambda: dimensions[0] * length,
            "capsule": lambda: dimensions[1] / 2 * along + dimensions[0] * length,
            "box": lambda: np.abs(n) @ np.array(dimensions) / 2,
            "cylinder": lambda: dimensions[1] / 2 * along + dimensions[0] * across,
            "hull": lambda: (n @ points.T).max(axis=-1),
        }
        return np.asarray(of[kind]())

    return value


def separation(a: Support, b: Support, row: Array) -> Support:
    """The distance of two bodies along directions n from A to B; the largest one is their signed distance."""
    R_A, p_A, R_B, p_B = row[:9].reshape(3, 3), row[9:12], row[12:21].reshape(3, 3), row[21:]
    return lambda n: np.asarray(n @ (p_B - p_A) - a(n @ R_A) - b(-n @ R_B))
