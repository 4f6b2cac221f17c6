# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives by finite differences between plants that are assembled
independently for each perturbed number.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import Scene
from numpy.typing import NDArray

import gelenk

Array = NDArray[np.float64]

# Central differences of fourth order, over x - 2 h .. x + 2 h.
CENTRAL = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
# First and second time derivatives of eighth order, over t - 4 h .. t + 4 h.
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


@dataclass(frozen=True)
class Linear:
    """C, D by output, A, B by state: columns are the states, the inputs; and the state derivatives."""

    states: list[str]
    A: Array
    B: Array
    C: Array
    D: Array
    xdot: Array


def linearized(plant: gelenk.Simulation) -> Linear:
    A, B, C, D, xdot, _ = plant._core._linearize()
    nx, nu, ny = len(xdot), len(plant.inputs), len(plant.outputs)

    def shaped(flat: Array, rows: int, columns: int) -> Array:
        return flat.reshape((columns, rows)).T

    return Linear(
        [plant.outputs[i].name for i in plant._core._states()],
        shaped(A, nx, nx),
        shaped(B, nx, nu),
        shaped(C, ny, nx),
        shaped(D, ny, nu),
        xdot,
    )


def output_derivatives(plant: gelenk.Simulation, udot: Any = (), uddot: Any = ()) -> Array:
    """First and second time derivatives of all outputs: shape (2, outputs)."""
    found: Array = plant._core._output_derivatives(list(udot), list(uddot)).reshape((2, -1))
    return found


class Assembler:
    """Assembles plants of a scene at states and inputs close to those of a running one."""

    def __init__(self, source: Scene, plant: gelenk.Simulation) -> None:
        self.source = source
        self.plant = plant
        self.states = [plant.outputs[i].name for i in plant._core._states()]
        self.values = dict(zip((s.name for s in plant.outputs), plant.values(), strict=True))
        self.inputs = {s.name: plant.input(s.name) for s in plant.inputs}

    def outputs(self, moved: Mapping[str, float]) -> Array:
        """All outputs with these states and inputs changed by the given amounts;
        quaternions are normalized afterwards.
        """
        scene = copy.deepcopy(self.source)
        for name, entry in scene["joints"].items():
            entry["start"] = self._start(name, moved)
        plant = gelenk.Simulation(scene)
        plant.initialize()
        for name, value in self.inputs.items():
            plant.set_input(name, value + moved.get(name, 0.0))
        return plant.values()

    def _start(self, joint: str, moved: Mapping[str, float]) -> dict[str, Any]:
        start: dict[str, Any] = {}
        fixed = []
        vectors: dict[str, list[float]] = {}
        for signal in self.plant.outputs:
            owner, _, quantity = signal.name.partition(".")
            if owner != joint or signal.level not in (0, 1):
                continue
            value = self.values[signal.name] + moved.get(signal.name, 0.0)
            bare = quantity.partition("[")[0]
            if bare != quantity:
                vectors.setdefault(bare, []).append(value)
            else:
                start[quantity] = value
            if signal.name in self.states and bare not in fixed:
                fixed.append(bare)
        if "Q" in vectors:
            vectors["Q"] = list(np.array(vectors["Q"]) / np.linalg.norm(vectors["Q"]))
        return start | vectors | ({"fixed": fixed} if fixed else {})

    def column(self, name: str, h: float) -> Array:
        """A column of the matrix d outputs / d states and inputs."""
        return sum((weight * self.outputs({name: k * h}) for k, weight in CENTRAL.items()), np.zeros(1)) / h


def in_time(run_to: Callable[[float], Array], t: float, h: float) -> Array:
    """First and second time derivatives by finite differences of outputs(t): shape (2, outputs)."""
    rows = np.array([run_to(t + k * h) for k in range(-4, 5)])
    return np.array([FIRST @ rows / h, SECOND @ rows / h**2])
