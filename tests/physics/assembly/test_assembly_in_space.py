# SPDX-License-Identifier: BSD-3-Clause
"""Wishes that contradict, in space and with quaternions: least squares over a platform's pose alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import reordered
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import gelenk
from gelenk.chart import mechanisms as shipped

LEGS = range(1, 7)
Array = NDArray[np.float64]


class Stewart:
    """Joint coordinates of the shipped platform as functions of its pose (x, y, z, rotation vector)."""

    def __init__(self, source: dict[str, Any]) -> None:
        joints = source["joints"]
        self.base = np.array([joints[f"base{k}"]["parent"]["position"] for k in LEGS])
        self.ball = np.array([joints[f"ball{k}"]["child"]["position"] for k in LEGS])
        frames = [joints[f"base{k}"]["parent"]["rotation"]["matrix"] for k in LEGS]
        self.frame = Rotation.from_matrix(np.array(frames))
        self.reference = np.array([0.0, 0.0, 1.1, 0.0, 0.0, 0.0])
        # The balls in the legs' frames: not on their axes, as the file's numbers have four digits.
        self.tip = self.frame.inv().apply(self.ball + self.reference[:3] - self.base)

    def at(self, pose: Array) -> tuple[Array, Array, Array, Rotation]:
        """Slides s, base angles phi_a (about x) and phi_b (about y), and the balls' rotations."""
        turn = Rotation.from_rotvec(pose[3:])
        leg = self.frame.inv().apply(pose[:3] + turn.apply(self.ball) - self.base)
        (x, y, z), (u, v, w) = leg.T, self.tip.T
        s = np.sqrt((leg**2).sum(axis=1) - u**2 - v**2) - w
        phi_b = np.arcsin(x / np.hypot(u, w + s)) - np.arctan2(u, w + s)
        depth = (w + s) * np.cos(phi_b) - u * np.sin(phi_b)
        phi_a = np.arctan2(z, y) - np.arctan2(depth, v)
        upper = self.frame * Rotation.from_euler("XY", np.column_stack([phi_a, phi_b]))
        return s, phi_a, phi_b, upper.inv() * turn * self.frame


@pytest.mark.parametrize("seed", [None, 1, 2])
def test_wishes_of_all_kinds_of_joints_are_met_by_least_squares(seed: int | None) -> None:
    """Thirty-six wishes for six freedoms, some of them at quaternions, wherever the loops are cut."""
    source = shipped.shipped("stewart")
    stewart = Stewart(source)
    rng = np.random.default_rng(8)
    s, phi_a, phi_b = rng.uniform(-0.1, 0.1, (3, 6))
    wished = Rotation.from_rotvec(rng.uniform(-0.2, 0.2, (6, 3)))
    of_s, of_base, of_ball = rng.uniform(0.3, 3, (3, 6))
    for i, k in enumerate(LEGS):
        joints = source["joints"]
        joints[f"leg{k}"]["start"] = {"s": s[i], "weight": of_s[i]}
        joints[f"base{k}"]["start"] = {"phi_a": phi_a[i], "phi_b": phi_b[i], "weight": of_base[i]}
        joints[f"ball{k}"]["start"] = {"Q": wished[i].as_quat(), "weight": {"Q": of_ball[i]}}

    def off(pose: Array) -> Array:
        at_s, at_a, at_b, ball = stewart.at(pose)
        turns = np.sqrt(of_ball)[:, None] * (wished.inv() * ball).as_rotvec()
        bases = np.sqrt(of_base) * np.array([at_a - phi_a, at_b - phi_b])
        return np.concatenate([np.sqrt(of_s) * (at_s - s), bases.ravel(), turns.ravel()])

    truth = least_squares(off, stewart.reference, jac="3-point", xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    assert np.abs(off(truth)).max() > 0.1
    if seed is not None:
        source = reordered(source, seed) | {"solver": {"reductions": {"cut_choice": False}}}
    plant = gelenk.Simulation(source)
    plant.initialize()
    found = [plant.output(f"leg{k}.s") for k in LEGS]
    # Third-order differences of the reference leave its gradient to 1e-10.
    assert np.abs(found - stewart.at(truth)[0]).max() < 1e-8
    assert np.abs([plant.output(f"pose.r[{i}]") for i in (1, 2, 3)] - truth[:3]).max() < 1e-8
