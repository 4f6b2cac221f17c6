# SPDX-License-Identifier: BSD-3-Clause
"""The picture of a study of cone solvers: work and failures against residual."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gelenk.chart.cones import KINDS, LEVELS, ConeRun, median_work, solved
from gelenk.chart.style import save
from gelenk.extras import pyplot

COLORS = {
    "hybrid": "black", "newton": "#D55E00", "p-spg-fb": "#0072B2", "apgd": "#009E73", "admm": "#CC79A7",
    "gauss-seidel": "#E69F00",
}  # fmt: skip
DASHES = {"newton": (0, (4, 2)), "hybrid": "-"}  # where both lie on each other, both are seen
SPARE = "#4B4B4B"
TITLES = {
    "dense": "dense: eigenvalues to 1 : 1e6",
    "chain": "chain: stacks of unequal bodies",
    "redundant": "redundant: half the rank",
    "spheres": "recorded: heaps of spheres",
    "boxes": "recorded: walls of boxes",
    "loops": "recorded: boxes on a linkage",
}


def draw(runs: Sequence[ConeRun], path: Path, exact_coulomb: bool = False) -> None:
    """Write the picture as PNG: a column for each kind of problem.

    Raises:
        UsageError: matplotlib is not installed.
        OSError: the file cannot be written.
    """
    plt = pyplot()
    kinds = [kind for kind in KINDS if any(run.kind == kind for run in runs)]
    solvers = list(dict.fromkeys(run.solver for run in runs))
    figure, axes = plt.subplots(
        3, len(kinds), figsize=(3.4 * len(kinds) + 1.2, 9.2), sharex=True, sharey="row", squeeze=False,
        layout="constrained", gridspec_kw={"height_ratios": [3, 3, 2]},
    )  # fmt: skip
    for j, kind in enumerate(kinds):
        mine = {solver: [r for r in runs if r.kind == kind and r.solver == solver] for solver in solvers}
        total = len(mine[solvers[0]])
        axes[0][j].set_title(f"{TITLES[kind]} ({total} problems)", fontsize=9)
        for solver in solvers:
            works = np.array([median_work(mine[solver], level) for level in LEVELS])
            works[np.isinf(works)] = math.nan
            axes[0][j].plot(LEVELS, works[:, 0], **_look(solver))
            axes[1][j].plot(LEVELS, 1e6 * works[:, 1], **_look(solver))
            share = [100 * (1 - solved(mine[solver], level) / total) for level in LEVELS]
            axes[2][j].plot(LEVELS, share, **_look(solver))
        _axes(axes[:, j])
    for row, label in enumerate(("products with G, median", "CPU time [µs], median", "not solved [%]")):
        axes[row][0].set_ylabel(label)
    handles = [axes[0][0].plot([], [], label=solver, **_look(solver))[0] for solver in solvers]
    figure.legend(handles=handles, loc="outside right center", fontsize=9, handlelength=3)
    law = "Coulomb's law" if exact_coulomb else "convex problems"
    title = f"Cone solvers: work and failures against residual, {law}"
    figure.suptitle(title, fontsize=12, fontweight="bold")
    save(figure, path, 85)
    plt.close(figure)


def _look(solver: str) -> dict[str, Any]:
    first = solver == "hybrid"
    return {"color": COLORS.get(solver, SPARE), "linestyle": DASHES.get(solver, "-"),
            "linewidth": 2.6 if first else 1.6, "zorder": 2 if first else 3}  # fmt: skip


def _axes(axes: Any) -> None:
    for axis in axes:
        axis.set_xscale("log")
        axis.grid(which="major", alpha=0.35)
    axes[0].set_xlim(LEVELS[0], LEVELS[-1])  # accuracy increases to the right
    axes[0].set_yscale("log")
    axes[1].set_yscale("log")
    axes[2].set_ylim(-3, 103)
    axes[2].set_xlabel("residual / largest |b|")
