# SPDX-License-Identifier: BSD-3-Clause
"""What a run needs of a plant, be it a scene or an FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gelenk.model.values import Value
from gelenk.simulation.derivatives import Derivatives


class Plant(Protocol):
    """A plant that stands at t = 0 once started."""

    name: str  # of the mechanism
    stop: float  # default end [s]
    step: float  # default communication step [s]
    inputs: list[str]
    outputs: list[str]
    parameters: list[str]
    idle: list[
        str
    ]  # inputs of what no wanted output depends on: they may be set, and act on nothing there is
    readings: list[str]  # outputs, and states and their derivatives that are none
    units: dict[str, str]  # of all that can be selected
    assembly_report: str

    @property
    def events(self) -> list[tuple[float, str]]:
        """Of the last advance(): times [s] and texts; empty where the plant does not tell."""

    def set_parameters(self, settings: Mapping[str, Value]) -> None:
        """Before start()."""

    def reset(self) -> None:
        """As if just opened: parameters and inputs are the plant's own again, and start() may follow."""

    def start(
        self,
        tolerance: float | None,
        inputs: Mapping[str, float],
        input_derivatives: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        """Makes everything consistent at t = 0. Raises AssemblyError."""

    def select(self, names: list[str]) -> None:
        """Chooses what read() gives."""

    def set_input(self, name: str, value: float) -> None:
        """Holds until set again. Raises UsageError."""

    def set_input_derivatives(self, name: str, derivatives: Sequence[float]) -> None:
        """Of orders 1, 2, ... over the next step [unit/s, ...]. Raises UsageError."""

    def advance(self, start: float, end: float) -> None:
        """Steps [s]. Raises StepError."""

    def read(self) -> NDArray[np.float64]:
        """The selected values now."""

    def derivatives(self, coordinates: Sequence[str]) -> Derivatives:
        """Here and now; once started. `coordinates` are states where the plant's own do not lead on.

        Raises:
            UsageError: a singular position, or a plant that gives no derivatives.
        """

    def close(self) -> None:
        """Frees what the plant holds."""
