# SPDX-License-Identifier: BSD-3-Clause
"""Drag forces and torques compared with closed-form solutions and a published
mechanism with mast, arm and disc.
"""

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


# J. Ros, Introduction to Multibody System Dynamics (UPNA 2020), problem 2: a slider on a mast, an arm that
# hangs from it, a disc that slides along and turns about the arm and rolls on the ground; a torque -c w on
# the disc. Steel of 7850 kg/m3.
SLIDER, ARM, DISC = 47.350084474905366, 215.78814539344893, 153.57950576430892  # kg
SLIDER_MOMENTS = (
    0.5161159207764685,
    0.5161159207764685,
    0.32198057442935646,
)  # kg m2, in the axes of its frame
ARM_MOMENTS = (0.26973518174181116, 220.41859934668335, 220.41859934668335)
DISC_MOMENTS = (19.266548998132556, 9.641273431658169, 9.641273431658169)
START = (0.5235987755982988, 1.4830127018922192, 0.5235987755982988, 2.1, 0.5235987755982988)
SPEEDS = (2.5, 0.283207284377342, 0.11679271562265808, 0.2, 7.843266739736608)
# psi, h, theta, l, phi after 6 s for each coefficient c [N m s]: five coordinates with multipliers, DOP853 at
# 1e-13.
AFTER_6_S = {
    0.0: (
        15.275231571044845,
        0.483542816244126,
        -0.010508494666374504,
        1.5634855231721154,
        46.80399512013649,
    ),
    10.0: (12.288303527873085, 1.0511821927051725, 0.3224026250333311, 1.8208946505186998, 37.43308577013671),
}


def mast(c: float) -> Scene:
    psi, h, theta, travel, phi = START
    rates = dict(zip(("psi", "h", "theta", "l", "phi"), SPEEDS, strict=True))
    forces: Scene = {
        "spring": {"type": "spring_damper", "from": "ground", "to": "slider"}
        | {"stiffness": 900, "damping": 30, "length": 1},
    }
    if c:
        forces["rolling_drag"] = {"type": "moment", "body": "disc", "damping": c}
    mast_at = {"v": rates["h"], "s": h, "phi": psi, "w": rates["psi"], "fixed": True}
    on_arm = {"v": rates["l"], "s": travel, "phi": -phi, "w": -rates["phi"], "fixed": True}
    return scene(
        {
            "slider": body(SLIDER, (0, 0, 0), SLIDER_MOMENTS),
            "arm": body(ARM, (1.75, 0, 0), ARM_MOMENTS),
            "disc": body(DISC, (0, 0, 0), DISC_MOMENTS),
        },
        {
            "mast": joint("cylindrical", frame("ground"), frame("slider"), axis=[0, 0, 1], start=mast_at),
            "hinge": joint("revolute", frame("slider"), frame("arm"), axis=[0, 1, 0],
                           start={"phi": theta, "w": rates["theta"]}),
            "shaft": joint("cylindrical", frame("arm"), frame("disc"), axis=[1, 0, 0], start=on_arm),
        },
        gravity=[0, 0, -9.80665],
        forces=forces,
        constraints={"rolls": {"type": "rolling", "body": "disc", "axis": [1, 0, 0], "radius": 0.5}},
        experiment={"stop": 6, "step": 0.5, "tolerance": 1e-11},
    )  # fmt: skip


@pytest.mark.parametrize("c", AFTER_6_S)
def test_mast_arm_and_disc_match_published_problem(c: float) -> None:
    run = gelenk.simulate(mast(c))
    found = [run[name][-1] for name in ("mast.phi", "mast.s", "hinge.phi", "shaft.s", "shaft.phi")]
    expected = AFTER_6_S[c]
    signs = (1, 1, 1, 1, -1)
    for x, sign, value in zip(found, signs, expected, strict=True):
        assert sign * x == pytest.approx(value, abs=1e-9 * max(1.0, abs(value)))
