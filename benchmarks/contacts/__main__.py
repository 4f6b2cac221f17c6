# SPDX-License-Identifier: BSD-3-Clause
"""Measure contacts against known motions for docs/nonsmooth-measurements.md: part of `make nonsmooth`.

The picture is written to docs/pictures/, all figures as CSV to out/nonsmooth/. MuJoCo, Drake and EXUDYN run
if they are installed. `--quick` runs two steps of each series and writes to out/nonsmooth/ only, as a test.
"""

from __future__ import annotations

import csv
import dataclasses
import importlib.util
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from benchmarks.contacts import draw, engines, problems
from benchmarks.contacts.problems import Problem
from benchmarks.page_parts import NonsmoothStudy, quick_parser

from gelenk.chart.tables import rows

MAKER = "benchmarks/contacts"
STEPS = (1e-2, 1e-3, 1e-4, 1e-5)  # s
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)  # of located events
ROUNDS = 3  # of runs that take less than a second; the fastest counts
LONGEST = 15.0  # s of CPU time, expected of a run
EXACT = 1e-9  # m, rad; smaller errors are those of rounding and of the cone solver


@dataclass(frozen=True)
class Run:
    """A run; error and CPU time are NaN if there is a reason why it has none."""

    problem: str
    series: str
    step: float  # s; of located events: the tolerance
    error: float = math.nan  # largest at the reference times [m, rad]
    cpu: float = math.nan  # s per simulated second
    reason: str = ""

    @property
    def per_step(self) -> float:
        """CPU time per step [us]."""
        return 1e6 * self.cpu * self.step


def runs_of(problem: Problem, count: int) -> Iterator[Run]:
    """Run all series with their first `count` steps or tolerances."""
    for series, (package, runner) in engines.SERIES.items():
        if importlib.util.find_spec(package) is None:
            continue
        least = 0.0
        settings = (TOLERANCES if series == engines.EVENTS else STEPS)[:count]
        for n, h in enumerate(settings):
            if n > 0 and series != engines.EVENTS and least * settings[n - 1] / h > LONGEST:
                break
            try:
                poses, least = runner(problem, h)
                for _ in range(ROUNDS - 1 if least < 1 else 0):
                    least = min(least, runner(problem, h)[1])
            except engines.NotOfferedError as reason:
                yield Run(problem.name, series, h, reason=str(reason))
                break
            except (RuntimeError, ValueError) as reason:
                yield Run(problem.name, series, h, reason=f"failed: {str(reason).splitlines()[0]}")
                continue
            yield Run(problem.name, series, h, problem.error(poses), least / problem.times[-1])


def order(found: list[Run]) -> str:
    """Return the order that a straight line through the errors has."""
    shown = [run for run in found if run.series == "Gelenk, steps"]
    if max(run.error for run in shown) < EXACT:
        return "exact"
    slope = np.polyfit(np.log([run.step for run in shown]), np.log([run.error for run in shown]), 1)[0]
    return f"{slope:.1f}"


def cells_of_best(others: list[Run], cost: Callable[[Run], float]) -> list[str]:
    """Return the series with the smallest error, its error and its cost; empty cells if there are no runs."""
    if not others:
        return ["", "", ""]
    best = min(others, key=lambda run: run.error)
    return [best.series, f"{best.error:.1e}", f"{cost(best):.1f}"]


def table(chosen: list[Problem], found: list[Run]) -> str:
    lines = []
    for problem in chosen:
        mine = [run for run in found if run.problem == problem.name]
        at = [run for run in mine if abs(run.step - 1e-3) < 1e-9 and not run.reason]
        own = next(run for run in at if run.series == "Gelenk, steps")
        cells = [problem.title, f"{own.error:.1e}", f"{own.per_step:.1f}", order(mine)]
        others = [run for run in at if run is not own and run.series != engines.EVENTS]
        lines.append(cells + cells_of_best(others, lambda run: run.per_step))
    return rows(
        ["problem, steps of 1 ms", "error [m, rad]", "µs per step", "order", "best of the others",
         "its error", "its µs per step"], lines,
    )  # fmt: skip


def table_of_events(chosen: list[Problem], found: list[Run]) -> str:
    lines = []
    for problem in chosen:
        mine = [run for run in found if run.problem == problem.name]
        located = [run for run in mine if run.series == engines.EVENTS]
        cells = [problem.title, *(run.reason or f"{run.error:.1e}" for run in located)]
        cells.append(" / ".join(f"{1e3 * run.cpu:.1f}" for run in located))
        others = [run for run in mine if not run.series.startswith("Gelenk") and not run.reason]
        lines.append(cells + cells_of_best(others, lambda run: 1e3 * run.cpu))
    heads = [f"error at {run.step:g} [m, rad]" for run in located]
    return rows(
        ["problem, located events", *heads, "ms per simulated second", "best of the others at any step",
         "its error", "its ms per simulated second"], lines,
    )  # fmt: skip


def main() -> None:
    study = NonsmoothStudy("nonsmooth-measurements.md", quick_parser(__doc__).parse_args().quick)
    chosen = problems.problems()
    found: list[Run] = []
    for problem in chosen:
        found += runs_of(problem, 2 if study.quick else len(STEPS))
        print(f"{problem.title}: {sum(run.problem == problem.name for run in found)} runs", flush=True)
    with (study.numbers / "contacts.csv").open("w", encoding="utf-8", newline="") as file:
        out = csv.DictWriter(file, [field.name for field in dataclasses.fields(Run)])
        out.writeheader()
        out.writerows(dataclasses.asdict(run) for run in found)
    picture = study.pictures / "contacts.png"
    draw.draw(chosen, found, picture)
    shown = f"![work against error of contacts](pictures/{picture.name})\n\n{table(chosen, found)}"
    study.put(MAKER, {"contacts": shown, "events": table_of_events(chosen, found)})


if __name__ == "__main__":
    main()
