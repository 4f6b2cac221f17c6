# SPDX-License-Identifier: BSD-3-Clause
"""Drive trains of inertias, clutches, one-way clutches, gears with losses and stops, solved without Gelenk.

From event to event with SciPy; at each one, all modes of all elements are tried for one in which every law
holds. Inputs are linear within segments. An inertia may be 0 if the elements determine its motion.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mechanisms import Array
from scipy.integrate import solve_ivp
from scipy.linalg import null_space
from scipy.optimize import linprog

from models.drive_elements import (
    REST,
    ROUNDING,
    TOUCH,
    UNLOADED,
    Element,
    Flanks,
    Friction,
    LossyGear,
    Modes,
    OneWay,
    Rigid,
)  # fmt: skip

AFTER = 1e-9  # s
MOST_EVENTS = 40  # in a segment


@dataclass
class DriveTrain:
    inertias: Array
    torques: Callable[[Array, Array, Array], Array]  # of the inputs, angles and speeds
    elements: Sequence[Element]
    instants: list[float] = field(default_factory=list, init=False)  # at which modes change, later than 0

    def speed(self, e: Element, w: Array) -> float:
        """Return the speed of an element, or its position from angles."""
        return float(w[e.a]) if isinstance(e, LossyGear) else float(e.row @ w)

    def solve(
        self, modes: Modes, u: Array, phi: Array, w: Array, *, forces_too: bool = True
    ) -> tuple[Array, list[Array]]:
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
                    size = e.sliding(u) + e.falling(mode * self.speed(e, w))
                    load += -mode * size * e.row
                    places.append(None)
            elif isinstance(e, Flanks):
                load += e.force(mode, self.speed(e, phi), self.speed(e, w)) * e.row
                places.append(None)
            elif isinstance(e, Rigid):
                places.append(len(columns))
                columns.append(e.row)
                rows.append(e.row)
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
                    columns.append(mesh - direction * e.loss(direction, sign, self.speed(e, w)) * sign * on_a)
                    load += -direction * e.bearing * on_a
        m = len(columns)
        system = np.zeros((n + m, n + m))
        system[:n, :n] = np.diag(self.inertias)
        if m:
            system[:n, n:] = -np.array(columns).T
            system[n:, :n] = np.array(rows)
        found, _, rank, _ = np.linalg.lstsq(system, np.concatenate([load, np.zeros(m)]), rcond=1e-12)
        x = found[n:]
        if rank < n + m and forces_too:
            x = x + self._distribute(modes, places, u, phi, x, null_space(system, 1e-12)[n:])
        forces = []
        for e, mode, place in zip(self.elements, modes, places, strict=True):
            if isinstance(e, LossyGear):
                forces.append(x[place : place + (2 if mode[0] == 0 else 1)])
            else:
                forces.append(x[place : place + 1] if place is not None else np.zeros(0))
        return found[:n], forces

    def _distribute(
        self, modes: Modes, places: list[Any], u: Array, phi: Array, x: Array, null: Array
    ) -> Array:
        """Return what to add to redundant forces so that each is as far from its limit as it can be."""
        above: list[Array] = []  # above @ (z, t) <= value
        values: list[float] = []

        def bound(row: Array, value: float, margin: float = 1.0) -> None:
            if np.isfinite(value):
                above.append(np.append(row @ null, margin))
                values.append(value - float(row @ x))

        unit = np.eye(len(x))
        for e, mode, place in zip(self.elements, modes, places, strict=True):
            if isinstance(e, LossyGear):
                direction, sign = mode
                bound(-sign * unit[place], 0.0, 0.0)
                if direction == 0:
                    least, most = e.range(sign)
                    bound(unit[place + 1] - most * unit[place], e.bearing)
                    bound(least * unit[place] - unit[place + 1], e.bearing)
            elif mode == 0 and isinstance(e, Friction):
                least, most = e.range(self.speed(e, phi), u)
                bound(unit[place], most)
                bound(-unit[place], -least)
            elif mode == 0 and isinstance(e, OneWay):
                bound(-unit[place], e.static(u))
        count = null.shape[1]
        best = linprog(
            np.append(np.zeros(count), -1.0), np.array(above), values,
            bounds=[(-1e4, 1e4)] * count + [(-1e4, 1e4)],
        )  # fmt: skip
        return null @ best.x[:count] if best.status == 0 else np.zeros(len(x))

    def indicators(self, modes: Modes, u: Array, phi: Array, w: Array, *, flanks: bool = True) -> Array:
        """Return numbers that are all positive or zero while the modes last."""
        _, forces = self.solve(modes, u, phi, w)
        out: list[float] = []
        for e, mode, x in zip(self.elements, modes, forces, strict=True):
            if isinstance(e, Friction):
                q = self.speed(e, phi)
                if mode == 0:
                    least, most = e.range(q, u)
                    out.append(min(most - float(x[0]), float(x[0]) - least) + UNLOADED)
                else:
                    out += [mode * self.speed(e, w), e.upper - q if mode > 0 else q - e.lower]
            elif isinstance(e, Flanks):
                if not flanks:
                    continue
                out += e.indicators(mode, self.speed(e, phi), self.speed(e, w))
            elif isinstance(e, Rigid):
                pass
            elif isinstance(e, OneWay):
                out.append(float(x[0]) + e.static(u) + UNLOADED if mode == 0 else self.speed(e, w))
            else:
                direction, sign = mode
                out.append(sign * x[0] + UNLOADED)
                if direction == 0:
                    # The friction of a is limited by what its motion in either direction would cause.
                    least, most = e.range(sign)
                    out.append(e.bearing + min(x[1] - least * x[0], most * x[0] - x[1]) + UNLOADED)
                else:
                    out.append(direction * float(w[e.a]))
        return np.array(out)

    def is_consistent(self, modes: Modes, u: Array, phi: Array, w: Array) -> bool:
        a, _ = self.solve(modes, u, phi, w)
        if (self.indicators(modes, u, phi, w, flanks=False) < -ROUNDING).any():
            return False
        for e, mode in zip(self.elements, modes, strict=True):
            if isinstance(e, (Flanks, Rigid)):
                continue
            direction = mode[0] if isinstance(e, LossyGear) else mode
            if direction != 0 and abs(self.speed(e, w)) < REST and direction * self.speed(e, a) < ROUNDING:
                return False
        return True

    def modes_at(self, u: Array, phi: Array, w: Array, a: Array) -> Modes:
        """Return the first consistent modes: what can remain at rest does.

        a: the accelerations before, which tell on which side of a limit the force of a stop is.
        """
        phi = phi + AFTER * w

        def moving(modes: Modes) -> int:
            return sum((mode[0] if isinstance(mode, tuple) else mode) != 0 for mode in modes)

        choices = (
            e.modes(self.speed(e, phi), self.speed(e, w + AFTER * a if isinstance(e, Flanks) else w))
            for e in self.elements
        )
        every = sorted(itertools.product(*choices), key=moving)
        found = next((modes for modes in every if self.is_consistent(modes, u, phi, w)), None)
        assert found is not None, f"no modes at {phi}, {w}"
        return found

    def run(
        self,
        inputs: Callable[[float], Array],
        segment: float,
        segments: int,
        w: Array,
        *,
        phi: Array | None = None,
        jump: float = 0.0,
    ) -> Iterator[Array]:
        """Yield (phi, w) at the ends of the segments, from angles 0.

        jump: inputs are linear up to their values so much before the end of each segment [s].
        """
        n = len(self.inertias)
        y = np.concatenate([np.zeros(n) if phi is None else phi, w])
        before: Modes | None = None
        for k in range(segments):
            start, end = inputs(k * segment), inputs((k + 1) * segment - jump)

            def u(t: float, start: Array = start, end: Array = end, first: float = k * segment) -> Array:
                return start + (end - start) * (t - first) / segment

            t = k * segment
            parts = 0
            while t < (k + 1) * segment - 1e-13:
                parts += 1
                assert parts <= MOST_EVENTS, f"events without end at t = {t}"
                # Just after an event, where its own indicator is not zero any more.
                a = self.solve(before, u(t), y[:n], y[n:], forces_too=False)[0] if before else np.zeros(n)
                modes = self.modes_at(u(t + AFTER), y[:n], y[n:], a)
                if before and any(_logged(a) != _logged(b) for a, b in zip(before, modes, strict=True)):
                    self.instants.append(t)
                before = modes
                t, y = self.advance(modes, u, t, (k + 1) * segment, y)
            yield y.copy()

    def advance(
        self, modes: Modes, u: Callable[[float], Array], t: float, stop: float, y: Array
    ) -> tuple[float, Array]:
        n = len(self.inertias)
        count = len(self.indicators(modes, u(t), y[:n], y[n:]))
        last: dict[tuple[float, bytes], Array] = {}

        def event(i: int) -> Any:
            def value(at: float, state: Array) -> float:
                if at <= t + 1e-12:
                    return 1.0
                key = at, state.tobytes()
                if key not in last:
                    last.clear()
                    last[key] = self.indicators(modes, u(at), state[:n], state[n:])
                return float(last[key][i])

            value.terminal = True  # type: ignore[attr-defined]
            value.direction = -1  # type: ignore[attr-defined]
            return value

        solution = solve_ivp(
            lambda at, s: np.concatenate(
                [s[n:], self.solve(modes, u(at), s[:n], s[n:], forces_too=False)[0]]
            ),
            (t, stop),
            y,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            max_step=(stop - t) / 8,  # indicators may be negative for a while
            events=[event(i) for i in range(count)],
        )
        after = solution.y[:, -1]
        for e in self.elements:
            if isinstance(e, Friction):
                self._strike(e, after)
        return float(solution.t[-1]), after

    def _strike(self, e: Friction, y: Array) -> None:
        """Stop what moves on at a bound."""
        n = len(self.inertias)
        q, v = self.speed(e, y[:n]), self.speed(e, y[n:])
        if (q >= e.upper - TOUCH and v > REST) or (q <= e.lower + TOUCH and v < -REST):
            column = e.row / self.inertias
            y[n:] -= column * v / (e.row @ column)


def _logged(mode: Any) -> int:
    """Return what Gelenk counts as a mode: neither the sign of a load nor what limits the force of a stop."""
    if isinstance(mode, tuple):
        return int(mode[0])
    return int(np.sign(mode)) if abs(mode) != 3 else 0
