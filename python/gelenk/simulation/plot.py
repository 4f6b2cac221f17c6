# SPDX-License-Identifier: BSD-3-Clause
"""Plots of results over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gelenk.errors import UsageError
from gelenk.extras import pyplot
from gelenk.model.values import check_names
from gelenk.simulation.result import Result
from gelenk.viewer.degrees import DEGREE, IN_DEGREES

WIDTH, HEIGHT = 7.2, 2.1  # inches; of a panel
MAX_IN_LEGEND = 12
POSITIONS = ("rad", "m")  # units of the signals that are plotted if none are named
EVENT_COLOR = "#999999"


def plot(result: Result, names: Sequence[str] = (), *, degrees: bool = False) -> Any:
    """Return a figure with a panel for each unit: see `Result.plot`."""
    plt = pyplot()
    if degrees and not any(result.units.values()):
        raise UsageError(
            "degrees: found a result without units, as CSV files are; expected one of .parquet, .nc or .mat"
        )
    panels = _panels(result, names or _positions(result))
    figure, all_axes = plt.subplots(
        len(panels), 1, sharex=True, squeeze=False, layout="constrained",
        figsize=(WIDTH, max(HEIGHT * len(panels), 1.5 * HEIGHT)),
    )  # fmt: skip
    for axes, (unit, signals) in zip(all_axes[:, 0], panels.items(), strict=True):
        for time, _ in result.events:
            axes.axvline(time, color=EVENT_COLOR, linewidth=0.5, zorder=0)
        turned = degrees and unit in IN_DEGREES
        for name in signals:
            values = result[name] / DEGREE if turned else result[name]
            axes.plot(result.time, values, linewidth=1.4, label=name)
        axes.set_ylabel("" if unit == "1" else IN_DEGREES[unit] if turned else unit)
        axes.grid(alpha=0.3)
        if len(signals) <= MAX_IN_LEGEND:
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")
    all_axes[-1, 0].set_xlabel("time [s]")
    if len(result):
        all_axes[-1, 0].set_xlim(result.time[0], result.time[-1] if len(result) > 1 else None)
    plt.close(figure)  # the figure is the caller's, and notebooks would show it twice
    return figure


def _positions(result: Result) -> list[str]:
    found = [name for name in result.names if result.units.get(name) in POSITIONS]
    return found or list(result.names)


def _panels(result: Result, names: Sequence[str]) -> dict[str, list[str]]:
    """Return the signals by unit, in the order in which they are named."""
    from gelenk.simulation.run import expanded

    chosen = expanded(names, result.names)
    check_names(chosen, result.names, "signal")
    out: dict[str, list[str]] = {}
    for name in chosen:
        out.setdefault(result.units.get(name, ""), []).append(name)
    if not out:
        raise UsageError("the result has no signals to plot")
    return out
