# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of runs through events: the saltation matrix, with what surrounds it for a short time."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import AssemblyError, SceneError, StepError, UsageError
from gelenk.gradients.neighbors import CENTRAL, difference, rounding
from gelenk.model.scene import Scene
from gelenk.simulation.simulation import Simulation

type Array = NDArray[np.float64]

# Lengths of the window around an event that are tried, relative to the communication step.
WINDOWS = (0.1, 0.01, 1e-3, 1e-4)
# Steps of rk4 in a window.
STEPS = 8
# Displacements of states, inputs and parameters, relative to their sizes, and the factor between those tried.
FIRST_DISPLACEMENT, LAST_DISPLACEMENT, SMALLER = 1e-3, 1e-13, 1 / 8
# Of two formulas, relative: the error of that of fourth order is about the square of it.
ACCEPTED_DIFFERENCE = 1e-5
# Rounding errors relative to the derivatives, by a bound that is some hundred times what was found.
ACCEPTED_ROUNDING = 1e-6
# Of the projection onto the displacements that what is held permits; the others are at least 1.
RANK = 1e-6
# Events beyond which no derivatives exist, or more than one motion.
OTHER_EVENTS = (
    "neighboring runs have other events; it grazes, or coincides with another one or the end of a step"
)
DOUBTFUL = ("singular configuration", "more than one motion", "motion afterwards are uncertain")


class NotPassed(Exception):  # noqa: N818
    """A window is not suited; the text says why."""


@dataclass(frozen=True)
class Window:
    """The time around an event, with one plant at its start.

    Attributes:
        leader: the plant at the start of the window.
        x: its states.
        sizes: of the states.
        movable: derivatives of the states by themselves: the unit matrix, unless something is kept at rest.
        end: of the window [s].
        step: its length [s].
        events: what happens in it.
    """

    leader: Simulation
    x: Array
    sizes: Array
    movable: Array
    end: float
    step: float
    events: tuple[str, ...]


class Saltation:
    """Differentiates the motion from shortly before an event to shortly after it.

    The motion across an event is smooth in states, inputs and parameters as long as the same events follow
    each other. A formula of fourth order is applied to runs from displaced states, in the modes of the
    leader. Its result is the saltation matrix (Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth
    Mechanical Systems, 2004) together with the motion in the window. Runs with other events, a result that
    depends on the displacement, and one lost in rounding are refused.
    """

    def __init__(self, scene: Scene, names: Sequence[str], inputs: Sequence[int], leader: Simulation) -> None:
        """Prepare.

        Args:
            scene: the scene.
            names: its parameters to differentiate by.
            inputs: indices of the inputs; -1: one that acts on nothing that is computed.
            leader: the plant of the run.
        """
        changes: dict[str, bool | int | float | str] = {"solver.integrator": "rk4"}
        if scene.parameters["solver.formulation"] in ("index3", "stabilized-index2"):  # not with rk4
            changes["solver.formulation"] = "projection"
        self._scene = scene.with_parameters(changes)
        self._names, self._inputs = tuple(names), tuple(inputs)
        self._states: list[int] = leader._core._states()
        self._chosen = leader._core.independent_coordinates, leader._core.independent_speeds
        self._displacements = [FIRST_DISPLACEMENT] * len(names)

    def matrix(self, window: Window) -> Array:
        """Return the derivatives of the states at the end by those at the start, inputs and parameters.

        Args:
            window: where.

        Raises:
            NotPassed: they cannot be determined in this window.
        """
        fine = self._scene.with_parameters({"solver.step": window.step / STEPS})
        plant = self._plant(fine, {})
        if self._run(window, plant, window.x) != window.events:
            raise NotPassed("a repetition has other events")
        undisplaced = plant._core.read_outputs(self._states)
        directions = _directions(window)
        columns = []
        for direction in directions.T:

            def displaced(by: float, along: Array = direction) -> Array:
                return self._end(window, plant, window.x + by * along)

            columns.append(self._column(displaced, undisplaced, window, FIRST_DISPLACEMENT, 1.0)[0])
        by_states = np.array(columns).reshape(-1, len(window.x)).T
        by_states = by_states @ np.linalg.pinv(directions) @ window.movable
        others = [self._by_input(window, plant, undisplaced, i) for i in self._inputs]
        others += [self._by_parameter(window, fine, undisplaced, k) for k in range(len(self._names))]
        return np.hstack([by_states, np.array(others).reshape(-1, len(window.x)).T])

    def _by_input(self, window: Window, plant: Simulation, undisplaced: Array, index: int) -> Array:
        if index < 0:
            return np.zeros(len(window.x))
        value = window.leader._core.input(index)

        def displaced(by: float) -> Array:
            return self._end(window, plant, window.x, (index, value + by))

        size = max(abs(value), 1.0)
        return self._column(displaced, undisplaced, window, size * FIRST_DISPLACEMENT, size)[0]

    def _by_parameter(self, window: Window, fine: Scene, undisplaced: Array, k: int) -> Array:
        name = self._names[k]
        value = float(fine.parameters[name])
        size = abs(value) or 1.0

        def displaced(by: float) -> Array:
            return self._end(window, self._plant(fine, {name: value + by}), window.x)

        found, used = self._column(displaced, undisplaced, window, size * self._displacements[k], size)
        self._displacements[k] = used / size  # where the next event begins
        return found

    def _plant(self, scene: Scene, changes: dict[str, float]) -> Simulation:
        try:
            with warnings.catch_warnings(action="ignore"):
                plant = Simulation(scene.with_parameters(changes) if changes else scene)
                plant.initialize()
        except (SceneError, AssemblyError, StepError, UsageError) as fault:
            raise NotPassed(str(fault)) from None
        plant._core._take_states(*self._chosen)
        return plant

    def _run(
        self, window: Window, plant: Simulation, x: Array, changed: tuple[int, float] | None = None
    ) -> tuple[str, ...]:
        """Make the run of a window from the states x; return its events."""
        try:
            plant._core.start_from(window.leader._core, x.tolist())
            if changed is not None:
                plant._core.set_input(*changed)
            plant.step_to(window.end)
        except (UsageError, StepError) as fault:
            raise NotPassed(str(fault)) from None
        return tuple(text for _, text in plant.events)

    def _end(
        self, window: Window, plant: Simulation, x: Array, changed: tuple[int, float] | None = None
    ) -> Array:
        if self._run(window, plant, x, changed) != window.events:
            raise NotPassed(OTHER_EVENTS)
        return plant._core.read_outputs(self._states)

    def _column(
        self,
        displaced: Callable[[float], Array],
        undisplaced: Array,
        window: Window,
        first: float,
        size: float,
    ) -> tuple[Array, float]:
        """Return the derivative of a function at 0, and the displacement with which it was found.

        Args:
            displaced: the function.
            undisplaced: its value at 0.
            window: where.
            first: the largest displacement.
            size: of its argument.
        """
        step, fault = first, ""
        while step >= LAST_DISPLACEMENT * size:
            try:
                rows = np.array([displaced(point * step) for point in CENTRAL.points])
            except NotPassed as error:
                fault = str(error)
                step *= SMALLER
                continue
            fourth = np.asarray(CENTRAL.weights) @ rows / step
            lower = np.asarray(CENTRAL.lower) @ rows / step
            # Zero for a polynomial of third degree; for a kink, the change of the derivative.
            kink = (np.array([1, -4, -4, 1]) @ rows + 6 * undisplaced) / (4 * step)
            least = np.maximum(
                1e-3 * window.sizes * np.abs(fourth / window.sizes).max(initial=0.0),
                0.1 * window.sizes / size,
            )
            noise = rounding(np.vstack([rows, window.sizes]), step)
            if (noise > ACCEPTED_ROUNDING * np.maximum(np.abs(fourth), least)).any():
                raise NotPassed(fault or "it is lost in rounding errors")
            apart = max(
                difference(fourth, lower, rows, step, least),
                difference(fourth, fourth + kink, rows, step, least),
            )
            if apart <= ACCEPTED_DIFFERENCE:
                return fourth, step
            fault = "it does not depend smoothly on what is differentiated by"
            step *= SMALLER
        raise NotPassed(fault)


def _directions(window: Window) -> Array:
    """Return independent displacements of the states, as columns, that what is kept at rest permits."""
    n = len(window.x)
    scaled = window.movable * window.sizes / window.sizes[:, None]
    if np.allclose(scaled, np.eye(n), atol=RANK):
        return np.diag(window.sizes)
    vectors, values, _ = np.linalg.svd(scaled)
    directions: Array = window.sizes[:, None] * vectors[:, values > RANK]
    return directions
