# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms with locks that an input engages, and what the plastic impact leaves of their motions."""

from __future__ import annotations

from typing import Any

import numpy as np
from mechanisms import Array, Scene, body, frame, frame_sensor, joint, rotation, scene

import gelenk

LOCK = {"input": "engagement"}
ENGAGEMENT = "port.lock.engagement"

STATION, CAPSULE = (2.0, (0.3, 0.4, 0.5)), (3.0, (0.6, 0.5, 0.7))  # kg, kg m2
PORT, HATCH = (0.5, 0.1, 0.0), (-0.4, 0.0, 0.2)  # m, on either body
TURN = rotation((0.3, -0.5, 0.8), 0.9)  # of the hatch on the capsule


def docking(lock: dict[str, Any] | None = None, kind: str = "free", **fields: Any) -> Scene:
    """Two bodies drift and spin in space; the joint `port` between them may be locked.

    Args:
        lock: the lock of the joint `port`.
        kind: type of the joint `port`.
        fields: other fields of the scene.
    """
    start: dict[str, Any] = {"w": [-0.2, 0.9, 0.4], "rotation": {"axis": [1, 2, -1], "angle": 0.4}}
    if kind == "free":
        start |= {"r": [0.6, 0.1, -0.2], "v": [-0.3, 0.5, 0.2]}
    port: dict[str, Any] = {"start": start} if kind != "weld" else {}
    return scene(
        {"station": body(STATION[0], inertia=STATION[1]), "capsule": body(CAPSULE[0], inertia=CAPSULE[1])},
        {
            "orbit": joint(
                "free",
                frame("ground"),
                frame("station"),
                start={"r": [0.1, 0.2, 0.3], "v": [0.4, -0.2, 0.1], "w": [0.5, 0.3, -0.7], "fixed": True},
            ),
            "port": joint(
                kind,
                frame("station", PORT),
                frame("capsule", HATCH, TURN),
                **port,
                **({"lock": lock} if lock is not None else {}),
            ),
        },
        gravity=[0, 0, 0],
        sensors={
            "station": frame_sensor("station"),
            "capsule": frame_sensor("capsule"),
            "transmitted": {"type": "reaction", "joint": "port"},
        },
        **fields,
    )


def vector(simulation: gelenk.Simulation, name: str, size: int = 3) -> Array:
    return np.array([simulation.output(f"{name}[{i + 1}]") for i in range(size)])


def matrix_of(Q: Array) -> Array:
    """The matrix of a unit quaternion x, y, z, w."""
    x, y, z, w = Q
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R: Array = np.eye(3) + 2 * w * K + 2 * K @ K
    return R


def momentum(simulation: gelenk.Simulation) -> tuple[Array, Array, float]:
    """Linear and angular momentum about the world's origin, and kinetic energy, of both bodies."""
    P, H, T = np.zeros(3), np.zeros(3), 0.0
    for name, (mass, moments) in {"station": STATION, "capsule": CAPSULE}.items():
        r, v, w = (vector(simulation, f"{name}.{k}") for k in "rvw")  # w along the body's axes
        spin = np.array(moments) * w
        P += mass * v
        H += mass * np.cross(r, v) + matrix_of(vector(simulation, f"{name}.Q", 4)) @ spin
        T += float(mass * v @ v + w @ spin) / 2
    return P, H, T


def stuck_together(simulation: gelenk.Simulation) -> float:
    """The kinetic energy that both bodies would have as one, with their momentum at present."""
    P, H, _ = momentum(simulation)
    mass = STATION[0] + CAPSULE[0]
    center = (
        STATION[0] * vector(simulation, "station.r") + CAPSULE[0] * vector(simulation, "capsule.r")
    ) / mass
    inertia = np.zeros((3, 3))
    for name, (own, moments) in {"station": STATION, "capsule": CAPSULE}.items():
        R = matrix_of(vector(simulation, f"{name}.Q", 4))
        d = vector(simulation, f"{name}.r") - center
        inertia += R @ np.diag(moments) @ R.T + own * (d @ d * np.eye(3) - np.outer(d, d))
    spin = H - np.cross(center, P)
    return float(P @ P / mass + spin @ np.linalg.solve(inertia, spin)) / 2


def started(
    source: Scene, integrator: str = "auto", tolerance: float = 1e-10, **solver: Any
) -> gelenk.Simulation:
    simulation = gelenk.Simulation({**source, "solver": {"integrator": integrator, **solver}})
    simulation.initialize(0.0, tolerance)
    return simulation
