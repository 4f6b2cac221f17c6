# SPDX-License-Identifier: BSD-3-Clause
"""A block, a ball or a box that touches a plane, with known motions.

The motions are closed forms, but for the tipping box: its references were computed by event-driven
Gragg-Bulirsch-Stoer extrapolation in 80-bit arithmetic, repeated with another step and with DOP853; their own
errors are below 1e-14.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

GRAVITY = 9.81  # m/s2
BLOCK, BLOCK_MASS = (0.4, 0.3, 0.1), 2.5  # m, kg
BOX, BOX_MASS = (0.2, 0.3, 0.6), 2.0
BALL, BALL_MASS, BALL_FRICTION = 0.05, 0.17, 0.2
BOUNCER, BOUNCER_MASS, RESTITUTION = 0.1, 0.7, 0.5


@dataclass(frozen=True)
class Problem:
    """A free body on a plane through the origin.

    Attributes:
        name: for files.
        title: for charts.
        size: edges of a box, or the radius of a sphere [m].
        mass: [kg]
        moments: principal moments of inertia [kg m2].
        friction: coefficient of Coulomb friction.
        restitution: coefficient of restitution.
        angle: of the plane, which falls towards +x [rad].
        height: of the body above the plane [m].
        v: velocity at the start [m/s].
        w: angular velocity at the start [rad/s].
        force: along x, constant in the world [N].
        at: point of the body on which it acts [m].
        shown: "slope" (way down the plane), "z", "xy", or "box" (x and tilt).
        times: of the references [s].
        exact: values of what is shown at the times [m, rad], shape (times, values).
    """

    name: str
    title: str
    size: tuple[float, ...]
    mass: float
    moments: tuple[float, float, float]
    friction: float
    restitution: float
    angle: float
    height: float
    v: tuple[float, float, float]
    w: tuple[float, float, float]
    force: float
    at: tuple[float, float, float]
    shown: str
    times: tuple[float, ...]
    exact: Array

    @property
    def start(self) -> tuple[list[float], list[float]]:
        """Position [m] and quaternion (x, y, z, w) at the start."""
        half = self.angle / 2
        p = [self.height * math.sin(self.angle), 0.0, self.height * math.cos(self.angle)]
        return p, [0.0, math.sin(half), 0.0, math.cos(half)]

    @property
    def normal(self) -> list[float]:
        """Outward normal of the plane."""
        return [math.sin(self.angle), 0.0, math.cos(self.angle)]

    @property
    def is_ball(self) -> bool:
        """Whether the body is a sphere."""
        return len(self.size) == 1

    def shown_of(self, poses: Array) -> Array:
        """Return what is compared.

        Args:
            poses: positions and quaternions (x, y, z, w), shape (times, 7).
        """
        if self.shown == "slope":
            down = [math.cos(self.angle), 0.0, -math.sin(self.angle)]
            way: Array = (poses[:, :3] - self.start[0]) @ np.array(down)[:, None]
            return way
        if self.shown == "box":
            tilt = 2 * np.arctan2(poses[:, 4], poses[:, 6])
            return np.column_stack([poses[:, 0], np.remainder(tilt + math.pi, 2 * math.pi) - math.pi])
        return poses[:, 2:3] if self.shown == "z" else poses[:, :2]

    def error(self, poses: Array) -> float:
        """Return the largest error at the times [m, rad]."""
        return float(np.abs(self.shown_of(np.asarray(poses, float)) - self.exact).max())


def _moments(mass: float, size: Sequence[float]) -> tuple[float, float, float]:
    if len(size) == 1:
        return (0.4 * mass * size[0] ** 2,) * 3
    x, y, z = (length**2 for length in size)
    return mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y)


def _problem(
    name: str, title: str, size: tuple[float, ...], mass: float, shown: str, times: tuple[float, ...],
    exact: Any, *, friction: float = 0.0, **fields: Any,
) -> Problem:  # fmt: skip
    rest: dict[str, Any] = {
        "restitution": 0.0, "angle": 0.0, "height": size[-1] / 2, "v": (0.0, 0.0, 0.0), "w": (0.0, 0.0, 0.0),
        "force": 0.0, "at": (0.0, 0.0, 0.0),
    }  # fmt: skip
    values = np.asarray(exact, float).reshape(len(times), -1)
    return Problem(
        name,
        title,
        size,
        mass,
        _moments(mass, size),
        friction,
        **(rest | fields),
        shown=shown,
        times=times,
        exact=values,
    )


def on_slope(
    name: str, title: str, degrees: float, friction: float, up: float, times: tuple[float, ...]
) -> Problem:
    """A block on a slope: it slides with constant acceleration in either direction, or sticks."""
    angle = math.radians(degrees)
    sine, cosine = math.sin(angle), math.cos(angle)
    braking = GRAVITY * (sine + friction * cosine)
    falling = max(0.0, GRAVITY * (sine - friction * cosine))
    stop = up / braking
    exact = [
        -up * t + braking / 2 * t * t if t < stop else -up * stop / 2 + falling / 2 * (t - stop) ** 2
        for t in times
    ]
    v = (-up * cosine, 0.0, up * sine)
    return _problem(
        name, title, BLOCK, BLOCK_MASS, "slope", times, exact, friction=friction, angle=angle, v=v
    )


def bouncing() -> Problem:
    """A ball that is dropped from 1 m: infinitely many impacts until 1.3546 s, then rest."""
    times = (0.3, 0.6, 1.0, 1.2, 1.3, 1.35, 2.0)
    exact = []
    for t in times:
        if t < (first := math.sqrt(2 / GRAVITY)):
            exact.append(1 - GRAVITY / 2 * t * t)
            continue
        left, speed = t - first, RESTITUTION * GRAVITY * first
        while left > 2 * speed / GRAVITY and speed > 1e-12:
            left -= 2 * speed / GRAVITY
            speed *= RESTITUTION
        exact.append(max(0.0, speed * left - GRAVITY / 2 * left**2) if speed > 1e-12 else 0.0)
    return _problem(
        "bounces", "Ball that bounces until it rests", (BOUNCER,), BOUNCER_MASS, "z", times,
        [BOUNCER + z for z in exact], restitution=RESTITUTION, height=1 + BOUNCER,
    )  # fmt: skip


def rolling() -> Problem:
    """A ball slides in a constant direction until it rolls, after 2/7 of its slip is gone."""
    times = (0.1, 0.3, 0.5, 0.6, 1.0, 2.0)
    v, w = np.array([2.0, 0.5]), (0.0, -30.0, 5.0)
    slip = v + BALL * np.array([-w[1], w[0]])
    speed = float(np.linalg.norm(slip))
    brake = BALL_FRICTION * GRAVITY / speed * slip
    end = 2 / 7 * speed / (BALL_FRICTION * GRAVITY)
    exact = [
        v * min(t, end) - brake / 2 * min(t, end) ** 2 + (v - brake * end) * max(0.0, t - end) for t in times
    ]
    return _problem(
        "rolls", "Ball that slides, then rolls", (BALL,), BALL_MASS, "xy", times, exact,
        friction=BALL_FRICTION, height=BALL, v=(2.0, 0.5, 0.0), w=w,
    )  # fmt: skip


def pushed(
    name: str, title: str, force: float, height: float, times: tuple[float, ...], exact: Any
) -> Problem:
    """A box that is pushed at a height above the ground."""
    at = (-BOX[0] / 2, 0.0, height - BOX[2] / 2)
    return _problem(name, title, BOX, BOX_MASS, "box", times, exact, friction=0.5, force=force, at=at)


def problems() -> list[Problem]:
    late, early = (0.5, 1.0, 2.0), (0.1, 0.2, 0.3)
    a = 12 / BOX_MASS - 0.5 * GRAVITY
    upright = [(a / 2 * t * t, 0) for t in late]
    return [
        on_slope("sticks", "Block that sticks on an incline", 20, 0.5, 0, late),
        on_slope("slides", "Block that slides down an incline", 35, 0.5, 0, late),
        on_slope("back", "Block that slides up, stops, slides back", 30, 0.5, 3, (0.2, 0.3, *late)),
        bouncing(),
        rolling(),
        pushed("upright", "Pushed box that slides upright", 12, 0.2, late, upright),
        pushed(
            "tips", "Pushed box that tips, its edge holds", 9, 0.5, early,
            [(0.014734275694396877, 0.04873772900429651), (0.06444178205298598, 0.20906728114424242),
             (0.1638102387904922, 0.5249313302239281)],
        ),
        pushed(
            "edge", "Pushed box that tips while its edge slides", 18, 0.25, early,
            [(0.020074803624550646, 0.00810249116993732), (0.07974330500139308, 0.046376050960760036),
             (0.17781586942674224, 0.176948074173501)],
        ),
    ]  # fmt: skip
