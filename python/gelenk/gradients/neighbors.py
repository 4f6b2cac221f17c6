# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of the equations of a scene by its parameters, at given states."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import AssemblyError, SceneError, SceneWarning, UsageError
from gelenk.model.scene import Scene
from gelenk.simulation.derivatives import LOCKED_ROUNDING
from gelenk.simulation.simulation import Simulation

type Array = NDArray[np.float64]


@dataclass(frozen=True)
class Formula:
    """A difference formula of fourth order for the first derivative, and one of lower order.

    Source: B. Fornberg, Mathematics of Computation 51 (1988) 699, tables 1 and 3.

    Attributes:
        points: in steps from the value of the parameter.
        weights: of fourth order, per step.
        lower: weights of second (central) or third order.
    """

    points: tuple[int, ...]
    weights: tuple[float, ...]
    lower: tuple[float, ...]


CENTRAL = Formula((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12), (0, -1 / 2, 1 / 2, 0))
FORWARD = Formula(
    (0, 1, 2, 3, 4), (-25 / 12, 4, -3, 4 / 3, -1 / 4), (-11 / 6, 3, -3 / 2, 1 / 3, 0)
)  # fmt: skip
BACKWARD = Formula(
    tuple(-k for k in FORWARD.points), tuple(-w for w in FORWARD.weights), tuple(-w for w in FORWARD.lower)
)

# Of the two formulas relative to the derivative. The error of that of fourth order is about the square of
# it, so the step is chosen for 1e-12, as the masses, lengths and stiffnesses of a mechanism enter by low
# powers; along a run, where nothing is chosen, 1e-7 is accepted, relative to the largest derivative so far.
CHOSEN_DIFFERENCE, ACCEPTED_DIFFERENCE = 1e-6, 3e-4
FIRST_STEP, LAST_STEP = 4e-3, 1e-5  # relative to the value; rounding errors are 1e-15 divided by it
ROUNDING = 1e-13  # of rates and outputs, relative, with closed loops


@dataclass
class _Side:
    """The plants beside one value of a parameter."""

    formula: Formula
    step: float
    plants: list[Simulation]
    starts: Array  # their states at the start, shape (plants, states)

    def derivative(self, rows: Array) -> tuple[Array, Array]:
        return self._by(self.formula.weights, rows), self._by(self.formula.lower, rows)

    def _by(self, weights: Sequence[float], rows: Array) -> Array:
        return np.asarray(weights) @ rows / self.step


class Neighbors:
    """Plants with slightly different parameters, which are placed at the states of another one.

    The equations, not trajectories, are differentiated: by a formula of fourth order in the parameter, whose
    result is compared with that of another formula.
    """

    def __init__(
        self, scene: Scene, names: Sequence[str], leader: Simulation, outputs: Sequence[int]
    ) -> None:
        """Choose steps.

        Args:
            scene: the scene.
            names: its parameters.
            leader: the plant at its start.
            outputs: indices of outputs.

        Raises:
            UsageError: a parameter is not a real number, or the start is not differentiable by it.
        """
        self._names, self._outputs = tuple(names), list(outputs)
        self._leader = leader
        self._states: list[int] = leader._core._states()
        self._sides = [self._chosen(scene, name) for name in names]
        self._plants = [plant._core for side in self._sides for plant in side.plants]
        self._largest = np.zeros((len(self._states) + len(self._outputs), len(self._names)))
        labels = [name for name, side in zip(names, self._sides, strict=True) for _ in side.plants]
        self._labels = labels

    def start(self, movable: Array) -> Array:
        """Return the derivatives of the states at the start, shape (states, parameters).

        They contain those of the closed loops.

        Args:
            movable: changes of the states by their changes; none of a speed that friction, a limit or a lock
                keeps zero.

        Raises:
            UsageError: a parameter is such a speed. Another value would end by an impact or by friction.
        """
        found = np.empty((len(self._states), len(self._names)))
        held = np.abs(movable).max(axis=1, initial=0.0) <= LOCKED_ROUNDING
        for k, side in enumerate(self._sides):
            found[:, k] = side.derivative(side.starts)[0]
            for i in np.flatnonzero(held & (np.abs(found[:, k]) > LOCKED_ROUNDING)):
                speed = self._leader._signals[self._states[i]].name
                raise UsageError(
                    f"{self._names[k]}: it changes {speed}, which friction, a limit or a lock keeps zero at "
                    "the start, so that derivatives by it do not exist"
                )
        return found

    def derivatives(self, x: Array) -> tuple[Array, Array]:
        """Return the derivatives of the rates of the states, and of the outputs, at the leader's states x.

        Returns:
            tuple[NDArray, NDArray]: the derivatives, shape (states + outputs, parameters), and bounds on
            their rounding errors.

        Raises:
            UsageError: a plant cannot be placed there, or depends on its parameter abruptly.
        """
        found = np.zeros((len(x) + len(self._outputs), len(self._names)))
        noise = np.zeros_like(found)
        if not self._plants:
            return found, noise
        rows = _core.follow_all(self._plants, self._labels, self._leader._core, x.tolist(), self._outputs)
        first = 0
        for k, side in enumerate(self._sides):
            own = rows[first : first + len(side.plants)]
            fourth, lower = side.derivative(own)
            first += len(side.plants)
            largest = self._largest[:, k] = np.maximum(self._largest[:, k], np.abs(fourth))
            if difference(fourth, lower, own, side.step, largest) > ACCEPTED_DIFFERENCE:
                raise UsageError(
                    f"{self._names[k]}: at t = {self._leader.time:g} s the equations of motion depend on it "
                    "abruptly, so that derivatives by it are not known"
                )
            found[:, k] = fourth
            noise[:, k] = rounding(own, side.step)
        return found, noise

    def _chosen(self, scene: Scene, name: str) -> _Side:
        value = scene.parameters[name]
        if isinstance(value, bool | str | int) and not isinstance(value, float):
            raise UsageError(f"{name}: found {value!r}, expected a real number to differentiate by")
        size = abs(float(value)) or 1.0
        step = FIRST_STEP * size
        fault = ""
        while step >= LAST_STEP * size:
            for formula in (CENTRAL, FORWARD, BACKWARD):
                try:
                    plants = self._beside(scene, name, float(value), step, formula)
                    starts = np.array([plant._core.read_outputs(self._states) for plant in plants])
                    side = _Side(formula, step, plants, starts)
                    if self._is_smooth(name, side, size):
                        return side
                except (SceneError, AssemblyError, UsageError) as error:
                    fault = f": {error}"
                else:
                    break  # other points would not be smoother
            step /= 4
        raise UsageError(f"{name}: the start cannot be differentiated by it{fault}")

    def _beside(
        self, scene: Scene, name: str, value: float, step: float, formula: Formula
    ) -> list[Simulation]:
        found = []
        leader = self._leader._core
        for point in formula.points:
            with warnings.catch_warnings(action="ignore", category=SceneWarning):
                plant = Simulation(scene.with_parameters({name: value + point * step}))
            for i in range(len(plant.inputs)):
                plant._core.set_input(i, leader.input(i))
                for order in range(1, 6):
                    plant._core.set_input_derivative(i, order, leader.input_derivative(i, order))
            with scene.located():
                plant._core.assemble(0.0)
            plant._core._take_states(leader.independent_coordinates, leader.independent_speeds)
            found.append(plant)
        return found

    def _is_smooth(self, name: str, side: _Side, size: float) -> bool:
        x = self._leader._core.read_outputs(self._states)
        copies = [plant._core for plant in side.plants]
        labels = [name] * len(copies)
        rows = _core.follow_all(copies, labels, self._leader._core, x.tolist(), self._outputs)
        for table in (rows, side.starts):
            fourth, lower = side.derivative(table)
            # A derivative may be zero just here.
            sizes = 1e-3 * (np.abs(table).max(axis=0) / size + np.abs(fourth).max(initial=0.0))
            if difference(fourth, lower, table, side.step, sizes) > CHOSEN_DIFFERENCE:
                return False
        return True


def difference(fourth: Array, lower: Array, rows: Array, step: float, sizes: Array | float = 0.0) -> float:
    """Return the largest difference of two formulas beyond rounding errors, relative to the derivatives.

    Args:
        fourth: derivatives by the first formula.
        lower: by the other one.
        rows: what they have been computed from, shape (points, derivatives).
        step: between the points.
        sizes: of the derivatives elsewhere.
    """
    if not len(fourth):
        return 0.0
    noise = rounding(rows, step)
    apart = np.maximum(np.abs(fourth - lower) - 10 * noise, 0.0)
    return float((apart / (np.maximum(np.abs(fourth), sizes) + noise + 1e-300)).max())


def rounding(rows: Array, step: float) -> Array:
    """Return bounds on rounding errors of derivatives; small entries may be differences of larger ones."""
    sizes = np.abs(rows).max(axis=0)
    bounds: Array = ROUNDING * (sizes + 0.01 * sizes.max(initial=0.0)) / step
    return bounds
