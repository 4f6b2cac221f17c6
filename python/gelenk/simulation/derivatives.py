# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of a plant at an operating point with respect to its declared states and inputs."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gelenk.model.scales import Scales

Array = NDArray[np.float64]


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


def differentiated_name(name: str, description: str) -> str | None:
    """Return the name of the quantity of which an output is the time derivative, from its description.

    "A.w" with the description "A: angular velocity, der(phi)" is the derivative of "A.phi"; None if the
    description does not end so.
    """
    found = re.search(r"\bder\(([^()]+)\)$", description)
    owner = name.rpartition(".")[0]
    return f"{owner}.{found.group(1)}" if found and owner else None
