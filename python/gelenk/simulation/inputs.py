# SPDX-License-Identifier: BSD-3-Clause
"""Inputs of a simulation as functions of time: constants, callables, tables, CSV files.

Within a communication step an input is a polynomial: plants accept the time derivatives of their inputs.
"""

from __future__ import annotations

import itertools
import math
from array import array
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gelenk.errors import UsageError
from gelenk.file_reading import existing
from gelenk.model.values import Value, number, unknown
from gelenk.simulation.csv_file import csv_rows

if TYPE_CHECKING:
    from gelenk.simulation.plant import Plant

_INTERPOLATION_POINTS = (0.0, 0.25, 0.5, 0.75, 1.0)  # as fractions of a step
# Matrix from the values at these points to the coefficients of the polynomial of degree 4.
_QUARTIC_INTERPOLANT = np.linalg.inv(np.vander(_INTERPOLATION_POINTS, increasing=True))
# The same for inputs that may jump: the last point is before a jump at the end of the step, whose time may
# differ from it by rounding. Between the points the polynomial is compared with the function.
_INNER_POINTS = (0.0, 0.25, 0.5, 0.75, 1.0 - 1e-9)
_INNER_INTERPOLANT = np.linalg.inv(np.vander(_INNER_POINTS, increasing=True))
_CHECK_POINTS = (0.125, 0.375, 0.625, 0.875)
_POINTS = np.sort([*_INNER_POINTS, *_CHECK_POINTS])  # alternating
# Matrix from the values at the inner points to those of the polynomial at the points between.
_BETWEEN = np.vander(_CHECK_POINTS, len(_INNER_POINTS), increasing=True) @ _INNER_INTERPOLANT
# Largest deviation there, relative to that of the value at the start of the step. If a step function jumps
# between two points, it is 0.27 or more.
_LARGEST_DEVIATION = 0.25
MAX_FAULTS = 20  # of a table that are reported
_FACTORIALS = (1.0, 1.0, 2.0, 6.0, 24.0)

type InputFunction = Callable[[float], float]
type Input = InputFunction | float | tuple[ArrayLike, ArrayLike]
type Inputs = Mapping[str, Input] | NDArray[np.void] | str | PathLike[str]


def functions(inputs: Inputs | None, known: Iterable[str]) -> dict[str, InputFunction]:
    """Return a function of time [s] for each named input.

    Args:
        inputs: for each name a callable of time, a constant, or (times, values), which are interpolated
            linearly and held before the first and after the last time; a repeated time is a discontinuity.
            Alternatively, all inputs as columns of a structured array or a CSV file with a column `time`.
        known: names of the plant's inputs.

    Raises:
        UsageError: unknown names, or tables that are not functions of time.
        OSError: the file cannot be read.
    """
    if inputs is None:
        return {}
    names = list(known)
    where = ""
    if isinstance(inputs, str | PathLike):
        where = f"{inputs}: "
        inputs = read_csv(inputs)
    if isinstance(inputs, np.ndarray):
        inputs = _columns(inputs, where)
    faults = [where + unknown(name, "input", names) for name in inputs if name not in names]
    if faults:
        raise UsageError("\n".join(faults))
    return {name: _function(where + name, value) for name, value in inputs.items()}


def functions_and_constants(
    inputs: Inputs | None, settings: dict[str, Value], known: Iterable[str], twice: str
) -> dict[str, InputFunction]:
    """Return a function of time [s] for each input named in `inputs` or, with a constant value, in
    `settings`.

    Args:
        inputs: as for `functions`.
        settings: values of parameters and inputs by name; the inputs are removed from it.
        known: names of the plant's inputs.
        twice: end of the message "NAME: given ..." for an input that both contain.

    Raises:
        UsageError: as for `functions`, or an input in both.
        OSError: the file cannot be read.
    """
    names = list(known)
    signals = functions(inputs, names)
    for name in [name for name in settings if name in names]:
        if name in signals:
            raise UsageError(f"{name}: given {twice}")
        signals[name] = _function(name, number(name, settings.pop(name), "real"))
    return signals


def set_inputs(plant: Plant, signals: Mapping[str, InputFunction], start: float, end: float) -> None:
    """Set the inputs of a plant for a communication step, as `sampled` does.

    Args:
        plant: the plant.
        signals: functions of time by input.
        start: start of the step [s].
        end: end of the step [s].
    """
    for name, signal in signals.items():
        if not varies(name, signal, plant.held):
            plant.set_input(name, signal(start))
            continue
        value, derivatives = in_step(name, signal, start, end)
        plant.set_input(name, value)
        plant.set_input_derivatives(name, derivatives)


@dataclass(frozen=True)
class Constant:
    """An input that is constant."""

    value: float

    def __call__(self, _: float) -> float:
        """Return the value at any time."""
        return self.value


@dataclass(frozen=True)
class Table:
    """An input that is interpolated linearly, and held before the first and after the last time.

    Attributes:
        times: [s], not decreasing.
        values: one for each time.
    """

    times: NDArray[np.float64]
    values: NDArray[np.float64]

    def __call__(self, time: float) -> float:
        """Return the value at a time [s]; after the jump where a time is repeated."""
        t, x = self.times, self.values
        i = int(np.searchsorted(t, time, side="right")) - 1  # t[i] <= time < t[i + 1]
        if i < 0:
            return float(x[0])
        if i == len(t) - 1:
            return float(x[-1])
        return float(x[i] + (x[i + 1] - x[i]) * ((time - t[i]) / (t[i + 1] - t[i])))


@dataclass(frozen=True)
class SampledInputs:
    """Inputs of a run, sampled at the start of each step.

    Attributes:
        held: names of the inputs that are held in a step: a column each.
        motions: names of those that vary in a step: then five columns each, value and time derivatives of
            orders 1 to 4.
        table: a row for each step, shape (steps, columns).
    """

    held: tuple[str, ...]
    motions: tuple[str, ...]
    table: NDArray[np.float64]

    def set(self, plant: Plant, step: int) -> None:
        """Set the inputs of a plant for a step."""
        row = self.table[step].tolist()
        for name, value in zip(self.held, row, strict=False):
            plant.set_input(name, value)
        for i, name in enumerate(self.motions):
            value, *derivatives = row[len(self.held) + 5 * i :][:5]
            plant.set_input(name, value)
            plant.set_input_derivatives(name, derivatives)


def sampled(
    signals: Mapping[str, InputFunction], times: NDArray[np.float64], hold: Collection[str] = ()
) -> SampledInputs:
    """Sample inputs as `simulate` does.

    In a step, an input follows the polynomial through five of its values. Where it jumps, and if it is to be
    held, it is held at its value at the start of the step. Motion inputs (NAME.*_ref) must not jump.

    Args:
        signals: functions of time by input.
        times: of the start of the first step and of the ends of all steps [s], shape (steps + 1,).
        hold: names of the inputs to be held.
    """
    motions = tuple(name for name, signal in signals.items() if varies(name, signal, hold))
    held = tuple(name for name in signals if name not in motions)
    table = np.empty((len(times) - 1, len(held) + 5 * len(motions)))
    for column, name in enumerate(held):
        signal = signals[name]
        if isinstance(signal, Constant):
            table[:, column] = signal.value
        else:
            table[:, column] = [signal(start) for start in times[:-1].tolist()]
    for i, name in enumerate(motions):
        columns = slice(len(held) + 5 * i, len(held) + 5 * (i + 1))
        if not is_motion(name):
            table[:, columns] = _in_steps(signals[name], times)
            continue
        for step, (start, end) in enumerate(itertools.pairwise(times.tolist())):
            value, derivatives = polynomial(signals[name], start, end)
            table[step, columns] = value, *derivatives
    return SampledInputs(held, motions, table)


def is_motion(name: str) -> bool:
    """Whether an input is a prescribed motion, by its name."""
    return name.endswith("_ref")


def varies(name: str, signal: InputFunction, hold: Collection[str] = ()) -> bool:
    """Whether an input varies within a step: motions, and all others that are neither constant nor held."""
    return is_motion(name) or not (isinstance(signal, Constant) or name in hold)


def in_step(name: str, signal: InputFunction, start: float, end: float) -> tuple[float, Sequence[float]]:
    """Return value and time derivatives of orders 1 to 4 of an input at the start of a step.

    Args:
        name: of the input.
        signal: function of time.
        start: start of the step [s].
        end: end of the step [s].
    """
    if is_motion(name):
        return polynomial(signal, start, end)
    value, *derivatives = _in_steps(signal, np.array([start, end]))[0].tolist()
    return value, derivatives


def _in_steps(signal: InputFunction, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return value and derivatives of an input at the start of each step, shape (steps, 5).

    The derivatives are 0 in steps in which the function deviates from the polynomial.
    """
    h = np.diff(times)
    points = times[:-1, None] + h[:, None] * _POINTS
    values = np.array([[signal(t) for t in row] for row in points.tolist()], np.float64)
    inner, between = values[:, ::2], values[:, 1::2]
    found = _product(_INNER_INTERPOLANT, inner) * _FACTORIALS / h[:, None] ** np.arange(len(_FACTORIALS))
    deviation = np.abs(_product(_BETWEEN, inner) - between).max(axis=1)
    change = np.abs(values - values[:, :1]).max(axis=1)
    follows = (deviation <= _LARGEST_DEVIATION * change) & (change > 0) & np.isfinite(found).all(axis=1)
    found[~follows] = 0.0
    found[:, 0] = values[:, 0]
    return found


def _product(matrix: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the products of a matrix with rows, whose bits do not depend on the number of rows."""
    out = rows[:, :1] * matrix[:, 0]
    for k in range(1, rows.shape[1]):
        out = out + rows[:, k, None] * matrix[:, k]
    return out


def shifted(value: float, derivatives: Sequence[float], s: float) -> tuple[float, Sequence[float]]:
    """Return value and derivatives of a polynomial `s` [s] after the time for which they are given."""
    terms = [value, *derivatives]
    found = [
        sum(c * s**k / math.factorial(k) for k, c in enumerate(terms[order:])) for order in range(len(terms))
    ]
    return found[0], found[1:]


def _derivatives(coefficients: NDArray[np.float64], h: float) -> list[float]:
    """Return the time derivatives at the start of a step from the coefficients of powers of its fraction."""
    return [math.factorial(k) * c / h**k for k, c in enumerate(coefficients.tolist()) if k > 0]


def polynomial(signal: InputFunction, start: float, end: float) -> tuple[float, list[float]]:
    """Interpolate an input in a step by a polynomial of degree 4.

    Args:
        signal: function of time.
        start: start of the step [s].
        end: end of the step [s].

    Returns:
        tuple[float, list[float]]: value, and time derivatives of orders 1 to 4, at the start.
    """
    h = end - start
    coefficients = _QUARTIC_INTERPOLANT @ [signal(start + h * s) for s in _INTERPOLATION_POINTS]
    return float(coefficients[0]), _derivatives(coefficients, h)


def read_csv(path: str | PathLike[str]) -> NDArray[np.void]:
    """Read a CSV file with a header line as a structured array.

    Raises:
        UsageError: the header is invalid, a cell is not a number, or a line has another number of cells; the
            message gives the lines.
        OSError: the file cannot be read.
    """
    lines = csv_rows(existing(path), pipes=True)
    names = [name.strip() for name in next(lines, (0, []))[1]]
    faults = [
        f"{path}:1: found column {name!r} twice, expected it once"
        for name, count in Counter(names).items()
        if count > 1
    ]
    if "" in names:
        faults.append(f"{path}:1: found column {names.index('') + 1} without a name, expected one")
    numbers = array("d")
    rows = 0
    for line, cells in lines:
        rows += 1
        if len(cells) != len(names):
            faults.append(f"{path}:{line}: found {len(cells)} cells, expected {len(names)}")
        else:
            numbers.extend(_numbers(f"{path}:{line}", names, cells, faults))
        if len(faults) >= MAX_FAULTS:
            break
    if not rows:
        found = min(len(names), 1)
        raise UsageError(
            f"{path}: found {found} lines, expected a header line and at least one line of numbers"
        )
    if faults:
        raise UsageError("\n".join(faults[:MAX_FAULTS]))
    table = np.frombuffer(numbers).reshape(rows, len(names))
    return table.view(np.dtype([(name, np.float64) for name in names])).reshape(-1)


def _numbers(where: str, names: Sequence[str], cells: Sequence[str], faults: list[str]) -> list[float]:
    """Return the numbers of a line; what is not a number is added to the faults."""
    try:
        values = [float(cell) for cell in cells]
        if all(map(math.isfinite, values)):
            return values
    except ValueError:
        pass
    return [_cell(f"{where}: {name}", cell, faults) for name, cell in zip(names, cells, strict=True)]


def _cell(where: str, text: str, faults: list[str]) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        faults.append(f"{where}: found {text.strip()!r}, expected a number")
    return value


def _columns(table: NDArray[np.void], where: str) -> dict[str, Input]:
    fields = table.dtype.names
    if fields is None or "time" not in fields:
        found = ", ".join(fields or ()) or "no names"
        raise UsageError(f"{where}found the columns {found}, expected a column time")
    return {name: (table["time"], table[name]) for name in fields if name != "time"}


def _function(name: str, value: Input) -> InputFunction:
    if callable(value):
        return value
    if isinstance(value, tuple):
        return _interpolated(name, *value)
    try:
        constant = float(value)
    except (TypeError, ValueError):
        raise UsageError(
            f"{name}: found {value!r}, expected a number, a function of time, or (times, values)"
        ) from None
    return Constant(constant)


def _interpolated(name: str, times: ArrayLike, values: ArrayLike) -> InputFunction:
    t = np.asarray(times, np.float64)
    x = np.asarray(values, np.float64)
    if t.ndim != 1 or t.shape != x.shape or not len(t):
        shapes = f"times of shape {t.shape} and values of shape {x.shape}"
        raise UsageError(f"{name}: found {shapes}, expected two lists of equal length")
    if not (np.isfinite(t).all() and np.isfinite(x).all()):
        raise UsageError(f"{name}: found NaN or infinity in times or values")
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        k = int(back[0])
        raise UsageError(f"{name}: times decrease from {t[k]:g} s to {t[k + 1]:g} s (row {k + 2})")
    return Table(t, x)
