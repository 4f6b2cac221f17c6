# SPDX-License-Identifier: BSD-3-Clause
"""Simulation: one running instance of a scene, stepped by hand."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import StartWarning, UsageError
from gelenk.model.scene import Source, load
from gelenk.model.values import unknown


class Simulation:
    """One running instance of a scene. Steps run without Python's lock: several may run in threads.

    >>> plant = gelenk.Simulation(four_bar)
    >>> plant.initialize()
    >>> plant.set_input("drive.tau", 3.0)     # N.m, held until it is set again
    >>> for k in range(100):
    ...     plant.step_to((k + 1) * 1e-3)
    >>> plant.output("A.w") > 0
    True
    """

    def __init__(self, scene: Source) -> None:
        """Compiles the scene (anything `gelenk.load` takes). Raises SceneError."""
        self.scene = load(scene)
        with self.scene.located():
            self._core = _core.Simulation(self.scene.pruned()._core)
        #: What can be set: tuple of signals with `.name`, `.unit`, `.description`.
        self.inputs = tuple(self._core.inputs)
        self._signals = tuple(self._core.outputs)  # those that are not wanted, too
        wanted = self._core.wanted
        #: What can be read, joints first, then sensors: tuple of signals.
        self.outputs = tuple(s for s, shown in zip(self._signals, wanted, strict=True) if shown)
        #: Health of the run: tuple of signals; their values are in `diagnostics`.
        self.diagnostic_signals = tuple(self._core.diagnostics)
        self._input = {s.name: i for i, s in enumerate(self.inputs)}
        self._diagnostic = {s.name: i for i, s in enumerate(self.diagnostic_signals)}
        self._output = {s.name: i for i, s in enumerate(self._signals) if wanted[i]}
        self._body = {name: i for i, name in enumerate(self._core.body_names)}

    def initialize(self, time: float = 0.0, tolerance: float = 0.0) -> None:
        """Closes the loops at the start values.

        Args:
            time: [s] at which the run starts.
            tolerance: relative tolerance of the integrator; 0: the scene's.

        Raises:
            AssemblyError: the loops cannot be closed.

        Warns:
            StartWarning: the start is a singular configuration, or beside one; or joint frames were moved
                within `assembly.tolerance`.
        """
        with self.scene.located():
            self._core.initialize(time, tolerance)
        for sentence in self._core.start_warnings():
            warnings.warn(sentence, StartWarning, stacklevel=2)

    def save(self) -> bytes:
        """All that decides how the run goes on: time, state, inputs, what methods carry from step to step.

        Methods with a history (ida, cvode, cvode-adams, dirk) begin anew here, in this run, too.
        """
        return self._core.save()

    def restore(self, saved: bytes) -> None:
        """Goes back to what `save` gave: from there the same calls give the same bits.

        Args:
            saved: by this instance, or another one of the same scene, initialized alike.

        Raises:
            UsageError: these are bytes of something else; the plant stays as it is.
        """
        self._core.restore(saved)

    def step_to(self, end: float) -> None:
        """Advances to `end` [s] under the inputs set now.

        Raises:
            StepError: the step cannot be made; the plant still stands at `time`.
            StepBudgetError: it has used up `solver.max_evaluations`; the plant stands at `time`, part of
                the way, and another step takes it on.
            UsageError: `end` lies before `time` or is not finite.
        """
        self._core.step_to(end)

    @property
    def time(self) -> float:
        """Where the plant stands [s]."""
        return self._core.time

    @property
    def size(self) -> _core.ModelSize:
        """Sizes: bodies, coordinates, speeds, rows, planar; rank and freedoms after `initialize`."""
        return self._core.size

    def set_input(self, name: str, value: float) -> None:
        """Sets an input, in its unit. Raises UsageError: no such name, or a value that is not finite."""
        self._core.set_input(self._index(name, "input", self._input), value)

    def input(self, name: str) -> float:
        """The present value of an input. Raises UsageError for an unknown name."""
        return self._core.input(self._index(name, "input", self._input))

    def set_input_derivative(self, name: str, order: int, value: float) -> None:
        """Sets a time derivative of an input at `time`, of order 1 to 5, in its unit per s^order.

        The next step follows the polynomial of the value and the derivatives, in whichever order they are
        set. After it the input is held at the value reached, unless new derivatives are set.

        Raises:
            UsageError: no such input, another order, a value that is not finite.
        """
        self._core.set_input_derivative(self._index(name, "input", self._input), order, value)

    def input_derivative(self, name: str, order: int) -> float:
        """A time derivative of this order of an input, as set, at `time`.

        Raises:
            UsageError: no such input, an order other than 1 to 5.
        """
        return self._core.input_derivative(self._index(name, "input", self._input), order)

    def output(self, name: str) -> float:
        """The present value of an output. Raises UsageError for an unknown name."""
        return float(self._core.read_outputs([self._index(name, "output", self._output)])[0])

    def values(self, names: Iterable[str] | None = None) -> NDArray[np.float64]:
        """The present values of these outputs, of all when None: shape (number of names,).

        Raises:
            UsageError: a name that does not exist.
        """
        if names is None:
            return self._core.read_outputs(list(self._output.values()))
        return self._core.read_outputs([self._index(name, "output", self._output) for name in names])

    def pose(self, body: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """A body's frame in the world: rotation matrix, shape (3, 3), and position [m], shape (3,).

        Raises:
            UsageError: no such body, or before `initialize`.
        """
        numbers = self._core.body_pose(self._index(body, "body", self._body))
        return numbers[:9].reshape(3, 3), numbers[9:]

    def diagnostic(self, name: str) -> float:
        """One of `diagnostics`, read alone. Raises UsageError for an unknown name."""
        return self._core.diagnostic(self._index(name, "diagnostic", self._diagnostic))

    @property
    def diagnostics(self) -> dict[str, float]:
        """Health of the run by name: constraint errors, energies, counts of the integrator."""
        return {s.name: self._core.diagnostic(i) for i, s in enumerate(self.diagnostic_signals)}

    @property
    def events(self) -> list[tuple[float, str]]:
        """Of the last `step_to`, in order: times [s] and what happened there, in words.

        A stop was met or left, or a singular position passed.
        """
        return self._core.events

    @property
    def independent_coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates that make up a minimal set of states; known after `initialize`."""
        return tuple(self._signals[i].name for i in self._core.independent_coordinates)

    @property
    def independent_speeds(self) -> tuple[str, ...]:
        """Names of the speeds beside them: fewer, where wheels roll; known after `initialize`."""
        return tuple(self._signals[i].name for i in self._core.independent_speeds)

    def assembly_report(self) -> str:
        """What assembly found, in words: the branch and what it changed."""
        return self._core.assembly_report()

    @staticmethod
    def _index(name: str, what: str, known: dict[str, int]) -> int:
        if name not in known:
            raise UsageError(unknown(name, what, known))
        return known[name]
