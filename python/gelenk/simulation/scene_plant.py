# SPDX-License-Identifier: BSD-3-Clause
"""Scenes as plants that `gelenk.simulate` can run, without an FMU."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import override

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import GelenkError, StepBudgetError, StepError, UsageError
from gelenk.model.scales import Scales
from gelenk.model.scene import Scene, by_parameter
from gelenk.model.values import Value
from gelenk.simulation.derivatives import Derivatives, Quaternion, quaternions_of, rates_of
from gelenk.simulation.inputs import SampledInputs
from gelenk.simulation.plant import Plant
from gelenk.simulation.simulation import Simulation

LONGEST_CALL = 0.1  # s; longer ones could not be interrupted from the keyboard
_ERRORS = {error.__name__: error for error in (StepBudgetError, StepError, UsageError)}


type RestPoint = tuple[str, str, str, list[float], list[float], float, float, float]


class ScenePlant(Plant):
    """A scene as a plant; see `gelenk.simulation.plant.Plant`."""

    def __init__(self, scene: Scene) -> None:
        self._whole = scene
        self._scene = scene.pruned()
        self._simulation = Simulation(self._scene)
        self.name = scene.name
        self.stop, self.step = scene.stop, scene.step
        self.inputs = [s.name for s in self._simulation.inputs]
        self.outputs = [s.name for s in self._simulation.outputs]
        self.readings = [s.name for s in self._simulation._signals]
        self.held: frozenset[str] = frozenset()
        self.idle = scene.inputs_beyond(self.inputs)
        diagnostics = self._simulation.diagnostic_signals
        signals = (*self._simulation._signals, *diagnostics, *self._simulation.inputs)
        self._units = {s.name: s.unit for s in signals}
        self.units = {name: self._units[name] for name in (*self.outputs, *(s.name for s in diagnostics))}
        self.parameters = list(scene.parameters)
        self.assembly_report = ""
        self._scales = Scales(*scene._core.scales)
        self._readings: list[str] = []
        self._selection: list[str] = []
        self._diagnostics: list[tuple[int, str]] = []

    @property
    @override
    def scene(self) -> Scene:
        return self._scene

    @property
    @override
    def events(self) -> list[tuple[float, str]]:
        return self._simulation.events

    @property
    @override
    def run_warnings(self) -> list[str]:
        return self._simulation._core.run_warnings()

    @property
    @override
    def quaternions(self) -> tuple[Quaternion, ...]:
        return quaternions_of(self._scene)

    @override
    def by_parameter(self, settings: Mapping[str, Value]) -> dict[str, Value]:
        return by_parameter(self._whole, settings)

    @override
    def set_parameters(self, settings: Mapping[str, Value]) -> None:
        kept = self._scene.parameters if self._scene is not self._whole else settings
        if any(name not in kept for name in settings):
            self._whole.with_parameters(settings)  # raises UsageError or SceneError
        self._simulation = Simulation(
            self._scene.with_parameters({name: value for name, value in settings.items() if name in kept})
        )

    @override
    def reset(self) -> None:
        self._simulation = Simulation(self._scene)

    @override
    def start(
        self,
        tolerance: float | None,
        inputs: Mapping[str, float],
        input_derivatives: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        for name, value in inputs.items():
            self.set_input(name, value)
        for name, derivatives in (input_derivatives or {}).items():
            self.set_input_derivatives(name, derivatives)
        self._simulation.initialize(0.0, tolerance or 0.0)
        self.assembly_report = self._simulation.assembly_report()

    @override
    def select(self, names: list[str]) -> None:
        outputs = set(self.outputs)
        self._readings = list(names)
        self._selection = [name for name in names if name in outputs]
        self._diagnostics = [(i, name) for i, name in enumerate(names) if name not in outputs]

    @override
    def set_input(self, name: str, value: float) -> None:
        if name not in self.idle:
            self._simulation.set_input(name, value)

    @override
    def set_input_derivatives(self, name: str, derivatives: Sequence[float]) -> None:
        for order, value in enumerate(derivatives if name not in self.idle else (), 1):
            self._simulation.set_input_derivative(name, order, value)

    @override
    def advance(self, start: float, end: float) -> None:
        self._simulation.step_to(end)

    @override
    def read(self) -> NDArray[np.float64]:
        values = self._simulation.values(self._selection)
        if not self._diagnostics:
            return values
        places = [i - k for k, (i, _) in enumerate(self._diagnostics)]
        return np.insert(values, places, [self._simulation.diagnostic(name) for _, name in self._diagnostics])

    @override
    def record(
        self, times: NDArray[np.float64], inputs: SampledInputs, rows: NDArray[np.float64]
    ) -> tuple[int, list[tuple[float, str]], GelenkError | None]:
        known = [name for name in (*inputs.held, *inputs.motions) if name in self.idle]
        if known:  # their columns have no effect
            return super().record(times, inputs, rows)
        plant = self._simulation
        channels = plant.channels(inputs.held, inputs.motions, self._readings)
        steps, events, kind, text = plant._core.record(channels, times, inputs.table, rows, LONGEST_CALL)
        return steps, events, _ERRORS[kind](text) if kind else None

    @override
    def derivatives(self, coordinates: Sequence[str], friction: str = "present") -> Derivatives:
        plant = self._simulation
        output = {s.name: i for i, s in enumerate(plant._signals)}
        rates = self.rates
        try:
            found = plant._core._linearize(friction)
        except UsageError:  # a dead center for the plant's own states, maybe not for the requested ones
            taken = [output[name] for name in coordinates if name in output]
            speeds = [output[rates[name]] for name in coordinates if name in rates]
            if not taken:
                raise
            plant._core._take_states(taken, speeds)
            found = plant._core._linearize(friction)
        _, _, C, D, _, locked = found
        states = self.states
        ny = len(self.readings)
        return Derivatives(
            tuple(states), tuple(self.inputs), tuple(self.outputs), tuple(self.readings),
            C.reshape((len(states), ny)).T, D.reshape((len(self.inputs), ny)).T,
            self.values | self.input_values, rates, self.quaternions,
            tuple(self.readings[i] for i in locked), self._units,
            plant.size.states, self._scales,
        )  # fmt: skip

    @property
    def rates(self) -> dict[str, str]:
        """Names of readings, and of the readings that are their time derivatives."""
        return rates_of(self._simulation._signals)

    @property
    def values(self) -> dict[str, float]:
        """The present values of all readings."""
        found = self._simulation._core.read_outputs(range(len(self.readings)))
        return dict(zip(self.readings, found.tolist(), strict=True))

    @property
    def input_values(self) -> dict[str, float]:
        """The present values of the inputs."""
        return {name: self._simulation.input(name) for name in self.inputs}

    def unit(self, name: str) -> str:
        """Return the unit of a reading."""
        return self._units.get(name, "1")

    def size(self, name: str) -> float:
        """Return the value of 1 of the mechanism's own units of a reading, in SI units."""
        return self._scales.size(self.unit(name))

    @property
    def states(self) -> list[str]:
        """Names of the readings that are the states."""
        return [self.readings[i] for i in self._simulation._core._states()]

    def trim(
        self,
        hold: Mapping[str, float],
        solve_for: Sequence[str],
        steady: bool,
        accelerations: Sequence[str],
        only_approach: bool,
    ) -> tuple[str, int, bool, dict[str, float]]:
        """Search for an equilibrium or a steady motion from the present state, after `start`.

        Args:
            hold: readings of coordinates and, in steady motion, velocities, and their values.
            solve_for: inputs to determine.
            steady: whether only these accelerations have to vanish, and velocities are unknowns.
            accelerations: their readings.
            only_approach: whether to hold the values without regard to accelerations.

        Returns:
            How it ended: "found", with the plant in the state and under the inputs found, or
            "not_converged", "none_near", "unreachable" (the values to hold); the number of steps; whether
            prescribed motions may act; and the accelerations that remain, by reading.

        Raises:
            UsageError: derivatives do not exist.
        """
        place = {name: i for i, name in enumerate(self.readings)}
        end, steps, is_driven, residual = self._simulation._core._trim(
            [(place[name], value) for name, value in hold.items()],
            [(self.inputs.index(name), self.size(name)) for name in solve_for],
            steady, [place[name] for name in accelerations], only_approach,
        )  # fmt: skip
        return end, steps, is_driven, {self.readings[i]: value for i, value in residual}

    def rest_forces(
        self,
    ) -> tuple[list[tuple[str, str, float, float, int]], bool, bool, list[RestPoint], bool, str]:
        """Return what dry friction, hard limits and contacts have to do to keep the present pose at rest.

        Returns:
            Of each coordinate with friction or a limit its name, the unit of its forces, the force along it,
            the largest static friction, and the bound that it touches: 1 for the upper, -1 for the lower one;
            whether nothing accelerates under these forces; and whether friction and contact can exert them.
            Of each point at which shapes touch the names of its contact and of the bodies, its position, the
            force on the first one, its normal part, its friction and the largest friction; whether no point
            has to pull; and a contact that is closed without such points, or "".
        """
        return self._simulation._core._rest_forces()

    @override
    def close(self) -> None:
        pass
