# SPDX-License-Identifier: BSD-3-Clause
"""Inconsistent initial guesses in space, also for quaternions, against least squares over the pose."""

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
        # The balls in the frames of the legs: not on their axes, since the file's numbers have four digits.
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
def test_guesses_of_all_types_of_joints_are_met_by_least_squares(seed: int | None) -> None:
    """36 guesses, some of them for quaternions, for six degrees of freedom; several choices of cut joints."""
    source = shipped.shipped("stewart")
    stewart = Stewart(source)
    rng = np.random.default_rng(8)
    s, phi_a, phi_b = rng.uniform(-0.1, 0.1, (3, 6))
    guessed = Rotation.from_rotvec(rng.uniform(-0.2, 0.2, (6, 3)))
    weight_s, weight_base, weight_ball = rng.uniform(0.3, 3, (3, 6))
    for i, k in enumerate(LEGS):
        joints = source["joints"]
        joints[f"leg{k}"]["start"] = {"s": s[i], "weight": weight_s[i]}
        joints[f"base{k}"]["start"] = {"phi_a": phi_a[i], "phi_b": phi_b[i], "weight": weight_base[i]}
        joints[f"ball{k}"]["start"] = {"Q": guessed[i].as_quat(), "weight": {"Q": weight_ball[i]}}

    def residuals(pose: Array) -> Array:
        at_s, at_a, at_b, ball = stewart.at(pose)
        turns = np.sqrt(weight_ball)[:, None] * (guessed.inv() * ball).as_rotvec()
        bases = np.sqrt(weight_base) * np.array([at_a - phi_a, at_b - phi_b])
        return np.concatenate([np.sqrt(weight_s) * (at_s - s), bases.ravel(), turns.ravel()])

    truth = least_squares(residuals, stewart.reference, jac="3-point", xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    assert np.abs(residuals(truth)).max() > 0.1
    if seed is not None:
        source = reordered(source, seed) | {"solver": {"reductions": {"cut_choice": False}}}
    plant = gelenk.Simulation(source)
    plant.initialize()
    found = [plant.output(f"leg{k}.s") for k in LEGS]
    # Third-order differences of the reference leave its gradient to 1e-10.
    assert np.abs(found - stewart.at(truth)[0]).max() < 1e-8
    assert np.abs([plant.output(f"pose.r[{i}]") for i in (1, 2, 3)] - truth[:3]).max() < 1e-8
