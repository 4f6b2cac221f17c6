# SPDX-License-Identifier: BSD-3-Clause
"""The interface of plants, which scenes and FMUs implement."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import GelenkError, StepError, UsageError
from gelenk.model.scene import Scene, by_parameter
from gelenk.model.values import Value
from gelenk.simulation.derivatives import Derivatives, Quaternion
from gelenk.simulation.inputs import SampledInputs


class Plant(Protocol):
    """A plant that can be simulated and linearized; `start` brings it to t = 0.

    Attributes:
        name: name of the mechanism.
        stop: default end of a simulation [s].
        step: default communication step [s].
        inputs: names of the inputs.
        outputs: names of the outputs.
        parameters: names of the parameters.
        held: names of the inputs that cannot vary within a step.
        idle: names of inputs on which no requested output depends; they can be set, without effect.
        readings: names of the outputs, and of states and their derivatives that are not outputs.
        units: units of everything that can be selected, by name.
        assembly_report: what assembly has found; empty if unknown.
    """

    name: str
    stop: float
    step: float
    inputs: list[str]
    outputs: list[str]
    parameters: list[str]
    held: frozenset[str]
    idle: list[str]
    readings: list[str]
    units: dict[str, str]
    assembly_report: str

    @property
    def scene(self) -> Scene | None:
        """The scene that the plant is made of; None if unknown."""

    @property
    def events(self) -> list[tuple[float, str]]:
        """Times [s] and descriptions of the events in the last `advance`; empty if unknown."""

    @property
    def run_warnings(self) -> list[str]:
        """Why the run since `start` may not have kept its tolerance, a sentence each."""

    @property
    def quaternions(self) -> tuple[Quaternion, ...]:
        """The quaternions of joints; empty if unknown."""

    def by_parameter(self, settings: Mapping[str, Value]) -> dict[str, Value]:
        """Return settings with names of parameters in place of paths in the scene. Raises UsageError."""
        known = {*self.parameters, *self.inputs, *self.idle}
        scene = None if known.issuperset(settings) else self.scene
        return dict(settings) if scene is None else by_parameter(scene, settings)

    def set_parameters(self, settings: Mapping[str, Value]) -> None:
        """Set parameters before `start`. Raises UsageError or SceneError for invalid names and values."""

    def reset(self) -> None:
        """Restore the plant's own parameters and inputs; `start` may follow."""

    def start(
        self,
        tolerance: float | None,
        inputs: Mapping[str, float],
        input_derivatives: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        """Assemble the plant and make its state consistent at t = 0.

        Args:
            tolerance: relative tolerance of the integrator; None: the plant's own.
            inputs: values of inputs at t = 0.
            input_derivatives: their time derivatives of orders 1, 2, ...

        Raises:
            AssemblyError: the loops cannot be closed.
        """

    def select(self, names: list[str]) -> None:
        """Select the quantities that `read` returns. Raises UsageError if one cannot be read."""

    def set_input(self, name: str, value: float) -> None:
        """Set an input, which is held until it is set again. Raises UsageError."""

    def set_input_derivatives(self, name: str, derivatives: Sequence[float]) -> None:
        """Set the time derivatives of orders 1, 2, ... of an input in the next step. Raises UsageError."""

    def advance(self, start: float, end: float) -> None:
        """Advance from `start` to `end` [s]. Raises StepError."""

    def read(self) -> NDArray[np.float64]:
        """Return the present values of the selected quantities, shape (selected,)."""

    def record(
        self, times: NDArray[np.float64], inputs: SampledInputs, rows: NDArray[np.float64]
    ) -> tuple[int, list[tuple[float, str]], GelenkError | None]:
        """Advance over steps, and write what `read` returns after each of them.

        Args:
            times: start of the first step and ends of all steps [s], shape (steps + 1,).
            inputs: with a row for each step.
            rows: shape (steps, selected).

        Returns:
            int: number of completed steps; at least one, but maybe fewer than all, if there was no error.
            list: times [s] and descriptions of the events in them.
            GelenkError | None: why the next step failed.
        """
        found: list[tuple[float, str]] = []
        for k, (start, end) in enumerate(itertools.pairwise(times.tolist())):
            try:
                inputs.set(self, k)
                self.advance(start, end)
                found += self.events
                rows[k] = self.read()
            except (StepError, UsageError) as e:
                return k, found, e
        return len(rows), found, None

    def derivatives(self, coordinates: Sequence[str], friction: str = "present") -> Derivatives:
        """Return the derivatives of all readings at the present state, after `start`.

        Args:
            coordinates: used as states if derivatives with respect to the plant's own states do not exist.
            friction: what joints with dry friction do, see `gelenk.linearize`; of an FMU, "present".

        Raises:
            UsageError: the configuration is singular, or the plant provides no derivatives.
        """

    def close(self) -> None:
        """Release the plant's resources."""

    def __repr__(self) -> str:
        counts = ((len(self.inputs), "input"), (len(self.outputs), "output"))
        listed = ", ".join(f"{n} {what}{'' if n == 1 else 's'}" for n, what in counts)
        return f"<{type(self).__name__} {self.name}: {listed}>"
