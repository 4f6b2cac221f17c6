# SPDX-License-Identifier: BSD-3-Clause
"""The tables of docs/performance.md, between their markers; what stands around them is written by hand."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from benchmarks.speed import families
from benchmarks.speed.errors import Run, cheapest, engines
from benchmarks.speed.masters import Step
from benchmarks.speed.operations import Cost
from benchmarks.speed.timings import ENGINES, Timing, forward_of, slope

FITS = {"chain_p": 16, "chain_s": 16, "nfourbar": 10}  # exponents are fitted from here on
KERNELS = ("positions", "constraint rows", "inverse dynamics", "mass matrix", "factorise",
           "forward dynamics", "derivatives", "projection")  # fmt: skip


def rows(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    out = ["| " + " | ".join(header) + " |", "|" + " --- |" * len(header)]
    return "\n".join(out + ["| " + " | ".join(line) + " |" for line in lines])


def figure(x: float) -> str:
    """Three digits; empty for what there is none of."""
    if not math.isfinite(x):
        return ""
    return f"{x:.0f}" if x >= 1000 else f"{x:.3g}"


def _value(timings: Sequence[Timing], scene: str, engine: str) -> float:
    found = forward_of(timings, scene, engine)
    return found.ratio if found else math.nan


def forward_table(timings: Sequence[Timing], scenes: Sequence[str]) -> str:
    """By mechanism: every engine's accelerations over `ref`, and Gelenk's over the cheapest."""
    lines = []
    for scene in scenes:
        values = {engine: _value(timings, scene, engine) for engine in ENGINES}
        others = [x for engine, x in values.items() if engine != "gelenk" and math.isfinite(x)]
        cells = [figure(values[engine]) for engine in ENGINES]
        pinocchio = values["gelenk"] / values["pinocchio"]
        best = values["gelenk"] / min(others) if others else math.nan
        lines.append([scene, *cells, figure(pinocchio), figure(best)])
    return rows(["mechanism", *ENGINES, "gelenk / pinocchio", "gelenk / cheapest of the others"], lines)


def family_scenes(timings: Sequence[Timing], family: str, least: int = 0) -> list[tuple[int, str]]:
    there = {t.scene for t in timings}
    members = [(n, f"{family}_{n}") for n in families.FAMILIES[family] if n >= least]
    return [(n, scene) for n, scene in members if scene in there]


def exponents(timings: Sequence[Timing]) -> str:
    """Of n in the cost of accelerations, from where the large ones begin."""
    lines = []
    for family, least in FITS.items():
        members = family_scenes(timings, family, least)
        cells = []
        for engine in ENGINES:
            values = [_value(timings, scene, engine) for _, scene in members]
            reached = [n for (n, _), x in zip(members, values, strict=True) if math.isfinite(x)]
            fitted = slope([n for n, _ in members], values)
            cells.append(f"{fitted:.2f} (to {reached[-1]})" if math.isfinite(fitted) else "")
        lines.append([family, f"{least} …", *cells])
    return rows(["family", "n", *ENGINES], lines)


def kernel_table(timings: Sequence[Timing], scenes: Sequence[str]) -> str:
    """Gelenk's kernels by mechanism, over the arithmetic kernel."""
    found = {(t.scene, t.kernel): t.ratio for t in timings if t.engine == "gelenk"}
    lines = [[s, *(figure(found.get((s, kernel), math.nan)) for kernel in KERNELS)] for s in scenes]
    return rows(["mechanism", *KERNELS], lines)


def method_table(timings: Sequence[Timing], scenes: Sequence[str]) -> str:
    """A step of 1 ms by every method, over the arithmetic kernel."""
    found = {(t.scene, t.kernel): t.ratio for t in timings if t.engine == "gelenk"}
    methods = list(dict.fromkeys(k for _, k in found if k.startswith("step ")))
    lines = [[s, *(figure(found.get((s, m), math.nan)) for m in methods)] for s in scenes]
    return rows(["mechanism", *(m.removeprefix("step ") for m in methods)], lines)


def step_table(steps: Sequence[Step]) -> str:
    """A step of 1 ms under another torque: microseconds, over `ref`, over Pinocchio's rk4, and the error."""
    yard = {s.scene: s.us for s in steps if (s.engine, s.method) == ("pinocchio", "rk4")}
    lines = []
    for s in steps:
        ratio = s.us / yard.get(s.scene, math.nan)
        error = f"{s.error:.0e}" if math.isfinite(s.error) else ""
        lines.append(
            [s.scene, f"{s.engine}: {s.method}", figure(s.us), figure(s.us / s.ref_us), figure(ratio), error]
        )
    return rows(["mechanism", "engine: method", "µs", "/ ref", "/ pinocchio rk4", "error after 0.5 s"], lines)


def error_table(runs: Sequence[Run], errors: Sequence[float]) -> str:
    """The cheapest run of every engine that errs by no more than this, and Gelenk's share of it."""
    header = ["mechanism", "engine"]
    for error in errors:
        header += [f"to {error:.0e}: ms per s", "method, setting", "Gelenk's share"]
    lines = []
    for scene in dict.fromkeys(run.scene for run in runs):
        for engine in engines([run for run in runs if run.scene == scene]):
            cells = [scene, engine]
            for error in errors:
                found, mine = cheapest(runs, scene, engine, error), cheapest(runs, scene, "gelenk", error)
                if found is None:
                    cells += ["", "", ""]
                    continue
                share = figure(mine.cost / found.cost) if mine else ""
                cells += [figure(found.cost), f"{found.method} {found.setting:g}", share]
            lines.append(cells)
    return rows(header, lines)


def operations_table(costs: Sequence[Cost], most: int = 7) -> str:
    """Instructions of an evaluation, and the shares of the functions that take most."""
    lines = []
    for cost in costs:
        first = sorted(cost.functions.items(), key=lambda item: -item[1])[:most]
        shares = ", ".join(f"`{name}` {100 * n / cost.instructions:.0f} %" for name, n in first)
        lines.append([cost.scene, f"{cost.instructions:.0f}", shares])
    return rows(["mechanism", "instructions", "of which in"], lines)


def faults(timings: Sequence[Timing]) -> str:
    """What gave no figure, and why."""
    found: dict[tuple[str, str], list[str]] = {}
    for t in timings:
        if t.fault:
            found.setdefault((f"{t.engine}: {t.kernel}", t.fault.replace("|", "/")), []).append(t.scene)
    lines = [[what, ", ".join(dict.fromkeys(scenes)), why] for (what, why), scenes in found.items()]
    return rows(["engine: kernel", "mechanisms", "why"], lines) if lines else "Every kernel gave a figure."
