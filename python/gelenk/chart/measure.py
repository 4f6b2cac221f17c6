# SPDX-License-Identifier: BSD-3-Clause
"""One run of a method on a test case: its cost, its errors and its outcome."""

from __future__ import annotations

import copy
import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import gelenk
from gelenk.chart.case import Array, Case, Jumps, Smooth
from gelenk.chart.methods import Method
from gelenk.chart.outcome import Outcome, judged
from gelenk.errors import GelenkError

ENERGY_KEPT = 1e-8  # energy variation of a conservative reference / largest kinetic energy


@dataclass(frozen=True)
class Task:
    """A run to be made: `tolerance` for methods with error control, `step` [s] for those with fixed steps."""

    case: Case
    method: Method
    tolerance: float | None = None
    step: float | None = None


@dataclass(frozen=True)
class Course:
    """The result of a run: its states at the samples, energies and constraint errors."""

    states: Array  # joint positions and speeds, states of elements; shape (samples, signals)
    kinetic: Array  # kinetic energy [J], shape (samples + 1,): the start is included
    total: Array  # total energy [J], shape (samples + 1,)
    position_residual: float  # largest closure error of the loops [m, rad]
    velocity_residual: float  # largest constraint error of the velocities [m/s, rad/s]
    counts: dict[str, float]


@dataclass(frozen=True)
class Reference:
    """A reference solution; `digits` is its largest error, measured as that of runs."""

    states: Array  # shape (samples, signals)
    scales: Array  # 1 unit, or the largest value of the signal if that is greater; shape (signals,)
    kinetic: Array  # [J], shape (samples + 1,)
    total: Array  # [J], shape (samples + 1,)
    digits: float
    words: str  # how it was computed and checked
    by_energy: bool = False  # runs are judged by their energy, which is conserved, not by their states

    @property
    def conserves(self) -> bool:
        """Whether the energy is conserved; that of a run is then compared with its own start."""
        return bool(np.ptp(self.total) <= ENERGY_KEPT * max(1e-12, self.kinetic.max()))


@dataclass(frozen=True)
class Run:
    """The figures of a run; NaN if missing. Times are in s, energy errors relative to the kinetic maximum."""

    scene: str
    method: str
    formulation: str
    integrator: str
    tolerance: float = math.nan
    step: float = math.nan
    outcome: str = Outcome.FAILED
    cpu: float = math.nan
    evaluations: float = math.nan
    steps: float = math.nan
    rejected: float = math.nan
    jacobians: float = math.nan
    error: float = math.nan
    digits: float = math.nan
    position_residual: float = math.nan
    velocity_residual: float = math.nan
    energy_error: float = math.nan
    reached: float = 0.0
    reason: str = ""

    @property
    def finished(self) -> bool:
        """Whether the run reached the end of the experiment, accurately or not."""
        return self.outcome in (Outcome.GOOD, Outcome.WRONG)

    @property
    def asked(self) -> float | None:
        """The requested tolerance; None for fixed steps."""
        return None if math.isnan(self.tolerance) else self.tolerance


def blank(task: Task) -> Run:
    """Return a run of the task without any results."""
    return Run(
        task.case.name,
        task.method.name,
        task.method.formulation,
        task.method.integrator,
        math.nan if task.tolerance is None else task.tolerance,
        math.nan if task.step is None else task.step,
    )


def scene_of(task: Task) -> dict[str, Any]:
    """Return the scene of the test case with the method as its solver; its reductions are kept."""
    data = copy.deepcopy(task.case.scene)
    kept = {k: v for k, v in data.get("solver", {}).items() if k == "reductions"}
    data["solver"] = {**kept, **task.method.solver(task.step)}
    data["experiment"] = {"stop": task.case.stop, "step": task.case.step}
    return data


class Runner:
    """A task compiled once, which can be run repeatedly."""

    def __init__(self, task: Task) -> None:
        """Compile the scene. Raises SceneError: the method cannot solve the scene."""
        self._tolerance = task.tolerance or 1e-6
        self._case = task.case
        self.simulation = gelenk.Simulation(scene_of(task))
        self._core = self.simulation._core
        self._constants = self._inputs((int, float))
        self._waves = self._inputs(Smooth)
        self._jumps = self._inputs(Jumps)
        own = task.case.scene.get("states", {})
        signals = self.simulation._signals
        self.states = [i for i, s in enumerate(signals) if s.level in (0, 1) or s.name in own]
        self.names = [self.simulation._signals[i].name for i in self.states]
        self._ends = task.case.grid[1:].tolist()
        self._values = [[x.at(k) for _, x in self._jumps] for k in range(len(self._ends))]

    def _inputs[T](self, kind: type[T] | tuple[type[T], ...]) -> list[tuple[int, T]]:
        """Return (index, value) of the inputs whose values have this type."""
        places = {signal.name: k for k, signal in enumerate(self.simulation.inputs)}
        return [(places[name], x) for name, x in self._case.inputs.items() if isinstance(x, kind)]

    def start(self) -> None:
        """Initialize at t = 0. Raises AssemblyError."""
        for index, value in self._constants:
            self._core.set_input(index, value)
        for (index, _), value in zip(self._jumps, self._values[0], strict=True):
            self._core.set_input(index, value)
        self._follow(0.0)
        self._core.initialize(0.0, self._tolerance)

    def record(self) -> Course:
        """Run to the end and record the states at the samples. Raises GelenkError."""
        self.start()
        samples = set(self._case.samples())
        health = [self.simulation.diagnostics]
        rows = []
        begin = 0.0
        for k, end in enumerate(self._ends):
            for (index, _), value in zip(self._jumps, self._values[k], strict=True):
                self._core.set_input(index, value)
            self._follow(begin)
            self._core.step_to(end)
            if self._case.saved:
                self._core.save()
            begin = end
            if k + 1 in samples:
                rows.append(self._core.read_outputs(self.states))
                health.append(self.simulation.diagnostics)
        column = {name: np.array([h[name] for h in health]) for name in health[0]}
        return Course(
            np.array(rows),
            column["energy.kinetic"],
            column["energy.total"],
            float(column["constraints.position"].max()),
            float(column["constraints.velocity"].max()),
            {name: float(values[-1]) for name, values in column.items() if name.startswith("solver.")},
        )

    def _follow(self, t: float) -> None:
        for index, wave in self._waves:
            value, *derivatives = wave.at(t)
            self._core.set_input(index, value)
            for order, derivative in enumerate(derivatives, 1):
                self._core.set_input_derivative(index, order, derivative)

    def timed(self) -> float:
        """Return the CPU time of the steps [s], without assembly, outputs and Python's overhead."""
        self.start()
        core, inputs = self._core, [index for index, _ in self._jumps]
        begun = time.thread_time()
        for end, values in zip(self._ends, self._values, strict=True):
            for index, value in zip(inputs, values, strict=True):
                core.set_input(index, value)
            core.step_to(end)
        between = time.thread_time()
        # The simulation is at its end and has these inputs: only the overhead of the calls is measured.
        last = self._values[-1]
        end = self._ends[-1]
        for _ in self._ends:
            for index, value in zip(inputs, last, strict=True):
                core.set_input(index, value)
            core.step_to(end)
        return max(1e-9, between - begun - (time.thread_time() - between))


def measured(task: Task, reference: Reference | None) -> Run:
    """Run a task once; refusals become results.

    Without a reference the run has no error, and a finished run counts as good.
    """
    run = blank(task)
    runner = None
    begun = time.thread_time()
    try:
        runner = Runner(task)
        begun = time.thread_time()
        course = runner.record()
    except GelenkError as e:
        reached = 0.0 if runner is None else _time(runner)
        return replace(run, outcome=Outcome.REFUSED, reason=first_sentence(str(e)), reached=reached)
    run = replace(
        run,
        outcome=Outcome.GOOD,
        cpu=time.thread_time() - begun,
        evaluations=course.counts["solver.evaluations"],
        steps=course.counts["solver.steps"],
        rejected=course.counts["solver.rejected_steps"],
        jacobians=course.counts.get("solver.jacobians", math.nan),
        position_residual=course.position_residual,
        velocity_residual=course.velocity_residual,
        reached=task.case.stop,
    )
    return run if reference is None else compared(run, course, reference)


def compared(run: Run, course: Course, reference: Reference) -> Run:
    """Return a finished run completed with its errors and its outcome."""
    error = difference(course.states, reference.states, reference.scales)
    if not math.isfinite(error):
        return replace(run, outcome=Outcome.FAILED, reason="the states are not finite")
    truth = course.total[0] if reference.conserves else reference.total
    drift = float(np.abs(course.total - truth).max()) / max(1e-12, float(reference.kinetic.max()))
    if reference.by_energy:
        error = drift
    outcome = judged(error, run.asked, reference.digits)
    reason = ""
    if outcome is Outcome.WRONG:
        reason = (
            "no two correct digits"
            if run.asked is None
            else f"error {error / run.asked:.0f} times the tolerance"
        )
    return replace(
        run, outcome=outcome, error=error, digits=reference.digits, energy_error=drift, reason=reason
    )


def difference(states: Array, truth: Array, scales: Array) -> float:
    """Return the largest |x - truth| / scale over samples and signals.

    Args:
        states: Shape (samples, signals).
        truth: Reference states, same shape.
        scales: Shape (signals,), see `scales_of`.
    """
    return float((np.abs(states - truth) / scales).max())


def scales_of(states: Array) -> Array:
    """Return 1 unit or, if greater, the largest value of each signal: shape (signals,)."""
    largest: Array = np.maximum(1.0, np.abs(states).max(axis=0))
    return largest


def first_sentence(words: str) -> str:
    """Return the first sentence of the first line of a message, without its period."""
    line = (words.strip().splitlines() or [""])[0]
    return line.split(". ")[0].rstrip(".")


def _time(runner: Runner) -> float:
    try:
        return runner.simulation.time
    except GelenkError:
        return 0.0
