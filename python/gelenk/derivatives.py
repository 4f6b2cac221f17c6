# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of a plant at a point, by its states as declared and by minimal ones.

A quaternion Q is four states for three freedoms. With dQ = 1/2 Q o (dtheta, 0) three numbers dtheta stand
for it: the small turn of the joint's frame M against where the motion itself takes it, along M's axes. So
theta is zero at the point, and changes by d(dtheta)/dt = dw - w x dtheta: with R the motion's own rotation
and S = R (1 + dtheta~) the one beside it, dS/dt = S (w + dw)~ and dR/dt = R w~ leave that to first order.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.scales import Scales
from gelenk.scene import unknown

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Derivatives:
    """What all that can be read differs by: dy = C dx + D du, exactly.

    Attributes:
        states: x, as the plant declares them.
        inputs: u.
        outputs: those of `readings` that are outputs.
        readings: y, the states and their derivatives among them, except for quaternions.
        C: shape (readings, states).
        D: shape (readings, inputs).
        values: of inputs and readings, at the point.
        rates: reading -> the reading that is its time derivative.
        units: of inputs and readings.
        order: how many states the mechanism has; None where that is not known.
        scales: of the mechanism.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    readings: tuple[str, ...]
    C: Array
    D: Array
    values: Mapping[str, float]
    rates: Mapping[str, str]
    units: Mapping[str, str]
    order: int | None = None
    scales: Scales = field(default_factory=Scales)

    def size(self, name: str) -> float:
        """The SI value of 1 of this input or reading in the mechanism's own units."""
        return self.scales.size(self.units.get(name, "1"))

    def in_own_units(self) -> Derivatives:
        """The same, values and slopes in the mechanism's own units; `units` and `scales` stay."""
        y, x, u = (
            np.array([self.size(name) for name in names])
            for names in (self.readings, self.states, self.inputs)
        )
        values = {name: value / self.size(name) for name, value in self.values.items()}
        return replace(self, C=self.C * x / y[:, None], D=self.D * u / y[:, None], values=values)


def rate_told(name: str, description: str) -> str | None:
    """Whose derivative an output is: A.w, "A: angular velocity, der(phi)" -> A.phi."""
    found = re.search(r"\bder\(([^()]+)\)$", description)
    owner = name.rpartition(".")[0]
    return f"{owner}.{found.group(1)}" if found and owner else None


@dataclass(frozen=True)
class _Turn:
    """A joint whose quaternion is read."""

    Q: list[int]  # rows of the readings
    w: list[int]
    G: Array  # shape (4, 3): dQ = G dtheta; dtheta = 4 G' dQ


class Minimal:
    """The same derivatives by as many states as the mechanism has, quaternions being three each.

    `names` are the states: those of the plant, J.theta[1..3] in the place of J.Q[1..4].
    """

    def __init__(self, of: Derivatives) -> None:
        self.of = of
        self._row = {name: i for i, name in enumerate(of.readings)}
        self._turns = self._find_turns()
        columns: dict[str, Array] = {}
        raw = np.eye(len(of.states))
        place = {name: i for i, name in enumerate(of.states)}
        for name in of.states:
            joint, _, component = name.rpartition(".Q[")
            if joint not in self._turns:
                columns[name] = raw[place[name]]
            elif component == "1]":
                across = self._turns[joint].G.T @ raw[[place[Q] for Q in _four(f"{joint}.Q")]]
                columns |= dict(zip(_three(f"{joint}.theta"), across, strict=True))
        self.names = tuple(sorted(columns, key=lambda name: not self.is_coordinate(name)))
        E = np.array([columns[name] for name in self.names]).reshape(len(columns), len(of.states)).T
        self.C: Array = of.C @ E
        self.D = of.D

    def _find_turns(self) -> dict[str, _Turn]:
        turns = {}
        for name in self.of.readings:
            joint = name.removesuffix(".Q[1]")
            wanted = [*_four(f"{joint}.Q"), *_three(f"{joint}.w")]
            # A sensor's frame has these, too; only joints tell the derivatives of their w.
            if joint == name or f"{joint}.w[1]" not in self.of.rates or not {*wanted} <= {*self._row}:
                continue
            rows = [self._row[n] for n in wanted]
            x, y, z, s = (self.of.values[n] for n in wanted[:4])
            G = 0.5 * np.array([[s, -z, y], [z, s, -x], [-y, x, s], [-x, -y, -z]])
            turns[joint] = _Turn(rows[:4], rows[4:], G)
        return turns

    @property
    def part_free(self) -> list[str]:
        """Joints with a quaternion that is no state, or not a whole one."""
        return [joint for joint in self._turns if f"{joint}.theta[1]" not in self.names]

    @property
    def candidates(self) -> list[str]:
        """All that may be states: whatever has a time derivative that can be read."""
        quaternions = {self.of.readings[k] for turn in self._turns.values() for k in turn.Q}
        out = [name for name in self.of.readings if name in self.of.rates and name not in quaternions]
        return out + [theta for joint in self._turns for theta in _three(f"{joint}.theta")]

    def speed(self, coordinate: str) -> str:
        """The state that goes with this one: A.w for A.phi, S.w[1] for S.theta[1]."""
        theta = self._theta(coordinate)
        if theta is None:
            return self.of.rates[coordinate]
        return coordinate.replace(".theta[", ".w[")

    def is_coordinate(self, name: str) -> bool:
        """It has a speed, which has an acceleration."""
        return self._theta(name) is not None or self.of.rates.get(name) in self.of.rates

    def row(self, name: str) -> Array:
        """A reading's, or a rotation coordinate's slopes by the states."""
        theta = self._theta(name)
        turn, i = theta or (None, 0)
        row: Array = self.C[self._row[name]] if turn is None else 4 * turn.G[:, i] @ self.C[turn.Q]
        return row

    def rate(self, name: str) -> tuple[Array, Array, float]:
        """The time derivative of a state: its slopes by the states, by the inputs, and itself."""
        theta = self._theta(name)
        if theta is None:
            row = self._row[self.of.rates[name]]
            return self.C[row], self.D[row], self.of.values[self.of.rates[name]]
        turn, i = theta
        w = np.array([self.of.values[self.of.readings[k]] for k in turn.w])
        carried = np.cross(w, 4 * (turn.G.T @ self.C[turn.Q]).T).T[i]
        return self.C[turn.w[i]] - carried, self.D[turn.w[i]], float(w[i])

    def unit(self, name: str) -> str:
        """Of a state."""
        return "rad" if self._theta(name) is not None else self.of.units.get(name, "1")

    def value(self, name: str) -> float:
        """Of a state at the point."""
        return 0.0 if self._theta(name) is not None else self.of.values[name]

    def _theta(self, name: str) -> tuple[_Turn, int] | None:
        joint, _, component = name.rpartition(".theta[")
        if name in self._row or joint not in self._turns or component not in ("1]", "2]", "3]"):
            return None
        return self._turns[joint], int(component[0]) - 1


def chosen_states(minimal: Minimal, wanted: Sequence[str] | None) -> list[str]:
    """The states that a user names, with their speeds if only coordinates are named; all when None.

    Coordinates and speeds named may be fewer than the mechanism has.

    Raises:
        UsageError: names that cannot be states, more than the mechanism has, or too few coordinates alone.
    """
    if wanted is None:
        return list(minimal.names)
    known = minimal.candidates
    faults = [_no_state(name, known) for name in wanted if name not in known]
    faults += [f"{name}: asked for twice" for name in dict.fromkeys(wanted) if list(wanted).count(name) > 1]
    if faults:
        raise UsageError("\n".join(faults))
    out = list(wanted)
    if all(minimal.is_coordinate(name) for name in wanted):
        out += [minimal.speed(name) for name in wanted]
    n = len(minimal.names)
    coordinates = sum(map(minimal.is_coordinate, minimal.names))
    if len(wanted) == coordinates and len(out) > n:  # fewer speeds are free: those of the plant
        out = [*wanted, *minimal.names[coordinates:]]
    if len(out) > n or (len(out) < n and all(map(minimal.is_coordinate, wanted))):
        speeds = f"their {n - coordinates}" if 2 * coordinates == n else f"{n - coordinates}"
        raise UsageError(
            f"states: found {len(wanted)}, expected {coordinates} coordinates, or these and {speeds} speeds"
        )
    return out


def _no_state(name: str, known: Sequence[str]) -> str:
    theta = re.sub(r"\.Q(\[[1-4]\])?$", ".theta[1]", name)
    if theta != name and theta in known:
        owner = name.rpartition(".")[0]
        return f"{name}: a quaternion is one number too many for states; {owner}.theta[1..3] stand for it"
    return unknown(name, "state", known)


def _three(name: str) -> list[str]:
    return [f"{name}[{i}]" for i in (1, 2, 3)]


def _four(name: str) -> list[str]:
    return [f"{name}[{i}]" for i in (1, 2, 3, 4)]
