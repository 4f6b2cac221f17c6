# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of docs/nonsmooth-measurements.md: work-precision diagrams and the failure map."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.nonsmooth.judge import Verdict
from benchmarks.nonsmooth.problems import Problem
from benchmarks.nonsmooth.runs import Run

from gelenk.chart.style import COLORS, save
from gelenk.extras import pyplot

LOOKS: dict[str, dict[str, Any]] = {
    "auto": {"color": "black", "marker": "o", "linewidth": 2.6, "markersize": 6, "zorder": 5},
    **{name: {"color": COLORS[name], "marker": "o"} for name in ("erk", "cvode", "ida", "dirk", "rk4")},
    "tanh": {"color": "#7F3C8D", "marker": "s", "linestyle": "--"},
    "proportional zone": {"color": "#8C564B", "marker": "D", "linestyle": "--"},
    "bristle": {"color": "#C44E9A", "marker": "^", "linestyle": "--"},
    "spring stop": {"color": "#7F3C8D", "marker": "s", "linestyle": "--"},
    "MuJoCo": {"color": "#B22222", "marker": "v", "linestyle": ":"},
    "EXUDYN": {"color": "#6B8E23", "marker": "P", "linestyle": ":"},
}
SMALLEST, LARGEST = 1e-14, 3.0  # errors are drawn within
ROW = 0.17  # inches, of a series in the band of runs that did not finish


def label(run: Run) -> str:
    return {"engine": f"{run.series} (run here)", "cited": f"{run.series} (cited)"}.get(run.group, run.series)


def draw(problem: Problem, runs: Sequence[Run], path: Path) -> None:
    """Write the work-precision diagram of a problem."""
    plt = pyplot()
    unfinished = list(dict.fromkeys(run.series for run in runs if run.reason))
    band = ROW * max(1, len(unfinished)) + 0.1
    figure, axes = plt.subplots(
        2, 2, figsize=(12.5, 4.4 + band), sharex=True, layout="constrained",
        gridspec_kw={"height_ratios": [band, 4.4]},
    )  # fmt: skip
    handles: dict[str, Any] = {}
    quantities = {
        "cpu": "CPU time per simulated second [ms]",
        "evaluations": "evaluations per simulated second",
    }
    for column, (quantity, words) in enumerate(quantities.items()):
        _lines(axes[1][column], runs, quantity, handles)
        axes[1][column].set_ylabel(words)
        _band(axes[0][column], runs, unfinished, named=column == 0)
    axes[0][0].set_title("not finished × (at its tolerance, step or width)", fontsize=8, loc="left")
    figure.legend(handles.values(), handles.keys(), loc="outside right center", fontsize=8, handlelength=3.2)
    figure.suptitle(f"{problem.title}: {problem.times[-1]:g} s\n", fontsize=13, fontweight="bold")
    figure.text(0.01, 0.945, problem.about, fontsize=8, color="#444444", va="top")
    save(figure, path, 85)
    plt.close(figure)


def _lines(axis: Any, runs: Sequence[Run], quantity: str, handles: dict[str, Any]) -> None:
    factor = 1e3 if quantity == "cpu" else 1.0
    for name in dict.fromkeys(label(run) for run in runs):
        mine = [run for run in runs if label(run) == name and not run.reason]
        shown = [(run.error, factor * getattr(run, quantity)) for run in mine if getattr(run, quantity) > 0]
        if not shown:
            continue
        look = {"markersize": 4.5, "linewidth": 1.4, "zorder": 3} | LOOKS[mine[0].series]
        if mine[0].group == "cited":
            look |= {"linestyle": "", "markerfacecolor": "white", "markersize": 7}
        x = [min(LARGEST, max(SMALLEST, error)) for error, _ in shown]
        (line,) = axis.plot(x, [y for _, y in shown], **look)
        handles.setdefault(name, line)
        if mine[0].group in ("regularized", "engine"):
            for run, place in ((mine[0], shown[0]), (mine[-1], shown[-1])):
                words = f"{run.setting:.0e}".replace("e-0", "e-").replace("e+0", "e")
                offset = {"xytext": (4, 3), "textcoords": "offset points"}
                axis.annotate(words, place, fontsize=6, color=look["color"], **offset)
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlim(2 * LARGEST, SMALLEST / 2)  # accuracy increases to the right
    axis.set_xlabel("largest error of positions [m, rad] at the reference times")
    axis.grid(which="major", alpha=0.35)


def _band(axis: Any, runs: Sequence[Run], names: Sequence[str], named: bool) -> None:
    axis.set_facecolor("#f6f1ea")
    axis.set_ylim(max(1, len(names)) - 0.3, -0.7)
    axis.set_yticks(range(len(names)), names if named else [""] * len(names))
    axis.tick_params(axis="y", labelsize=7, length=0)
    axis.tick_params(axis="x", which="both", length=0)
    for row, name in enumerate(names):
        settings = [min(1.0, run.setting) for run in runs if run.series == name and run.reason]
        axis.plot(settings, [row] * len(settings), "x", color=LOOKS[name]["color"], markersize=5)
    if not names:
        axis.text(0.5, 0.5, "all runs finished", transform=axis.transAxes, ha="center", va="center",
                  fontsize=8, color="#666666")  # fmt: skip


FILL = {"right": "#a9dcb3", "count": "#d9e8a0", "wrong": "#ffb000", "refused": "#5b8ccf"}
MEANING = {
    "right": "right",
    "count": "right, but another number of events",
    "wrong": "wrong: error over 100 × tolerance",
    "refused": "refused with an error message",
}
CELL, LINE = 0.62, 0.15  # inches
LEFT, HEAD = 2.75, 0.52  # inches: row names; title and column names of a family


def draw_map(verdicts: Sequence[Verdict], integrators: Sequence[str], path: Path) -> None:
    """Write the failure map: a table for each family, each cell divided among the integrators."""
    plt = pyplot()
    families = list(dict.fromkeys(v.trial.family for v in verdicts))
    tables = [_table([v for v in verdicts if v.trial.family == family]) for family in families]
    heights = [HEAD + LINE * len(rows) + 0.12 for rows, _, _ in tables]
    half, columns = sum(heights) / 2, [[], []]  # type: tuple[float, list[list[int]]]
    for k in range(len(families)):
        first = sum(heights[i] for i in columns[0]) + heights[k] / 2 <= half
        columns[0 if first and not columns[1] else 1].append(k)
    width = [LEFT + CELL * max(len(tables[k][1]) for k in column) + 0.15 for column in columns]
    size = sum(width), max(sum(heights[k] for k in column) for column in columns) + 0.75
    figure = plt.figure(figsize=size)
    for side, column in enumerate(columns):
        top = size[1] - 0.4
        for k in column:
            rows, names, cells = tables[k]
            x, high = side * width[0] + LEFT, LINE * len(rows)
            place = (x / size[0], (top - HEAD - high) / size[1], CELL * len(names) / size[0], high / size[1])
            _family(figure.add_axes(place), plt, families[k], rows, names, cells, integrators)
            top -= heights[k]
    figure.text(0.1 / size[0], 1 - 0.08 / size[1], "Failure map at a tolerance of 1e-8", va="top",
                fontsize=13, fontweight="bold")  # fmt: skip
    handles = [plt.Rectangle((0, 0), 1, 1, facecolor=FILL[o]) for o in MEANING]
    figure.legend(handles, list(MEANING.values()), loc="lower left", bbox_to_anchor=(0.0, 0.12 / size[1]),
                  ncols=4, fontsize=8, frameon=False)  # fmt: skip
    stripes = ", ".join(integrators)
    figure.text(0.1 / size[0], 0.08 / size[1], f"Stripes of a cell, from the left: {stripes}.", fontsize=8)
    save(figure, path, 85)
    plt.close(figure)


Table = tuple[list[str], list[str], dict[tuple[str, str], dict[str, str]]]


def _table(verdicts: Sequence[Verdict]) -> Table:
    rows = list(dict.fromkeys(v.trial.row for v in verdicts))
    names = list(dict.fromkeys(v.trial.column for v in verdicts))
    cells: dict[tuple[str, str], dict[str, str]] = {}
    for v in verdicts:
        cells.setdefault((v.trial.row, v.trial.column), {})[v.integrator] = v.outcome
    return rows, names, cells


def _family(axis: Any, plt: Any, title: str, rows: Sequence[str], names: Sequence[str],
            cells: dict[tuple[str, str], dict[str, str]], integrators: Sequence[str]) -> None:  # fmt: skip
    axis.set_xlim(0, len(names))
    axis.set_ylim(len(rows), 0)
    axis.set_axis_off()
    for j, name in enumerate(names):
        axis.text(
            j + 0.5,
            -0.15,
            name.replace(" ", "\n", 1) if len(name) > 13 else name,
            ha="center",
            va="bottom",
            fontsize=6,
        )
    above = {"xytext": (-5, 3), "textcoords": "offset points", "ha": "right", "va": "bottom"}
    axis.annotate(title, (0, 0), fontsize=8, fontweight="bold", **above)
    for i, row in enumerate(rows):
        axis.text(-0.08, i + 0.5, row, ha="right", va="center", fontsize=6.3)
        for j, name in enumerate(names):
            found = cells.get((row, name), {})
            for k, integrator in enumerate(integrators):
                fill = FILL.get(found.get(integrator, ""), "#f2f2f2")
                wide = 0.94 / len(integrators)
                axis.add_patch(
                    plt.Rectangle((j + 0.03 + k * wide, i + 0.08), wide, 0.84, facecolor=fill, linewidth=0)
                )
