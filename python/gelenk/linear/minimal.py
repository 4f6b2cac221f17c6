# SPDX-License-Identifier: BSD-3-Clause
"""A plant's derivatives at a point by minimal states, as many as the mechanism has.

A quaternion Q is four states for three freedoms. With dQ = 1/2 Q o (dtheta, 0) three numbers dtheta stand
for it: the small turn of the joint's frame M against where the motion itself takes it, along M's axes. So
theta is zero at the point, and changes by d(dtheta)/dt = dw - w x dtheta: with R the motion's own rotation
and S = R (1 + dtheta~) the one beside it, dS/dt = S (w + dw)~ and dR/dt = R w~ leave that to first order.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import GelenkError, UsageError
from gelenk.model.values import check_names, elements, unknown
from gelenk.simulation.derivatives import Derivatives

Array = NDArray[np.float64]


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
                across = self._turns[joint].G.T @ raw[[place[Q] for Q in elements(f"{joint}.Q", 4)]]
                columns |= dict(zip(elements(f"{joint}.theta", 3), across, strict=True))
        self.names = tuple(sorted(columns, key=lambda name: not self.is_coordinate(name)))
        E = np.array([columns[name] for name in self.names]).reshape(len(columns), len(of.states)).T
        self.C: Array = of.C @ E
        self.D = of.D

    def _find_turns(self) -> dict[str, _Turn]:
        turns = {}
        for name in self.of.readings:
            joint = name.removesuffix(".Q[1]")
            wanted = [*elements(f"{joint}.Q", 4), *elements(f"{joint}.w", 3)]
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
        return out + [theta for joint in self._turns for theta in elements(f"{joint}.theta", 3)]

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
    check_names(wanted, known, "state", lambda name: _no_state(name, known))
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


def check_whole(minimal: Minimal) -> None:
    """All that moves has to move by the states."""
    found = minimal.of
    names, joints = ", ".join(minimal.names), ", ".join(minimal.part_free)
    sentence = (
        f"a joint with a quaternion turns in part freely{f' ({joints})' if joints else ''} and can give no "
        f"states; the others, {names}, do not tell all of the motion"
    )
    if found.order is not None:
        if len(minimal.names) != found.order:
            raise GelenkError(
                f"{sentence}: they are {len(minimal.names)} of {found.order}. A loop that is cut at this "
                "joint needs no states of it: list it behind the loop's other joints, or leave the "
                "reduction cut_choice on"
            )
        return
    # Other FMUs do not tell how many it takes. But what is read moves as the states let it: dy/dt = C dx/dt.
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    for i, name in enumerate(found.readings):
        speed = found.rates.get(name)
        if speed is None:
            continue
        terms = minimal.C[i] * rates
        scale = 1 + np.abs(terms).sum() + abs(found.values[speed])
        if abs(terms.sum() - found.values[speed]) > 1e-4 * scale:  # loops held by a penalty may gape a little
            raise GelenkError(f"{sentence}: {name} moves otherwise")


def _no_state(name: str, known: Sequence[str]) -> str:
    theta = re.sub(r"\.Q(\[[1-4]\])?$", ".theta[1]", name)
    if theta != name and theta in known:
        owner = name.rpartition(".")[0]
        return f"{name}: a quaternion is one number too many for states; {owner}.theta[1..3] stand for it"
    return unknown(name, "state", known)
