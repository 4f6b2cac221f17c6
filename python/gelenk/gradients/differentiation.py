# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of runs by parameters, start values and inputs."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import StartWarning, UsageError
from gelenk.gradients.collocation import NODES, Sample, advance, product, unit
from gelenk.gradients.neighbors import Neighbors
from gelenk.gradients.run import DifferentiatedRun
from gelenk.gradients.saltation import DOUBTFUL, WINDOWS, NotPassed, Saltation, Window
from gelenk.model.scene import Scene, Source, load
from gelenk.model.settable import with_listed
from gelenk.model.values import Value, check_names, unknown
from gelenk.simulation.inputs import InputFunction, Inputs, functions, in_step, is_motion, shifted, varies
from gelenk.simulation.run import expanded, grid
from gelenk.simulation.simulation import Simulation

type Array = NDArray[np.float64]

MOST_BISECTIONS = 40  # one after another, where there is a kink
MOST_PARTS = 1000  # of a communication step
# A step that was bisected this often contains a kink. If accelerations change in it by more than this part,
# they jump.
BISECTIONS_AT_KINK, LARGEST_CHANGE = 14, 1e-3
MOST_EVENTS = 1000  # of a communication step


class _Event(Exception):  # noqa: N818
    """There are events in a part of a step."""

    def __init__(self, events: list[tuple[float, str]]) -> None:
        super().__init__()
        self.time, self.text = events[0]


def sensitivity(
    scene: Source,
    by: Sequence[str],
    *,
    outputs: Sequence[str],
    parameters: Mapping[str, Value] | None = None,
    inputs: Inputs | None = None,
    stop: float | None = None,
    step: float | None = None,
    accuracy: float = 1e-9,
) -> DifferentiatedRun:
    """Simulate a scene together with the derivatives of its outputs by parameters, start values and inputs.

    The variational equations are integrated along the run, with the exact Jacobians of the equations of
    motion by states and inputs, through closed loops; those by parameters are found by a formula of fourth
    order at each state. At events, such as impacts at limits, the derivatives jump, as the saltation matrix
    says. The derivatives are those of the exact solution, so that the integrator should be as accurate as
    they have to be. Where a run is not differentiable, it is refused.

    Args:
        scene: anything `gelenk.load` accepts.
        by: names of parameters, start values ("A.phi_start"), numbers by their path in the file
            ("crank.com[1]"), and inputs that are not prescribed motions.
        outputs: names and patterns of the outputs.
        parameters: values that differ from those of the scene, by name.
        inputs: as in `gelenk.simulate`.
        stop: end of the run [s]; by default that of the scene.
        step: communication step [s]; inputs are held in it.
        accuracy: of the integration of the derivatives in each step, relative.

    Returns:
        DifferentiatedRun: values and derivatives; `gelenk.jvp` and `gelenk.vjp` use it.

    Raises:
        SceneError, AssemblyError, UsageError: the scene, a name or a value is invalid; or derivatives do not
            exist, because an event grazes, coincides with another one or with a communication point, or a
            singular position is passed, or accelerations jump without an event. The message says when.
        StepError: a step failed.

    >>> run = gelenk.sensitivity(four_bar, ["crank.m", "A.phi_start"], outputs=["D.phi"], stop=0.1)
    >>> run.derivative("D.phi", by="crank.m").shape
    (101,)
    """
    if not 0 < accuracy < 1:
        raise UsageError(f"accuracy: found {accuracy}, expected a number between 0 and 1")
    loaded = load(scene)
    loaded, renamed = with_listed(loaded, [*by, *(parameters or {})])
    if parameters:
        loaded = loaded.with_parameters({renamed.get(n, n): v for n, v in parameters.items()})
    return Differentiator(loaded, by, renamed, outputs, inputs, accuracy).run(
        grid(loaded.stop if stop is None else stop, loaded.step if step is None else step)
    )


class Differentiator:
    """Makes one differentiated run of a scene."""

    def __init__(
        self, scene: Scene, by: Sequence[str], renamed: Mapping[str, str], outputs: Sequence[str],
        inputs: Inputs | None, accuracy: float,
    ) -> None:  # fmt: skip
        """Start the run.

        Args:
            scene: with the values of all parameters.
            by: names of parameters and inputs.
            renamed: parameters by the names that were given for them.
            outputs: names and patterns.
            inputs: as in `gelenk.simulate`.
            accuracy: see `sensitivity`.

        Raises:
            SceneError, AssemblyError, UsageError: see `sensitivity`.
        """
        names = expanded(outputs, [s.name for s in Simulation(scene.with_outputs(None)).outputs])
        check_names(names, [s.name for s in Simulation(scene.with_outputs(None)).outputs], "output")
        scene = scene.with_outputs(names)
        self._accuracy = accuracy
        self._parts = 0
        self._plant = plant = Simulation(scene)
        self._given = tuple(by)
        self._signals: dict[str, InputFunction] = functions(inputs, [s.name for s in plant.inputs])
        known = [*scene.parameters, *(s.name for s in plant.inputs)]
        whole = [*known, *(s.name for s in Simulation(scene.with_outputs(None)).inputs)]
        faults = [
            unknown(name, "parameter or input", whole) for name in by if renamed.get(name, name) not in whole
        ]
        if faults:
            raise UsageError("\n".join(faults))
        inputs_by = [name for name in by if name not in renamed and name not in scene.parameters]
        self._check_inputs(scene, inputs_by)
        self._inputs = tuple(inputs_by)
        self._parameters = tuple(name for name in by if name not in inputs_by)
        self.outputs = tuple(names)
        self._moving: dict[
            str, tuple[float, float, Sequence[float]]
        ] = {}  # start of the step, value, derivatives
        self._set_inputs(0.0, self._plant.scene.step)
        with warnings.catch_warnings(action="ignore", category=StartWarning):
            plant.initialize()
        self._indices = [plant._output[name] for name in names]
        self._states: list[int] = plant._core._states()
        self._columns = [plant._input.get(name, -1) for name in inputs_by]
        self._largest, self._fastest = np.zeros((len(self._states), len(by))), np.zeros(len(self._states))
        self._whole = 0.0  # the communication step [s]
        given = [renamed.get(name, name) for name in self._parameters]
        self._neighbors = Neighbors(scene, given, plant, self._indices)
        self._saltation = Saltation(scene, given, self._columns, plant)

    def run(self, times: Array) -> DifferentiatedRun:
        """Simulate.

        Args:
            times: of the communication points [s].

        Raises:
            UsageError, StepError: see `sensitivity`.
        """
        m, units = len(self._inputs), {s.name: s.unit for s in self._plant.outputs}
        points: list[Sample] = []
        steps: list[Array] = []
        values = [self._values()]
        last: Sample | None = None
        for k in range(len(times) - 1):
            begin, end = float(times[k]), float(times[k + 1])
            fault: UsageError | None = None
            if self._set_inputs(begin, end) or last is None:
                try:
                    last = self._sample()
                except UsageError as error:  # unless the inputs change a mode just here
                    if last is None:
                        raise
                    fault = error
            if not points:
                points.append(last)
            self._whole = end - begin
            matrix, last = self._through_events(last, begin, end, fault)
            steps.append(matrix)
            points.append(last)
            values.append(self._values())
        if not points:
            points.append(self._sample())
        n = len(self._states)
        table = np.array(steps).reshape(len(steps), n, n + m + len(self._parameters))
        D = np.array([p.D for p in points])
        return DifferentiatedRun(
            times, self.outputs, self._inputs, self._parameters, np.array(values),
            {name: units[name] for name in self.outputs},
            table[:, :, :n], table[:, :, n : n + m], table[:, :, n + m :],
            np.array([p.C for p in points]), D[:, :, :m], D[:, :, m:],
            self._neighbors.start(points[0].movable),
        )  # fmt: skip

    def _values(self) -> Array:
        return self._plant._core.read_outputs(self._indices)

    def _check_inputs(self, scene: Scene, names: Sequence[str]) -> None:
        for name in names:
            if is_motion(name):
                raise UsageError(
                    f"{name}: it prescribes a motion, by which derivatives are not available; differentiate "
                    "by parameters of the motion, such as start values"
                )
        if names and scene.parameters["solver.start"] == "equilibrium":
            raise UsageError(
                f"{names[0]}: the start is an equilibrium, which depends on it in a way that is not "
                "differentiated; give start values"
            )

    def _set_inputs(self, begin: float, end: float) -> bool:
        """Set the inputs for a step; return whether one has changed or moves."""
        changed = False
        self._moving = {}
        for name, signal in self._signals.items():
            if varies(name, signal):
                value, derivatives = in_step(name, signal, begin, end)
                for order, derivative in enumerate(derivatives, 1):
                    self._plant.set_input_derivative(name, order, derivative)
                if is_motion(name) or any(derivatives):
                    self._moving[name] = begin, value, derivatives
            else:
                value = signal(begin)
            changed = changed or name in self._moving or value != self._plant.input(name)
            self._plant.set_input(name, value)
        return changed

    def _sample(self) -> Sample:
        core = self._plant._core
        n = len(self._states)
        flat = core._linearize()
        x = core.read_outputs(self._states)
        A = flat[0].reshape((n, n), order="F")
        inputs, signals = len(self._plant.inputs), len(self._plant._signals)
        B = flat[1].reshape((n, inputs), order="F")
        C = flat[2].reshape((signals, n), order="F")[self._indices]
        movable = flat[2].reshape((signals, n), order="F")[self._states]
        D = flat[3].reshape((signals, inputs), order="F")[self._indices]
        for name, row in zip(self.outputs, np.hstack([C, D]), strict=True):
            if np.isnan(row).any():
                raise UsageError(
                    f"{name}: t = {core.time:g} s: it has no derivatives, since redundant constraints do not "
                    "determine it"
                )
        by_parameter, noise = self._neighbors.derivatives(x)
        return Sample(
            A, np.hstack([_columns(B, self._columns), by_parameter[:n]]),
            np.hstack([np.zeros((n, len(self._columns))), noise[:n]]), np.asarray(flat[4]), x,
            C, np.hstack([_columns(D, self._columns), by_parameter[n:]]), movable,
        )  # fmt: skip

    def _through_events(
        self, first: Sample, begin: float, end: float, fault: UsageError | None
    ) -> tuple[Array, Sample]:
        """Advance the plant from `begin` to `end`; return [F, G, P] and the sample at the end.

        Args:
            first: the sample at the start.
            begin: the start.
            end: the end.
            fault: why `first` is from before the last change of the inputs, an event at the start perhaps.
        """
        matrix, at = unit(first), begin
        for _ in range(MOST_EVENTS):
            saved, self._parts = self._plant.save(), 0
            try:
                if fault is not None:
                    self._step(at, at + WINDOWS[-1] * (end - at))
                    raise fault
                part, last = self._advanced(first, at, end, 0)
            except _Event as event:
                if fault is not None and event.time > at:
                    raise fault from None
                fault = None
                part, first, at = self._across(event, saved, first, at, end)
                matrix = product(part, matrix)
            else:
                return product(part, matrix), last
            if at >= end:
                return matrix, first
        raise UsageError(
            f"t = {at:.9g} s: derivatives through more than {MOST_EVENTS} events in a step are not computed"
        )

    def _across(
        self, event: _Event, saved: bytes, first: Sample, begin: float, end: float
    ) -> tuple[Array, Sample, float]:
        """Advance the plant from `begin` to shortly after an event; return [F, G, P], sample and time."""
        why = "it cannot be passed"
        for length in WINDOWS:
            start = event.time - length * self._whole / 2
            start, stop = max(begin, start), min(end, event.time + length * self._whole / 2)
            self._plant.restore(saved)
            self._parts = 0
            self._move_inputs(begin, end)
            try:
                matrix, sample = unit(first), first
                if start > begin:
                    matrix, sample = self._advanced(first, begin, start, 0)
                matrix = product(self._jumped(sample, start, stop), matrix)
                return matrix, self._sample(), stop
            except NotPassed as fault:
                why = str(fault)
            except _Event as earlier:  # the time of the event depends on the steps that lead to it
                why = f"its time is not known well enough ({earlier.time:.9g} s)"
            except UsageError as fault:  # just before or after it, the mode may be about to change
                why = str(fault)
        raise UsageError(
            f"t = {event.time:.9g} s: {event.text}; derivatives through this event are not available: {why}"
        )

    def _jumped(self, first: Sample, begin: float, end: float) -> Array:
        """Advance the plant through events from `begin` to `end`; return [F, G, P]."""
        self._move_inputs(begin, end)
        before = self._plant.save()
        self._plant.step_to(end)
        texts = tuple(text for _, text in self._plant.events)
        doubtful = [text for text in texts if any(word in text for word in DOUBTFUL)]
        if doubtful:
            raise NotPassed(doubtful[0])
        after = self._plant.save()
        self._plant.restore(before)
        self._move_inputs(begin, end)
        sizes = np.maximum(np.abs(first.x), self._whole * np.abs(first.rates))
        sizes = np.maximum(sizes, 1e-3 * sizes.max(initial=0.0) or 1.0)
        window = Window(self._plant, first.x, sizes, first.movable, end, end - begin, texts)
        matrix = self._saltation.matrix(window)
        self._plant.restore(after)
        return matrix

    def _advanced(self, first: Sample, begin: float, end: float, depth: int) -> tuple[Array, Sample]:
        """Advance the plant from `begin` to `end`; return [F, G, P] and the sample at the end."""
        self._parts += 1
        if self._parts > MOST_PARTS:
            raise UsageError(
                f"t = {begin:.9g} s: the derivatives do not converge in {MOST_PARTS} parts of a step; "
                "they vary too fast, or not smoothly. A shorter step or a larger `accuracy` may help"
            )
        saved = self._plant.save()
        samples = [first]
        for a, b in itertools.pairwise(NODES.tolist()):
            at, to = begin + a * (end - begin), (end if b == 1 else begin + b * (end - begin))
            self._step(at, to)
            samples.append(self._sample())
        for sample in samples:
            np.maximum(self._largest, self._whole * np.abs(sample.B), out=self._largest)
            np.maximum(self._fastest, self._whole * np.abs(sample.rates), out=self._fastest)
        matrix, error = advance(samples, end - begin, self._largest, self._fastest)
        if error <= self._accuracy:
            if depth >= BISECTIONS_AT_KINK:
                self._check_jump(samples, begin)
            return matrix, samples[-1]
        middle = begin + (end - begin) / 2
        if depth == MOST_BISECTIONS or not begin < middle < end or end - begin < 1e-14 * abs(end):
            self._check_jump(samples, begin)
            return matrix, samples[-1]
        self._plant.restore(saved)
        left, between = self._advanced(first, begin, middle, depth + 1)
        if self._moving:
            self._move_inputs(middle, end)
            between = self._sample()
        right, last = self._advanced(between, middle, end, depth + 1)
        return product(right, left), last

    def _move_inputs(self, begin: float, end: float) -> None:
        """Set the inputs that vary for a part of a step; forces follow the polynomials of the whole step."""
        for name, (start, value, derivatives) in self._moving.items():
            if is_motion(name):
                value, derivatives = in_step(name, self._signals[name], begin, end)
            else:
                value, derivatives = shifted(value, derivatives, begin - start)
            self._plant.set_input(name, value)
            for order, derivative in enumerate(derivatives, 1):
                self._plant.set_input_derivative(name, order, derivative)

    def _step(self, begin: float, end: float) -> None:
        self._move_inputs(begin, end)
        self._plant.step_to(end)
        if events := self._plant.events:
            raise _Event(events)

    def _check_jump(self, samples: list[Sample], time: float) -> None:
        rates = np.array([s.rates for s in samples])
        size = np.abs(rates).max(initial=0.0)
        if np.ptp(rates, axis=0).max(initial=0.0) > LARGEST_CHANGE * size:
            raise UsageError(
                f"t = {time:.9g} s: the accelerations jump, so that derivatives beyond this time are "
                "not known"
            )


def _columns(matrix: Array, indices: Sequence[int]) -> Array:
    """Select columns; -1 is a column of zeros, of an input that acts on nothing that is computed."""
    found: Array = np.zeros((len(matrix), len(indices)))
    for k, index in enumerate(indices):
        if index >= 0:
            found[:, k] = matrix[:, index]
    return found
