# SPDX-License-Identifier: BSD-3-Clause
"""Work of the cone solvers against their residual, over problems with known solutions and recorded ones."""

from __future__ import annotations

import csv
import io
import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gelenk import _core
from gelenk.chart import tables
from gelenk.chart.cone_problems import COUNT, ConeProblem, cone_problem
from gelenk.chart.recorded_cones import RecordedScene, record
from gelenk.errors import UsageError
from gelenk.file_writing import write_text
from gelenk.model.values import unknown

KINDS = ("dense", "chain", "redundant", "spheres", "boxes", "loops")  # the last three: recorded from scenes
TIGHTEST = 1e-13  # relative residual at which the runs end
LEVELS = tuple(10.0 ** (-k / 2) for k in range(2, 25))  # relative residuals of the chart
REPORTED = (1e-8, 1e-10)  # those of the table
ITERATIONS = 3000
ROUNDS = 3  # each run is timed several times; the least time counts
LONG = 0.3  # s; longer runs are timed once


@dataclass(frozen=True)
class ConeRun:
    """One solver on one problem.

    `residuals` are relative to the largest entry of b, at the start and after each iteration; `products` and
    `seconds` are the work up to then.
    """

    problem: int
    kind: str
    solver: str
    products: list[int]
    seconds: list[float]
    residuals: list[float]

    def work(self, level: float) -> tuple[float, float]:
        """Return products and seconds until the residual is at most `level`; infinity if it never is."""
        for products, seconds, residual in zip(self.products, self.seconds, self.residuals, strict=True):
            if residual <= level:
                return products, seconds
        return math.inf, math.inf


def solver_names() -> list[str]:
    """Return the names of the solvers; the first is the default."""
    return [name for name, _ in _core.cone_solvers()]


def study(
    solvers: Sequence[str] | None = None,
    numbers: Sequence[int] = range(COUNT),
    exact_coulomb: bool = False,
    recorded: Sequence[RecordedScene] = (),
    progress: Callable[[str, float], None] | None = None,
) -> list[ConeRun]:
    """Run solvers on problems.

    Args:
        solvers: Names; default: all.
        numbers: Problems, 0 to 99.
        exact_coulomb: Solve Coulomb's law with the same G, b and coefficients, whose solutions are not known
            in advance, instead of the convex problems.
        recorded: Scenes from which further problems are taken, numbered from 100 on.
        progress: Called with the current activity and the completed fraction.

    Raises:
        UsageError: a solver is unknown.
    """
    known = solver_names()
    faults = [unknown(name, "cone solver", known) for name in solvers or [] if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    chosen = list(solvers or known)
    problems = [(number, *from_arrays(cone_problem(number))) for number in numbers]
    problems += [(COUNT + k, *found) for k, found in enumerate(record(recorded, progress))]
    runs = []
    for k, (number, kind, problem) in enumerate(problems):
        if progress is not None:
            progress("cone problems", k / len(problems))
        runs += [measured(number, kind, problem, solver, exact_coulomb) for solver in chosen]
    return runs


def from_arrays(problem: ConeProblem) -> tuple[str, _core.ConeProblem]:
    """Return the kind of a problem with a known solution, and the problem as solvers take it."""
    cones = []
    for i, friction in enumerate(problem.friction):
        cone = _core.Cone.contact(3 * i, friction)
        cone.tangential = 2  # also without friction
        cones.append(cone)
    return problem.kind, _core.ConeProblem(problem.G, problem.b, cones)


def measured(number: int, kind: str, problem: _core.ConeProblem, solver: str, exact_coulomb: bool) -> ConeRun:
    """Run one solver on one problem, from x = 0."""
    scale = float(np.abs(problem.b).max())
    rounds: list[list[tuple[int, float, float]]] = []
    while len(rounds) < ROUNDS and not (rounds and rounds[-1][-1][1] > LONG):
        found = problem.solve(solver, TIGHTEST * scale, ITERATIONS, exact_coulomb)
        rounds.append(found.history)
    products, _, residuals = zip(*rounds[0], strict=True)
    seconds = [min(times) for times in zip(*([t for _, t, _ in one] for one in rounds), strict=True)]
    return ConeRun(number, kind, solver, list(products), seconds, [r / scale for r in residuals])


def median_work(runs: Sequence[ConeRun], level: float) -> tuple[float, float]:
    """Return the medians of products and seconds; runs that do not reach the level count as infinite."""
    works = [run.work(level) for run in runs]
    return statistics.median_high(p for p, _ in works), statistics.median_high(s for _, s in works)


def solved(runs: Sequence[ConeRun], level: float) -> int:
    """Return the number of runs that reach the level."""
    return sum(math.isfinite(run.work(level)[0]) for run in runs)


def table(runs: Sequence[ConeRun]) -> str:
    """Return a table of the problems solved and the median work, by solver."""
    kinds = [kind for kind in KINDS if any(run.kind == kind for run in runs)]
    count = {kind: len({run.problem for run in runs if run.kind == kind}) for kind in kinds}
    header = ["solver"]
    levels = " / ".join(f"{level:.0e}" for level in REPORTED)
    header += [f"{kind}: solved of {count[kind]} to {levels}" for kind in kinds]
    header += ["products to 1e-8, median", "CPU to 1e-8, median [µs]"]
    lines = []
    for solver in dict.fromkeys(run.solver for run in runs):
        mine = [[run for run in runs if run.solver == solver and run.kind == kind] for kind in kinds]
        works = [median_work(part, REPORTED[0]) for part in mine]
        lines.append(
            [
                f"`{solver}`",
                *(" / ".join(str(solved(part, level)) for level in REPORTED) for part in mine),
                " / ".join("-" if math.isinf(p) else f"{p:.0f}" for p, _ in works),
                " / ".join("-" if math.isinf(s) else f"{1e6 * s:.0f}" for _, s in works),
            ]
        )
    return tables.rows(header, lines)


def write(runs: Sequence[ConeRun], path: Path) -> None:
    """Write the work at each level as CSV; empty cells: not reached. Raises OSError."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["problem", "kind", "solver", "residual", "products", "seconds"])
    for run in runs:
        for level in LEVELS:
            products, seconds = run.work(level)
            cells = ["", ""] if math.isinf(products) else [f"{products:.0f}", f"{seconds:.3g}"]
            writer.writerow([run.problem, run.kind, run.solver, f"{level:.3g}", *cells])
    write_text(path, text.getvalue())
