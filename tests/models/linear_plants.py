# SPDX-License-Identifier: BSD-3-Clause
"""Scenes with known linear models, and properties of linear models."""

from __future__ import annotations

import numpy as np
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

from gelenk.chart import mechanisms
from gelenk.linear import LinearModel
from models.differences import Array

# Furuta's pendulum: arm and rod [kg, m, kg m2], dampers [N m s/rad].
ARM_MOMENT, ARM, MASS, LENGTH, MOMENT = 0.012, 0.2, 0.15, 0.13, 9e-4
ARM_DAMPING, ROD_DAMPING = 2e-3, 1e-4


def furuta(rod_angle: float = 0.0) -> Scene:
    """An arm that rotates about z and carries at its tip a rod that rotates about
    the longitudinal axis of the arm, x.
    """
    return scene(
        {
            "arm": body(0.3, (0, 0, 0), (ARM_MOMENT / 2, ARM_MOMENT / 2, ARM_MOMENT)),
            "rod": body(MASS, (0, 0, LENGTH), (MOMENT, MOMENT, 0)),
        },
        {
            "pillar": joint(
                "revolute",
                frame("ground"),
                frame("arm"),
                axis=[0, 0, 1],
                damping=ARM_DAMPING,
                start={"phi": 0.0, "w": 0.0, "fixed": True},
            ),
            "tip": joint(
                "revolute",
                frame("arm", (ARM, 0, 0)),
                frame("rod"),
                axis=[1, 0, 0],
                damping=ROD_DAMPING,
                start={"phi": rod_angle, "w": 0.0, "fixed": True},
            ),
        },
        name="Furuta",
        gravity=[0, 0, -GRAVITY],
        motors={"drive": {"joint": "pillar"}},
    )


# A top with a fixed tip: kg, m, kg m2 about the tip, along and across its axis z.
TOP_MASS, TOP_REACH, ALONG, ACROSS = 0.6, 0.09, 8e-4, 6.2e-3


def top(spin: float, upright: bool = True) -> Scene:
    """A top on a spherical joint, its axis z vertical, with a spin in rad/s; torques on it are inputs."""
    across = ACROSS - TOP_MASS * TOP_REACH**2
    reach = TOP_REACH if upright else -TOP_REACH
    return scene(
        {"top": body(TOP_MASS, (0, 0, reach), (across, across, ALONG))},
        {
            "S": joint(
                "spherical",
                frame("ground"),
                frame("top"),
                start={"Q": [0, 0, 0, 1], "w": [0, 0, spin], "fixed": True},
            )
        },
        name="Top",
        gravity=[0, 0, -GRAVITY],
        forces={"push": {"type": "wrench", "body": "top", "frame": "body", "input": True}},
    )


def still_cart_pole(angle: float = 0.0) -> Scene:
    out = mechanisms.shipped("cart_pole")
    out["joints"]["hinge"]["start"]["phi"] = angle
    return out


def hidden_modes(model: LinearModel, by: str) -> list[complex]:
    """Eigenvalues that are uncontrollable (by "B") or unobservable (by "C").

    Popov-Belevitch-Hautus test: otherwise [A - s 1, B] has full rank at each eigenvalue s. Rates are scaled
    by 1 / 10 s, so that velocities and coordinates have similar magnitudes; rank is lost if the smallest
    singular value is below 1e-7 of the largest: modes that are controllable have 4e-3 and more in these
    tests.
    """
    n = len(model.states)
    scale = np.where(np.arange(n) < n // 2, 1.0, 10.0)
    A = model.A * scale / scale[:, None] / 10.0
    other = model.B / scale[:, None] if by == "B" else (model.C * scale).T
    A = A if by == "B" else A.T
    other = other / max(np.abs(other).max(), 1e-300)
    out = []
    for s in np.linalg.eigvals(A):
        size = np.linalg.svd(np.hstack([A - s * np.eye(n), other]), compute_uv=False)
        if size[-1] < 1e-7 * size[0]:
            out.append(complex(10 * s))
    return out


def mass_matrix_model(M: Array, K: Array, damping: Array, drive: Array) -> tuple[Array, Array]:
    """Return (A, B) of M q'' = -K q - damping q' + drive u."""
    n = len(M)
    zero, one = np.zeros((n, n)), np.eye(n)
    A = np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, damping)]])
    return A, np.vstack([np.zeros_like(drive), np.linalg.solve(M, drive)])
