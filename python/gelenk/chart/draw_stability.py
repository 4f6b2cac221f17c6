# SPDX-License-Identifier: BSD-3-Clause
"""The picture of a stability map: a table of cells colored by outcome."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import Any

from gelenk.chart.measure import Run
from gelenk.chart.methods import DEFAULT, Method
from gelenk.chart.outcome import Outcome
from gelenk.chart.stability import SKIPPED, Map
from gelenk.chart.style import save
from gelenk.extras import pyplot

FILL = {
    Outcome.GOOD: "#a9dcb3", Outcome.WRONG: "#ffe08a", Outcome.REFUSED: "#b9cfec", Outcome.FAILED: "#f0a39b",
    SKIPPED: "#eeeeee",
}  # fmt: skip
MEANING = {
    Outcome.GOOD: "good",
    Outcome.WRONG: "wrong: error over 100 × tolerance, over 0.01 with fixed steps",
    Outcome.REFUSED: "refused with an error message (framed: as expected)",
    Outcome.FAILED: "failed: timeout or crash",
}  # fmt: skip
WIDTH, HEIGHT, LEFT, TOP = 0.82, 0.52, 4.3, 0.85  # inches: cells, margins for the names of scenes and methods


def draw(found: Map, tolerance: float, path: Path) -> None:
    """Write the picture of one tolerance as PNG.

    Raises:
        UsageError: matplotlib is not installed.
        OSError: the file cannot be written.
    """
    plt = pyplot()
    rows, columns = len(found.cases), len(found.methods)
    width, height = LEFT + WIDTH * columns + 0.1, TOP + HEIGHT * rows + 0.75
    figure = plt.figure(figsize=(width, height))
    axis = figure.add_axes((LEFT / width, 0.65 / height, WIDTH * columns / width, HEIGHT * rows / height))
    axis.set_xlim(0, columns)
    axis.set_ylim(rows, 0)
    axis.set_axis_off()
    for j, method in enumerate(found.methods):
        axis.text(j + 0.5, -0.1, heading(method), ha="center", va="bottom", fontsize=7.5,
                  fontweight="bold" if method.automatic else "normal")  # fmt: skip
    for i, case in enumerate(found.cases):
        axis.text(-0.1, i + 0.2, case.name, ha="right", va="center", fontsize=8.5, fontweight="bold")
        about = textwrap.fill(case.about, 70)
        axis.text(-0.1, i + 0.66, about, ha="right", va="center", fontsize=6.8, color="#333333")
        for j, method in enumerate(found.methods):
            run = found.cell(case, method, tolerance)
            fill = (
                "white" if run is None else FILL[Outcome(run.outcome) if run.outcome != SKIPPED else SKIPPED]
            )
            axis.add_patch(plt.Rectangle((j + 0.02, i + 0.03), 0.96, 0.94, facecolor=fill, linewidth=0))
            if run is not None:
                _cell(axis, j, i, run)
            if run is not None and run.outcome == case.expected == Outcome.REFUSED:
                frame = plt.Rectangle(
                    (j + 0.04, i + 0.05), 0.92, 0.9, fill=False, edgecolor="#2e8b46", lw=1.8
                )
                axis.add_patch(frame)
    figure.text(0.008, 1 - 0.12 / height,
                f"Stability map: tolerance {tolerance:.0e}, fixed steps of 1 ms", va="top",
                fontsize=13, fontweight="bold")  # fmt: skip
    _legend(figure, plt, height)
    save(figure, path, 80)
    plt.close(figure)


def heading(method: Method) -> str:
    """Return a method's name, broken to the width of a column."""
    if method.automatic:
        return "auto"
    upper = "" if method.formulation == DEFAULT else method.formulation.replace("-", "-\n") + "\n"
    return upper + method.integrator.replace("-", "-\n")


def cell_lines(run: Run) -> tuple[str, ...]:
    """Return the lines of a cell: error, closure error and energy error, or outcome and reason."""
    if run.finished:
        return short(run.error), f"closure {short(run.position_residual)}", f"E {short(run.energy_error)}"
    if run.outcome == SKIPPED:
        return ("skipped",)
    if run.outcome == Outcome.REFUSED:
        return ("refused", f"at {run.reached:.3g} s")
    return ("failed", *textwrap.wrap(run.reason, 15)[:2])


def short(value: float) -> str:
    """Format a number with one digit and a short exponent, for instance 3e-9; NaN is `?`."""
    if math.isnan(value):
        return "?"
    if value == 0:
        return "0"
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def _cell(axis: Any, j: int, i: int, run: Run) -> None:
    first, *rest = cell_lines(run)
    text = axis.text
    text(j + 0.5, i + (0.3 if rest else 0.5), first, ha="center", va="center", fontsize=8, fontweight="bold")
    text(j + 0.5, i + 0.68, "\n".join(rest), ha="center", va="center", fontsize=6.2, linespacing=1.1)


def _legend(figure: Any, plt: Any, height: float) -> None:
    handles = [plt.Rectangle((0, 0), 1, 1, facecolor=FILL[o]) for o in MEANING]
    figure.legend(
        handles, list(MEANING.values()), loc="lower left", bbox_to_anchor=(0.0, 0.28 / height), ncols=4,
        fontsize=8, frameon=False,
    )  # fmt: skip
    figure.text(
        0.008, 0.1 / height,
        "Cells: largest error of joint positions and speeds; largest closure error of the loops [m, rad]; "
        "E: largest energy error relative to the largest kinetic energy. "
        "Formulation: projection unless another is named.", fontsize=8, color="#333333",
    )  # fmt: skip
