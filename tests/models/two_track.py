# SPDX-License-Identifier: BSD-3-Clause
"""A car in the plane after TwoTrackWithDifferentialGear of PlanarMechanics (D. Zimmer).

A frame, whose rear wheels a torque drives through a differential, and two front bodies on vertical axes,
which are steered alike by a pulsating torque and trail behind their axes. Wheels slip by a law of the speed
of slip, with a peak and a lower level beyond: the Magic Formula, in place of PlanarMechanics' "triple S".
"""

from __future__ import annotations

from itertools import pairwise
from math import pi, tan
from typing import Any

import numpy as np
from mechanisms import Array
from scipy.integrate import solve_ivp

FRAME, FRAME_MOMENT, FRONT, FRONT_MOMENT = 300.0, 0.1, 100.0, 1.0  # kg, kg m2
LENGTH, HALF_TRACK, TRAIL, RADIUS = 2.0, 0.75, 0.05, 0.25  # m
SPIN, DIAMETRAL = 1.0, 0.5  # kg m2
STEERING, TORQUE, PULSE = 0.43633231299858, 25.0, 2.0  # rad, N m, N m
ADHESION, MU, SLIDING = 0.1, 1.0, 0.7  # m/s at the peak; its coefficient, and that at large slip
SHAPE = 2 - 2 / pi * np.arcsin(SLIDING / MU)
# Slip refers to a mean of the speed and `standstill`: with a large one, forces follow the speed of slip.
STANDSTILL = 1e4  # m/s
STIFFNESS = MU * SHAPE * tan(pi / (2 * SHAPE)) * STANDSTILL / 2 / ADHESION
# Of the wheels: x, y in the frame [m] (of the steering axes in front), load [N].
WHEELS = {
    "front_left": (LENGTH, HALF_TRACK, 1000.0),
    "front_right": (LENGTH, -HALF_TRACK, 1000.0),
    "rear_left": (0.0, HALF_TRACK, 1500.0),
    "rear_right": (0.0, -HALF_TRACK, 1500.0),
}


def two_track() -> dict[str, Any]:
    """Return the scene; inputs engine.tau and steer.tau."""
    law = {
        "type": "tire", "radius": RADIUS, "standstill": STANDSTILL,
        "slip_stiffness": STIFFNESS, "cornering_stiffness": STIFFNESS,
        "friction_long": MU, "friction_lat": MU, "shape_long": SHAPE, "shape_lat": SHAPE,
    }  # fmt: skip
    bodies: dict[str, Any] = {
        "frame": {"mass": FRAME, "inertia": [FRAME_MOMENT] * 3},
        "cage": {"mass": 0},
    }
    start = {"s_x": 0, "s_y": 0, "phi": 0, "v_x": 0, "v_y": 0, "w": 0, "fixed": True}
    joints: dict[str, Any] = {
        "ride": {
            "type": "planar", "parent": {"body": "ground", "position": [0, 0, RADIUS]}, "child": "frame",
            "start": start,
        },
        "bearing": {"type": "revolute", "axis": [0, 1, 0], "parent": "frame", "child": "cage"},
    }  # fmt: skip
    forces: dict[str, Any] = {}
    for name, (x, y, load) in WHEELS.items():
        parent: dict[str, Any] = {"body": "frame", "position": [x, y, 0]}
        if name.startswith("front"):
            bodies[f"{name}_fork"] = {"mass": FRONT, "com": [-TRAIL, 0, 0], "inertia": [FRONT_MOMENT] * 3}
            joints[f"{name}_axis"] = {
                "type": "revolute", "axis": [0, 0, 1], "parent": parent, "child": f"{name}_fork",
                "start": {"phi": STEERING, "w": 0, "fixed": True},
            }  # fmt: skip
            parent = {"body": f"{name}_fork", "position": [-TRAIL, 0, 0]}
        bodies[name] = {"mass": 0, "inertia": [DIAMETRAL, SPIN, DIAMETRAL]}
        joints[f"{name}_hub"] = {
            "type": "revolute", "axis": [0, 1, 0], "parent": parent, "child": name,
            "start": {"phi": 0, "w": 0, "fixed": True},
        }  # fmt: skip
        forces[name] = {**law, "body": name, "load": load}
    return {
        "gelenk": 1,
        "name": "TwoTrack",
        "bodies": bodies,
        "joints": joints,
        "forces": forces,
        "motors": {"engine": {"joint": "bearing"}, "steer": {"joint": "front_left_axis"}},
        "constraints": {
            "steering": {"type": "gear", "joint": "front_right_axis", "with": "front_left_axis", "ratio": 1},
            "differential": {
                "type": "gear", "joint": "rear_left_hub", "with": "rear_right_hub", "carrier": "bearing",
                "ratio": -1,
            },
        },
    }  # fmt: skip


def turn(v: Array) -> Array:
    return np.array([-v[1], v[0]])


def at_angle(phi: float, x: float, y: float) -> Array:
    c, s = np.cos(phi), np.sin(phi)
    return np.array([c * x - s * y, s * x + c * y])


def slip_force(along: float, sliding: Array, load: float) -> Array:
    """Return the force opposite to a sliding velocity; along: the speed of the wheel's center [m/s]."""
    reference = (STANDSTILL + along**2 / STANDSTILL) / 2
    size = float(np.hypot(*sliding))
    if size == 0:
        return np.zeros(2)
    e = STIFFNESS * size / reference / MU
    out: Array = -load * MU * np.sin(SHAPE * np.arctan(e / SHAPE)) * sliding / size
    return out


def rates(y: Array, steer: float) -> Array:
    """Newton-Euler in the plane. y: x, y, heading, steering angle, their rates, spins of WHEELS.

    A massless cage divides its torque evenly.
    """
    (phi, delta), v, (w, w_delta), spins = y[2:4], y[4:6], y[6:8], y[8:]
    M, force = np.zeros((4, 4)), np.zeros(4)
    M[:2, :2] = FRAME * np.eye(2)
    M[2, 2] = FRAME_MOMENT
    force[3] = steer
    spin_rates = []
    for (name, (x, side, load)), spin in zip(WHEELS.items(), spins, strict=True):
        is_front = name.startswith("front")
        arm = at_angle(phi, x, side)
        trail = at_angle(phi + delta, -TRAIL, 0) if is_front else np.zeros(2)
        J = np.column_stack([np.eye(2), turn(arm + trail), turn(trail)])
        about = np.array([0, 0, 1.0, float(is_front)])
        mass, moment = (FRONT, FRONT_MOMENT + DIAMETRAL) if is_front else (0.0, DIAMETRAL)
        M += mass * J.T @ J + moment * np.outer(about, about)
        force += mass * J.T @ (w**2 * arm + (w + w_delta) ** 2 * trail)
        heading = at_angle(phi + delta * is_front, 1, 0)
        velocity = J @ np.array([*v, w, w_delta])
        along = float(heading @ velocity)
        f = slip_force(along, velocity - RADIUS * spin * heading, load)
        force += J.T @ f
        drive = 0.0 if is_front else TORQUE / 2
        spin_rates.append((drive - RADIUS * float(heading @ f)) / SPIN)
    return np.concatenate([y[4:8], np.linalg.solve(M, force), spin_rates])


def pulse(t: float) -> float:
    """Return the steering torque: 30 % of every 2 s, from 1 s on."""
    return PULSE if t >= 1 and (t - 1) % 2 < 0.6 - 1e-9 else 0.0


def solved(times: Array) -> Array:
    """Return the states at times that contain all jumps of the pulse, one row each."""
    y = np.zeros(12)
    y[3] = STEERING
    rows = [y]
    for t, end in pairwise(times):
        run = solve_ivp(
            lambda _, y, steer: rates(y, steer), (t, end), rows[-1], args=(pulse(t + 1e-6),), method="LSODA",
            rtol=1e-10, atol=1e-11,
        )  # fmt: skip
        assert run.success, run.message
        rows.append(run.y[:, -1])
    return np.array(rows)
