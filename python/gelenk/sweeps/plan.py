# SPDX-License-Identifier: BSD-3-Clause
"""The plan of a sweep: all that a worker needs to make any of its runs. Plans can be pickled."""

from __future__ import annotations

import tempfile
import threading
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gelenk import _core
from gelenk.errors import GelenkError, StartWarning
from gelenk.model.scene import Scene
from gelenk.simulation.inputs import SampledInputs, is_motion
from gelenk.simulation.simulation import Simulation
from gelenk.sweeps.outputs import Output

type Array = NDArray[np.float64]


@dataclass
class Chunk:
    """The outcome of successive runs.

    Attributes:
        first: number of the first run.
        values: of each variable, shape (runs,) or (runs, points); NaN where a run has failed.
        errors: why each run has failed; empty if it has not.
        warnings: of each run.
        seconds: time that the runs have taken [s].
    """

    first: int
    values: dict[str, Array]
    errors: list[str]
    warnings: list[str]
    seconds: float = 0.0

    @property
    def last(self) -> int:
        """Number of the run after the last one."""
        return self.first + len(self.errors)


@dataclass(frozen=True)
class Outcome:
    """What a plant reports of one run: completed steps, error, warnings, events, time taken [s]."""

    steps: int
    error: str
    warnings: Sequence[str]
    events: Sequence[tuple[float, str]]
    seconds: float


class Runner(Protocol):
    """A plant that makes runs, in any number of threads."""

    def run(
        self, parameters: NDArray[Any], inputs: Array, rows: Array, seconds: float
    ) -> Sequence[Outcome | _core.RunReport]:
        """Make a run for each row of values; fewer after `stop`.

        Args:
            parameters: shape (runs, parameters).
            inputs: values of inputs that are constant in a run, shape (runs, inputs).
            rows: where the recorded signals are written, shape (runs, signals, points).
            seconds: the longest time that a run may take [s]; 0: any.
        """

    def stop(self) -> None:
        """End the calls of `run` at the next communication point."""

    def close(self) -> None:
        """Release resources."""


@dataclass(frozen=True)
class Plan:
    """What is common to all runs of a sweep.

    Attributes:
        plant: a scene, with the parameters that all runs have in common, or the bytes of an FMU.
        settings: these parameters, of an FMU.
        parameters: names of the parameters that differ.
        inputs: names of the inputs that differ.
        times: communication points [s].
        sampled: inputs that all runs have in common.
        signals: names of the recorded outputs.
        variables: what is computed of them.
        max_run_time: the longest time that a run may take [s]; 0: any.
    """

    plant: Scene | bytes
    settings: dict[str, Any]
    parameters: tuple[str, ...]
    inputs: tuple[str, ...]
    times: Array
    sampled: SampledInputs
    signals: tuple[str, ...]
    variables: tuple[Output, ...]
    max_run_time: float = 0.0
    _local: list[Runner] = field(default_factory=list, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_local": []}  # what is compiled stays in its process

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    @property
    def runner(self) -> Runner:
        """The plant, compiled at the first use in a process."""
        with _LOCK:
            if not self._local:
                scene = isinstance(self.plant, Scene)
                self._local.append(_SceneRunner(self) if scene else _FmuRunner(self))
            return self._local[0]

    def close(self) -> None:
        """Release what `runner` holds."""
        with _LOCK:
            while self._local:
                self._local.pop().close()

    @property
    def bytes_per_run(self) -> int:
        """Memory of the recorded signals of a run."""
        return 8 * max(1, len(self.signals)) * len(self.times)

    def run(self, first: int, parameters: NDArray[Any], inputs: Array) -> Chunk:
        """Make runs; fewer if another thread stops the runner.

        Args:
            first: number of the first run.
            parameters: shape (runs, parameters).
            inputs: shape (runs, inputs).
        """
        rows = np.full((len(parameters), len(self.signals), len(self.times)), np.nan)
        outcomes = self.runner.run(parameters, inputs, rows, self.max_run_time)
        chunk = self.empty(first, len(outcomes))
        chunk.seconds = sum(outcome.seconds for outcome in outcomes)
        for i, outcome in enumerate(outcomes):
            chunk.warnings[i] = "\n".join(outcome.warnings)
            chunk.errors[i] = self._located(outcome.error)
            if not outcome.error:
                chunk.errors[i] = self._reduce(chunk, i, rows[i], outcome.events)
        for variable in self.variables:
            if variable.is_trajectory:
                chunk.values[variable.name][:] = rows[: len(outcomes), variable.signals[0]]
        return chunk

    def empty(self, first: int, runs: int, error: str = "") -> Chunk:
        """Return a chunk of NaN, with the same error for all runs."""
        values = {
            v.name: np.full((runs, len(self.times)) if v.is_trajectory else runs, np.nan)
            for v in self.variables
        }
        return Chunk(first, values, [error] * runs, [""] * runs)

    def _reduce(self, chunk: Chunk, i: int, rows: Array, events: Sequence[tuple[float, str]]) -> str:
        """Compute the variables of a complete run; returns the errors of functions of the user."""
        errors = []
        for variable in self.variables:
            if variable.is_trajectory:
                continue
            try:
                chunk.values[variable.name][i] = variable.value(self.times, rows, events)
            except Exception as e:  # of the user's function, which may raise anything
                errors.append(f"{variable.name}: {type(e).__name__}: {e}")
        return "\n".join(errors)

    def _located(self, error: str) -> str:
        if not error or not isinstance(self.plant, Scene) or self.plant._places is None:
            return error
        return "\n".join(self.plant._places.located(error.splitlines(), whole=False))


_LOCK = threading.Lock()


class _SceneRunner(Runner):
    """Runs of a scene, compiled with the loops over runs and communication points."""

    def __init__(self, plan: Plan) -> None:
        assert isinstance(plan.plant, Scene)
        sampled = plan.sampled
        constants = [(name, 0.0, is_motion(name)) for name in plan.inputs]
        channels = Simulation(plan.plant).channels(sampled.held, sampled.motions, plan.signals, constants)
        core = plan.plant.pruned()._core
        self._batch = _core.Batch(core, plan.parameters, channels, plan.times, sampled.table)

    def run(
        self, parameters: NDArray[Any], inputs: Array, rows: Array, seconds: float
    ) -> Sequence[Outcome | _core.RunReport]:
        return self._batch.run(
            np.ascontiguousarray(parameters, np.float64), np.ascontiguousarray(inputs), rows, seconds
        )

    def stop(self) -> None:
        self._batch.stop()

    def close(self) -> None:
        pass


class _FmuRunner(Runner):
    """Runs of an FMU: each thread has its own instance, which is reset before each run."""

    def __init__(self, plan: Plan) -> None:
        assert isinstance(plan.plant, bytes)
        self._plan = plan
        self._folder = tempfile.TemporaryDirectory(prefix="gelenk-")
        self._file = Path(self._folder.name) / "plant.fmu"
        self._file.write_bytes(plan.plant)
        self._instances: dict[int, Any] = {}  # by thread
        self._stopped = False

    def run(
        self, parameters: NDArray[Any], inputs: Array, rows: Array, seconds: float
    ) -> Sequence[Outcome | _core.RunReport]:
        outcomes = []
        for i in range(len(rows)):
            outcome = self._run(parameters[i].tolist(), inputs[i].tolist(), rows[i], seconds)
            if self._stopped:
                break
            outcomes.append(outcome)
        return outcomes

    def _run(self, parameters: list[Any], inputs: list[float], rows: Array, seconds: float) -> Outcome:
        from time import monotonic

        start = monotonic()
        plan, steps, error = self._plan, 0, ""
        found: list[str] = []
        plant = self._instance()
        try:
            plant.set_parameters(plan.settings | dict(zip(plan.parameters, parameters, strict=True)))
            plant.select(list(plan.signals))
            sampled = _with_constants(plan.sampled, dict(zip(plan.inputs, inputs, strict=True)))
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", StartWarning)
                _start(plant, sampled)
            found += [str(w.message) for w in caught if issubclass(w.category, StartWarning)]
            rows[:, 0] = plant.read()
            fault: GelenkError | None = None
            while steps + 1 < len(plan.times) and fault is None and not self._stopped:
                if seconds and monotonic() - start > seconds:
                    error = f"the run has taken longer than {seconds:g} s; it had reached t = "
                    error += f"{plan.times[steps]:g} s of {plan.times[-1]:g} s"
                    break
                part = slice(steps, steps + _BLOCK + 1)
                table = SampledInputs(sampled.held, sampled.motions, sampled.table[part])
                done, _, fault = plant.record(plan.times[part], table, rows[:, part][:, 1:].T)
                steps += done
            error = str(fault) if fault is not None else error
        except GelenkError as e:
            error = str(e)
        if error:  # the instance may not be used further
            plant.close()
            del self._instances[threading.get_ident()]
        return Outcome(steps, error, found, (), monotonic() - start)

    def _instance(self) -> Any:
        from gelenk.simulation.fmu_plant import FmuPlant

        thread = threading.get_ident()
        if thread in self._instances:
            self._instances[thread].reset()
        else:
            with _FMU_LOCK:  # loading it changes the current folder
                self._instances[thread] = FmuPlant(self._file)
        return self._instances[thread]

    def stop(self) -> None:
        self._stopped = True

    def close(self) -> None:
        for plant in self._instances.values():
            plant.close()
        self._folder.cleanup()


_BLOCK = 100  # steps of an FMU between looks at the clock
_FMU_LOCK = threading.Lock()


def _with_constants(sampled: SampledInputs, constants: dict[str, float]) -> SampledInputs:
    held = tuple(name for name in constants if not is_motion(name))
    motions = tuple(name for name in constants if is_motion(name))
    if not constants:
        return sampled
    n = len(sampled.held)
    row = [constants[name] for name in held]
    still = [x for name in motions for x in (constants[name], 0.0, 0.0, 0.0, 0.0)]
    steps = len(sampled.table)
    table = np.hstack(
        [sampled.table[:, :n], np.tile(row, (steps, 1)), sampled.table[:, n:], np.tile(still, (steps, 1))]
    )
    return SampledInputs((*sampled.held, *held), (*sampled.motions, *motions), table)


def _start(plant: Any, sampled: SampledInputs) -> None:
    """Start a plant with the inputs of the first step."""
    row = sampled.table[0].tolist()
    values = dict(zip(sampled.held, row, strict=False))
    derivatives: dict[str, list[float]] = {}
    for i, name in enumerate(sampled.motions):
        values[name], *derivatives[name] = row[len(sampled.held) + 5 * i :][:5]
    plant.start(None, values, derivatives)
