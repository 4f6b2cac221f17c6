# SPDX-License-Identifier: BSD-3-Clause
"""What is kept of each run of a sweep: trajectories, numbers computed from them, times of events."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import UsageError
from gelenk.model.values import check_names
from gelenk.simulation.run import expanded

type Array = NDArray[np.float64]
type Function = Callable[..., float]
type Reduction = str | Function
type Outputs = Sequence[str] | Mapping[str, Reduction | Sequence[Reduction] | tuple[Function, Sequence[str]]]

EVENTS = "events"
TRAJECTORY = "trajectory"
_CROSSING = re.compile(r"first\s*([<>])\s*(\S+)")


def _last(_: Array, x: Array) -> float:
    return float(x[-1])


def _max(_: Array, x: Array) -> float:
    return float(x.max())


def _min(_: Array, x: Array) -> float:
    return float(x.min())


def _mean(time: Array, x: Array) -> float:
    span = time[-1] - time[0]
    return float(np.trapezoid(x, time) / span) if span > 0 else float(x[-1])


def _rms(time: Array, x: Array) -> float:
    return float(np.sqrt(_mean(time, x * x)))


def _crossing(time: Array, x: Array, *, threshold: float, above: bool) -> float:
    """Return the time at which x is first beyond a threshold, interpolated linearly; NaN if it never is."""
    y = x - threshold if above else threshold - x
    beyond = np.flatnonzero(y > 0)
    if not len(beyond):
        return float("nan")
    k = int(beyond[0])
    if k == 0:
        return float(time[0])
    return float(time[k - 1] + (time[k] - time[k - 1]) * (-y[k - 1] / (y[k] - y[k - 1])))


_NAMED: dict[str, Function] = {"last": _last, "max": _max, "min": _min, "mean": _mean, "rms": _rms}


@dataclass(frozen=True)
class Output:
    """One variable of the result.

    Attributes:
        name: of the variable.
        unit: its unit; empty: unknown.
        signals: indices of the recorded signals of which it is computed.
        function: of time and these signals; None for a trajectory or an event.
        pattern: of the events whose first time it is; empty: the number of all events; None: not of events.
    """

    name: str
    unit: str
    signals: tuple[int, ...] = ()
    function: Function | None = None
    pattern: str | None = None

    @property
    def is_trajectory(self) -> bool:
        """Whether the variable has a value at each time."""
        return self.function is None and self.pattern is None

    def value(self, time: Array, rows: Array, events: Sequence[tuple[float, str]]) -> float:
        """Return the value of a complete run, which is not a trajectory.

        Args:
            time: communication points [s], shape (points,).
            rows: the recorded signals, shape (signals, points).
            events: times [s] and descriptions.
        """
        if self.pattern is not None:
            if not self.pattern:
                return float(len(events))
            return next((t for t, text in events if fnmatchcase(text, self.pattern)), float("nan"))
        assert self.function is not None
        return float(self.function(time, *(rows[i] for i in self.signals)))


def selected(
    outputs: Outputs | None, known: Sequence[str], units: Mapping[str, str], *, has_events: bool
) -> tuple[list[str], list[Output]]:
    """Return the signals to record, and the variables to compute.

    Args:
        outputs: see `gelenk.sweep`; None: the trajectories of all outputs.
        known: names of the plant's outputs.
        units: of everything that can be recorded.
        has_events: whether the plant reports events.

    Raises:
        UsageError: a name or a reduction is unknown, or a variable would be defined twice.
    """
    requests = _requests(outputs if outputs is not None else list(known), known)
    signals: dict[str, int] = {}
    variables: list[Output] = []
    for name, reduction in requests:
        if name == EVENTS and not isinstance(reduction, tuple) and EVENTS not in units:
            variables.append(_of_events(reduction, has_events))
            continue
        of = reduction[1] if isinstance(reduction, tuple) else [name]
        check_names(list(of), units, "output")
        places = tuple(signals.setdefault(signal, len(signals)) for signal in of)
        variables.append(_of_signals(name, reduction, places, units.get(name, "")))
    names = [variable.name for variable in variables]
    check_names(names, names, "output")
    if not variables:
        raise UsageError("outputs: found none, expected at least one")
    return list(signals), variables


def recorded_names(outputs: Outputs | None) -> list[str] | None:
    """Return the names and patterns of the plant's outputs that a sweep needs; None: all."""
    if outputs is None:
        return None
    names: dict[str, None] = {}
    for name, reduction in _requests(outputs, None):
        names |= dict.fromkeys(reduction[1] if isinstance(reduction, tuple) else [name])
    if EVENTS in names:
        return None  # of all parts
    return list(names)


def _requests(outputs: Outputs, known: Sequence[str] | None) -> list[tuple[str, Any]]:
    """Return pairs of a name and a reduction; patterns are replaced by names if these are known."""

    def names(entry: str) -> Iterable[str]:
        return [entry] if known is None or entry == EVENTS else expanded([entry], known)

    if not isinstance(outputs, Mapping):
        entries = [outputs] if isinstance(outputs, str) else list(outputs)
        listed = entries if known is None else expanded(entries, known)
        return [(name, TRAJECTORY) for name in listed]
    found: list[tuple[str, Any]] = []
    for entry, given in outputs.items():
        if isinstance(given, tuple) and len(given) == 2 and callable(given[0]) and not callable(given[1]):
            of = [given[1]] if isinstance(given[1], str) else list(given[1])
            found.append((entry, (given[0], of)))
            continue
        reductions = [given] if isinstance(given, str) or callable(given) else list(given)
        found += [(name, reduction) for name in names(entry) for reduction in reductions]
    return found


def _of_events(reduction: Any, has_events: bool) -> Output:
    if not has_events:
        raise UsageError(f"{EVENTS}: found an FMU, which does not report its events; expected a scene")
    if reduction == "count":
        return Output(f"{EVENTS}.count", "1", pattern="")
    if isinstance(reduction, str) and reduction.startswith("first:") and reduction[6:].strip():
        return Output(f"{EVENTS}.{reduction}", "s", pattern=reduction[6:].strip())
    raise UsageError(f"{EVENTS}: found {reduction!r}, expected 'count' or 'first:PATTERN'")


def _of_signals(name: str, reduction: Any, places: tuple[int, ...], unit: str) -> Output:
    if isinstance(reduction, tuple):
        return Output(name, "", places, reduction[0])
    if callable(reduction):
        label = getattr(reduction, "__name__", type(reduction).__name__).strip("<>")
        return Output(f"{name}.{label}", "", places, reduction)
    if reduction == TRAJECTORY:
        return Output(name, unit, places)
    if reduction in _NAMED:
        return Output(f"{name}.{reduction}", unit, places, _NAMED[reduction])
    crossing = _CROSSING.fullmatch(reduction) if isinstance(reduction, str) else None
    try:
        threshold = float(crossing[2]) if crossing else float("nan")
    except ValueError:
        threshold = float("nan")
    if crossing is None or not np.isfinite(threshold):
        expected = ", ".join([TRAJECTORY, *_NAMED, "first>NUMBER", "first<NUMBER"])
        raise UsageError(f"{name}: found the reduction {reduction!r}, expected {expected} or a function")
    function = functools.partial(_crossing, threshold=threshold, above=crossing[1] == ">")
    return Output(f"{name}.first{crossing[1]}{crossing[2]}", "s", places, function)
