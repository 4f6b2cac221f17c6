# SPDX-License-Identifier: BSD-3-Clause
"""Generated parts of docs/nonsmooth-measurements.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from benchmarks.nonsmooth.judge import Verdict
from benchmarks.nonsmooth.problems import Problem
from benchmarks.nonsmooth.runs import Run

from gelenk.chart.tables import rows


def chart(problem: Problem, runs: Sequence[Run], picture: str) -> str:
    """Return the picture of a problem with its description."""
    return f"![{problem.title}: cost against error](pictures/{picture})\n\n{problem.about} {len(runs)} runs."


def goals(problems: Sequence[Problem], runs: Sequence[Run]) -> str:
    """Return a table of the cost of the errors that Gelenk and the best regularized law reach."""
    lines = []
    for problem in problems:
        mine = [run for run in runs if run.problem == problem.name and not run.reason]
        auto = next(run for run in mine if run.series == "auto" and abs(run.setting - 1e-8) < 1e-12)
        laws = [run for run in mine if run.group == "regularized"]
        best = min(laws, key=lambda run: run.error, default=None)
        others = (
            ["not run", "", ""]
            if best is None
            else [f"{best.series}, {best.setting:g}", f"{best.error:.1e}", f"{best.evaluations:.0f}"]
        )
        lines.append(
            [problem.title, str(problem.events), f"{auto.error:.1e}", f"{1e3 * auto.cpu:.2g}",
             f"{auto.evaluations:.0f}", *others]
        )  # fmt: skip
    return rows(
        ["problem", "events", "error of `auto` at 1e-8", "CPU [ms/s]", "evaluations/s",
         "best regularized law", "its error", "its evaluations/s"], lines,
    )  # fmt: skip


def outcomes(verdicts: Sequence[Verdict], integrators: Sequence[str]) -> str:
    """Return a table of the outcomes by family and integrator."""
    lines = []
    for family in dict.fromkeys(v.trial.family for v in verdicts):
        mine = [v for v in verdicts if v.trial.family == family]
        cells = [family, str(sum(v.integrator == integrators[0] for v in mine))]
        for name in integrators:
            counts = Counter(v.outcome for v in mine if v.integrator == name)
            bad = [f"{counts[o]} {o}" for o in ("count", "wrong", "refused") if counts[o]]
            cells.append(", ".join(bad) or "right")
        lines.append(cells)
    return rows(["trials", "number", *(f"`{name}`" for name in integrators)], lines)


def findings(verdicts: Sequence[Verdict]) -> str:
    """Return a table of the trials that are not right, those with the same outcome together."""
    bad: dict[tuple[str, str, str], list[Verdict]] = {}
    for v in verdicts:
        if v.outcome in ("wrong", "refused"):
            bad.setdefault((v.trial.family, v.trial.row, v.trial.column), []).append(v)
    groups: dict[tuple[str, str, str, str], list[tuple[str, list[Verdict]]]] = {}
    for (family, row, column), mine in bad.items():
        key = (family, column, mine[0].outcome, ", ".join(v.integrator for v in mine))
        groups.setdefault(key, []).append((row, mine))
    lines = []
    for (family, column, outcome, names), found in groups.items():
        worst = max((v for _, mine in found for v in mine), key=lambda v: v.error)
        much = f"error {worst.error:.1e}" if outcome == "wrong" else worst.words.split(". The ")[0]
        lines.append([family, column, "; ".join(row for row, _ in found), names, f"{outcome}: {much}"])
    if not lines:
        return "All trials are right."
    return rows(["trials", "column", "rows", "integrators", "outcome"], lines)
