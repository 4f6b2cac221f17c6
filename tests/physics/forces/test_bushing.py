# SPDX-License-Identifier: BSD-3-Clause
"""Six-axis bushings: oscillations along and about each axis, energy at large angles,
planar and spatial algebra.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array, Scene, body, frame, joint, matrix, scene
from scipy.spatial.transform import Rotation

import gelenk

MASS, MOMENTS = 1.3, (0.02, 0.03, 0.04)
K, K_R = (200.0, 300.0, 500.0), (2.0, 3.0, 5.0)
C, C_R = (2.0, 1.0, 4.0), (0.02, 0.05, 0.01)


def hung(start: dict[str, Any], **bushing: Any) -> Scene:
    """A body connected to the ground only by the bushing."""
    return scene(
        {"b": body(MASS, (0, 0, 0), MOMENTS)},
        {"F": joint("free", frame("ground"), frame("b"), start={**start, "fixed": True})},
        gravity=[0, 0, 0],
        forces={"B": {"type": "bushing", "from": "ground", "to": "b", **bushing}},
        sensors={"E": {"type": "energy"}},
        experiment={"stop": 1, "step": 0.01, "tolerance": 1e-11},
    )


def damped_oscillation(m: float, c: float, k: float, x_0: float, t: Array) -> Array:
    s = np.sqrt(complex(c * c - 4 * m * k))
    a, b = (-c + s) / (2 * m), (-c - s) / (2 * m)
    return np.real((a * np.exp(b * t) - b * np.exp(a * t)) * x_0 / (a - b))


@pytest.mark.parametrize("i", range(3))
def test_each_axis_is_a_damped_oscillator(i: int) -> None:
    r = np.zeros(3)
    r[i] = 0.1
    run = gelenk.simulate(hung({"r": r.tolist()}, stiffness=K, damping=C))
    np.testing.assert_allclose(
        run[f"F.r[{i + 1}]"], damped_oscillation(MASS, C[i], K[i], 0.1, run.time), atol=1e-10
    )


@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("angle", [0.05, 1.0, 2.5])
def test_rotation_about_a_principal_axis_is_a_damped_oscillation_at_any_angle(i: int, angle: float) -> None:
    """I angle'' = -c angle' - k angle, because the rotation vector lies along the axis."""
    turn = np.zeros(3)
    turn[i] = angle
    start = {"rotation": matrix(Rotation.from_rotvec(turn).as_matrix())}
    run = gelenk.simulate(hung(start, rotational_stiffness=K_R, rotational_damping=C_R))
    Q = np.column_stack([run[f"F.Q[{k}]"] for k in range(1, 5)])
    found = Rotation.from_quat(Q).as_rotvec()[:, i]
    np.testing.assert_allclose(
        found, damped_oscillation(MOMENTS[i], C_R[i], K_R[i], angle, run.time), atol=1e-9
    )


def test_energy_is_conserved_for_large_rotations() -> None:
    """Three different stiffnesses, with combined rotation and displacement:
    the energy is that initially stored.
    """
    start = {
        "r": [0.2, -0.1, 0.3],
        "v": [1.0, 0.5, -0.4],
        "rotation": matrix(Rotation.from_rotvec([1.0, -1.2, 0.8]).as_matrix()),
        "w": [2.0, 1.0, -3.0],
    }
    run = gelenk.simulate(hung(start, stiffness=K, rotational_stiffness=K_R))
    np.testing.assert_allclose(run["E.total"], run["E.total"][0], rtol=1e-9)  # 100 x tolerance
    stored = sum(k * run[f"F.r[{i + 1}]"] ** 2 / 2 for i, k in enumerate(K))
    Q = np.column_stack([run[f"F.Q[{k}]"] for k in range(1, 5)])
    theta = Rotation.from_quat(Q).as_rotvec()
    stored += (np.array(K_R) * theta**2).sum(axis=1) / 2
    np.testing.assert_allclose(run["E.potential"], stored, rtol=1e-12)


@pytest.mark.parametrize("planar", [True, False])
def test_planar_mechanism_with_a_bushing_moves_as_in_space(planar: bool) -> None:
    """Two links in an oblique plane; a bushing with oblique frames between them and the ground."""
    R = Rotation.from_rotvec([0.3, -0.4, 0.5])
    askew = Rotation.from_euler("xyz", [0.2, 0.1, -0.3]).as_matrix()
    source = scene(
        {"a": body(1.0, (0.2, 0, 0), (0.01, 0.02, 0.02)), "b": body(0.5, (0.1, 0, 0), (0.01, 0.01, 0.01))},
        {
            "A": joint("revolute", frame("ground", R=R.as_matrix()), frame("a"), axis=[0, 0, 1],
                       start={"phi": 0.4, "w": 1.0, "fixed": True}),
            "B": joint("revolute", frame("a", (0.4, 0, 0)), frame("b"), axis=[0, 0, 1], start={"phi": -0.9}),
        },
        gravity=[0, 0, -9.81],
        forces={"X": {"type": "bushing", "from": frame("ground", (0.2, 0.1, 0.1)),
                      "to": frame("b", (0.1, 0.05, 0.02), askew),
                      "stiffness": K, "damping": C, "rotational_stiffness": K_R, "rotational_damping": C_R}},
        experiment={"stop": 0.5, "step": 0.05, "tolerance": 1e-10},
        solver={"reductions": {"planar": planar}},
    )  # fmt: skip
    other = {**source, "solver": {"reductions": {"all": False}}}
    one, two = gelenk.simulate(source), gelenk.simulate(other)
    for name in ("A.phi", "B.phi", "A.w", "B.w"):
        np.testing.assert_allclose(one[name], two[name], atol=1e-8)  # 100 x tolerance
