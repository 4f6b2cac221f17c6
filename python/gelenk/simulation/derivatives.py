# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of a plant at a point, by its states as it declares them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gelenk.model.scales import Scales

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
