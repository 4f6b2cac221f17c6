# SPDX-License-Identifier: BSD-3-Clause
"""Scenes run with located events and in time steps, with all of their outputs at the same times."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from elements.scenes import with_sensors
from mechanisms import Array, Scene

import gelenk

GRID = 0.027  # s: no event of the cases is near one of its multiples, but for inputs that jump there
STEPS = (1e-3, 2.5e-4)  # s
SMALL = 1e-3  # errors of outputs that are smaller are relative to this
TOLERANCE = 1e-10  # of located events


@dataclass(frozen=True)
class Outputs:
    """All outputs of a run, and their units, by name."""

    values: dict[str, Array]
    units: dict[str, str]


@dataclass
class Case:
    """A scene and what happens to it.

    Args:
        source: the scene; without sensors of its own it has all kinds of sensors.
        stop: end of the run [s].
        inputs: by name, functions of time; held in each communication step.
        error: of steps of the larger size: part of the largest value of an output up to which it may err.
        tuned: by time [s], parameters that are changed there.
        small: by unit, values up to which errors are relative to them; SMALL for other units.
    """

    source: Scene
    stop: float
    inputs: Mapping[str, Callable[[float], float]] = field(default_factory=dict)
    error: float = 0.02
    tuned: Mapping[float, Mapping[str, Any]] = field(default_factory=dict)
    small: Mapping[str, float] = field(default_factory=dict)

    def scene(
        self, integrator: str, step: float, reductions: Mapping[str, bool] | None = None
    ) -> gelenk.Scene:
        """Return the scene with a solver and sensors."""
        source = self.source if "sensors" in self.source else with_sensors(self.source)
        parameters = sorted({name for values in self.tuned.values() for name in values})
        solver = {"integrator": integrator, "step": step, "reductions": dict(reductions or {})}
        return gelenk.load({**source, "solver": solver, **({"parameters": parameters} if parameters else {})})

    def times(self) -> list[float]:
        """Return the ends of the communication steps [s]."""
        return [GRID * k for k in range(1, round(self.stop / GRID) + 1)]


class Running:
    """A plant that is led through a case."""

    def __init__(
        self,
        case: Case,
        integrator: str,
        step: float,
        tolerance: float = TOLERANCE,
        reductions: Mapping[str, bool] | None = None,
    ) -> None:
        self.case = case
        self.original = self.scene = case.scene(integrator, step, reductions)
        self.plant = gelenk.Simulation(self.scene)
        for name, value in case.inputs.items():
            self.plant.set_input(name, value(0.0))
        self.plant.initialize(tolerance=tolerance)

    def advance(self, time: float) -> Array:
        """Make a communication step to a time [s] and return all outputs."""
        start = self.plant.time + 1e-9
        for name, value in self.case.inputs.items():
            self.plant.set_input(name, value(start))
        for when, values in self.case.tuned.items():
            if start - GRID < when <= start:
                self._tune(self.scene.with_parameters(values))
        self.plant.step_to(time)
        return self.plant.values()

    def _tune(self, scene: gelenk.Scene) -> None:
        self.scene = scene
        self.plant._core.tune(scene._core)

    def restore(self, saved: bytes, time: float) -> None:
        """Continue from a state that was saved at a time [s] of the case, with the parameters of then."""
        scene = self.original
        for when, values in self.case.tuned.items():
            if when < time - GRID / 2:
                scene = scene.with_parameters(values)
        if self.case.tuned:
            self._tune(scene)
        self.plant.restore(saved)


def run(case: Case, integrator: str, step: float, tolerance: float = TOLERANCE) -> Outputs:
    """Return all outputs at the times of the case."""
    running = Running(case, integrator, step, tolerance)
    rows = []
    for t in case.times():
        rows.append(running.advance(t))
        # What is to be located is not in steps.
        assert integrator == "moreau-jean" or not running.plant.diagnostics.get("solver.scheme", 0)
    units = {signal.name: signal.unit for signal in running.plant.outputs}
    return Outputs(dict(zip(units, np.array(rows).T, strict=True)), units)


def located(case: Case) -> Outputs:
    """Return all outputs of a run with located events."""
    return run(case, "auto", STEPS[0])


def deviations(case: Case, found: Outputs, exact: Outputs) -> dict[str, float]:
    """By output, its largest deviation, relative to its largest value."""
    assert found.units == exact.units
    out = {}
    for name, values in exact.values.items():
        size = max(case.small.get(exact.units[name], SMALL), float(np.abs(values).max()))
        difference = found.values[name] - values
        if name.startswith("euler_angles"):  # pi and -pi are the same
            difference = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        out[name] = float(np.abs(difference).max()) / size
    return out


def errors_of_steps(case: Case) -> Iterator[tuple[float, dict[str, float]]]:
    """Steps of each size [s], and the errors of all outputs."""
    exact = located(case)
    for step in STEPS:
        yield step, deviations(case, run(case, "moreau-jean", step), exact)


def assert_steps_converge(case: Case) -> None:
    """At first order: a quarter of the step, a quarter of the error."""
    found = {
        (output, step): error
        for step, errors in errors_of_steps(case)
        for output, error in errors.items()
        if not error <= case.error * step / STEPS[0]
    }
    assert not found
