# SPDX-License-Identifier: BSD-3-Clause
"""Drive trains of inertias, clutches, one-way clutches and gears with losses, solved without Gelenk.

From event to event with SciPy; at each one, all modes of all elements are tried for one in which every law
holds. Inputs are linear within segments.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mechanisms import Array
from scipy.integrate import solve_ivp

REST = 1e-9  # rad/s: what is slower than this may stick
ROUNDING = 1e-10  # of forces at their limits, which are located to about 1e-12

AFTER = 1e-9  # s
MOST_EVENTS = 40  # in a segment
UNLOADED = 1e-9  # N m: less in a mesh has no sign, and breaks nothing away

type Modes = tuple[Any, ...]


@dataclass(frozen=True)
class Friction:
    """Between two inertias or, as a brake, on one; `row` gives its speed from those of the inertias."""

    row: Array
    sliding: Callable[[Array], float]  # of the inputs [N m]
    static: Callable[[Array], float]

    def modes(self, v: float) -> Sequence[int]:
        return (0, 1, -1) if abs(v) < REST else (int(np.sign(v)),)


@dataclass(frozen=True)
class OneWay:
    """row w is not negative; a clutch beside it resists positive speeds, too."""

    row: Array
    sliding: Callable[[Array], float] = lambda _u: 0.0
    static: Callable[[Array], float] = lambda _u: 0.0

    def modes(self, v: float) -> Sequence[int]:
        return (0, 1) if abs(v) < REST else (1,)  # 0: it holds


@dataclass(frozen=True)
class LossyGear:
    """w[a] = ratio w[b], with losses of a's torque; `bearing` adds a constant friction on a."""

    a: int
    b: int
    ratio: float
    driving: float  # efficiency if a drives
    driven: float  # if b drives
    bearing: float = 0.0

    def modes(self, v: float) -> Sequence[tuple[int, int]]:
        """Return the direction of motion of a (0: at rest), and the sign of the torque it delivers."""
        directions = (0, 1, -1) if abs(v) < REST else (int(np.sign(v)),)
        return [(d, s) for d in directions for s in (1, -1)]

    def loss(self, direction: int, sign: int) -> float:
        """Return the friction on a per torque in the mesh."""
        return 1 / self.driving - 1 if direction * sign > 0 else 1 - self.driven


@dataclass
class DriveTrain:
    inertias: Array
    torques: Callable[[Array, Array, Array], Array]  # of the inputs, angles and speeds
    elements: Sequence[Friction | OneWay | LossyGear]
    events: int = field(default=0, init=False)

    def speed(self, e: Friction | OneWay | LossyGear, w: Array) -> float:
        return float(w[e.a]) if isinstance(e, LossyGear) else float(e.row @ w)

    def solve(self, modes: Modes, u: Array, phi: Array, w: Array) -> tuple[Array, list[Array]]:
        """Return the accelerations, and of each element its forces: of a gear mesh and friction."""
        n = len(self.inertias)
        load = self.torques(u, phi, w).astype(float)
        columns: list[Array] = []  # of unknown forces
        rows: list[Array] = []  # of accelerations that vanish
        places: list[Any] = []
        for e, mode in zip(self.elements, modes, strict=True):
            if isinstance(e, Friction):
                if mode == 0:
                    places.append(len(columns))
                    columns.append(e.row)
                    rows.append(e.row)
                else:
                    load += -mode * e.sliding(u) * e.row
                    places.append(None)
            elif isinstance(e, OneWay):
                places.append(len(columns) if mode == 0 else None)
                if mode == 0:
                    columns.append(e.row)
                    rows.append(e.row)
                else:
                    load += -e.sliding(u) * e.row
            else:
                on_a, on_b = np.eye(n)[e.a], np.eye(n)[e.b]
                direction, sign = mode
                places.append(len(columns))
                mesh = -on_a + e.ratio * on_b
                rows.append(on_a - e.ratio * on_b)
                if direction == 0:
                    columns += [mesh, on_a]
                    rows.append(on_a)
                else:
                    columns.append(mesh - direction * e.loss(direction, sign) * sign * on_a)
                    load += -direction * e.bearing * on_a
        m = len(columns)
        system = np.zeros((n + m, n + m))
        system[:n, :n] = np.diag(self.inertias)
        if m:
            system[:n, n:] = -np.array(columns).T
            system[n:, :n] = np.array(rows)
        found = np.linalg.lstsq(system, np.concatenate([load, np.zeros(m)]), rcond=1e-12)[0]
        x = found[n:]
        forces = []
        for e, mode, place in zip(self.elements, modes, places, strict=True):
            if isinstance(e, LossyGear):
                forces.append(x[place : place + (2 if mode[0] == 0 else 1)])
            else:
                forces.append(x[place : place + 1] if place is not None else np.zeros(0))
        return found[:n], forces

    def indicators(self, modes: Modes, u: Array, phi: Array, w: Array) -> Array:
        """Return numbers that are all positive or zero while the modes last."""
        _, forces = self.solve(modes, u, phi, w)
        out: list[float] = []
        for e, mode, x in zip(self.elements, modes, forces, strict=True):
            if isinstance(e, Friction):
                out.append(e.static(u) - abs(x[0]) + UNLOADED if mode == 0 else mode * self.speed(e, w))
            elif isinstance(e, OneWay):
                out.append(float(x[0]) + e.static(u) + UNLOADED if mode == 0 else self.speed(e, w))
            else:
                direction, sign = mode
                out.append(sign * x[0] + UNLOADED)
                if direction == 0:
                    # The friction of a is limited by what its motion in either direction would cause.
                    up = e.bearing + e.loss(1, sign) * abs(x[0])
                    down = e.bearing + e.loss(-1, sign) * abs(x[0])
                    out.append(min(x[1] + up, down - x[1]))
                else:
                    out.append(direction * float(w[e.a]))
        return np.array(out)

    def is_consistent(self, modes: Modes, u: Array, phi: Array, w: Array) -> bool:
        a, _ = self.solve(modes, u, phi, w)
        if (self.indicators(modes, u, phi, w) < -ROUNDING).any():
            return False
        for e, mode in zip(self.elements, modes, strict=True):
            direction = mode[0] if isinstance(e, LossyGear) else mode
            if direction != 0 and abs(self.speed(e, w)) < REST and direction * self.speed(e, a) < ROUNDING:
                return False
        return True

    def modes_at(self, u: Array, phi: Array, w: Array) -> Modes:
        """Return the first consistent modes: what can remain at rest does."""

        def moving(modes: Modes) -> int:
            return sum((mode[0] if isinstance(mode, tuple) else mode) != 0 for mode in modes)

        every = sorted(itertools.product(*(e.modes(self.speed(e, w)) for e in self.elements)), key=moving)
        found = next((modes for modes in every if self.is_consistent(modes, u, phi, w)), None)
        assert found is not None, f"no modes at {phi}, {w}"
        return found

    def run(
        self, inputs: Callable[[float], Array], segment: float, segments: int, w: Array
    ) -> Iterator[Array]:
        """Yield (phi, w) at the ends of the segments, from angles 0."""
        n = len(self.inertias)
        y = np.concatenate([np.zeros(n), w])
        for k in range(segments):
            start, end = inputs(k * segment), inputs((k + 1) * segment)

            def u(t: float, start: Array = start, end: Array = end, first: float = k * segment) -> Array:
                return start + (end - start) * (t - first) / segment

            t = k * segment
            parts = 0
            while t < (k + 1) * segment - 1e-13:
                parts += 1
                assert parts <= MOST_EVENTS, f"events without end at t = {t}"
                # Just after an event, where its own indicator is not zero any more.
                modes = self.modes_at(u(t + AFTER), y[:n] + AFTER * y[n:], y[n:])
                t, y = self.advance(modes, u, t, (k + 1) * segment, y)
            yield y.copy()

    def advance(
        self, modes: Modes, u: Callable[[float], Array], t: float, stop: float, y: Array
    ) -> tuple[float, Array]:
        n = len(self.inertias)
        count = len(self.indicators(modes, u(t), y[:n], y[n:]))

        def event(i: int) -> Any:
            def value(at: float, state: Array) -> float:
                if at <= t + 1e-12:
                    return 1.0
                return float(self.indicators(modes, u(at), state[:n], state[n:])[i])

            value.terminal = True  # type: ignore[attr-defined]
            value.direction = -1  # type: ignore[attr-defined]
            return value

        solution = solve_ivp(
            lambda at, s: np.concatenate([s[n:], self.solve(modes, u(at), s[:n], s[n:])[0]]),
            (t, stop),
            y,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            max_step=(stop - t) / 8,  # indicators may be negative for a while
            events=[event(i) for i in range(count)],
        )
        after = solution.y[:, -1]
        for e, mode in zip(self.elements, modes, strict=True):
            direction = mode[0] if isinstance(e, LossyGear) else mode
            if abs(self.speed(e, after[n:])) < 1e-10 and direction != 0:
                self.events += solution.status == 1
        return float(solution.t[-1]), after
