# SPDX-License-Identifier: BSD-3-Clause
"""What the drive trains of models/drive_trains.py consist of: each with the modes that a state permits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import Array

REST = 1e-9  # rad/s: what is slower than this may stick
TOUCH = 1e-12  # m, rad: nearer to a bound is at it
ROUNDING = 1e-10  # of forces at their limits, which are located to about 1e-12

UNLOADED = 1e-9  # N m: less in a mesh has no sign, and breaks nothing away

type Modes = tuple[Any, ...]


@dataclass(frozen=True)
class Friction:
    """Between two inertias or, as a brake, on one; `row` gives its speed from those of the inertias.

    Inelastic hard stops bound its position.
    """

    row: Array
    sliding: Callable[[Array], float]  # of the inputs [N m]
    static: Callable[[Array], float]
    falling: Callable[[float], float] = lambda _v: 0.0  # sliding friction beside it, of the size of the speed
    lower: float = -math.inf
    upper: float = math.inf

    def modes(self, q: float, v: float) -> Sequence[int]:
        if abs(v) >= REST:
            return (int(np.sign(v)),)
        return [0] + [d for d, free in ((1, q < self.upper - TOUCH), (-1, q > self.lower + TOUCH)) if free]

    def range(self, q: float, u: Array) -> tuple[float, float]:
        """Return what the force that holds it may be: at a bound any that pushes."""
        static = self.static(u)
        least = -math.inf if q >= self.upper - TOUCH else -static
        return least, math.inf if q <= self.lower + TOUCH else static


@dataclass(frozen=True)
class OneWay:
    """row w is not negative; a clutch beside it resists positive speeds, too."""

    row: Array
    sliding: Callable[[Array], float] = lambda _u: 0.0
    static: Callable[[Array], float] = lambda _u: 0.0

    def modes(self, _q: float, v: float) -> Sequence[int]:
        return (0, 1) if abs(v) < REST else (1,)  # 0: it holds


@dataclass(frozen=True)
class Rigid:
    """row w = 0."""

    row: Array

    def modes(self, _q: float, _v: float) -> Sequence[int]:
        return (1,)


@dataclass(frozen=True)
class Flanks:
    """A spring and damper beyond two bounds of row phi, which pushes and does not pull.

    Modes: 0 between the bounds; beyond the upper one 1, or 2 where the damping force is limited to the spring
    force, or 3 where it would pull; beyond the lower one -1, -2, -3.
    """

    row: Array
    lower: float
    upper: float
    stiffness: float
    damping: float
    limited: bool

    def _parts(self, mode: int, q: float, v: float) -> tuple[float, float]:
        """Return spring and damping force, positive if they push."""
        if mode > 0:
            return self.stiffness * (q - self.upper), self.damping * v
        return self.stiffness * (self.lower - q), -self.damping * v

    def modes(self, q: float, v: float) -> Sequence[int]:
        for side in (1, -1):
            spring, damper = self._parts(side, q, v)
            if spring > 0:
                kind = 3 if spring + damper < 0 else 2 if self.limited and damper > spring else 1
                return (side * kind,)
        return (0,)

    def force(self, mode: int, q: float, v: float) -> float:
        spring, damper = self._parts(mode, q, v)
        return -math.copysign([0.0, spring + damper, 2 * spring, 0.0][abs(mode)], mode)

    def indicators(self, mode: int, q: float, v: float) -> list[float]:
        spring, damper = self._parts(mode, q, v)
        if mode == 0:
            return [self.upper - q, q - self.lower]
        if abs(mode) == 1:
            return [spring + damper] + ([spring - damper] if self.limited else [])
        return [spring, damper - spring] if abs(mode) == 2 else [spring, -spring - damper]


@dataclass(frozen=True)
class LossyGear:
    """w[a] = ratio w[b], with losses of a's torque; `bearing` adds a constant friction on a."""

    a: int
    b: int
    ratio: float
    driving: float  # efficiency if a drives
    driven: float  # if b drives
    bearing: float = 0.0
    worse: float = 0.0  # by which both efficiencies fall with the size of a's speed [s/rad]

    def modes(self, _q: float, v: float) -> Sequence[tuple[int, int]]:
        """Return the direction of motion of a (0: at rest), and the sign of the torque it delivers."""
        directions = (0, 1, -1) if abs(v) < REST else (int(np.sign(v)),)
        return [(d, s) for d in directions for s in (1, -1)]

    def range(self, sign: int) -> tuple[float, float]:
        """Return the friction on a per torque in the mesh up to which it rests; `bearing` is added."""
        return -sign * self.loss(1, sign), sign * self.loss(-1, sign)

    def loss(self, direction: int, sign: int, speed: float = 0.0) -> float:
        """Return the friction on a per torque in the mesh."""
        less = self.worse * abs(speed)
        return 1 / (self.driving - less) - 1 if direction * sign > 0 else 1 - (self.driven - less)


type Element = Friction | OneWay | Rigid | Flanks | LossyGear
