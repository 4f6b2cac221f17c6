# SPDX-License-Identifier: BSD-3-Clause
"""Drag forces and torques compared with closed-form solutions."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

import gelenk

MASS = 0.7  # kg


def falling_ball(**drag: float) -> Scene:
    return scene(
        {"ball": body(MASS, (0, 0, 0), (0.01, 0.01, 0.01))},
        {"F": joint("free", frame("ground"), frame("ball"))},
        gravity=[0, 0, -GRAVITY],
        forces={"air": {"type": "drag", "body": "ball", **drag}},
        experiment={"stop": 3, "step": 0.1, "tolerance": 1e-11},
    )


def test_falling_ball_approaches_terminal_velocity() -> None:
    """From rest, m v' = m g - k v^2: v = V tanh(g t/V), V^2 = m g/k, after V^2/g log cosh(g t/V)."""
    k = 0.05
    run = gelenk.simulate(falling_ball(coefficient=k))
    V = np.sqrt(MASS * GRAVITY / k)
    np.testing.assert_allclose(
        run["F.v[3]"], -V * np.tanh(GRAVITY * run.time / V), atol=1e-10
    )  # 10 x tolerance
    fall = V**2 / GRAVITY * np.log(np.cosh(GRAVITY * run.time / V))
    np.testing.assert_allclose(run["F.r[3]"], -fall, atol=1e-9)


def test_linear_drag_gives_exponential_decay() -> None:
    """With linear drag m v' = -c v: v = v_0 exp(-c t/m), along a direction oblique to all axes."""
    c = 0.4
    v_0 = np.array([1.0, -2.0, 0.5])
    source = falling_ball(damping=c)
    source["gravity"] = [0, 0, 0]
    source["joints"]["F"]["start"] = {"v": v_0.tolist(), "fixed": True}
    run = gelenk.simulate(source)
    for i in range(3):
        np.testing.assert_allclose(run[f"F.v[{i + 1}]"], v_0[i] * np.exp(-c * run.time / MASS), atol=1e-10)


def test_drag_with_an_offset_exerts_a_torque() -> None:
    """Applied at the offset a from the center of mass,
    the force exerts the torque a x f, exactly at the start.
    """
    source = falling_ball(coefficient=0.3)
    source["forces"]["air"]["position"] = [0, 0.2, 0]
    source["joints"]["F"]["start"] = {"v": [2.0, 0, 0], "fixed": True}
    plant = gelenk.Simulation(source)
    plant.initialize()
    assert plant.output("F.a[1]") == pytest.approx(-0.3 * 4 / MASS, rel=1e-12)
    assert plant.output("F.z[3]") == pytest.approx(0.2 * 0.3 * 4 / 0.01, rel=1e-12)


def test_drag_torque_slows_a_wheel() -> None:
    """I w' = -c w - k w^2: w = c w_0 e / (c + k w_0 (1 - e)), e = exp(-c t / I)."""
    c, k, moment, w_0 = 0.3, 0.02, 0.4, 12.0
    source = scene(
        {"wheel": body(1.0, (0, 0, 0), (0.2, 0.2, moment))},
        {
            "A": joint(
                "revolute", frame("ground"), frame("wheel"), axis=[0, 0, 1], start={"w": w_0, "fixed": True}
            )
        },
        gravity=[0, 0, 0],
        forces={"oil": {"type": "moment", "body": "wheel", "damping": c, "coefficient": k}},
        experiment={"stop": 3, "step": 0.1, "tolerance": 1e-11},
    )
    run = gelenk.simulate(source)
    e = np.exp(-c * run.time / moment)
    np.testing.assert_allclose(
        run["A.w"], c * w_0 * e / (c + k * w_0 * (1 - e)), atol=1e-9
    )  # 10 x tolerance x w_0
