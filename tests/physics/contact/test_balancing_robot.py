# SPDX-License-Identifier: BSD-3-Clause
"""A robot that balances on two wheels, which are contacts: its linear model, and a controller for it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.linalg
from models.standing import G

import gelenk

# A body of mass M [kg] and moment PITCH [kg m2] about the direction of the axle, with its center L above the
# axle [m]; each of the two wheels has mass m, moment J about the axle and radius R.
M, PITCH, L = 6.0, 0.11, 0.22
m, J, R = 0.4, 0.002, 0.08


def robot(pitch: float = 0.0) -> dict[str, Any]:
    across = {"rotation": {"axis": [1, 0, 0], "angle": np.pi / 2}}
    tire = {"wheel": {"radius": R, "crown": 0.01}, **across, "surface": "rubber"}
    wheels = {
        f"wheel_{side}": {"mass": m, "inertia": [J / 2, J, J / 2], "shapes": {"tire": tire}} for side in "lr"
    }
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {"body": {"mass": M, "com": [0, 0, L], "inertia": [0.1, PITCH, 0.05]}, **wheels},
        "ground": {"shapes": {"road": {"plane": [0, 0, 1], "surface": "asphalt"}}},
        "joints": {
            "J": {
                "type": "free", "parent": "ground", "child": "body",
                "start": {"r": [0, 0, R], "Q": [0, np.sin(pitch / 2), 0, np.cos(pitch / 2)], "fixed": True},
            },
            **{
                f"axle_{side}": {
                    "type": "revolute", "axis": [0, 1, 0], "child": f"wheel_{side}",
                    "parent": {"body": "body", "position": [0, y, 0]},
                }
                for side, y in (("l", 0.15), ("r", -0.15))
            },
        },
        "motors": {f"motor_{side}": {"joint": f"axle_{side}"} for side in "lr"},
        "contacts": {"tire": {"between": ["rubber", "asphalt"], "friction": 0.8}},
    }  # fmt: skip


STATES = ["J.r[1]", "J.theta[2]", "J.theta[3]", "J.v[1]", "J.w[2]", "J.w[3]"]


def test_its_linear_model_is_that_of_a_wheeled_inverted_pendulum() -> None:
    """(M + 2 m + 2 J / R^2) x'' + M L p'' = t / R, M L x'' + (PITCH + M L^2) p'' = M g L p - t."""
    model = gelenk.linear.linear_model(robot(), states=STATES)
    mass = np.array([[M + 2 * m + 2 * J / R**2, M * L], [M * L, PITCH + M * L**2]])
    by_pitch = np.linalg.solve(mass, [0, M * G * L])
    by_torque = np.linalg.solve(mass, [1 / R, -1])
    A = np.zeros((6, 6))
    A[:3, 3:] = np.eye(3)
    A[3:5, 1] = by_pitch
    assert np.abs(model.A - A).max() <= 1e-9 * np.abs(A).max()
    assert np.abs(model.B[3:5] - by_torque[:, None]).max() <= 1e-9 * np.abs(by_torque).max()
    assert np.abs(model.B[5, 0] + model.B[5, 1]) <= 1e-9 * np.abs(model.B[5, 0])  # they turn it opposite ways
    assert model.residual_rates == ""


@pytest.mark.parametrize("turn", [0.0, 0.02])
def test_a_controller_made_from_it_has_its_poles_in_the_run(turn: float) -> None:
    """Small motions decay as the sampled closed loop of the linear model: what differs is of second order."""
    model = gelenk.linear.linear_model(robot(), states=STATES)
    motors = [model.inputs.index(f"motor_{side}.tau") for side in "lr"]
    B = model.B[:, motors]
    P = scipy.linalg.solve_continuous_are(model.A, B, np.diag([10, 10, 10, 1, 1, 1]), np.eye(2))
    K = B.T @ P
    assert np.linalg.eigvals(model.A - B @ K).real.max() < -0.5
    step, steps, pitch = 2e-3, 150, 1e-3
    held = scipy.linalg.expm(step * np.block([[model.A, B], [np.zeros((2, 8))]]))
    x = np.array([0, pitch, 0, 0, 0, 0])
    plant = gelenk.Simulation(robot(pitch))
    plant.initialize(0.0, 1e-10)
    deviation = 0.0
    for k in range(steps):
        Q = np.array([plant.output(f"J.Q[{i}]") for i in (1, 2, 3, 4)])
        theta = 2 * Q[:3] / Q[3]
        read = np.array([
            plant.output("J.r[1]"), theta[1], theta[2], plant.output("J.v[1]"), plant.output("J.w[2]"),
            plant.output("J.w[3]"),
        ])  # fmt: skip
        deviation = max(deviation, float(np.abs(read - x).max()))
        u = -K @ (read - [0, 0, turn * pitch, 0, 0, 0])
        for side, torque in zip("lr", u, strict=True):
            plant.set_input(f"motor_{side}.tau", float(torque))
        x = held[:6, :6] @ x + held[:6, 6:] @ (-K @ (x - [0, 0, turn * pitch, 0, 0, 0]))
        plant.step_to((k + 1) * step)
    assert np.abs(x).max() > 1e-5  # it still moves
    assert deviation <= 20 * pitch**2  # wrong friction, or wheels that slip, differ by parts of `pitch`


def test_it_is_the_same_without_reductions() -> None:
    scene = gelenk.load(robot())
    own, whole = (gelenk.linear.linear_model(of, states=STATES) for of in (scene, scene.without(["all"])))
    assert np.abs(own.A - whole.A).max() <= 1e-10 * np.abs(own.A).max()
    assert np.abs(own.B - whole.B).max() <= 1e-10 * np.abs(own.B).max()
