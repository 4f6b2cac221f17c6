# SPDX-License-Identifier: BSD-3-Clause
"""Motions with friction in proportion to a reaction that depends on it, by DOP853 at 1e-13 between events.

Along one coordinate, inertia a + friction |reaction(a)| = force. If friction grows faster with a than
inertia, there is no such acceleration, or there are two (Painleve); of these the one counts near which a
small force along the coordinate accelerates it in its own direction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from benchmarks.nonsmooth.exact_drives import roots
from scipy.integrate import solve_ivp

GRAVITY = 9.81


Load = Callable[[float, float, float, float], float]


class ParadoxError(Exception):
    """No acceleration, or more than one, agrees with the law."""


@dataclass(frozen=True)
class Eccentric:
    """A wheel in a bearing, with its center of mass beside the axis; gravity pulls it to angle 0."""

    mass: float
    arm: float  # m, of the center of mass
    inertia: float  # kg m2, about the axis
    friction: float  # coefficient times radius [m]
    gravity: float = GRAVITY
    torque: float = 0.0

    def acceleration(self, phi: float, w: float, side: float) -> float:
        """Return the one that agrees with the friction of a motion in the direction `side`."""
        drive = self.torque - self.mass * self.gravity * self.arm * math.sin(phi)
        # drive - inertia a = side friction |(along, fixed + moment a)|: squared, a quadratic equation.
        along = self.mass * (self.arm * w * w + self.gravity * math.cos(phi))
        fixed, moment = self.mass * self.gravity * math.sin(phi), self.mass * self.arm
        squared = self.friction**2
        found = roots(
            self.inertia**2 - squared * moment**2,
            -2 * (drive * self.inertia + squared * fixed * moment),
            drive**2 - squared * (along**2 + fixed**2),
        )
        if self.friction * moment < self.inertia:  # without friction, both roots are the same
            return max(found, key=lambda a: side * (drive - self.inertia * a))
        for a in found:
            size = math.hypot(along, fixed + moment * a)
            growth = self.inertia * size + side * self.friction * (fixed + moment * a) * moment
            if side * (drive - self.inertia * a) >= 0 and growth > 0:
                return a
        raise ParadoxError

    def rests(self, phi: float) -> bool:
        """Return whether friction holds it."""
        drive = self.torque - self.mass * self.gravity * self.arm * math.sin(phi)
        return abs(drive) <= self.friction * self.mass * self.gravity


@dataclass(frozen=True)
class SliderCrank:
    """Slender crank and rod, and a slider whose guide has friction; gravity acts across the guide."""

    lengths: tuple[float, float]
    masses: tuple[float, float, float]
    friction: float
    gravity: float = GRAVITY
    torque: float = 0.0

    def equations(self, phi: float, w: float) -> tuple[float, float, float, Load]:
        """Return M, force and slide in M a = force + slide F, with the friction F of the guide, and its load.

        The load is a function of acceleration, squared speed, gravity and F.
        """
        (a, b), (m1, m2, m3) = self.lengths, self.masses
        sine, cosine = math.sin(phi), math.cos(phi)
        tilt = -math.asin(a * sine / b)  # of the rod from its center line
        k = -a * cosine / (b * math.cos(tilt))  # its rate by that of the crank
        bend = (a * sine + b * math.sin(tilt) * k * k) / (b * math.cos(tilt))
        e, n = np.array([math.cos(tilt), math.sin(tilt)]), np.array([-math.sin(tilt), math.cos(tilt)])
        pin, pin_bend = a * np.array([-sine, cosine]), -a * np.array([cosine, sine])
        rod, rod_bend = pin + b / 2 * k * n, pin_bend + b / 2 * (bend * n - k * k * e)
        slide, slide_bend = pin[0] + b * k * n[0], pin_bend[0] + b * (bend * n - k * k * e)[0]
        g = np.array([0.0, -self.gravity])
        # By virtual power.
        M = m1 * a * a / 3 + m2 * (rod @ rod + (b * k) ** 2 / 12) + m3 * slide**2
        force = (
            self.torque
            + m1 * g[1] * a / 2 * cosine
            + m2 * rod @ g
            - w * w * (m2 * (rod @ rod_bend + b * b * k * bend / 12) + m3 * slide * slide_bend)
        )

        # The load of the guide: moments of the rod about its pin on the crank, the force on its end (f, h).
        # b (e x (f, h)) + b/2 e x m2 (g - acceleration) = m2 b^2/12 rod's angular acceleration
        # f = -m3 slide's acceleration + F, h = load - m3 gravity
        def load(accelerations: float, speeds: float, gravity: float, F: float) -> float:
            center = rod * accelerations + rod_bend * speeds - g * gravity
            turn = k * accelerations + bend * speeds
            f = -m3 * (slide * accelerations + slide_bend * speeds) + F
            moment = m2 * b * b / 12 * turn + b / 2 * m2 * (e[0] * center[1] - e[1] * center[0])
            return float((moment / b + e[1] * f) / e[0] + m3 * self.gravity * gravity)

        return float(M), float(force), float(slide), load

    def rests(self, phi: float) -> bool:
        """Return whether friction holds it."""
        _, force, slide, load = self.equations(phi, 0.0)
        needed = -force / slide
        return abs(needed) <= self.friction * abs(load(0, 0, 1, needed))

    def acceleration(self, phi: float, w: float, side: float) -> float:
        """Return that of the crank; side: the direction of its rotation."""
        M, force, slide, load = self.equations(phi, w)
        # F = -s friction |load|, with load = fixed + by_a a + by_F F and a = (force + slide F) / M.
        s = math.copysign(1.0, slide * side)
        fixed = load(0, w * w, 1, 0) + load(1, 0, 0, 0) * force / M
        by_F = load(0, 0, 0, 1) + load(1, 0, 0, 0) * slide / M
        # load + s friction by_F |load| = fixed
        sign = math.copysign(1.0, fixed)
        if 1 + sign * s * self.friction * by_F <= 0:
            raise ParadoxError
        size = abs(fixed) / (1 + sign * s * self.friction * by_F)
        return float((force - slide * s * self.friction * size) / M)

    def slides(self, phi: float) -> float:
        """Return the speed of the slider per speed of the crank."""
        a, b = self.lengths
        tilt = -math.asin(a * math.sin(phi) / b)
        return -a * math.sin(phi) + a * math.cos(phi) * math.tan(tilt)


def reversing(
    machine: Eccentric | SliderCrank, phi: float, w: float, times: Sequence[float]
) -> tuple[list[tuple[float, float]], int]:
    """Return angles and speeds at the times, and the number of instants at which something stops or reverses.

    Raises ParadoxError where the motion comes to a position without a law.
    """
    now, y, events = 0.0, np.array([phi, w]), 0
    found: list[tuple[float, float]] = []
    side = math.copysign(1.0, w) if w else 0.0
    extra = 1e-9  # rad, beyond a dead center
    while len(found) < len(times):
        if side == 0:
            if machine.rests(float(y[0])):
                found += [(float(y[0]), 0.0)] * (len(times) - len(found))
                break
            side = next(s for s in (1.0, -1.0) if s * machine.acceleration(float(y[0]), 0.0, s) > 0)

        def speed(_t: float, s: np.ndarray, side: float = side) -> float:
            return float(side * s[1])

        stops: list[Callable[..., float]] = [speed]
        if isinstance(machine, SliderCrank):
            direction = math.copysign(1.0, machine.slides(float(y[0]) + side * extra))

            def center(_t: float, s: np.ndarray, direction: float = direction) -> float:
                return direction * machine.slides(float(s[0]))

            stops.append(center)
        for stop in stops:
            stop.terminal, stop.direction = True, -1  # type: ignore[attr-defined]

        def rates(_t: float, s: np.ndarray, side: float = side) -> list[float]:
            return [s[1], machine.acceleration(float(s[0]), float(s[1]), side)]

        # From rest the speed is 0 at first.
        run = solve_ivp(rates, (now, times[-1]), y, "DOP853", dense_output=True, events=stops, rtol=1e-13,
                        atol=1e-14, max_step=0.05, first_step=1e-7)  # fmt: skip
        for t in times[len(found) :]:
            if t <= run.t[-1]:
                found.append((float(run.sol(t)[0]), float(run.sol(t)[1])))
        now, y = float(run.t[-1]), run.y[:, -1].copy()
        if run.status == 1:
            events += 1
            if len(run.t_events[0]) > 0:
                y[1], side = 0.0, 0.0
    return found, events
