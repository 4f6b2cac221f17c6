# SPDX-License-Identifier: BSD-3-Clause
"""Work-precision diagrams: every method at several tolerances or step sizes on a scene."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import gelenk
from gelenk.chart.case import Case
from gelenk.chart.measure import Reference, Run, Runner, Task, blank, measured
from gelenk.chart.methods import DEFAULT, Method
from gelenk.chart.outcome import Outcome, allowed
from gelenk.chart.reference import references
from gelenk.chart.workers import Failure, work_off
from gelenk.errors import UsageError

TOLERANCES = tuple(10.0**-k for k in range(3, 13))
PARTS = tuple(2**k for k in range(2, 12))  # steps per communication step, of methods with fixed steps
QUICK_TOLERANCES = (1e-4, 1e-6, 1e-8)
QUICK_PARTS = (8, 32)
REGRETTED = (1e-4, 1e-6, 1e-8)

ROUNDS = 7
LONG = 1.0  # s; longer runs are timed only once
SHORT = 2e-3  # s; shorter runs are timed several times per round
TIMING_LIMIT = 1800.0  # s, limit of the timing of one scene


@dataclass(frozen=True)
class Settings:
    """Settings of a study; `parts` are fixed steps per communication step, `limit` is wall-clock time [s]."""

    tolerances: tuple[float, ...] = TOLERANCES
    parts: tuple[int, ...] = PARTS
    rounds: int = ROUNDS
    jobs: int = 1
    limit: float = 10.0
    quick: bool = False


QUICK = Settings(QUICK_TOLERANCES, QUICK_PARTS, 2, limit=5.0, quick=True)


@dataclass(frozen=True)
class Study:
    """A test case with its reference solution and its runs."""

    case: Case
    reference: Reference
    runs: list[Run]


def tasks_of(case: Case, methods: Sequence[Method], settings: Settings) -> list[Task]:
    """Return the runs of a case: each method at the tolerances, or with fixed steps of several sizes.

    Without constraints all formulations are identical, and only the default is run.
    """
    tasks = []
    loops = gelenk.Simulation(case.scene).size.constraint_equations > 0
    for method in methods:
        if not loops and not method.automatic and method.formulation != DEFAULT:
            continue
        if method.fixed_step:
            tasks += [Task(case, method, None, case.step / n) for n in settings.parts]
        else:
            tasks += [Task(case, method, tolerance) for tolerance in settings.tolerances]
    return tasks


def study(
    cases: Sequence[Case],
    methods: Sequence[Method],
    settings: Settings,
    progress: Callable[[str, float], None] | None = None,
) -> list[Study]:
    """Run all methods on all cases, compare them with reference solutions and time the finished runs.

    Args:
        cases: Test cases.
        methods: Methods to be compared.
        settings: Tolerances, steps, processes and limits.
        progress: Called with the current activity and the completed fraction.

    Raises:
        UsageError: a case has no reference solution.
    """
    report = progress or (lambda _activity, _fraction: None)
    report("references", 0.0)
    truth = references(cases, settings.jobs, max(60.0, settings.limit), settings.quick)
    faults = [f"{name}: {found.reason}" for name, found in truth.items() if isinstance(found, Failure)]
    if faults:
        raise UsageError("\n".join(faults))
    tasks = [task for case in cases for task in tasks_of(case, methods, settings)]
    runs = run_all(tasks, truth, settings.jobs, settings.limit, lambda fraction: report("runs", fraction))
    studies = []
    for i, case in enumerate(cases):
        report(f"timing {case.name}", i / len(cases))
        mine = [k for k, task in enumerate(tasks) if task.case is case]
        timed_runs = timed([tasks[k] for k in mine], [runs[k] for k in mine], settings.rounds)
        reference = truth[case.name]
        assert isinstance(reference, Reference)
        studies.append(Study(case, reference, timed_runs))
    return studies


def run_all(
    tasks: Sequence[Task],
    truth: dict[str, Reference | Failure],
    jobs: int,
    limit: float,
    progress: Callable[[float], None] | None = None,
) -> list[Run]:
    """Run each task once in separate processes.

    If a task times out or crashes, those of the same case and method that follow it, with tighter tolerances
    or smaller steps, are not run: they fail for the same reason.

    Args:
        tasks: Tasks, ordered from loose to tight for each case and method.
        truth: References by the name of the case.
        jobs: Number of concurrent processes.
        limit: Wall-clock limit of each run [s].
        progress: Called with the completed fraction.

    Returns:
        The runs in the order of the tasks.
    """
    runs: dict[int, Run] = {}
    for wave in waves(tasks):
        fresh = []
        for k, before in wave:
            if before is not None and runs[before].outcome == Outcome.FAILED:
                runs[k] = replace(blank(tasks[k]), reason=runs[before].reason)
            else:
                fresh.append(k)
        calls = []
        for k in fresh:
            found = truth.get(tasks[k].case.name)
            calls.append((measured, (tasks[k], found if isinstance(found, Reference) else None), limit))
        for k, result in zip(fresh, work_off(calls, jobs), strict=True):
            runs[k] = result if isinstance(result, Run) else replace(blank(tasks[k]), reason=result.reason)
        if progress is not None:
            progress(len(runs) / len(tasks))
    return [runs[k] for k in range(len(tasks))]


def waves(tasks: Sequence[Task]) -> list[list[tuple[int, int | None]]]:
    """Return waves of concurrent tasks: (index, index of the previous task of the same case and method)."""
    last: dict[tuple[str, Method], tuple[int, int]] = {}  # index and wave
    found: list[list[tuple[int, int | None]]] = []
    for k, task in enumerate(tasks):
        key = (task.case.name, task.method)
        before, wave = last.get(key, (None, -1))
        last[key] = (k, wave + 1)
        if wave + 1 == len(found):
            found.append([])
        found[wave + 1].append((k, before))
    return found


def timed(tasks: Sequence[Task], runs: Sequence[Run], rounds: int) -> list[Run]:
    """Return the runs with the smallest CPU time of several rounds in one process."""
    places = [k for k, run in enumerate(runs) if run.finished and run.cpu <= LONG]
    if not places or rounds == 0:
        return list(runs)
    call = (
        interleaved_times,
        ([tasks[k] for k in places], [runs[k].cpu for k in places], rounds),
        TIMING_LIMIT,
    )
    (found,) = work_off([call], 1)
    out = list(runs)
    if isinstance(found, Failure):
        raise UsageError(f"timing: {found.reason}")
    for k, cpu in zip(places, found, strict=True):
        out[k] = replace(out[k], cpu=cpu)
    return out


def interleaved_times(tasks: Sequence[Task], expected: Sequence[float], rounds: int) -> list[float]:
    """Return the smallest CPU time [s] of each task; all tasks are run in each round."""
    runners = [Runner(task) for task in tasks]
    shortest = [math.inf] * len(tasks)
    for _ in range(rounds):
        for k, runner in enumerate(runners):
            for _ in range(max(1, min(10, int(SHORT / max(expected[k], 1e-9))))):
                shortest[k] = min(shortest[k], runner.timed())
    return shortest


# --- cost of `auto` relative to the best method ---


@dataclass(frozen=True)
class Regret:
    """CPU time [s] of `auto` and of the cheapest good methods on a scene; NaN if there is none."""

    scene: str
    tolerance: float
    outcome: str
    cpu: float
    error: float
    best: str  # cheapest good method with error control at this tolerance
    best_cpu: float
    best_of_all: str  # the same including runs with fixed steps that are accurate enough
    best_of_all_cpu: float

    @property
    def ratio(self) -> float:
        """CPU time of `auto` / best with error control at this tolerance."""
        return self.cpu / self.best_cpu

    @property
    def ratio_of_all(self) -> float:
        """CPU time of `auto` / best including fixed steps."""
        return self.cpu / self.best_of_all_cpu


def regrets(runs: Sequence[Run], tolerances: Sequence[float] = REGRETTED) -> list[Regret]:
    """Return the cost of `auto` relative to the best method on every scene at these tolerances."""
    found = []
    for scene in dict.fromkeys(run.scene for run in runs):
        mine = [run for run in runs if run.scene == scene]
        for tolerance in tolerances:
            asked = [run for run in mine if math.isclose(run.tolerance, tolerance)]
            fixed = [run for run in mine if run.asked is None and run.error <= allowed(tolerance)]
            auto = next((run for run in asked if run.method == "auto"), None)
            if auto is not None:
                found.append(_regret(auto, tolerance, asked, fixed))
    return found


def _regret(auto: Run, tolerance: float, asked: Sequence[Run], fixed: Sequence[Run]) -> Regret:
    good = [run for run in asked if run.outcome == Outcome.GOOD]
    return Regret(
        auto.scene,
        tolerance,
        auto.outcome,
        auto.cpu,
        auto.error,
        *_cheapest(good),
        *_cheapest([*good, *fixed]),
    )


def _cheapest(runs: Sequence[Run]) -> tuple[str, float]:
    """Return method and CPU time [s] of the cheapest run."""
    best = min(runs, key=lambda run: run.cpu, default=None)
    return (best.method, best.cpu) if best else ("none", math.nan)


def observed_order(runs: Sequence[Run]) -> float:
    """Return the observed order of a method with fixed steps.

    It is the median of log2(error(h) / error(h/2)) over neighboring steps whose errors are below 0.1 and well
    above rounding and the error of the reference; NaN if there are no two of them.
    """
    clear = [r for r in runs if r.finished and max(1e-11, 30 * r.digits) < r.error < 0.1]
    usable = sorted(clear, key=lambda r: -r.step)
    orders = [math.log(a.error / b.error) / math.log(a.step / b.step) for a, b in itertools.pairwise(usable)]
    return statistics.median(orders) if orders else math.nan
