# SPDX-License-Identifier: BSD-3-Clause
"""A plant put at rest in a pose, and the steps from one pose to the next that its loops allow."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from gelenk.errors import AssemblyError, UsageError
from gelenk.linear.minimal import Minimal, check_whole
from gelenk.linear.model import standing
from gelenk.linear.operating_point import START
from gelenk.model.rotation import turned
from gelenk.model.values import Value, start_parameter, unknown
from gelenk.simulation.derivatives import Derivatives
from gelenk.simulation.plant import Plant

Array = NDArray[np.float64]

FULL_ANGLE = 0.3  # rad: what a step may turn a joint by, so that the branch is kept


@dataclass(frozen=True)
class Pose:
    """A plant at a point: accelerations a that have to vanish, and what they change by, da = A dx + B du.

    All in the mechanism's own units, `found` among it, so that bounds and least squares are. At rest, x are
    those coordinates that tell the others best there: the acceleration of one that stands at its dead centre
    would vanish, whatever the others do. In steady motion x are the independent coordinates and speeds.

    Attributes:
        found: all derivatives here.
        minimal: the same by independent states.
        unknowns: the names of x.
        conditions: speeds, whose accelerations have to vanish.
        accelerations: theirs, shape (conditions,).
        A: shape (conditions, unknowns).
        B: shape (conditions, inputs).
        basis: what the states of `minimal` change by with x, shape (states, unknowns).
        ways: at rest, how x goes with the speeds of the conditions, dx/dt = ways v; empty in motion.
    """

    found: Derivatives
    minimal: Minimal
    unknowns: tuple[str, ...]
    conditions: tuple[str, ...]
    accelerations: Array
    A: Array
    B: Array
    basis: Array
    ways: Array

    def slopes(self, names: Sequence[str]) -> Array:
        """Of readings or rotation coordinates, by the unknowns, shape (names, unknowns)."""
        return _rows(self.minimal, names) @ self.basis

    def accelerations_of(self, speeds: Sequence[str]) -> Array:
        """Of other speeds than those of the conditions here."""
        return np.array([self.minimal.rate(name)[2] for name in speeds])

    @property
    def stands(self) -> bool:
        """Whether the accelerations vanish, to rounding of the terms they are sums of."""
        return bool((np.abs(self.accelerations) <= standing(self.A, self.sizes)).all())

    @property
    def residual(self) -> float:
        """The largest acceleration of those that are told, in SI units."""
        return max((abs(self.in_si(name, a)) for name, a in self._told.items()), default=0.0)

    def largest(self) -> tuple[str, float, str]:
        """The largest of these: what it is called, itself, its unit in SI."""
        told = self._told
        if not told:
            return "", 0.0, ""
        name = max(told, key=lambda name: abs(told[name]))
        return name, told[name], self.found.units.get(name, "1")

    @property
    def _told(self) -> dict[str, float]:
        """Accelerations by name: of the plant's own independent speeds, or of those to be steady."""
        own = [name for name in self.minimal.names if not self.minimal.is_coordinate(name)]
        speeds = own if len(self.ways) else self.conditions
        return {self.found.rates[name]: self.minimal.rate(name)[2] for name in speeds}

    def in_si(self, name: str, value: float) -> float:
        """What an input or a reading is called to users."""
        return value * self.found.size(name)

    @property
    def sizes(self) -> Array:
        """Of the unknowns: 1 rad or the mechanism's length, speeds by themselves."""
        return np.array(
            [1.0 if self.minimal.is_coordinate(n) else 1 + abs(self.minimal.value(n)) for n in self.unknowns]
        )


def _rows(minimal: Minimal, names: Sequence[str]) -> Array:
    return np.array([minimal.row(name) for name in names]).reshape(len(names), len(minimal.names))


def pose_of(found: Derivatives, conditions: Sequence[str] | None = None) -> Pose:
    """The point where these derivatives were taken: at rest, or in motion, where `conditions` are given."""
    found = found.in_own_units()
    minimal = Minimal(found)
    check_whole(minimal)
    unknowns, ways = minimal.names, np.empty((0, 0))
    basis = np.eye(len(unknowns))
    if conditions is None:
        n = sum(map(minimal.is_coordinate, minimal.names))
        known = [name for name in minimal.candidates if minimal.is_coordinate(name)]
        unknowns, by_coordinates = _telling(minimal, known, slice(n))
        conditions, by_speeds = _telling(minimal, [minimal.speed(name) for name in known], slice(n, None))
        basis = np.vstack([by_coordinates, np.zeros((len(minimal.names) - n, n))])
        ways = np.array([minimal.rate(q)[0][n:] for q in unknowns]).reshape(n, len(by_speeds)) @ by_speeds
    rates = [minimal.rate(name) for name in conditions]
    A = np.array([by_x for by_x, _, _ in rates]).reshape(len(rates), len(basis)) @ basis
    B = np.array([by_u for _, by_u, _ in rates]).reshape(len(rates), len(found.inputs))
    accelerations = np.array([a for _, _, a in rates])
    return Pose(found, minimal, tuple(unknowns), tuple(conditions), accelerations, A, B, basis, ways)


def _telling(minimal: Minimal, known: Sequence[str], states: slice) -> tuple[tuple[str, ...], Array]:
    """As many of these names as there are such states, which tell the others best, and the states by them."""
    rows = _rows(minimal, known)[:, states]
    order = qr(rows.T, mode="r", pivoting=True)[1][: rows.shape[1]] if rows.size else []
    chosen = sorted(map(int, order))
    return tuple(known[i] for i in chosen), np.linalg.inv(rows[chosen])


class Rest:
    """A plant that is put into poses by its own assembly: as near as the loops allow, all speeds zero.

    In steady motion, where `conditions` are given, speeds are put as coordinates are.
    """

    def __init__(
        self,
        plant: Plant,
        size: Callable[[str], float],
        settings: Mapping[str, Value],
        hold: Mapping[str, float],
        speeds: Mapping[str, float] | None = None,
        conditions: Sequence[str] | None = None,
    ) -> None:
        """size: the SI value of 1 of an input or output in the mechanism's own units; settings: parameters
        besides start values; hold, speeds: coordinates and speeds to be kept, and the values they keep, in
        these units, as all below; conditions: speeds whose accelerations have to vanish, by default all.
        """
        self._plant = plant
        self._size = size
        self._held = list(hold)
        self.hold = {**hold, **(speeds or {})}
        self.conditions = conditions
        known = set(plant.parameters)
        self._starts = [name for name in plant.readings if start_parameter(name) in known]
        flags: dict[str, Value] = {
            name: False for name in plant.parameters if name.endswith(".fixed") and self._owned(name)
        }
        self._settings = {**settings, **flags}
        self._settings.pop(START, None)
        self._can_settle = START in known

    def _owned(self, flag: str) -> list[str]:
        joint = flag.removesuffix("fixed")
        return [name for name in self._starts if name.startswith(joint)]

    def check_hold(self, pose: Pose) -> None:
        """Raises UsageError: names that cannot be held."""
        can = [name for name in self._starts if name in pose.minimal.candidates]
        can = [name for name in can if pose.minimal.is_coordinate(name)]
        faults = []
        for name in [name for name in self._held if name not in can]:
            if name in self._starts:
                faults.append(f"{name}: only a joint's coordinates can be held, one by one; no speeds, no Q")
            else:
                faults.append(unknown(name, "coordinate", can))
        if faults:
            raise UsageError("\n".join(faults))
        for name in self._held:  # exact where the joint has no other coordinate
            joint = name.rpartition(".")[0]
            if [n for n in can if n.startswith(f"{joint}.")] == [name] and f"{joint}.fixed" in self._settings:
                self._settings[f"{joint}.fixed"] = True

    def starts(self, pose: Pose, step: Array) -> dict[str, float]:
        """Start values of all joints a step of the unknowns away, to first order."""
        out: dict[str, float] = {}
        for name in self._starts:
            joint, _, component = name.rpartition(".Q[")
            if joint and f"{joint}.theta[1]" in pose.minimal.candidates:
                if component == "1]":
                    out |= _turned(pose, joint, step)
            elif joint or pose.minimal.is_coordinate(name) or self.conditions is not None:
                out[name] = pose.found.values[name]
                if not joint:
                    out[name] += float(pose.slopes([name])[0] @ step)
            else:
                out[name] = 0.0  # a speed
        return out

    def settled(self, pose: Pose, begin: Mapping[str, Value] | None, inputs: Mapping[str, float]) -> Pose:
        """Where the plant's own search ends: what is found is what a run would begin with.

        The pose itself where the plant has no search, finds nothing, or where something is to be held.

        Args:
            pose: from which it begins.
            begin: parameters that put a plant there, if they are known.
            inputs: in own units.
        """
        if not self._can_settle or self.hold or self.conditions is not None:
            return pose
        try:
            if begin is None:
                begin = self.settings(self.starts(pose, np.zeros(len(pose.unknowns))))
            return self._put(begin, inputs, "equilibrium")
        except AssemblyError:
            return pose

    def put(self, starts: Mapping[str, float], inputs: Mapping[str, float]) -> Pose:
        """Raises AssemblyError, or UsageError at a singular position."""
        return self._put(self.settings(starts), inputs)

    def _put(
        self, settings: Mapping[str, Value], inputs: Mapping[str, float], start: str = "as_given"
    ) -> Pose:
        self._plant.reset()
        self._plant.set_parameters({**settings, **({START: start} if self._can_settle else {})})
        self._plant.start(None, self.in_si(inputs))
        return pose_of(self._plant.derivatives(()), self.conditions)

    def settings(self, starts: Mapping[str, float]) -> dict[str, Value]:
        """What puts a plant there."""
        return {
            **self._settings,
            **{start_parameter(name): value for name, value in self.in_si(starts).items()},
        }

    def in_si(self, values: Mapping[str, float]) -> dict[str, float]:
        """Of inputs and outputs."""
        return {name: value * self._size(name) for name, value in values.items()}

    def turns(self, pose: Pose, step: Array) -> Array:
        """By what a step turns the joints [rad]."""
        angles = [n for n in pose.minimal.candidates if pose.minimal.unit(n) == "rad"]
        out: Array = pose.slopes(angles) @ step
        return out

    def share(self, turns: Array) -> float:
        """The part of a step that turns no joint by more than is good."""
        turn = float(np.abs(turns).max(initial=0.0))
        return min(1.0, FULL_ANGLE / turn) if turn else 1.0


def _turned(pose: Pose, joint: str, step: Array) -> dict[str, float]:
    """Q o exp(theta / 2), the quaternion after a turn about the frame's own axes."""
    theta = pose.slopes([f"{joint}.theta[{i}]" for i in (1, 2, 3)]) @ step
    names = [f"{joint}.Q[{i}]" for i in (1, 2, 3, 4)]
    Q = np.array([pose.found.values[name] for name in names])
    return dict(zip(names, map(float, turned(Q, theta)), strict=True))
