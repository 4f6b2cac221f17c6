# SPDX-License-Identifier: BSD-3-Clause
"""Exact motions of clutches, freewheels and gears with losses under constant torques."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

ROUNDING = 1e-12  # of forces at their limits


@dataclass(frozen=True)
class Gear:
    """w1 = ratio w2; the first shaft has losses in proportion to the torque of the mesh."""

    inertias: tuple[float, float]
    ratio: float
    efficiency: float  # if the first shaft drives
    backdriving: float
    load: float  # on the second shaft [N m]

    def loss(self, direction: int, sign: int) -> float:
        """Return friction per torque of the mesh; sign: of the torque that the first shaft delivers."""
        return 1 / self.efficiency - 1 if direction * sign > 0 else 1 - self.backdriving

    def holds(self, torque: float) -> bool:
        """Return whether its losses keep it at rest."""
        mesh = -self.load / self.ratio
        sign = 1 if mesh >= 0 else -1
        friction = mesh - torque
        slack = ROUNDING * abs(mesh)
        return -self.loss(1, sign) * abs(mesh) - slack <= friction <= self.loss(-1, sign) * abs(mesh) + slack

    def acceleration(self, direction: int, torque: float) -> float:
        """Return that of the first shaft in motion."""
        J1, J2 = self.inertias
        for sign in (1, -1):
            k = 1 + direction * self.loss(direction, sign) * sign
            inertia = J1 + k * J2 / self.ratio**2
            a = (torque + k * self.load / self.ratio) / inertia
            if sign * (J2 * a / self.ratio - self.load) / self.ratio >= 0:
                return a
        raise AssertionError("no sign of the mesh is consistent")


def gear_course(
    gear: Gear, w: float, times: Sequence[float], torques: Sequence[float]
) -> tuple[list[tuple[float, float]], int]:
    """Return angles and speeds of the first shaft, and the number of events.

    torques[k] act until times[k].
    """
    x, now, events, found, resting = 0.0, 0.0, 0, [], False
    for end, torque in zip(times, torques, strict=True):
        while now < end:
            if w == 0 and gear.holds(torque):
                resting, now = True, end
                continue
            events += resting
            resting = False
            direction = int(math.copysign(1, w)) if w else 1 if gear.acceleration(1, torque) > 0 else -1
            a = gear.acceleration(direction, torque)
            halt = -w / a if a * w < 0 else math.inf
            h = min(end - now, halt)
            x, w, now = x + w * h + a / 2 * h * h, w + a * h, now + h
            if h == halt:
                w, events = 0.0, events + 1
        now = end
        found.append((x, w))
    return found, events


@dataclass
class Clutch:
    """Two wheels, of which a torque drives the first; the clutch between them is engaged in ramps."""

    inertias: tuple[float, float]
    torque: float  # N m
    sliding: float  # N m, fully engaged
    static: float
    speeds: tuple[float, float]

    def course(
        self, times: Sequence[float], values: Sequence[float], slopes: Sequence[float]
    ) -> tuple[list[tuple[float, float, float, float]], int]:
        """Return angles and speeds at the times, and the number of events.

        values, slopes: of the engagement, from each of the times before, which is 0 at first.
        """
        J1, J2 = self.inertias
        carried = self.torque * J2 / (J1 + J2)
        state, now, events, found = [0.0, 0.0, *self.speeds], 0.0, 0, []
        locked = self.speeds[0] == self.speeds[1] and self.static * values[0] >= abs(carried)
        for end, value, slope in zip(times, values, slopes, strict=True):
            begin = now
            while now < end:
                engaged = value + slope * (now - begin)
                if locked:
                    spare = engaged - abs(carried) / self.static if carried else math.inf
                    h = max(0.0, spare / -slope) if slope < 0 else 0.0 if spare < -ROUNDING else math.inf
                    if h < end - now:
                        locked, events = False, events + 1
                    h = min(h, end - now)
                    self._move(state, h, carried, 0.0)
                    now = now + h
                    continue
                slip = state[2] - state[3]
                side = math.copysign(1.0, slip if slip else carried)
                # slip + p h + q h^2 is 0 where it locks.
                inverse = 1 / J1 + 1 / J2
                p = self.torque / J1 - side * self.sliding * engaged * inverse
                q = -side * self.sliding * slope * inverse / 2
                h = end - now
                meets = [r for r in roots(q, p, slip) if 1e-13 < r <= h]
                h = min([h, *meets])
                self._move(state, h, side * self.sliding * engaged, side * self.sliding * slope)
                now = now + h
                if meets:
                    state[2] = state[3]
                    locked, events = True, events + 1
            now = end
            found.append((state[0], state[1], state[2], state[3]))
        return found, events

    def _move(self, state: list[float], h: float, passed: float, rate: float) -> None:
        """Advance under the torque passed + rate t of the clutch."""
        for k, (J, constant, slope) in enumerate(
            ((self.inertias[0], self.torque - passed, -rate), (self.inertias[1], passed, rate))
        ):
            state[k] += h * state[2 + k] + (constant / 2 + slope * h / 6) * h * h / J
            state[2 + k] += (constant + slope * h / 2) * h / J


def roots(a: float, b: float, c: float) -> list[float]:
    """Return the real roots of a x^2 + b x + c."""
    if a == 0:
        return [-c / b] if b else []
    inside = b * b - 4 * a * c
    if inside < -ROUNDING * b * b:
        return []
    large = -(b + math.copysign(math.sqrt(max(inside, 0.0)), b)) / 2
    return [large / a, *([c / large] if large else [])]


def freewheel_course(
    inertias: tuple[float, float], load: float, times: Sequence[float], torques: Sequence[float]
) -> tuple[list[tuple[float, float]], int]:
    """Return the speeds of two wheels from rest, and the events; the first cannot overtake the second.

    torques[k] act on the first until times[k], load on the second.
    """
    J1, J2 = inertias
    w1 = w2 = now = 0.0
    held, events, found = True, 0, []
    for end, torque in zip(times, torques, strict=True):
        while now < end:
            pushes = J2 * torque - J1 * load  # the torque that the first passes on, times both inertias
            if held and pushes < 0:
                held, events = False, events + 1
            if held:
                a1 = a2 = (torque + load) / (J1 + J2)
                h = end - now
            else:
                a1, a2 = torque / J1, load / J2
                meet = (w2 - w1) / (a1 - a2) if a1 > a2 else math.inf
                h = min(end - now, meet)
                if h == meet and w2 > w1:
                    held, events = True, events + 1
            w1, w2, now = w1 + a1 * h, w2 + a2 * h, now + h
            if held:
                w2 = w1
        now = end
        found.append((w1, w2))
    return found, events
