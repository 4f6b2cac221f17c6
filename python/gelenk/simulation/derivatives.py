# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of a plant at an operating point with respect to its declared states and inputs."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.model.scales import Scales
from gelenk.model.scene import Scene
from gelenk.model.values import elements

Array = NDArray[np.float64]

# Of the change of a velocity by itself where friction, a limit or a lock permits none.
LOCKED_ROUNDING = 1e-10


@dataclass(frozen=True)
class Quaternion:
    """The quaternion of a joint.

    Attributes:
        joint: name of the joint.
        Q: names of its four components.
        w: names of the three components of its angular velocity.
    """

    joint: str
    Q: Sequence[str]
    w: Sequence[str]

    @property
    def theta(self) -> list[str]:
        """Names of the three rotation coordinates that replace it in minimal states."""
        return elements(f"{self.joint}.theta", 3)


def quaternions_of(scene: Scene) -> tuple[Quaternion, ...]:
    """Return the quaternions of the joints of a scene."""
    return tuple(Quaternion(*of) for of in _core.quaternions(scene._core))


def rates_of(signals: Sequence[_core.Signal]) -> dict[str, str]:
    """Return the outputs that have time derivatives among the outputs of a scene, and these, by name."""
    return {s.name: signals[s.derivative].name for s in signals if s.derivative >= 0}


@dataclass(frozen=True)
class Derivatives:
    """Exact derivatives of all readings: dy = C dx + D du.

    Attributes:
        states: names of x, as the plant declares them.
        inputs: names of u.
        outputs: those of `readings` that are outputs.
        readings: names of y, which include the states and, except for quaternions, their derivatives.
        C: derivatives with respect to the states, shape (readings, states).
        D: derivatives with respect to the inputs, shape (readings, inputs).
        values: values of inputs and readings at the operating point.
        rates: name of a reading -> name of the reading that is its time derivative.
        quaternions: quaternions of joints; not all of their components need be readings.
        locked: coordinates among the states that friction, a limit or a lock keeps at rest; no quaternions.
        units: units of inputs and readings.
        order: minimal number of states of the mechanism; None if unknown.
        scales: the mechanism's own units.
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    readings: tuple[str, ...]
    C: Array
    D: Array
    values: Mapping[str, float]
    rates: Mapping[str, str]
    quaternions: tuple[Quaternion, ...]
    locked: tuple[str, ...]
    units: Mapping[str, str]
    order: int | None = None
    scales: Scales = field(default_factory=Scales)

    def size(self, name: str) -> float:
        """Return the SI value of 1 own unit of an input or reading."""
        return self.scales.size(self.units.get(name, "1"))

    def undetermined_outputs(self) -> frozenset[str]:
        """Return the outputs without derivatives: forces that hold the joints of a loop redundantly."""
        rows = np.isnan(self.C).any(axis=1) | np.isnan(self.D).any(axis=1)
        return frozenset(name for name, row in zip(self.readings, rows, strict=True) if row)

    def without(self, outputs: Collection[str]) -> Derivatives:
        """Return the same without some of the outputs."""
        kept = [i for i, name in enumerate(self.readings) if name not in outputs]
        return replace(
            self, outputs=tuple(name for name in self.outputs if name not in outputs),
            readings=tuple(self.readings[i] for i in kept), C=self.C[kept], D=self.D[kept],
        )  # fmt: skip

    def in_own_units(self) -> Derivatives:
        """Convert derivatives and values to the mechanism's own units; `units` and `scales` are unchanged."""
        y, x, u = (
            np.array([self.size(name) for name in names])
            for names in (self.readings, self.states, self.inputs)
        )
        values = {name: value / self.size(name) for name, value in self.values.items()}
        return replace(self, C=self.C * x / y[:, None], D=self.D * u / y[:, None], values=values)
