# SPDX-License-Identifier: BSD-3-Clause
"""Inputs of a run as functions of time: constants, callables, tables, CSV files."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gelenk.errors import UsageError
from gelenk.model.values import Value, number, unknown

if TYPE_CHECKING:
    from gelenk.simulation.plant import Plant

_PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)
_THROUGH_FIVE = np.linalg.inv(np.vander(_PLACES, increasing=True))

type Signal = Callable[[float], float]
type Input = Signal | float | tuple[ArrayLike, ArrayLike]
type Inputs = Mapping[str, Input] | NDArray[np.void] | str | PathLike[str]


def functions(inputs: Inputs | None, known: Iterable[str]) -> dict[str, Signal]:
    """One function of time [s] per input named.

    Args:
        inputs: by name, a callable of time, a constant, or (times, values) between which it is linear, held
            before the first and after the last; a time given twice is a jump. Or all of them as columns of a
            structured array or CSV file with a column `time`.
        known: the names of the plant's inputs.

    Raises:
        UsageError: unknown names, tables that are no functions of time.
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
) -> dict[str, Signal]:
    """As `functions`, with the inputs that `settings` names, which go from there and are constant.

    Args:
        inputs: as of `functions`.
        settings: parameters and inputs by name; the inputs are taken out.
        known: the names of the plant's inputs.
        twice: completes "NAME: given ..." where both name it.
    """
    names = list(known)
    signals = functions(inputs, names)
    for name in [name for name in settings if name in names]:
        if name in signals:
            raise UsageError(f"{name}: given {twice}")
        signals[name] = _function(name, number(name, settings.pop(name), "real"))
    return signals


def set_inputs(plant: Plant, signals: Mapping[str, Signal], start: float, end: float) -> None:
    """What the inputs are over a step [s]: held at their values at its start.

    Inputs that are motions, NAME.*_ref, cannot be held and jump: they follow the polynomial through five of
    their values in the step.
    """
    for name, signal in signals.items():
        if not is_motion(name):
            plant.set_input(name, signal(start))
            continue
        value, derivatives = polynomial(signal, start, end)
        plant.set_input(name, value)
        plant.set_input_derivatives(name, derivatives)


def is_motion(name: str) -> bool:
    """Whether the input of this name is a motion, as constraints of scenes name them."""
    return name.endswith("_ref")


def polynomial(signal: Signal, start: float, end: float) -> tuple[float, list[float]]:
    """Value and derivatives of orders 1 to 4 at the start of the polynomial through five values in a step."""
    h = end - start
    coefficients = (_THROUGH_FIVE @ [signal(start + h * s) for s in _PLACES]).tolist()
    return coefficients[0], [math.factorial(k) * c / h**k for k, c in enumerate(coefficients) if k > 0]


def read_csv(path: str | PathLike[str]) -> NDArray[np.void]:
    """A CSV file with a line of names as a structured array.

    Raises:
        UsageError: with the line of each cell that is no number, or too many or few of them.
        OSError: the file cannot be read.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as file:
            lines = [(i, row) for i, row in enumerate(csv.reader(file), 1) if row]
    except (UnicodeDecodeError, csv.Error) as e:
        raise UsageError(f"{path}: no CSV file: {e}") from None
    if len(lines) < 2:
        raise UsageError(
            f"{path}: found {len(lines)} lines, expected one of names and at least one of numbers"
        )
    names = [name.strip() for name in lines[0][1]]
    faults = [
        f"{path}:1: column {name!r} is there twice" for name in dict.fromkeys(names) if names.count(name) > 1
    ]
    if "" in names:
        faults.append(f"{path}:1: found column {names.index('') + 1} without a name, expected one")
    rows = []
    for line, cells in lines[1:]:
        if len(cells) != len(names):
            faults.append(f"{path}:{line}: found {len(cells)} cells, expected {len(names)}")
            continue
        rows.append(tuple(_cell(f"{path}:{line}: {name}", cell, faults)
                          for name, cell in zip(names, cells, strict=True)))  # fmt: skip
    if faults:
        raise UsageError("\n".join(faults[:20]))
    return np.array(rows, dtype=[(name, np.float64) for name in names])


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
        raise UsageError(f"{where}found the columns {found}, expected one called time")
    return {name: (table["time"], table[name]) for name in fields if name != "time"}


def _function(name: str, value: Input) -> Signal:
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
    return lambda _: constant


def _interpolated(name: str, times: ArrayLike, values: ArrayLike) -> Signal:
    t = np.asarray(times, np.float64)
    x = np.asarray(values, np.float64)
    if t.ndim != 1 or t.shape != x.shape or not len(t):
        shapes = f"times of shape {t.shape} and values of shape {x.shape}"
        raise UsageError(f"{name}: found {shapes}, expected two lists of one length")
    if not (np.isfinite(t).all() and np.isfinite(x).all()):
        raise UsageError(f"{name}: found times or values that are not finite")
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        k = int(back[0])
        raise UsageError(f"{name}: time goes back from {t[k]:g} s to {t[k + 1]:g} s (row {k + 2})")
    last = len(t) - 1

    def at(time: float) -> float:
        i = int(np.searchsorted(t, time, side="right")) - 1  # t[i] <= time < t[i + 1]
        if i < 0:
            return float(x[0])
        if i == last:
            return float(x[last])
        return float(x[i] + (x[i + 1] - x[i]) * ((time - t[i]) / (t[i + 1] - t[i])))

    return at
