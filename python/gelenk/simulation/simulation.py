# SPDX-License-Identifier: BSD-3-Clause
"""Simulation of a scene in single steps."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import StartWarning, UsageError
from gelenk.model.scene import Scene, Source, load
from gelenk.model.values import unknown

type _Start = tuple[float, float, list[list[float]]]  # time, tolerance, inputs with their derivatives


class Simulation:
    """A running instance of a scene. Steps release the GIL, so that several instances can run in threads.

    >>> plant = gelenk.Simulation(four_bar)
    >>> plant.initialize()
    >>> plant.set_input("drive.tau", 3.0)     # N.m, held until it is set again
    >>> for k in range(100):
    ...     plant.step_to((k + 1) * 1e-3)
    >>> plant.output("A.w") > 0
    True
    """

    def __init__(self, scene: Source) -> None:
        """Compile a scene (anything `gelenk.load` accepts). Raises SceneError."""
        self.scene = load(scene)
        with self.scene.located():
            self._core = _core.Simulation(self.scene.pruned()._core)
        #: The inputs: tuple of signals with `.name`, `.unit`, `.description`.
        self.inputs = tuple(self._core.inputs)
        self._signals = tuple(self._core.outputs)  # including outputs that were not requested
        wanted = self._core.wanted
        #: The outputs, those of joints first, then those of sensors: tuple of signals.
        self.outputs = tuple(s for s, shown in zip(self._signals, wanted, strict=True) if shown)
        #: Diagnostics of the simulation: tuple of signals; `diagnostics` has their values.
        self.diagnostic_signals = tuple(self._core.diagnostics)
        self._input = {s.name: i for i, s in enumerate(self.inputs)}
        self._diagnostic = {s.name: i for i, s in enumerate(self.diagnostic_signals)}
        self._output = {s.name: i for i, s in enumerate(self._signals) if wanted[i]}
        self._start: _Start = (0.0, 0.0, [])
        self._runs = False
        #: Names of the bodies, in the order of the scene.
        self.body_names = tuple(self._core.body_names)
        self._body = {name: i for i, name in enumerate(self.body_names)}

    def initialize(self, time: float = 0.0, tolerance: float = 0.0) -> None:
        """Close the loops at the start values and initialize the integrators.

        Args:
            time: start time [s].
            tolerance: relative tolerance of the integrator; 0: the scene's.

        Raises:
            AssemblyError: the loops cannot be closed.

        Warns:
            StartWarning: the start is at or near a singular configuration, or joint frames were moved within
                `assembly.tolerance`.
        """
        self._start = (time, tolerance, self._input_values())
        with self.scene.located():
            self._core.initialize(time, tolerance)
        self._runs = True
        for sentence in self._core.start_warnings():
            warnings.warn(sentence, StartWarning, stacklevel=2)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the scene, how it was initialized, and the state: the copy continues identically."""
        if not self._runs:
            return _unpickled, (self.scene, (0.0, 0.0, self._input_values()), None)
        return _unpickled, (self.scene, self._start, self.save())

    def _input_values(self) -> list[list[float]]:
        """Return the value of each input and its derivatives of orders 1 to 5."""
        core, orders = self._core, range(1, 6)
        return [
            [core.input(i), *(core.input_derivative(i, order) for order in orders)]
            for i in range(len(self.inputs))
        ]

    def save(self) -> bytes:
        """Return everything that determines how the simulation continues, as bytes.

        Multistep methods (ida, cvode, cvode-adams) and dirk are reinitialized, so that this simulation and a
        restored one continue identically.
        """
        return self._core.save()

    def restore(self, saved: bytes) -> None:
        """Restore a state that `save` returned; the same calls then give bitwise identical results.

        Args:
            saved: bytes from this instance, or from another one of the same scene that was initialized
                equally.

        Raises:
            UsageError: the bytes are not a state of this scene; the simulation is unchanged.
        """
        self._core.restore(saved)

    def step_to(self, end: float) -> None:
        """Advance to the time `end` [s] with the present inputs.

        Raises:
            StepError: the step failed; the simulation remains at `time`.
            StepBudgetError: the step has exhausted `solver.max_evaluations`; the simulation is at `time`,
                before `end`, and can continue with the next step.
            UsageError: `end` is before `time` or not finite.
        """
        self._core.step_to(end)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing: a simulation holds nothing that has to be closed."""

    def __repr__(self) -> str:
        counts = {"input": len(self.inputs), "output": len(self.outputs)}
        sizes = ", ".join(f"{n} {what}{'' if n == 1 else 's'}" for what, n in counts.items())
        return f"<Simulation of {self.scene.name or 'a scene'} at t = {self.time:g} s: {sizes}>"

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self._core.time

    @property
    def size(self) -> _core.ModelSize:
        """Sizes of the model: numbers of bodies, coordinates, velocities, constraint equations, islands.

        The rank and the degrees of freedom are known after `initialize`.
        """
        return self._core.size

    def set_input(self, name: str, value: float) -> None:
        """Set an input, in its unit. Raises UsageError if the name is unknown or the value not finite."""
        self._core.set_input(self._index(name, "input", self._input), value)

    def input(self, name: str) -> float:
        """Return the present value of an input. Raises UsageError for an unknown name."""
        return self._core.input(self._index(name, "input", self._input))

    def set_input_derivative(self, name: str, order: int, value: float) -> None:
        """Set a time derivative of an input at `time`.

        In the next step the input follows the polynomial given by its value and derivatives, which can be set
        in any order. After this step it is held at the value reached, unless new derivatives are set.

        Args:
            name: name of the input.
            order: order of the derivative, 1 to 5.
            value: the derivative, in the input's unit per s^order.

        Raises:
            UsageError: the input is unknown, the order out of range, or the value not finite.
        """
        self._core.set_input_derivative(self._index(name, "input", self._input), order, value)

    def input_derivative(self, name: str, order: int) -> float:
        """Return a time derivative of an input at `time`, as it was set.

        Args:
            name: name of the input.
            order: order of the derivative, 1 to 5.

        Raises:
            UsageError: the input is unknown, or the order is out of range.
        """
        return self._core.input_derivative(self._index(name, "input", self._input), order)

    def output(self, name: str) -> float:
        """Return the present value of an output. Raises UsageError for an unknown name."""
        return float(self._core.read_outputs([self._index(name, "output", self._output)])[0])

    def values(self, names: Iterable[str] | None = None) -> NDArray[np.float64]:
        """Return the present values of outputs, shape (number of names,).

        Args:
            names: names of outputs; None: all.

        Raises:
            UsageError: a name is unknown.
        """
        if names is None:
            return self._core.read_outputs(list(self._output.values()))
        return self._core.read_outputs([self._index(name, "output", self._output) for name in names])

    def pose(self, body: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the pose of a body's frame in the world frame.

        Args:
            body: name of the body.

        Returns:
            tuple[NDArray, NDArray]: rotation matrix, shape (3, 3), and position [m], shape (3,).

        Raises:
            UsageError: the body is unknown, or `initialize` has not been called.
        """
        numbers = self._core.body_pose(self._index(body, "body", self._body))
        return numbers[:9].reshape(3, 3), numbers[9:]

    def channels(
        self,
        held: Iterable[str],
        motions: Iterable[str],
        readings: Iterable[str],
        constants: Iterable[tuple[str, float, bool]] = (),
    ) -> _core.Channels:
        """Return the inputs and readings of a run by their indices, for the compiled loop over its points.

        Args:
            held: inputs that are held in a step.
            motions: inputs that follow a polynomial in a step.
            readings: outputs and diagnostics.
            constants: further inputs, their values, and whether they are motions.

        Raises:
            UsageError: a name is unknown.
        """

        def inputs(names: Iterable[str]) -> list[int]:
            return [self._index(name, "input", self._input) for name in names]

        known = {name: -1 - i for name, i in self._diagnostic.items()} | self._output
        return _core.Channels(
            inputs(held),
            inputs(motions),
            [self._index(name, "output", known) for name in readings],
            [(self._index(name, "input", self._input), value, moves) for name, value, moves in constants],
        )

    def diagnostic(self, name: str) -> float:
        """Return the present value of a diagnostic. Raises UsageError for an unknown name."""
        return self._core.diagnostic(self._index(name, "diagnostic", self._diagnostic))

    @property
    def diagnostics(self) -> dict[str, float]:
        """Present values of all diagnostics: constraint errors, energies, counters of the integrator."""
        return {s.name: self._core.diagnostic(i) for i, s in enumerate(self.diagnostic_signals)}

    @property
    def events(self) -> list[tuple[float, str]]:
        """Times [s] and descriptions of the events in the last `step_to`, in order.

        Events are contacts with stops and releases from them, and singular configurations that are crossed.
        """
        return self._core.events

    @property
    def independent_coordinates(self) -> tuple[str, ...]:
        """Names of the independent coordinates, part of a minimal set of states; known after `initialize`."""
        return tuple(self._signals[i].name for i in self._core.independent_coordinates)

    @property
    def independent_speeds(self) -> tuple[str, ...]:
        """Names of the independent velocities; fewer than coordinates if wheels roll."""
        return tuple(self._signals[i].name for i in self._core.independent_speeds)

    def assembly_report(self) -> str:
        """Return what assembly has found: the coordinates and the changes of initial guesses."""
        return self._core.assembly_report()

    @staticmethod
    def _index(name: str, what: str, known: dict[str, int]) -> int:
        if name not in known:
            raise UsageError(unknown(name, what, known))
        return known[name]


def _unpickled(scene: Scene, start: _Start, saved: bytes | None) -> Simulation:
    plant = Simulation(scene)
    time, tolerance, inputs = start
    for i, (value, *derivatives) in enumerate(inputs):
        plant._core.set_input(i, value)
        for order, derivative in enumerate(derivatives, 1):
            plant._core.set_input_derivative(i, order, derivative)
    if saved is not None:
        with warnings.catch_warnings(action="ignore", category=StartWarning):  # already given
            plant.initialize(time, tolerance)
        plant.restore(saved)
    return plant
