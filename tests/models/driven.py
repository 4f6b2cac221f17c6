# SPDX-License-Identifier: BSD-3-Clause
"""Prescribed motions as functions of time with derivatives, and plants whose inputs follow them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

import gelenk

Array = NDArray[np.float64]
# The value and its time derivatives at t [s].
Law = Callable[[float], Sequence[float]]

ORDERS = 5  # the maximum number of derivatives that an input accepts


def sine(amplitude: float, frequency: float, phase: float = 0.0, derived: int = 0) -> Law:
    """The function amplitude sin(2 pi frequency t + phase), or its derivative of the given order."""
    omega = 2 * math.pi * frequency

    def law(t: float) -> list[float]:
        return [
            amplitude * omega**k * math.sin(omega * t + phase + k * math.pi / 2)
            for k in range(derived, derived + ORDERS + 1)
        ]

    return law


def polynomial(coefficients: Sequence[float], derived: int = 0) -> Law:
    """The polynomial c0 + c1 t + c2 t^2 + ..., or its derivative of the given order."""
    p = np.polynomial.Polynomial(coefficients)
    derivatives = [p.deriv(k) if k else p for k in range(derived, derived + ORDERS + 1)]
    return lambda t: [float(d(t)) for d in derivatives]


def run(source: Mapping[str, Any], times: Iterable[float], tolerance: float) -> dict[str, Array]:
    """Return every output at the times, of which the first is the start time."""
    plant = gelenk.Simulation(gelenk.load(dict(source)))
    rows = []
    for k, t in enumerate(times):
        if k == 0:
            plant.initialize(float(t), tolerance)
        else:
            plant.step_to(float(t))
        rows.append(plant.values())
    return dict(zip((s.name for s in plant.outputs), np.array(rows).T, strict=True))


def follow(
    source: Mapping[str, Any],
    laws: Mapping[str, Law],
    steps: int,
    size: float,
    tolerance: float,
    orders: int = ORDERS,
) -> dict[str, Array]:
    """Return every output at the start and after each step of `size` [s],
    with inputs given with `orders` derivatives.
    """
    plant = gelenk.Simulation(gelenk.load(dict(source)))

    def give(t: float) -> None:
        for name, law in laws.items():
            value, *derivatives = law(t)
            plant.set_input(name, value)
            for order, d in enumerate(derivatives[:orders], 1):
                plant.set_input_derivative(name, order, d)

    give(0.0)
    plant.initialize(0.0, tolerance)
    rows = [plant.values()]
    for k in range(steps):
        give(k * size)
        plant.step_to((k + 1) * size)
        rows.append(plant.values())
    return dict(zip((s.name for s in plant.outputs), np.array(rows).T, strict=True))


class Slave:
    """An FMU instance in fmpy."""

    def __init__(self, fmu: Path, folder: Path) -> None:
        self.description = fmpy.read_model_description(str(fmu))
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmi: Any = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=fmpy.extract(str(fmu), unzipdir=str(folder)),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="plant",
        )
        self.fmi.instantiate()

    def start(self, tolerance: float, inputs: Mapping[str, Sequence[float]] | None = None) -> None:
        """Initialize; inputs are given as value and derivatives by name."""
        self.fmi.setupExperiment(tolerance=tolerance, startTime=0.0)
        self.fmi.enterInitializationMode()
        for name, law in (inputs or {}).items():
            self.give(name, law)
        self.fmi.exitInitializationMode()

    def set(self, name: str, value: float) -> None:
        self.fmi.setReal([self.reference[name]], [value])

    def give(self, name: str, law: Sequence[float]) -> None:
        """Set an input and its derivatives."""
        value, *derivatives = law
        self.set(name, value)
        self.fmi.setRealInputDerivatives(
            [self.reference[name]] * len(derivatives), list(range(1, len(derivatives) + 1)), derivatives
        )

    def get(self, *names: str) -> Array:
        return np.array(self.fmi.getReal([self.reference[name] for name in names]))

    def free(self) -> None:
        self.fmi.terminate()
        self.fmi.freeInstance()
