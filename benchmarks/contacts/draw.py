# SPDX-License-Identifier: BSD-3-Clause
"""The picture of contacts in docs/nonsmooth-measurements.md: work against error, a panel for each problem."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.contacts.problems import Problem

from gelenk.chart.style import save
from gelenk.extras import pyplot

LOOKS: dict[str, dict[str, Any]] = {
    "Gelenk, steps": {"color": "black", "marker": "o", "linewidth": 2.4, "markersize": 6, "zorder": 5},
    "Gelenk, events": {"color": "#009E73", "marker": "*", "linewidth": 2.4, "markersize": 9, "zorder": 6},
    "MuJoCo": {"color": "#B22222", "marker": "v", "linestyle": ":"},
    "MuJoCo, contacts of 2 steps": {"color": "#B22222", "marker": "v"},
    "MuJoCo, contacts of 10 steps": {"color": "#E08214", "marker": "v"},
    "Drake SAP": {"color": "#1F78B4", "marker": "s", "linestyle": ":"},
    "Drake SAP, tightened": {"color": "#1F78B4", "marker": "s"},
    "Drake lagged": {"color": "#7F3C8D", "marker": "D", "linestyle": ":"},
    "Drake lagged, tightened": {"color": "#7F3C8D", "marker": "D"},
    "EXUDYN": {"color": "#6B8E23", "marker": "P", "linestyle": ":"},
    "EXUDYN, tightened": {"color": "#6B8E23", "marker": "P"},
}
SMALLEST, LARGEST = 1e-15, 0.3  # m, rad; what has a larger error has failed: fallen over, not bounced
COLUMNS = 4


def draw(problems: Sequence[Problem], runs: Sequence[Any], path: Path) -> None:
    """Write the picture.

    Args:
        problems: the problems.
        runs: of all of them, with the attributes of `Run` in `benchmarks.contacts.__main__`.
        path: the file.
    """
    plt = pyplot()
    lines = -(-len(problems) // COLUMNS)
    figure, axes = plt.subplots(
        lines, COLUMNS, figsize=(15, 4.1 * lines + 0.5), sharex=True, layout="constrained"
    )
    handles: dict[str, Any] = {}
    for axis, problem in zip(axes.flat, problems, strict=False):
        _panel(axis, [run for run in runs if run.problem == problem.name], handles)
        axis.set_title(problem.title, fontsize=9, fontweight="bold")
    for row in axes:
        row[0].set_ylabel("CPU time per simulated second [ms]")
    for axis in axes[-1]:
        axis.set_xlabel("largest error [m, rad]")
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=5, fontsize=8)
    save(figure, path, 85)
    plt.close(figure)


def _panel(axis: Any, runs: Sequence[Any], handles: dict[str, Any]) -> None:
    axis.axvspan(LARGEST, 4 * LARGEST, color="#f6e6e0", zorder=0)
    missing = []
    for name in dict.fromkeys(run.series for run in runs):
        mine = [run for run in runs if run.series == name]
        shown = [run for run in mine if not run.reason]
        look = {"markersize": 4.5, "linewidth": 1.3, "zorder": 3} | LOOKS[name]
        missing += [f"{name}: {run.reason}" for run in mine if run.reason][:1]
        if not shown:
            continue
        x = [min(1.7 * LARGEST, max(SMALLEST, run.error)) for run in shown]
        (line,) = axis.plot(x, [1e3 * run.cpu for run in shown], **look)
        handles.setdefault(name, line)
        failed = [(x[k], 1e3 * run.cpu) for k, run in enumerate(shown) if not run.error < LARGEST]
        for place in failed:
            axis.plot(*place, "x", color="black", markersize=7, zorder=6)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlim(4 * LARGEST, SMALLEST / 2)  # accuracy increases to the right
    axis.grid(which="major", alpha=0.35)
    axis.text(
        1.2 * LARGEST, 0.5, "failed ×", transform=axis.get_xaxis_transform(), fontsize=6, ha="center",
        va="center", rotation=90,
    )  # fmt: skip
    words = {f"{text.split()[0].rstrip(',:')}: {text.split(': ', 1)[1]}" for text in missing}
    axis.text(
        0.98, 0.02, "\n".join(sorted(words)), transform=axis.transAxes, fontsize=6.5, va="bottom", ha="right",
        color="#555555",
    )  # fmt: skip
