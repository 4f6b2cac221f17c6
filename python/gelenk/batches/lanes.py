# SPDX-License-Identifier: BSD-3-Clause
"""Batches: instances of one scene with parameters, states and inputs of their own."""

from __future__ import annotations

import math
import operator
import time
from collections.abc import Iterator, Mapping
from typing import Any, NoReturn, override

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.model.scene import Scene, Source, by_parameter, load
from gelenk.model.settable import with_listed
from gelenk.model.values import number, unknown

type Numbers = NDArray[np.float64]

MOST_LANES = 2**31 - 65  # their numbers are of 32 bits, and blocks are whole
_LONGEST_CALL = 0.1  # s; longer ones could not be interrupted from the keyboard


class Rows(Mapping[str, Numbers]):
    """Rows of an array by name, each of shape (lanes,). They are views: what is written is used."""

    def __init__(self, names: list[str], what: str, array: Numbers) -> None:
        self._index = {name: k for k, name in enumerate(names)}
        self._what = what
        self._array = array

    @override
    def __getitem__(self, name: str) -> Numbers:
        if name not in self._index:
            raise UsageError(unknown(name, self._what, self._index))
        row: Numbers = self._array[self._index[name]]
        return row

    @override
    def __iter__(self) -> Iterator[str]:
        return iter(self._index)

    @override
    def __len__(self) -> int:
        return len(self._index)

    def __setitem__(self, name: str, values: ArrayLike) -> None:
        self[name][:] = _row(name, values, self._array.shape[1], finite=False)


class Batch:
    """Instances of one scene, which are stepped together; `gelenk.batch` makes them.

    It cannot be copied or pickled; `array` and `parameters` say all that changes.

    Attributes:
        step_size: step of the Runge-Kutta method [s].
        states: coordinates, velocities ("A.phi", "A.w") and element states by name: rows of `array`.
        inputs: inputs by name ("drive.tau"), each of shape (lanes,), in SI units. They are held until they
            are changed.
        array: the states, shape (states, lanes), in SI units and radians. It may be written: the state is
            projected onto the constraints at the end of the next step.
    """

    def __init__(self, core: _core.LaneBatch, scene: Scene, names: dict[str, str], threads: int) -> None:
        """See `gelenk.batch`. names: of the parameters that may vary, by the names the user gives."""
        self._core = core
        self._scene = scene
        self._names = names
        self._threads = threads
        self._values = {name: np.full(core.lanes, scene.parameters[own]) for name, own in names.items()}
        self._steps_per_second = 0.0
        self.step_size = core.step
        self.array: Numbers = core.state()
        names_of_states = [of.name for of in (*core.coordinates, *core.velocities)]
        self.states = Rows([*names_of_states, *core.element_states], "state", self.array)
        self.inputs = Rows([of.name for of in core.inputs], "input", core.input())

    @property
    def lanes(self) -> int:
        """The number of instances."""
        return self._core.lanes

    @property
    def time(self) -> float:
        """The time that all instances have reached, but for those that have stopped [s]."""
        return self._core.time

    @property
    def parameters(self) -> dict[str, Numbers]:
        """Copies of the values of the parameters that may vary, each of shape (lanes,)."""
        return {name: values.copy() for name, values in self._values.items()}

    @property
    def errors(self) -> dict[int, str]:
        """By the number of an instance that has stopped: when and why. It remains where it was."""
        return {stop.lane: f"t = {stop.time:.10g} s: {stop.text}" for stop in self._core.stopped}

    @property
    def running(self) -> NDArray[np.bool_]:
        """Which instances have not stopped, shape (lanes,)."""
        out = np.ones(self.lanes, np.bool_)
        out[[stop.lane for stop in self._core.stopped]] = False
        return out

    @property
    def evaluations(self) -> int:
        """Evaluations of the equations of motion since the batch was made, by all instances."""
        return self._core.evaluations

    def set(self, values: Mapping[str, ArrayLike]) -> None:
        """Set parameters, and put all instances to their starts, which may depend on them.

        Args:
            values: by name, one number for all instances or an array of shape (lanes,); as in the file, in SI
                units and radians. Others keep their values.

        Raises:
            UsageError: a name is not among those that may vary, an array has another shape, or a value is
                outside of its bounds.
            SceneError, AssemblyError: the values of an instance, which is named, contradict each other, or
                its loops cannot be closed. The batch is then as it was.
        """
        given = dict(self._values)
        for name, of in mapping("values", values).items():
            if name not in self._names:
                raise UsageError(
                    f"{name}: not among the parameters that may vary ({', '.join(self._names) or 'none'}); "
                    "name it when the batch is made"
                )
            given[name] = _row(name, of, self.lanes)
        with self._scene.located():
            self._core.set([given[name].tolist() for name in self._names], self._threads)
        self._values = given

    def reset(self) -> None:
        """Put all instances to their starts, at time 0; inputs keep their values."""
        self._core.reset()

    def step(self, count: int = 1) -> None:
        """Make steps with the present inputs.

        Instances that fail stop before the step that fails, see `errors`; the others are not affected.

        Args:
            count: the number of steps.

        Raises:
            UsageError: the count is negative, or an input is not finite.
        """
        count = whole("count", count, 0)
        for name, row in self.inputs.items():
            if not np.isfinite(row).all():
                lane = int(np.flatnonzero(~np.isfinite(row))[0])
                raise UsageError(f"{name}: found {row[lane]} in lane {lane}, expected a finite number")
        self._advance(count)

    def _advance(self, count: int) -> None:
        """Make steps. Instances with inputs that are not finite stop."""
        while count > 0:
            now = min(count, max(1, int(self._steps_per_second * _LONGEST_CALL)))
            begin = time.perf_counter()
            self._core.advance(now, self._threads)
            self._steps_per_second = now / max(time.perf_counter() - begin, 1e-9)
            count -= now

    def run(self, stop: float) -> None:
        """Make steps until a time.

        Args:
            stop: the time [s], a multiple of the step.

        Raises:
            UsageError: the time has passed or is no multiple of the step.
        """
        steps = stop / self.step_size if math.isfinite(stop) else math.nan
        done = round(self.time / self.step_size)
        if not (abs(steps - round(steps)) < 1e-6 if math.isfinite(steps) else False) or round(steps) < done:
            raise UsageError(
                f"stop: found {stop} s, expected a multiple of the step, {self.step_size} s, "
                f"from {self.time:.10g} s on"
            )
        self.step(round(steps) - done)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a Batch cannot be copied or pickled; make another one, and set its array")

    def __repr__(self) -> str:
        return (
            f"<Batch of {self.lanes} {self._scene.name}: t = {self.time:.6g} s, {len(self.errors)} stopped>"
        )


def batch(
    scene: Source,
    lanes: int,
    parameters: Mapping[str, ArrayLike] | None = None,
    *,
    step: float | None = None,
    threads: int = 1,
) -> Batch:
    """Return many instances of one scene that are stepped together, several in one instruction.

    The equations of the scene are recorded once, as `gelenk.equations` does it, and evaluated for blocks of
    instances. The method is the Runge-Kutta method of order 4 with fixed steps and projection onto the
    constraints: what `gelenk.simulate` with `integrator="rk4"` computes, up to rounding. The results of an
    instance do not depend, to the bit, on how many others there are, on its number, on `threads`, or on the
    processor; they depend on which parameters may vary, in rounding.

    Args:
        scene: anything `gelenk.load` accepts. Trees and closed loops with forces, springs, dampers and
            motors. Dry friction, limits, contacts, prescribed motions, tables and expressions with branches
            are refused.
        lanes: the number of instances.
        parameters: values by name, one number or an array of shape (lanes,): start values, gravity,
            parameters, and other numbers of the scene by their path ("crank.mass", "coupler.com[1]"), in SI
            units and radians. These may be changed later, see `Batch.set`; all others are the same for all
            instances.
        step: step of the method [s]; by default that of the solver of the scene, or its communication step.
        threads: the number of threads among which blocks of instances are divided.

    Returns:
        Batch: the instances at their starts.

    Raises:
        SceneError: the scene is invalid or has an element that is refused, which the message names.
        AssemblyError: loops cannot be closed.
        UsageError: a name or a value is invalid.

    >>> batch = gelenk.batch("scenes/pendulum.yaml", 3, {"gravity[3]": [-9.81, -3.71, -1.62]}, step=1e-3)
    >>> batch.step(500)
    >>> batch.states["pin.phi"].shape
    (3,)
    """
    loaded = load(scene)
    lanes = whole("lanes", lanes, 1, MOST_LANES)
    threads = whole("threads", threads, 1)
    values = dict(mapping("parameters", parameters or {}))
    listed, renamed = with_listed(loaded, values)
    names = {name: renamed.get(name, name) for name in values}
    for name, own in names.items():
        if own not in listed.parameters:
            names[name] = _parameter(listed, name)
    if twice := [name for name in names if [*names.values()].count(names[name]) > 1]:
        raise UsageError(f"{' and '.join(twice[:2])}: found two names of one parameter, expected one")
    size = _step_of(loaded) if step is None else number("step", step, "real")
    if not (math.isfinite(size) and size > 0):
        raise UsageError(f"step: found {size} s, expected more than 0 s")
    with loaded.located():
        core = _core.LaneBatch(listed._core, lanes, size, list(names.values()))
    made = Batch(core, listed, names, threads)
    if values:
        made.set(values)
    return made


def _parameter(scene: Scene, name: str) -> str:
    own = next(iter(by_parameter(scene, {name: 0.0})))
    if own not in scene.parameters:
        raise UsageError(unknown(name, "parameter", scene.parameters))
    return own


def _step_of(scene: Scene) -> float:
    parameters: Mapping[str, Any] = scene.parameters
    return float(parameters["solver.step"]) or scene.step


def whole(name: str, value: object, least: int, most: int = 2**62) -> int:
    """Return a whole number. Raises UsageError: it is another value, or beyond its bounds."""
    try:
        out = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise UsageError(f"{name}: found {value!r}, expected a whole number") from None
    if out < least:
        expected = f"{least} or more" if least == 0 else f"at least {least}"
        raise UsageError(f"{name}: found {value}, expected {expected}")
    if out > most:
        raise UsageError(f"{name}: found {value}, expected at most {most}")
    return int(out)


def mapping[T](name: str, value: Mapping[str, T]) -> Mapping[str, T]:
    """Return the mapping. Raises UsageError: it is something else."""
    if not isinstance(value, Mapping):
        raise UsageError(f"{name}: found {type(value).__name__}, expected values by name")
    return value


def _row(name: str, values: ArrayLike, lanes: int, *, finite: bool = True) -> Numbers:
    try:
        given = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"{name}: found {values!r}, expected one number or an array of ({lanes},)") from None
    if given.shape not in ((), (lanes,)):
        raise UsageError(f"{name}: found an array of shape {given.shape}, expected one number or ({lanes},)")
    if finite and not np.isfinite(given).all():
        raise UsageError(f"{name}: found a value that is not finite")
    return np.broadcast_to(given, (lanes,)).copy()
