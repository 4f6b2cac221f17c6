# SPDX-License-Identifier: BSD-3-Clause
"""The picture of a map of stiff poles: a panel for each method, cells colored by outcome."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from benchmarks.poles import PoleMap, short_power

from gelenk.chart.draw_stability import FILL, short
from gelenk.chart.measure import Run
from gelenk.chart.methods import Method
from gelenk.chart.outcome import Outcome
from gelenk.chart.style import save
from gelenk.extras import pyplot

LOOSE = 10.0  # error / tolerance
COSTLY = (
    10.0  # times the fewest evaluations of a run with the same time constant and tolerance that is not loose
)
LOOSE_FILL, COSTLY_FILL = "#eef0a0", "#d3dbd6"
MEANING = {
    FILL[Outcome.GOOD]: "good",
    COSTLY_FILL: "good, but over 10 × the fewest evaluations",
    LOOSE_FILL: "error of 10 to 100 × tolerance",
    FILL[Outcome.WRONG]: "wrong: error over 100 × tolerance, over 0.01 with fixed steps",
    FILL[Outcome.REFUSED]: "refused with an error message",
    FILL[Outcome.FAILED]: "failed: timeout or crash",
}
COLUMNS = 3
NARROWEST = 5  # cells, as wide as the heading of a panel
WIDTH, HEIGHT = 0.56, 0.36  # inches: cells
LEFT, TOP, GAP, HEAD, BOTTOM = 0.85, 0.35, 0.25, 0.68, 0.9  # inches: margins, between and above panels


def draw(found: PoleMap, path: Path) -> None:
    """Write the picture as PNG.

    Raises:
        UsageError: matplotlib is not installed.
        OSError: the file cannot be written.
    """
    plt = pyplot()
    methods = sorted(found.methods, key=lambda method: method.fixed_step)
    rows = len(found.settings.time_constants)
    widest = max(NARROWEST, *(len(found.asked(method)) for method in methods))
    lines = math.ceil(len(methods) / COLUMNS)
    panel = (GAP + WIDTH * widest, HEAD + HEIGHT * rows)
    width, height = LEFT + COLUMNS * panel[0], TOP + lines * panel[1] + BOTTOM
    figure = plt.figure(figsize=(width, height))
    for k, method in enumerate(methods):
        line, column = divmod(k, COLUMNS)
        count = len(found.asked(method))
        left, top = LEFT + column * panel[0], TOP + line * panel[1] + HEAD
        place = (left, height - top - HEIGHT * rows, WIDTH * count, HEIGHT * rows)
        axis = figure.add_axes(tuple(x / size for x, size in zip(place, 2 * (width, height), strict=True)))
        axis.set_xlim(0, count)
        axis.set_ylim(rows, 0)
        axis.set_axis_off()
        _panel(axis, plt, found, method, named=column == 0)
    figure.text(0.1 / width, 1 - 0.12 / height, _title(found), va="top", fontsize=13, fontweight="bold")
    _legend(figure, plt, width, height)
    save(figure, path, 80)
    plt.close(figure)


def _title(found: PoleMap) -> str:
    return "DC motor with a stiff armature: " + (
        "a new voltage every 10 ms" if found.settings.jumps else "constant voltage, read every 100 ms"
    )


def _panel(axis: Any, plt: Any, found: PoleMap, method: Method, named: bool) -> None:
    name = "auto" if method.automatic else method.integrator
    axis.text(0, -0.85, name, ha="left", va="bottom", fontsize=10, fontweight="bold")
    what, end = "step [s]" if method.fixed_step else "tolerance", max(NARROWEST, len(found.asked(method)))
    axis.text(end, -0.85, what, ha="right", va="bottom", fontsize=8, color="#333333")
    if named:
        axis.text(-0.12, -0.15, "L/R [s]", ha="right", va="bottom", fontsize=8, color="#333333")
    for j, asked in enumerate(found.asked(method)):
        axis.text(j + 0.5, -0.15, short_power(asked), ha="center", va="bottom", fontsize=8)
        for i, time_constant in enumerate(found.settings.time_constants):
            run = found.cell(method, time_constant, asked)
            fill = fill_of(found, method, time_constant, asked)
            axis.add_patch(plt.Rectangle((j + 0.02, i + 0.03), 0.96, 0.94, facecolor=fill, linewidth=0))
            first, second = cell_lines(run)
            axis.text(j + 0.5, i + 0.33, first, ha="center", va="center", fontsize=7.5, fontweight="bold")
            axis.text(j + 0.5, i + 0.75, second, ha="center", va="center", fontsize=6.5)
    for i, time_constant in enumerate(found.settings.time_constants):
        if named:
            axis.text(-0.12, i + 0.5, short_power(time_constant), ha="right", va="center", fontsize=8)


def fill_of(found: PoleMap, method: Method, time_constant: float, asked: float) -> str:
    """Return the color of a cell."""
    run = found.cell(method, time_constant, asked)
    if run.outcome != Outcome.GOOD or method.fixed_step:
        return FILL[Outcome(run.outcome)]
    if run.error > LOOSE * asked:
        return LOOSE_FILL
    others = [found.cell(m, time_constant, asked) for m in found.methods if not m.fixed_step]
    fewest = min(other.evaluations for other in others if other.error <= LOOSE * asked)
    return COSTLY_FILL if run.evaluations > COSTLY * fewest else FILL[Outcome.GOOD]


def cell_lines(run: Run) -> tuple[str, str]:
    """Return the error, of methods with error control relative to the tolerance, and the evaluations."""
    if not run.finished:
        return str(run.outcome), f"at {run.reached:.2g} s" if run.outcome == Outcome.REFUSED else ""
    return (short(run.error) if run.asked is None else ratio(run.error / run.asked)), count(run.evaluations)


def ratio(x: float) -> str:
    """Format an error relative to the tolerance."""
    if 9.5 <= x < 1000:
        return f"{x:.0f}"
    return f"{x:.2g}" if 0.095 <= x < 9.5 else short(x)


def count(evaluations: float) -> str:
    """Format a number of evaluations with k for thousands, M for millions."""
    for size, sign in ((1e6, "M"), (1e3, "k")):
        if evaluations >= 0.9995 * size:
            digits = 1 if evaluations < 9.95 * size else 0
            return f"{evaluations / size:.{digits}f}{sign}"
    return f"{evaluations:.0f}"


def _legend(figure: Any, plt: Any, width: float, height: float) -> None:
    handles = [plt.Rectangle((0, 0), 1, 1, facecolor=fill) for fill in MEANING]
    figure.legend(
        handles, list(MEANING.values()), loc="lower left", bbox_to_anchor=(0.0, 0.28 / height), ncols=3,
        fontsize=8, frameon=False, columnspacing=1.2,
    )  # fmt: skip
    figure.text(
        0.1 / width, 0.1 / height,
        "Cells: largest error of angle, speed and current divided by the tolerance, with fixed steps the "
        "error itself; below it the evaluations (k: thousands, M: millions).", fontsize=8, color="#333333",
    )  # fmt: skip
