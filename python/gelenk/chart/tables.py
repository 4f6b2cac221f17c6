# SPDX-License-Identifier: BSD-3-Clause
"""Runs as Markdown tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from gelenk.chart.draw_stability import short
from gelenk.chart.measure import Run
from gelenk.chart.outcome import Outcome
from gelenk.chart.stability import SKIPPED, Map

SIGNS = {Outcome.GOOD: "", Outcome.WRONG: "wrong ", Outcome.REFUSED: "refused", Outcome.FAILED: "failed",
         SKIPPED: "skipped"}  # fmt: skip


def rows(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    whole = [header, ["---"] * len(header), *lines]
    return "\n".join("| " + " | ".join(line) + " |" for line in whole) + "\n"


def stability(found: Map, tolerances: Sequence[float]) -> str:
    """Return a table per tolerance: error, closure error and energy error, or the outcome."""
    parts = []
    for tolerance in tolerances:
        header = ["scene", *(method.name for method in found.methods)]
        lines = [
            [case.name, *(cell(found.cell(case, method, tolerance)) for method in found.methods)]
            for case in found.cases
        ]
        parts.append(
            f"Tolerance {tolerance:.0e}: error, closure error, energy error.\n\n" + rows(header, lines)
        )
    return "\n".join(parts)


def cell(run: Run | None) -> str:
    """Return the text of a cell."""
    if run is None:
        return ""
    sign = SIGNS[Outcome(run.outcome) if run.outcome != SKIPPED else SKIPPED]
    if not run.finished:
        return sign
    figures = (run.error, run.position_residual, run.energy_error)
    return f"{sign}{' '.join(short(x) for x in figures)}"


def counts(found: Map) -> str:
    """Return a text table of the numbers of outcomes by method."""
    width = max(len(method.name) for method in found.methods)
    lines = [f"{'':{width}}  " + " ".join(f"{outcome:>8}" for outcome in Outcome)]
    for method in found.methods:
        count = Counter(run.outcome for run in found.runs if run.method == method.name)
        lines.append(f"{method.name:{width}}  " + " ".join(f"{count[outcome]:8d}" for outcome in Outcome))
    return "\n".join(lines)


def reasons(found: Map) -> str:
    """Return a table of refused and failed runs with their messages."""
    lines = []
    for case in found.cases:
        runs: dict[tuple[str, str], list[str]] = {}
        for run in found.runs:
            if run.scene == case.name and run.outcome in (Outcome.REFUSED, Outcome.FAILED):
                runs.setdefault((run.outcome, run.reason), []).append(f"{run.method} {_asked(run)}")
        lines += [
            [case.name, outcome, reason, ", ".join(methods) if len(methods) <= 4 else f"{len(methods)} runs"]
            for (outcome, reason), methods in runs.items()
        ]
    return rows(["scene", "outcome", "message", "runs"], lines)


def _asked(run: Run) -> str:
    return "" if run.asked is None else f"{run.asked:.0e}"
