# SPDX-License-Identifier: BSD-3-Clause
"""Exact motion of one coordinate with dry friction and hard limits under piecewise constant forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scipy.integrate import solve_ivp

TINY = 1e-9  # m/s, rad/s: slower bounces are rest; they last 1e-9 s at 1 m/s2


@dataclass(frozen=True)
class Law:
    """A coordinate with the given inertia; `static` >= `coulomb`, `lower` < `upper`."""

    inertia: float
    coulomb: float = 0.0
    static: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    restitution: float = 0.0


class Motion:
    """The motion from a position and a speed. `events` counts instants of events, NaN if infinitely many."""

    def __init__(self, law: Law, x: float, v: float) -> None:
        self.law, self.x, self.v = law, x, v
        self.events = 0.0
        self.resting = False

    def advance(self, span: float, force: float) -> None:
        """Move on under a constant force."""
        rested = self.resting
        while span > 0:
            acceleration = self._acceleration(force)
            if self.resting:
                return
            self.events += rested  # it breaks away
            rested = False
            span = self._arc(span, acceleration)

    def _acceleration(self, force: float) -> float:
        """Return the acceleration, and determine whether it is at rest."""
        law = self.law
        if self.v == 0:
            side = 1 if self.x >= law.upper and force > 0 else -1 if self.x <= law.lower and force < 0 else 0
            self.resting = side != 0 or abs(force) <= law.static
            if side and law.restitution > 0 and self.events:
                self.events = math.nan  # the end of a series
            return 0.0 if self.resting else (force - math.copysign(law.coulomb, force)) / law.inertia
        self.resting = False
        return (force - math.copysign(law.coulomb, self.v)) / law.inertia

    def _arc(self, span: float, a: float) -> float:
        """Follow a parabola until its next event or for the whole span; return the time left."""
        law = self.law
        if self._strikes():
            return span
        direction = math.copysign(1.0, self.v or a)
        bound = law.upper if direction > 0 else law.lower
        halt = -self.v / a if a * self.v < 0 else math.inf
        meet = _first_root(direction * a / 2, abs(self.v), direction * (bound - self.x))
        t = min(span, halt, meet)
        self.x, self.v = (bound if t == meet else self.x + self.v * t + a / 2 * t * t), self.v + a * t
        if t == halt and t < meet:
            self.v = 0.0
            if law.static > 0:
                self.events += 1
        elif t == meet:
            self._strikes()
        return span - t

    def _strikes(self) -> bool:
        """Return whether it strikes a bound, and change the speed."""
        law = self.law
        for side, bound in ((1, law.upper), (-1, law.lower)):
            if side * (self.x - bound) >= 0 and side * self.v > 0:
                self.events += 1
                self.v *= -law.restitution
                if abs(self.v) < TINY:
                    self.v = 0.0
                return True
        return False


def _first_root(half: float, v: float, distance: float) -> float:
    """Return the first t > 0 with half t^2 + v t = distance >= 0, infinite if there is none."""
    if not math.isfinite(distance):
        return math.inf
    inside = v * v + 4 * half * distance
    if inside < 0 or (half <= 0 and v <= 0):
        return math.inf
    return 2 * distance / (v + math.sqrt(inside)) if v + math.sqrt(inside) > 0 else math.inf


def course(
    law: Law, x: float, v: float, times: Sequence[float], forces: Sequence[float]
) -> tuple[list[tuple[float, float]], float]:
    """Return positions and speeds at the times, under forces[k] until times[k], and the number of events."""
    motion, found, now = Motion(law, x, v), [], 0.0
    for t, force in zip(times, forces, strict=True):
        motion.advance(t - now, force)
        now = t
        found.append((motion.x, motion.v))
    return found, motion.events


def with_stribeck(
    law: Law, stribeck: float, v: float, times: Sequence[float], force: float
) -> tuple[list[tuple[float, float]], int]:
    """Return the same from x = 0 with v >= 0, without limits, until it rests or beyond (DOP853 at 1e-13)."""

    def rates(_t: float, y: Sequence[float]) -> list[float]:
        friction = law.coulomb + (law.static - law.coulomb) * math.exp(-((y[1] / stribeck) ** 2))
        return [y[1], (force - friction) / law.inertia]

    def speed(_t: float, y: Sequence[float]) -> float:
        return y[1]

    speed.terminal, speed.direction = True, -1  # type: ignore[attr-defined]
    found = solve_ivp(
        rates, (0.0, times[-1]), [0.0, v], "DOP853", times, events=[speed], rtol=1e-13, atol=1e-15
    )
    moving = [(float(x), float(w)) for x, w in zip(*found.y, strict=True)]  # none if it rests before
    if found.status == 0:
        return moving, 0
    rest = float(found.y_events[0][0][0])
    return moving + [(rest, 0.0)] * (len(times) - len(moving)), 1


def springy(
    law: Law, stiffness: float, x: float, times: Sequence[float]
) -> tuple[list[tuple[float, float]], int]:
    """Return the same of a spring-mass released from x: half oscillations about +-coulomb / stiffness."""
    rate, shift, stuck = math.sqrt(stiffness / law.inertia), law.coulomb / stiffness, law.static / stiffness
    begins, ends = [0.0], [x]
    while abs(ends[-1]) > stuck:
        center = math.copysign(shift, ends[-1])
        ends.append(2 * center - ends[-1])
        begins.append(begins[-1] + math.pi / rate)
    found = []
    for t in times:
        k = max(i for i, begin in enumerate(begins) if begin <= t)
        if abs(ends[k]) <= stuck:
            found.append((ends[k], 0.0))
            continue
        center = math.copysign(shift, ends[k])
        arc = rate * (t - begins[k])
        found.append(
            (center + (ends[k] - center) * math.cos(arc), -rate * (ends[k] - center) * math.sin(arc))
        )
    return found, sum(begin <= times[-1] for begin in begins[1:])
