# SPDX-License-Identifier: BSD-3-Clause
"""Random trees of bodies connected by massless rods:
rods as distance constraints and as bodies give the same motion.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import (
    Array,
    Scene,
    body,
    frame,
    frame_sensor,
    general_body,
    joint,
    numbers,
    placed,
    reordered,
    rotation,
    scene,
)
from models.rods import sizes
from models.running import assert_close, run

SEEDS = range(16)
TIMES = np.linspace(0, 0.5, 6)
Z = np.array([0.0, 0.0, 1.0])
# Types of joints between bodies: axes, and start values in motion.
IN_SPACE: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "revolute": ({"axis": [0, 0, 1]}, {"phi": 0, "w": 1.5}),
    "prismatic": ({"axis": [0, 0, 1]}, {"s": 0, "v": 0.3}),
    "cylindrical": ({"axis": [0, 0, 1]}, {"s": 0, "phi": 0, "v": 0.1, "w": 1.0}),
    "universal": ({"axes": [[1, 0, 0], [0, 1, 0]]}, {"phi_a": 0, "phi_b": 0, "w_a": 1.0, "w_b": 0.5}),
    "spherical": ({}, {"Q": [0, 0, 0, 1], "w": [0.3, 0.2, -0.4]}),
}
IN_PLANE: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "revolute": ({"axis": [0, 0, 1]}, {"phi": 0, "w": 3.0}),
    "prismatic": ({"axis": [1, 0, 0]}, {"s": 0, "v": 0.3}),
    "planar": ({"axis": [0, 0, 1]}, {"s_x": 0, "s_y": 0, "phi": 0, "v_x": 0.1, "v_y": 0.1, "w": 1.0}),
}


class Builder:
    """Builds a mechanism in its reference position, where all coordinates are zero."""

    def __init__(self, seed: int, planar: bool) -> None:
        self.rng = np.random.default_rng(seed)
        self.planar = planar
        self.bodies: dict[str, Any] = {}
        self.joints: dict[str, Any] = {}
        self.sensors: dict[str, Any] = {"E": {"type": "energy"}}
        self.poses: dict[str, tuple[Array, Array]] = {"ground": (np.eye(3), np.zeros(3))}

    def random_rotation(self) -> Array:
        """A random orientation; in the plane, z is kept or reversed."""
        angle = self.rng.uniform(-3, 3)
        if not self.planar:
            return rotation(self.rng.normal(size=3), angle)
        return rotation(Z, angle) @ np.diag([1, *([self.rng.choice([-1, 1])] * 2)])

    def random_perpendicular(self, a: Array) -> Array:
        """A random unit vector perpendicular to a."""
        out = np.cross(a, self.rng.normal(size=3))
        return out / np.linalg.norm(out)

    def add_joint(self, name: str, kind: str, halves: list[dict[str, Any]], **fields: Any) -> None:
        if self.rng.random() < 0.5:
            halves.reverse()
        self.joints[name] = joint(kind, *halves, **fields)

    def add_body(self, i: int) -> None:
        kinds = IN_PLANE if self.planar else IN_SPACE
        kind = str(self.rng.choice(list(kinds)))
        axes, start = kinds[kind]
        parent = str(self.rng.choice(list(self.poses)))
        R_parent, p_parent = self.poses[parent]
        p_F, p_M = self.rng.uniform(-0.6, 0.6, (2, 3))
        R = rotation(Z, self.rng.uniform(-3, 3)) if self.planar else self.random_rotation()
        self.poses[f"b{i}"] = R, p_parent + R_parent @ p_F - R @ p_M
        J = self.rng.normal(size=(3, 3))
        inertia = np.trace(J @ J.T) * np.eye(3) - J @ J.T + np.eye(3)
        self.bodies[f"b{i}"] = general_body(
            self.rng.uniform(0.5, 2), self.rng.uniform(-0.2, 0.2, 3), 0.02 * inertia
        )
        R_F = self.random_rotation()
        self.add_joint(
            f"J{i}",
            kind,
            [frame(parent, p_F, R_parent.T @ R_F), frame(f"b{i}", p_M, R.T @ R_F)],
            **axes,
            start=start,
        )

    def add_rod(self, i: int, ends: tuple[str, str]) -> None:
        """Add a rod from an arbitrary point of one body to one of another."""
        name = f"rod{i}"
        points = self.rng.uniform(-0.5, 0.5, (2, 3))
        placed_ends = [self.poses[end] for end in ends]
        a, b = (p + R @ point for (R, p), point in zip(placed_ends, points, strict=True))
        R = rotation(Z, self.rng.uniform(-3, 3)) if self.planar else self.random_rotation()
        origin = self.rng.uniform(-0.3, 0.3, 3)
        self.bodies[name] = body(0)
        self.sensors[f"F{i}"] = frame_sensor(name, (0.1, 0.2, 0.3), rotation([1, 2, 3], 0.4))
        kinds = ["revolute"] * 2 if self.planar else ["universal", "spherical"]
        on_rod = [origin, origin + R.T @ (b - a)]
        for k, kind in enumerate(kinds):
            R_F = self.random_rotation()
            neighbor = frame(ends[k], points[k], placed_ends[k][0].T @ R_F)
            fields = {"axis": [0, 0, 1]} if self.planar else {}
            self.add_joint(f"{'US'[k]}{i}", kind, [neighbor, frame(name, on_rod[k], R.T @ R_F)], **fields)
            if kind == "universal":
                self.point_axes(self.joints[f"U{i}"], name, R_F, (b - a) / np.linalg.norm(b - a))

    def point_axes(self, universal: dict[str, Any], rod: str, R_F: Array, along: Array) -> None:
        """Point the axis on the rod perpendicular to it, and the other axis perpendicular to that one."""
        on_rod = self.random_perpendicular(along)
        axes = [R_F.T @ self.random_perpendicular(on_rod), R_F.T @ on_rod]
        if universal["parent"]["body"] == rod:
            axes.reverse()
        universal["axes"] = [numbers(a) for a in axes]

    def scene(self) -> Scene:
        n = int(self.rng.integers(2, 5))
        for i in range(n):
            self.add_body(i)
        # Rods connected in series, so that each can be in a tree and carry another body there.
        chain = self.rng.permutation(list(self.poses))[: int(self.rng.integers(2, 4))]
        for i in range(len(chain) - 1):
            self.add_rod(i, (str(chain[i]), str(chain[i + 1])))
        gravity = [2.0, -9.0, 0.0] if self.planar else [0.3, -1.0, -9.81]
        return scene(self.bodies, self.joints, gravity=gravity, sensors=self.sensors)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("planar", [True, False], ids=["planar", "spatial"])
def test_random_rods_as_constraints_move_like_bodies(planar: bool, seed: int) -> None:
    """Compares all outputs, to 1e-9 of the largest value of their unit;
    the reduction never adds velocities or constraint equations.
    """
    source = reordered(Builder(seed, planar).scene(), seed)
    if planar:
        source = placed(source, rotation([0.3, -0.7, 0.5], 1.3), (1, 2, 3))
    rows = run(source, TIMES, tolerance=1e-12)
    bodies = run(source, TIMES, tolerance=1e-12, reductions={"massless": False})
    largest: dict[str, float] = {}
    for name, unit in rows.units.items():
        largest[unit] = max(largest.get(unit, 1.0), float(np.abs(bodies[name]).max()))
    for name, unit in rows.units.items():
        assert_close(name, rows[name], bodies[name], 1e-9 * largest[unit], "1000 rtol, 0.5 s")
    small, large = sizes(source), sizes(source, massless=False)
    assert small[0] <= large[0]
    assert small[1] <= large[1]
    assert small[2] == large[2]


@pytest.mark.parametrize("planar", [True, False], ids=["planar", "spatial"])
def test_most_random_rods_become_constraints(planar: bool) -> None:
    """Verifies that the test above is meaningful: most rods do not remain bodies."""
    fewer = 0
    for seed in SEEDS:
        source = Builder(seed, planar).scene()
        fewer += sizes(source)[0] < sizes(source, massless=False)[0]
    assert fewer > len(SEEDS) / 3
