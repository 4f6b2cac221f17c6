# SPDX-License-Identifier: BSD-3-Clause
"""Tables of docs/accuracy.md."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from benchmarks.accuracy.explained import explanation
from benchmarks.accuracy.runs import INTEGRATORS
from benchmarks.accuracy.scenes import GRIDS, INPUTS

from gelenk.chart.measure import Run
from gelenk.chart.outcome import Outcome
from gelenk.chart.tables import rows


@dataclass(frozen=True)
class Way:
    """The conditions of a run: scene, inputs, communication points, and whether its state was saved."""

    scene: str
    inputs: str
    grid: str
    saved: bool


def way_of(run: Run) -> Way:
    """Return the conditions of a run from its name, see `scenes.Plant.cases`."""
    scene, inputs, grid, *saved = run.scene.split("/")
    return Way(scene, inputs, grid, bool(saved))


def ratio(run: Run) -> float:
    """Return error / tolerance."""
    return run.error / run.tolerance


def figure(x: float) -> str:
    """Format with two digits; return an empty string for NaN."""
    if math.isnan(x):
        return ""
    return f"{x:.2g}" if x < 1e4 else f"{x:.1e}".replace("e+0", "e")


def by_tolerance(runs: Sequence[Run]) -> str:
    """Return a table of the errors and outcomes by integrator and tolerance."""
    lines = []
    for name in INTEGRATORS:
        for tolerance in sorted({run.tolerance for run in runs}, reverse=True):
            mine = [run for run in runs if run.integrator == name and run.tolerance == tolerance]
            lines.append([name, f"{tolerance:.0e}".replace("e-0", "e-"), *_columns(mine)])
    return rows(["integrator", "tolerance", *COLUMNS], lines)


def by_way(runs: Sequence[Run]) -> str:
    """Return a table of the largest error/tolerance and the number of wrong runs by conditions."""
    ways: list[tuple[str, Callable[[Way], bool]]] = [
        *((f"{kind} inputs", lambda way, kind=kind: way.inputs == kind) for kind in INPUTS),
        *((f"{kind} grid", lambda way, kind=kind: way.grid == kind) for kind in GRIDS),
        ("state saved", lambda way: way.saved),
        ("not saved", lambda way: not way.saved),
    ]
    lines = []
    for words, asked in ways:
        cells = []
        for name in INTEGRATORS:
            mine = [run for run in runs if run.integrator == name and asked(way_of(run))]
            worst = max((ratio(run) for run in mine if run.finished), default=math.nan)
            wrong = sum(run.outcome == Outcome.WRONG for run in mine)
            cells.append(f"{figure(worst)}; {wrong} of {len(mine)}")
        lines.append([words, *cells])
    return rows(["runs with", *INTEGRATORS], lines)


COLUMNS = ("runs", "median error/tolerance", "95 %", "maximum", "good", "wrong", "refused", "failed")


def _columns(runs: Sequence[Run]) -> list[str]:
    ratios = sorted(ratio(run) for run in runs if run.finished)
    counts = Counter(run.outcome for run in runs)
    figures = ["", "", ""]
    if ratios:
        figures = [
            figure(statistics.median(ratios)),
            figure(ratios[int(0.95 * (len(ratios) - 1))]),
            figure(ratios[-1]),
        ]
    return [str(len(runs)), *figures, *(str(counts[outcome]) for outcome in Outcome)]


def outliers(runs: Iterable[Run]) -> str:
    """Return a table of wrong, refused and failed runs by integrator, scene and inputs, with explanations."""
    groups: dict[tuple[str, ...], list[Run]] = {}
    for run in runs:
        if run.outcome != Outcome.GOOD:
            way = way_of(run)
            key = (run.integrator, way.scene, way.inputs, "yes" if way.saved else "no", run.outcome)
            groups.setdefault(key, []).append(run)
    lines = []
    for (name, scene, inputs, saved, outcome), mine in sorted(groups.items()):
        worst = max(mine, key=lambda run: ratio(run) if run.finished else 0.0)
        at = f"{way_of(worst).grid} {worst.tolerance:.0e}".replace("e-0", "e-")
        much = figure(ratio(worst)) if worst.finished else worst.reason
        why = explanation(name, scene, inputs, saved == "yes", outcome)
        lines.append([name, scene, inputs, saved, f"{len(mine)} {outcome}", much, at, why])
    return rows(
        ["integrator", "scene", "inputs", "saved", "runs", "max. error/tolerance", "at", "explanation"], lines
    )


def scenes(runs: Sequence[Run], about: Sequence[tuple[str, float, str]]) -> str:
    """Return a table of the scenes with duration, inputs, accuracy of the references and outcomes."""
    lines = []
    for name, stop, inputs in about:
        mine = [run for run in runs if way_of(run).scene == name]
        digits = [run.digits for run in mine if run.finished and not math.isnan(run.digits)]
        wrong = sum(run.outcome == Outcome.WRONG for run in mine)
        lines.append(
            [name, f"{stop:g}", inputs, f"{max(digits):.0e}" if digits else "", str(len(mine)), str(wrong)]
        )
    return rows(["scene", "duration [s]", "inputs", "reference error", "runs", "wrong"], lines)
