# SPDX-License-Identifier: BSD-3-Clause
"""Results as notebooks show them: the extremes of each signal and a small chart."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gelenk import _html

if TYPE_CHECKING:
    from gelenk.simulation.result import Result

MAX_SIGNALS = 40
MAX_EVENTS = 20
BINS = 120  # of a chart; of each, the smallest and the largest value are drawn


def result_html(result: Result) -> str:
    """Return a result as HTML."""
    if not len(result):
        return _html.heading("Result", "empty")
    head = f"{len(result)} rows, {len(result.names)} signals"
    parts: list[_html.Cell] = [
        _html.heading(f"{_html.number(result.time[0])} to {_html.number(result.time[-1])} s", head)
    ]
    shown = result.names[:MAX_SIGNALS]
    if shown:
        titles = ("signal", "unit", "start", "min", "at [s]", "max", "at [s]", "end", "over time")
        rows = (_row(result, name) for name in shown)
        parts.append(_html.table(titles, rows, [False, False, *[True] * 6, False]))
    left = len(result.names) - len(shown)
    if left:
        parts.append(_html.paragraph(f"and {left} more; result.names lists all"))
    parts.extend(_html.paragraph(sentence) for sentence in result.warnings)
    if result.events:
        parts.append(_html.folded(f"{len(result.events)} events", _events(result)))
    return _html.joined(parts)


def _row(result: Result, name: str) -> list[_html.Cell]:
    time, x = result.time, result[name]
    finite = np.isfinite(x)
    extremes = ["–"] * 4
    if finite.any():
        low, high = int(np.where(finite, x, np.inf).argmin()), int(np.where(finite, x, -np.inf).argmax())
        extremes = [_html.number(float(v)) for v in (x[low], time[low], x[high], time[high])]
    start, end = (_html.number(float(x[k])) for k in (0, -1))
    kept = extremes_in_bins(x)
    chart = _html.sparkline(time[kept].tolist(), x[kept].tolist()) if len(x) > 1 else ""
    return [name, _html.unit(result.units.get(name, "1")), start, *extremes, end, chart]


def _events(result: Result) -> _html.Fragment:
    rows: Iterable[tuple[str, str]] = ((_html.number(t), text) for t, text in result.events[:MAX_EVENTS])
    listed = _html.table(("t [s]", "event"), rows, (True, False))
    left = len(result.events) - MAX_EVENTS
    return _html.joined([listed, _html.paragraph(f"and {left} more")]) if left > 0 else listed


def extremes_in_bins(x: NDArray[np.float64], bins: int = BINS) -> NDArray[np.intp]:
    """Return the indices of the values that a chart has to show, ascending.

    Args:
        x: values, shape (rows,); NaN and infinity are kept, as gaps, where a bin contains nothing else.
        bins: number of groups of successive values; of each, the smallest and the largest are kept.
    """
    if len(x) <= 2 * bins:
        return np.arange(len(x))
    kept: set[int] = {0, len(x) - 1}
    for rows in np.array_split(np.arange(len(x)), bins):
        finite = rows[np.isfinite(x[rows])]
        if len(finite):
            kept |= {int(finite[x[finite].argmin()]), int(finite[x[finite].argmax()])}
        else:
            kept.add(int(rows[0]))
    return np.array(sorted(kept), np.intp)
