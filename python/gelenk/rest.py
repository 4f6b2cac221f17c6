# SPDX-License-Identifier: BSD-3-Clause
"""A plant put at rest in a pose, and the steps from one pose to the next that its loops allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gelenk.derivatives import Derivatives, Minimal
from gelenk.errors import UsageError
from gelenk.linearization import check_whole, start_parameter
from gelenk.mode_shapes import turned
from gelenk.plant import Plant
from gelenk.scene import Value, unknown

Array = NDArray[np.float64]

FULL_ANGLE = 0.3  # rad: what a step may turn a joint by, so that the branch is kept


@dataclass(frozen=True)
class Pose:
    """A plant at rest: accelerations v' and what they change by, dv' = A dq + B du.

    Attributes:
        found: all derivatives here.
        minimal: the same by independent coordinates.
        coordinates: the independent ones.
        accelerations: of the coordinates, shape (n,).
        A: shape (n, n).
        B: shape (n, inputs).
    """

    found: Derivatives
    minimal: Minimal
    coordinates: tuple[str, ...]
    accelerations: Array
    A: Array
    B: Array

    def slopes(self, names: Sequence[str]) -> Array:
        """Of readings or rotation coordinates, by the independent coordinates, shape (names, n)."""
        n = len(self.coordinates)
        return np.array([self.minimal.row(name)[:n] for name in names]).reshape(len(names), n)

    def accelerations_of(self, coordinates: Sequence[str]) -> Array:
        """Of other coordinates than those that are independent here."""
        return np.array([self.minimal.rate(self.minimal.speed(name))[2] for name in coordinates])

    def largest(self) -> tuple[str, float, str]:
        """The largest acceleration: what it is called, itself, its unit."""
        if not len(self.accelerations):
            return "", 0.0, ""
        i = int(np.abs(self.accelerations).argmax())
        speed = self.minimal.speed(self.coordinates[i])
        name = self.found.rates[speed]
        return name, float(self.accelerations[i]), self.found.units.get(name, "1")


def pose_of(found: Derivatives) -> Pose:
    """The point where these derivatives were taken, at rest."""
    minimal = Minimal(found)
    check_whole(minimal)
    q = tuple(name for name in minimal.names if minimal.is_coordinate(name))
    rates = [minimal.rate(minimal.speed(name)) for name in q]
    n = len(q)
    A = np.array([by_x[:n] for by_x, _, _ in rates]).reshape(n, n)
    B = np.array([by_u for _, by_u, _ in rates]).reshape(n, len(found.inputs))
    return Pose(found, minimal, q, np.array([a for _, _, a in rates]), A, B)


class Rest:
    """A plant that is put into poses by its own assembly: as near as the loops allow, all speeds zero."""

    def __init__(self, plant: Plant, settings: Mapping[str, Value], hold: Mapping[str, float]) -> None:
        """settings: parameters besides start values; hold: coordinates and the values to be kept."""
        self._plant = plant
        self.hold = dict(hold)
        known = set(plant.parameters)
        self._starts = [name for name in plant.outputs if start_parameter(name) in known]
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
        for name in [name for name in self.hold if name not in can]:
            if name in self._starts:
                faults.append(f"{name}: only a joint's coordinates can be held, one by one; no speeds, no Q")
            else:
                faults.append(unknown(name, "coordinate", can))
        if faults:
            raise UsageError("\n".join(faults))
        for name in self.hold:  # exact where the joint has no other coordinate
            joint = name.rpartition(".")[0]
            if [n for n in can if n.startswith(f"{joint}.")] == [name] and f"{joint}.fixed" in self._settings:
                self._settings[f"{joint}.fixed"] = True

    def starts(self, pose: Pose, step: Array) -> dict[str, float]:
        """Start values of all joints a step of the independent coordinates away, to first order."""
        out: dict[str, float] = {}
        for name in self._starts:
            joint, _, component = name.rpartition(".Q[")
            if joint and f"{joint}.theta[1]" in pose.minimal.candidates:
                if component == "1]":
                    out |= _turned(pose, joint, step)
            elif joint or pose.minimal.is_coordinate(name):
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
        self._plant.start(None, inputs)
        return pose_of(self._plant.derivatives(()))

    def settings(self, starts: Mapping[str, float]) -> dict[str, Value]:
        """What puts a plant there."""
        return {**self._settings, **{start_parameter(name): value for name, value in starts.items()}}

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
