# SPDX-License-Identifier: BSD-3-Clause
"""Processor time against error: every engine at several settings; the error is the largest of any joint."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.speed import families, timings
from benchmarks.speed.tools import HERE, Tools
from benchmarks.speed.tree import Array

SCENES = ("fourbar", "slidercrank", "arm7", "chain_s_32", "stewart", "bricard", "governor")
TOLERANCES = ("1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9", "1e-10", "1e-11")
STEPS = ("0.01", "0.005", "0.002", "0.001", "0.0005", "0.0002")
# Of the governor: small enough for explicit methods
STIFF_STEPS = ("0.001", "0.0005", "0.0002", "0.0001", "5e-05")
TRUTH = "1e-12"
LONGEST = 60.0  # s, limit of a process
UNIT = ("simbody", "simbody (assertions on)")  # measured elsewhere, in units of `ref`


@dataclass(frozen=True)
class Run:
    """A run: processor time per simulated second [ms] and the largest error of any joint [rad, m]."""

    scene: str
    engine: str
    method: str
    setting: float
    cost: float
    error: float
    ref_us: float
    finished: bool


@dataclass(frozen=True)
class Truth:
    """Reference solution: joints at the samples, and the difference between two programs at 1e-12."""

    samples: Array
    digits: float


class TruthError(RuntimeError):
    """A scene has no reference solution."""


def _settings(engine: str, scene: str) -> list[str]:
    """Return METHOD=SETTING of all runs of an engine."""
    tree = families.make(scene)
    loops, stiff = bool(tree.closures), scene == "governor"
    steps = STIFF_STEPS if stiff else STEPS
    if engine == "gelenk":
        fixed = [f"projection+rk4={h}" for h in steps]
        implicit = [f"projection+cvode={t}" for t in TOLERANCES[:8]] if stiff else []
        return [f"projection+auto={t}" for t in TOLERANCES] + fixed + implicit
    if engine == "pinocchio":
        return list(TOLERANCES[1:])
    if engine == "mujoco":
        return [f"RK4={h}" for h in (*steps, *(() if stiff else ("0.0001",)))] + (
            [f"implicitfast={h}" for h in steps] if stiff else []
        )
    if engine == "drake":
        if loops:
            return [f"discrete={h}" for h in STEPS]
        return [f"runge_kutta3={t}" for t in (TOLERANCES[:2] if stiff else TOLERANCES[1:6])]
    return [f"{'GenAlpha' if loops or stiff else 'RK44'}={h}" for h in STEPS]


def _command(tools: Tools, engine: str, scene: str, settings: Sequence[str]) -> list[str]:
    plain = str(tools.scenes / f"{scene}.txt")
    if engine == "gelenk":
        return [str(tools.gelenk_runs), str(tools.scenes / f"{scene}.json"), plain, *settings]
    if engine == "pinocchio":
        return [str(tools.pinocchio), "run", plain, *settings]
    return tools.peer(engine, "run", scene, *settings)


def _lines(tools: Tools, engine: str, scene: str, settings: Sequence[str]) -> list[dict[str, Any]]:
    if engine in tools.missing:
        return []
    found, _ = timings.lines(tools, _command(tools, engine, scene, settings), LONGEST)
    return [line for line in found if "samples" in line]


def _error(samples: Any, truth: Array) -> float:
    """Return the largest error; NaN if samples are missing."""
    found = np.asarray(samples, float)
    return float(np.max(np.abs(found - truth))) if found.shape == truth.shape else math.nan


def truth_of(tools: Tools, scene: str) -> Truth:
    """Return Gelenk's run at 1e-12, checked by Pinocchio's equations with DOP853 or else by another
    formulation.

    Raises:
        TruthError: one of the runs did not finish.
    """
    mine = _lines(tools, "gelenk", scene, [f"projection+auto={TRUTH}"])
    other = _lines(tools, "pinocchio", scene, [TRUTH])
    if not other or not other[0]["finished"]:
        other = _lines(tools, "gelenk", scene, [f"udwadia-kalaba+erk={TRUTH}"])
    if not mine or not mine[0]["finished"] or not other:
        raise TruthError(f"{scene}: the runs at {TRUTH} did not finish; there is no reference solution")
    samples = np.asarray(mine[0]["samples"], float)
    return Truth(samples, _error(other[0]["samples"], samples))


def _published(scene: str, ref_us: float) -> list[Run]:
    """Return the runs that were measured once (simbody.csv), scaled to this machine by `ref`."""
    with (HERE / "simbody.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["scene"] == scene]
    return [
        Run(scene, r["engine"], r["method"], float(r["setting"]), float(r["cpu_over_ref"]) * ref_us * 1e-3,
            float(r["error"]), ref_us, True)
        for r in rows
    ]  # fmt: skip


def study_scene(tools: Tools, scene: str, rounds: int) -> tuple[list[Run], Truth]:
    """Measure all engines on a scene, alternating; keep the cheapest run of each setting."""
    timings.write_scene(tools, scene)
    stop = families.make(scene).stop
    truth = truth_of(tools, scene)
    best: dict[tuple[str, str, float], Run] = {}
    for turn in range(rounds):
        for engine in timings.ENGINES:
            if turn > 0 and engine in timings.ONCE:
                continue
            for line in _lines(tools, engine, scene, _settings(engine, scene)):
                error = _error(line["samples"], truth.samples)
                finished = bool(line["finished"]) and error < 1e3
                cost = 1e3 * line["cpu_s"] / stop
                run = Run(
                    scene, engine, line["method"], line["setting"], cost, error, line["ref_us"], finished
                )
                key = (engine, run.method, run.setting)
                if key not in best or run.cost < best[key].cost:
                    best[key] = run
    ref_us = min(run.ref_us for run in best.values())
    return [*best.values(), *_published(scene, ref_us)], truth


def study(
    tools: Tools, scenes: Sequence[str], rounds: int, report: Callable[[str], None]
) -> tuple[list[Run], dict[str, Truth]]:
    runs: list[Run] = []
    truths: dict[str, Truth] = {}
    for scene in scenes:
        try:
            found, truths[scene] = study_scene(tools, scene, rounds)
        except TruthError as fault:
            report(str(fault))
            continue
        runs += found
        summary = [f"{e} {x.cost:.3g} ms" for e in engines(found) if (x := cheapest(found, scene, e, 1e-6))]
        report(f"{scene}, to 1e-6: {', '.join(summary)}; reference to {truths[scene].digits:.1e}")
    return runs, truths


def engines(runs: Sequence[Run]) -> list[str]:
    return list(dict.fromkeys(run.engine for run in runs))


def cheapest(runs: Sequence[Run], scene: str, engine: str, error: float) -> Run | None:
    """Return the cheapest run of an engine whose error is at most `error`, or None."""
    good = [r for r in runs if (r.scene, r.engine) == (scene, engine) and r.finished and r.error <= error]
    return min(good, key=lambda r: r.cost, default=None)


def write_csv(runs: Sequence[Run], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "engine", "method", "setting", "ms_per_s", "error", "ref_us", "finished"])
        for r in runs:
            writer.writerow([r.scene, r.engine, r.method, f"{r.setting:g}", f"{r.cost:.5g}", f"{r.error:.4g}",
                             f"{r.ref_us:.4g}", r.finished])  # fmt: skip
