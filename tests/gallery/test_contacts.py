# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms of the gallery that touch things."""

from __future__ import annotations

from math import cos, pi

import pytest

import gelenk

from .entries import assert_stated, file, source


def test_gripper_presses_with_the_torque_over_the_length_of_its_arms() -> None:
    """Virtual work with vertical arms: 2 tau = 2 F L. Friction carries the weight m g."""
    torque = 0.8
    run = gelenk.simulate(file("gripper"), inputs={"grip1.tau": torque, "grip2.tau": torque})
    scene = source("gripper")
    arm = -scene["joints"]["tip1"]["parent"]["position"][2]
    weight = scene["bodies"]["box"]["mass"] * 9.81
    assert run["left.f[1]"][-1] == pytest.approx(torque / arm, rel=1e-8)
    assert run["right.f[1]"][-1] == pytest.approx(-torque / arm, rel=1e-8)
    # Means over the last step, which ends at 1.8 s, of m (g + a) with the palm at 0.05 (1 - cos(pi t)) m.
    acceleration = 0.05 * pi**2 * cos(pi * (1.8 - 0.5e-3))
    carried = run["left.f[3]"][-1] + run["right.f[3]"][-1]
    assert carried == pytest.approx(weight * (1 + acceleration / 9.81), rel=1e-6)
    assert_stated("gripper", torque / arm, "N")
    assert_stated("gripper", weight, "N")
    assert_stated("gripper", 1e3 * run["lift.s"].max(), "mm")
