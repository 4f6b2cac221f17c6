# SPDX-License-Identifier: BSD-3-Clause
"""A wheel that slides, rolls and leaves a plane: equations of Newton and Euler from event to event.

The wheel of radius r has the radius of curvature k across its tread. With its axis a, the normal n = z and
s = |a x n|, its lowest point is at (r - k) d - k n from its center, d = ((n . a) a - n)/s. The force there
keeps the acceleration of this point along n at zero; it is N (n - mu u) while the point slides along u, and
keeps its whole acceleration at zero while it rolls. The equations are solved by DOP853 at 1e-12.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from mechanisms import Array
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

G = 9.81  # m/s2
UP = np.array([0.0, 0.0, 1.0])
# m/s: below it what slides rolls, and with it what rolled starts to slide. It changes positions by less than
# this times the duration of the run.
NO_SLIP = 1e-11


@dataclass(frozen=True)
class Wheel:
    """A wheel about its y axis: kg, moments about the axes of its body [kg m2], m."""

    mass: float
    moments: tuple[float, float, float]
    radius: float
    crown: float
    friction: float
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)  # from the center of mass, in the body

    def arm(self, R: Array, w: Array) -> tuple[Array, Array]:
        """Return the vector from the center of mass to the lowest point [m], and its rate [m/s].

        w: angular velocity in the world [rad/s].
        """
        a = R[:, 1]
        a_dot = np.cross(w, a)
        s = np.hypot(a[0], a[1])
        s_dot = (a[0] * a_dot[0] + a[1] * a_dot[1]) / s
        d = (a[2] * a - UP) / s
        d_dot = (a_dot[2] * a + a[2] * a_dot) / s - s_dot / s * d
        center = R @ np.array(self.center)
        ring = self.radius - self.crown
        return center + ring * d - self.crown * UP, np.cross(w, center) + ring * d_dot

    def forces(self, y: Array, mode: str) -> tuple[Array, Array, Array]:
        """Return force [N], acceleration [m/s2] and rate of w in the world; y: r, Q (x, y, z, w), v, w."""
        R = Rotation.from_quat(y[3:7]).as_matrix()
        v, w = y[7:10], y[10:13]
        inertia = R @ np.diag(self.moments) @ R.T
        inverse = np.linalg.inv(inertia)
        gyroscopic = -inverse @ np.cross(w, inertia @ w)
        weight = -G * UP
        if mode == "fly":
            return np.zeros(3), weight, gyroscopic
        arm, arm_dot = self.arm(R, w)
        cross = np.cross(arm, np.eye(3), axisb=0, axisc=0)  # arm x
        per_force = np.eye(3) / self.mass - cross @ inverse @ cross  # acceleration of the point
        free = weight + np.cross(gyroscopic, arm) + np.cross(w, arm_dot)
        if mode == "roll":
            f = np.linalg.solve(per_force, -free)
        else:
            slip = v + np.cross(w, arm)
            slip[2] = 0
            direction = UP - self.friction * slip / np.linalg.norm(slip)
            f = -free[2] / (per_force @ direction)[2] * direction
        return f, weight + f / self.mass, gyroscopic + inverse @ np.cross(arm, f)

    def rates(self, y: Array, mode: str) -> Array:
        _, acceleration, turning = self.forces(y, mode)
        w = y[10:13]
        x, yy, z, s = y[3:7]
        Q_dot = 0.5 * np.array(
            [
                s * w[0] + w[1] * z - w[2] * yy,
                s * w[1] + w[2] * x - w[0] * z,
                s * w[2] + w[0] * yy - w[1] * x,
                -w @ [x, yy, z],
            ]
        )
        return np.concatenate([y[7:10], Q_dot, acceleration, turning])

    def slip(self, y: Array) -> Array:
        arm, _ = self.arm(Rotation.from_quat(y[3:7]).as_matrix(), y[10:13])
        return (y[7:10] + np.cross(y[10:13], arm))[:2]

    def margin(self, y: Array) -> float:
        """Return what friction could hold more while it rolls [N]."""
        f = self.forces(y, "roll")[0]
        return float(self.friction * f[2] - np.hypot(f[0], f[1]))


@dataclass(frozen=True)
class Course:
    """States at the times, and the events: their times, and the modes that begin there."""

    states: Array
    events: list[tuple[float, str]]


def course(wheel: Wheel, y: Array, times: Array, mode: str = "slide") -> Course:
    """Integrate from y at times[0]; ends in flight, without landing."""
    t, stop = float(times[0]), float(times[-1])
    rows = [np.array(y, float)]
    events: list[tuple[float, str]] = []
    while True:

        def stops(_: float, y: Array) -> float:
            return float(np.hypot(*wheel.slip(y)) - NO_SLIP)

        def breaks(_: float, y: Array) -> float:
            return wheel.margin(y)

        def leaves(_: float, y: Array, mode: str = mode) -> float:
            return float(wheel.forces(y, mode)[0][2])

        watched = {"slide": [stops, leaves], "roll": [breaks, leaves], "fly": []}[mode]
        for event in watched:
            event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
        inner = times[(times > t) & (times <= stop)]
        found = solve_ivp(
            lambda _, y, mode=mode: wheel.rates(y, mode),
            (t, stop), y, method="DOP853", rtol=1e-12, atol=1e-13, events=watched or None, dense_output=True,
            max_step=0.02,
        )  # fmt: skip
        t = float(found.t[-1])
        rows += [found.sol(at) for at in inner if at <= t]
        if found.status != 1:
            return Course(np.array(rows), events)
        y = found.y[:, -1]
        if len(found.t_events[1]):
            mode = "fly"
        elif mode == "slide":
            mode = "roll" if wheel.margin(y) > 0 else "slide"
        else:
            mode = "slide"
            f = wheel.forces(y, "roll")[0]
            # At rest the direction of what starts to slide is opposite to friction.
            y[7:9] -= 2 * NO_SLIP * f[:2] / np.hypot(*f[:2])
        events.append((t, mode))


TO_Y = {"rotation": {"axis": [1, 0, 0], "angle": pi / 2}}  # of a shape: its z axis along -y of the body
DISC = Wheel(2.0, (0.06, 0.12, 0.06), 0.3, 0.0, 0.25)


def scene_of(wheel: Wheel, y: Array, **law: Any) -> dict[str, Any]:
    """The wheel above the plane z = 0, on a joint of type `free`; y: r, Q, v, w (in the world)."""
    R = Rotation.from_quat(y[3:7])
    start = {
        "r": y[:3].tolist(),
        "Q": y[3:7].tolist(),
        "v": y[7:10].tolist(),
        "w": R.inv().apply(y[10:13]).tolist(),
        "fixed": True,
    }
    tire = {"radius": wheel.radius, "crown": wheel.crown}
    shape = {"wheel": tire, "surface": "rubber", "position": list(wheel.center), **TO_Y}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {"wheel": {"mass": wheel.mass, "inertia": list(wheel.moments), "shapes": {"tire": shape}}},
        "ground": {"shapes": {"plane": {"plane": [0, 0, 1], "surface": "road"}}},
        "joints": {"J": {"type": "free", "parent": "ground", "child": "wheel", "start": start}},
        "contacts": {"tire": {"between": ["rubber", "road"], "friction": wheel.friction, **law}},
        "experiment": {"step": 1e-3},
    }


def on_the_plane(wheel: Wheel, lean: float, v: tuple[float, float], w: tuple[float, float, float]) -> Array:
    """A state in contact: heading x, leaning about x [rad]; v along x and y, w in the world; no bouncing."""
    R = Rotation.from_euler("x", lean)
    rate = np.array(w)
    arm, _ = wheel.arm(R.as_matrix(), rate)
    up = -np.cross(rate, arm)[2]
    return np.concatenate([[0, 0, -arm[2]], R.as_quat(), [*v, up], rate])
