# SPDX-License-Identifier: BSD-3-Clause
"""Tires: the Magic Formula by its coefficients, wheels on test rigs, the single-track model of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import Array

G = 9.81  # m/s2
LOAD, RADIUS = 3000.0, 0.32  # N, m
LONG, LAT = (18.0, 1.65, 1.1, 0.3), (9.0, 1.3, 0.95, -1.2)  # B, C, D/N, E


def magic(x: Any, B: float, C: float, D: float, E: float) -> Any:
    """Return Pacejka's formula (2012, eq. 4.6): the force per normal force at the slip x."""
    return D * np.sin(C * np.arctan(B * x - E * (B * x - np.arctan(B * x))))


def tire(**changes: Any) -> dict[str, Any]:
    """Return a tire of the Magic Formula with the coefficients LONG and LAT."""
    return {
        "type": "tire", "body": "wheel", "radius": RADIUS, "load": LOAD,
        "slip_stiffness": LONG[0] * LONG[1] * LONG[2], "cornering_stiffness": LAT[0] * LAT[1] * LAT[2],
        "friction_long": LONG[2], "shape_long": LONG[1], "curvature_long": LONG[3],
        "friction_lat": LAT[2], "shape_lat": LAT[1], "curvature_lat": LAT[3],
        **changes,
    }  # fmt: skip


def rig(velocity: tuple[float, float], spin: float, **changes: Any) -> dict[str, Any]:
    """Return a wheel, heading x, on a carriage with a velocity [m/s], and its spin [rad/s]."""
    moving = {"type": "planar", "parent": {"body": "ground", "position": [0, 0, RADIUS]}, "child": "carriage"}
    start = {"s_x": 0, "s_y": 0, "phi": 0, "v_x": velocity[0], "v_y": velocity[1], "w": 0, "fixed": True}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "carriage": {"mass": 1e6, "inertia": [1e6] * 3},
            "wheel": {"mass": 20, "inertia": [0.5, 1.0, 0.5]},
        },
        "joints": {
            "road": {**moving, "start": start},
            "hub": {
                "type": "revolute", "axis": [0, 1, 0], "parent": "carriage", "child": "wheel",
                "start": {"phi": 0, "w": spin, "fixed": True},
            },
        },
        "forces": {"tire": tire(**changes)},
    }  # fmt: skip


@dataclass(frozen=True)
class SingleTrack:
    """The linear single-track model (Riekert & Schunck 1940): kg, kg m2, m, N/rad per axle, m/s."""

    mass: float
    moment: float
    to_front: float
    to_rear: float
    front: float
    rear: float
    speed: float

    def matrices(self) -> tuple[Array, Array]:
        """Return A and B of the states lateral velocity and yaw rate, for the steering angle."""
        m, J, a, b, V = self.mass, self.moment, self.to_front, self.to_rear, self.speed
        turn = self.rear * b - self.front * a
        A = np.array(
            [
                [-(self.front + self.rear) / (m * V), turn / (m * V) - V],
                [turn / (J * V), -(self.front * a**2 + self.rear * b**2) / (J * V)],
            ]
        )
        return A, np.array([self.front / m, self.front * a / J])

    def understeer(self) -> float:
        """Return the gradient K of delta = L/R + K V^2/R [rad s2/m]."""
        L = self.to_front + self.to_rear
        return self.mass / L * (self.to_rear / self.front - self.to_front / self.rear)

    def yaw_gain(self) -> float:
        """Return the steady yaw rate per steering angle [1/s]."""
        return self.speed / (self.to_front + self.to_rear + self.understeer() * self.speed**2)

    def sideslip_gain(self) -> float:
        """Return the steady lateral velocity over the speed per steering angle."""
        L = self.to_front + self.to_rear
        inner = self.to_rear - self.mass * self.to_front * self.speed**2 / (self.rear * L)
        return self.yaw_gain() / self.speed * inner


def two_wheels(track: SingleTrack, steering: float = 0.0) -> dict[str, Any]:
    """Return a body on a plane with a tire in front, steered by an angle [rad], and one in the rear."""
    a, b = track.to_front, track.to_rear
    start = {"s_x": 0, "s_y": 0, "phi": 0, "v_x": track.speed, "v_y": 0, "w": 0, "fixed": True}
    # The wheels are part of the body, so that longitudinal slip has no meaning: its stiffness is 0.
    free = {"type": "tire", "radius": RADIUS, "load": LOAD, "slip_stiffness": 0.0}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "car": {"mass": track.mass, "inertia": [track.moment / 2, track.moment, track.moment]},
            "fork": {"mass": 0},
        },
        "joints": {
            "road": {
                "type": "planar", "parent": {"body": "ground", "position": [0, 0, RADIUS]}, "child": "car",
                "start": start,
            },
            "steer": {
                "type": "revolute", "axis": [0, 0, 1], "parent": {"body": "car", "position": [a, 0, 0]},
                "child": "fork", "start": {"phi": steering, "w": 0},
            },
        },
        "constraints": {"bars": {"type": "motion", "joint": "steer", "input": "position"}},
        "forces": {
            "front": {**free, "body": "fork", "cornering_stiffness": track.front / LOAD},
            "rear": {**free, "body": "car", "position": [-b, 0, 0], "cornering_stiffness": track.rear / LOAD},
        },
    }  # fmt: skip
