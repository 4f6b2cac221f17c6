# SPDX-License-Identifier: BSD-3-Clause
"""A plant put at rest in a pose, and the steps from one pose to the next that its loops allow."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.linear.minimal import Minimal, check_whole
from gelenk.linear.model import standing
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
    the independent coordinates; in steady motion these and the independent speeds, of which there may be
    fewer.

    Attributes:
        found: all derivatives here.
        minimal: the same by independent states.
        unknowns: the names of x.
        conditions: speeds, whose accelerations have to vanish.
        accelerations: theirs, shape (conditions,).
        A: shape (conditions, unknowns).
        B: shape (conditions, inputs).
    """

    found: Derivatives
    minimal: Minimal
    unknowns: tuple[str, ...]
    conditions: tuple[str, ...]
    accelerations: Array
    A: Array
    B: Array

    def slopes(self, names: Sequence[str]) -> Array:
        """Of readings or rotation coordinates, by the unknowns, shape (names, unknowns)."""
        n = len(self.unknowns)
        return np.array([self.minimal.row(name)[:n] for name in names]).reshape(len(names), n)

    def accelerations_of(self, speeds: Sequence[str]) -> Array:
        """Of other speeds than those of the conditions here."""
        return np.array([self.minimal.rate(name)[2] for name in speeds])

    @property
    def stands(self) -> bool:
        """Whether the accelerations vanish, to rounding of the terms they are sums of."""
        return bool((np.abs(self.accelerations) <= standing(self.A, self.sizes)).all())

    @property
    def residual(self) -> float:
        """The largest acceleration in SI units."""
        sizes = [self.found.size(self.found.rates[name]) for name in self.conditions]
        return float(np.abs(self.accelerations * sizes).max(initial=0.0))

    def largest(self) -> tuple[str, float, str]:
        """The largest acceleration: what it is called, itself, its unit in SI."""
        if not len(self.accelerations):
            return "", 0.0, ""
        i = int(np.abs(self.accelerations).argmax())
        name = self.found.rates[self.conditions[i]]
        return name, float(self.accelerations[i]), self.found.units.get(name, "1")

    def in_si(self, name: str, value: float) -> float:
        """What an input or a reading is called to users."""
        return value * self.found.size(name)

    @property
    def sizes(self) -> Array:
        """Of the unknowns: 1 rad or the mechanism's length, speeds by themselves."""
        return np.array(
            [1.0 if self.minimal.is_coordinate(n) else 1 + abs(self.minimal.value(n)) for n in self.unknowns]
        )

    @property
    def ways(self) -> Array:
        """How the coordinates go with the independent speeds: dq/dt = ways v, shape (coordinates, speeds)."""
        names = self.minimal.names
        n = sum(map(self.minimal.is_coordinate, names))
        return np.array([self.minimal.rate(q)[0][n:] for q in names[:n]]).reshape(n, len(names) - n)


def pose_of(found: Derivatives, conditions: Sequence[str] | None = None) -> Pose:
    """The point where these derivatives were taken: at rest, or in motion, where `conditions` are given."""
    found = found.in_own_units()
    minimal = Minimal(found)
    check_whole(minimal)
    n = len(minimal.names)
    if conditions is None:
        conditions = [name for name in minimal.names if not minimal.is_coordinate(name)]
        n -= len(conditions)
    rates = [minimal.rate(name) for name in conditions]
    A = np.array([by_x[:n] for by_x, _, _ in rates]).reshape(len(rates), n)
    B = np.array([by_u for _, by_u, _ in rates]).reshape(len(rates), len(found.inputs))
    return Pose(
        found, minimal, minimal.names[:n], tuple(conditions), np.array([a for _, _, a in rates]), A, B
    )


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

    def put(self, starts: Mapping[str, float], inputs: Mapping[str, float]) -> Pose:
        """Raises AssemblyError, or UsageError at a singular position."""
        self._plant.reset()
        self._plant.set_parameters(self.settings(starts))
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

    def share(self, pose: Pose, step: Array) -> float:
        """The part of a step that turns no joint by more than is good."""
        angles = [n for n in pose.minimal.candidates if pose.minimal.unit(n) == "rad"]
        turn = float(np.abs(pose.slopes(angles) @ step).max(initial=0.0))
        return min(1.0, FULL_ANGLE / turn) if turn else 1.0


def _turned(pose: Pose, joint: str, step: Array) -> dict[str, float]:
    """Q o exp(theta / 2), the quaternion after a turn about the frame's own axes."""
    theta = pose.slopes([f"{joint}.theta[{i}]" for i in (1, 2, 3)]) @ step
    names = [f"{joint}.Q[{i}]" for i in (1, 2, 3, 4)]
    Q = np.array([pose.found.values[name] for name in names])
    return dict(zip(names, map(float, turned(Q, theta)), strict=True))
