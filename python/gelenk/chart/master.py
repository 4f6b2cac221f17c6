# SPDX-License-Identifier: BSD-3-Clause
"""Cost per communication step with a new torque at every step."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gelenk.chart.case import Case
from gelenk.chart.measure import Reference, Run, Task
from gelenk.chart.methods import Method
from gelenk.chart.reference import references
from gelenk.chart.scenes import stability_cases
from gelenk.chart.tables import rows
from gelenk.chart.work_precision import run_all, timed
from gelenk.chart.workers import Failure
from gelenk.errors import UsageError

TOLERANCES = (1e-4, 1e-6, 1e-8)


def master_case() -> Case:
    """Return the test case: the four-bar for 5 s with communication steps of 1 ms."""
    (case,) = (case for case in stability_cases() if case.name == "torque-steps-1e-3")
    return case


def master_runs(
    methods: Sequence[Method],
    tolerances: Sequence[float] = TOLERANCES,
    jobs: int = 1,
    limit: float = 10.0,
    rounds: int = 5,
    case: Case | None = None,
) -> tuple[list[Run], Reference]:
    """Run and time every method at the tolerances; methods with fixed steps take one per communication step.

    Args:
        methods: Methods to be compared.
        tolerances: Relative tolerances.
        jobs: Number of concurrent processes.
        limit: Wall-clock limit of one run [s].
        rounds: Number of timing rounds; the smallest time counts.
        case: Test case; `master_case()` by default.

    Returns:
        The runs, and the reference solution from which their errors are measured.

    Raises:
        UsageError: there is no reference solution because no two methods agree.
    """
    case = master_case() if case is None else case
    truth = references([case], jobs, max(60.0, limit))
    found = truth[case.name]
    if isinstance(found, Failure):
        raise UsageError(found.reason)
    tasks = [
        Task(case, method, tolerance, case.step if method.fixed_step else None)
        for method in methods
        for tolerance in ((None,) if method.fixed_step else tolerances)
    ]
    runs = timed(tasks, run_all(tasks, truth, jobs, limit), rounds)
    return runs, found


def master_table(runs: Sequence[Run], steps: int, tolerances: Sequence[float] = TOLERANCES) -> str:
    """Return the table of CPU time [µs] and evaluations per communication step and of the errors.

    Args:
        runs: Runs of `master_runs`.
        steps: Number of communication steps of a run.
        tolerances: Tolerances in the columns.
    """
    header = ["method"]
    for tolerance in tolerances:
        header += [f"{tolerance:.0e}: µs", "evaluations", "error"]
    lines = []
    for name in dict.fromkeys(run.method for run in runs):
        cells = [name]
        for tolerance in tolerances:
            run = next(r for r in runs if r.method == name and r.asked in (None, tolerance))
            cells += _cells(run, steps)
        lines.append(cells)
    return rows(header, lines)


def _cells(run: Run, steps: int) -> tuple[str, str, str]:
    if not run.finished:
        return run.outcome, "", ""
    wrong = " wrong" if run.outcome == "wrong" else ""
    return f"{1e6 * run.cpu / steps:.2f}", f"{run.evaluations / steps:.1f}", f"{run.error:.0e}{wrong}"


def ida_fraction(runs: Sequence[Run], tolerance: float) -> tuple[float, float]:
    """Return CPU time and error of `auto` relative to projection+ida at a tolerance, or NaN."""
    found = {run.method: run for run in runs if run.asked == tolerance}
    auto, ida = found.get("auto"), found.get("projection+ida")
    if auto is None or ida is None or not (auto.finished and ida.finished):
        return math.nan, math.nan
    return auto.cpu / ida.cpu, auto.error / ida.error
