# SPDX-License-Identifier: BSD-3-Clause
"""Tables of docs/performance.md, put between their markers; the text around them is written by hand."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from benchmarks.speed import families
from benchmarks.speed.errors import Run, cheapest, engines
from benchmarks.speed.masters import Step
from benchmarks.speed.operations import Cost
from benchmarks.speed.timings import ENGINES, Timing, forward_of, slope

from gelenk.chart.measure import first_sentence

FITS = {"chain_p": 16, "chain_s": 16, "nfourbar": 10}  # smallest sizes used for fitting exponents
KERNELS = ("positions", "constraint equations", "inverse dynamics", "mass matrix", "factorize",
           "forward dynamics", "derivatives", "projection")  # fmt: skip
# Sizes (chains, N-four-bars) that each table shows; the CSV files and pictures have all.
SHOWN = {
    "forward": ({1, 16, 32, 256}, {1, 40, 100, 1000}),
    "kernels": ({32, 1024}, {40, 1000}),
    "methods": ({32}, {10}),
}


def shown(table: str, scenes: Iterable[str]) -> list[str]:
    """Return the scenes that a table shows: all of one size, and the chosen sizes of each family."""
    chains, four_bars = SHOWN[table]

    def chosen(scene: str) -> bool:
        family, _, n = scene.rpartition("_")
        return family not in FITS or int(n) in (four_bars if family == "nfourbar" else chains)

    return [scene for scene in scenes if chosen(scene)]


def rows(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    out = ["| " + " | ".join(header) + " |", "|" + " --- |" * len(header)]
    return "\n".join(out + ["| " + " | ".join(line) + " |" for line in lines])


def figure(x: float) -> str:
    """Format with three digits; return an empty string for NaN and infinities."""
    if not math.isfinite(x):
        return ""
    return f"{x:.0f}" if x >= 1000 else f"{x:.3g}"


def _value(timings: Sequence[Timing], scene: str, engine: str) -> float:
    found = forward_of(timings, scene, engine)
    return found.ratio if found else math.nan


def forward_table(timings: Sequence[Timing], scenes: Sequence[str]) -> str:
    """Return the accelerations of every engine over `ref`, and the ratios of Gelenk's to the others'."""
    lines = []
    for scene in shown("forward", scenes):
        values = {engine: _value(timings, scene, engine) for engine in ENGINES}
        others = [x for engine, x in values.items() if engine != "gelenk" and math.isfinite(x)]
        cells = [figure(values[engine]) for engine in ENGINES]
        pinocchio = values["gelenk"] / values["pinocchio"]
        best = values["gelenk"] / min(others) if others else math.nan
        lines.append([scene, *cells, figure(pinocchio), figure(best)])
    return rows(["mechanism", *ENGINES, "gelenk / pinocchio", "gelenk / fastest other"], lines)


def family_scenes(timings: Sequence[Timing], family: str, least: int = 0) -> list[tuple[int, str]]:
    """Return (size, scene) of the measured mechanisms of a family with at least `least` members."""
    there = {t.scene for t in timings}
    members = [(n, f"{family}_{n}") for n in families.FAMILIES[family] if n >= least]
    return [(n, scene) for n, scene in members if scene in there]


def exponents(timings: Sequence[Timing]) -> str:
    """Return the growth exponents of the cost of accelerations, fitted to the larger mechanisms."""
    lines = []
    for family, least in FITS.items():
        members = family_scenes(timings, family, least)
        cells = []
        for engine in ENGINES:
            values = [_value(timings, scene, engine) for _, scene in members]
            reached = [n for (n, _), x in zip(members, values, strict=True) if math.isfinite(x)]
            fitted = slope([n for n, _ in members], values)
            cells.append(f"{fitted:.2f} (to {reached[-1]})" if math.isfinite(fitted) else "")
        lines.append([family, f"n = {least}", *cells])
    return rows(["family", "fitted from", *ENGINES], lines)


def kernel_table(timings: Sequence[Timing], scenes: Sequence[str]) -> str:
    """Return the time of Gelenk's kernels over `ref`, by mechanism."""
    found = {(t.scene, t.kernel): t.ratio for t in timings if t.engine == "gelenk"}
    lines = [[s, *(figure(found.get((s, kernel), math.nan)) for kernel in KERNELS)]
             for s in shown("kernels", scenes)]  # fmt: skip
    return rows(["mechanism", *KERNELS], lines)


def method_table(timings: Sequence[Timing], scenes: Sequence[str]) -> str:
    """Return the time of a step of 1 ms by every method over `ref`, by mechanism."""
    found = {(t.scene, t.kernel): t.ratio for t in timings if t.engine == "gelenk"}
    methods = list(dict.fromkeys(k for _, k in found if k.startswith("step ")))
    lines = [[s, *(figure(found.get((s, m), math.nan)) for m in methods)]
             for s in shown("methods", scenes)]  # fmt: skip
    return rows(["mechanism", *(m.removeprefix("step ") for m in methods)], lines)


def step_table(steps: Sequence[Step]) -> str:
    """Return the time [µs] of a step of 1 ms and, in parentheses, the error after all steps."""
    cells: dict[tuple[str, str, int], str] = {}
    columns: dict[tuple[str, int], list[str]] = {}  # methods by engine and rank among its methods
    for s in steps:
        rank = sum(key[:2] == (s.scene, s.engine) for key in cells)
        error = f" ({s.error:.0e})" if math.isfinite(s.error) else ""
        cells[s.scene, s.engine, rank] = figure(s.us) + error
        methods = columns.setdefault((s.engine, rank), [])
        if s.method not in methods:
            methods.append(s.method)
    order = sorted(columns, key=lambda column: ENGINES.index(column[0]))
    lines = [
        [scene, *(cells.get((scene, *column), "") for column in order)]
        for scene in dict.fromkeys(s.scene for s in steps)
    ]
    return rows(["mechanism", *(f"{column[0]}: {' / '.join(columns[column])}" for column in order)], lines)


def error_table(runs: Sequence[Run], errors: Sequence[float]) -> str:
    """Return the cost [ms/s] of the cheapest run of every engine within each error bound.

    `*` marks Simbody with assertions; the last column is the ratio of Gelenk to the cheapest other engine.
    """
    names = list(dict.fromkeys(engine.split(" ")[0] for engine in engines(runs)))
    lines = []
    for scene in dict.fromkeys(run.scene for run in runs):
        for error in errors:
            costs, marks = {}, {}
            for engine in engines([run for run in runs if run.scene == scene]):
                found = cheapest(runs, scene, engine, error)
                if found is not None:
                    name = engine.split(" ")[0]
                    costs[name], marks[name] = found.cost, "*" if name != engine else ""
            others = [cost for name, cost in costs.items() if name != "gelenk"]
            ratio = costs["gelenk"] / min(others) if others and "gelenk" in costs else math.nan
            cells = [figure(costs[name]) + marks[name] if name in costs else "" for name in names]
            lines.append([scene, f"{error:.0e}".replace("e-0", "e-"), *cells, figure(ratio)])
    return rows(["mechanism", "error", *names, "gelenk / cheapest other"], lines)


def operations_table(costs: Sequence[Cost], most: int = 3) -> str:
    """Return the instructions of one evaluation and the functions with the largest shares."""
    lines = []
    for cost in costs:
        first = sorted(cost.functions.items(), key=lambda item: -item[1])[:most]
        shares = ", ".join(f"`{name}` {100 * n / cost.instructions:.0f} %" for name, n in first)
        lines.append([cost.scene, f"{cost.instructions:.0f}", shares])
    return rows(["mechanism", "instructions", "functions with the largest shares"], lines)


def faults(timings: Sequence[Timing]) -> str:
    """Return the measurements that are missing, with the reason."""
    found: dict[tuple[str, str], list[str]] = {}
    for t in timings:
        if t.fault:
            reason = first_sentence(t.fault.replace("|", "/"))
            found.setdefault((f"{t.engine}: {t.kernel}", reason), []).append(t.scene)
    lines = [[what, ", ".join(dict.fromkeys(scenes)), why] for (what, why), scenes in found.items()]
    return rows(["engine: measurement", "mechanisms", "reason"], lines) if lines else "None."
