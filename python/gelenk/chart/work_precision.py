# SPDX-License-Identifier: BSD-3-Clause
"""Work against precision: every method over its tolerances or steps, on a scene."""

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
PARTS = tuple(2**k for k in range(2, 12))  # of a communication step, for methods with fixed steps
QUICK_TOLERANCES = (1e-4, 1e-6, 1e-8)
QUICK_PARTS = (8, 32)
REGRETTED = (1e-4, 1e-6, 1e-8)

ROUNDS = 7
LONG = 1.0  # s: runs that take longer are timed once
SHORT = 2e-3  # s: runs that take less are timed several times a round
TIMING_LIMIT = 1800.0  # s, of all timing of a scene


@dataclass(frozen=True)
class Settings:
    """How a study is done. limit: wall time of one run [s]."""

    tolerances: tuple[float, ...] = TOLERANCES
    parts: tuple[int, ...] = PARTS
    rounds: int = ROUNDS
    jobs: int = 1
    limit: float = 10.0
    quick: bool = False


QUICK = Settings(QUICK_TOLERANCES, QUICK_PARTS, 2, limit=5.0, quick=True)


@dataclass(frozen=True)
class Study:
    """A case with its reference and its runs."""

    case: Case
    reference: Reference
    runs: list[Run]


def tasks_of(case: Case, methods: Sequence[Method], settings: Settings) -> list[Task]:
    """What is run: each method over the tolerances, or over steps that divide the communication step. Without
    loops formulations are one and the same, and only the default is run.
    """
    tasks = []
    loops = gelenk.Simulation(case.scene).size.rows > 0
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
    told: Callable[[str, float], None] | None = None,
) -> list[Study]:
    """Runs all, checks all against references, then times alternately what came to its end.

    Raises:
        UsageError: a case without a reference to measure errors against.
    """
    tell = told or (lambda _words, _share: None)
    tell("references", 0.0)
    truth = references(cases, settings.jobs, max(60.0, settings.limit), settings.quick)
    faults = [f"{name}: {found.reason}" for name, found in truth.items() if isinstance(found, Failure)]
    if faults:
        raise UsageError("\n".join(faults))
    tasks = [task for case in cases for task in tasks_of(case, methods, settings)]
    runs = run_all(tasks, truth, settings.jobs, settings.limit, lambda share: tell("runs", share))
    studies = []
    for i, case in enumerate(cases):
        tell(f"timing {case.name}", i / len(cases))
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
    told: Callable[[float], None] | None = None,
) -> list[Run]:
    """One run of each task in processes of their own, no longer than `limit` [s] each. What came to no end is
    not tried at the tighter tolerances or steps that follow among the tasks: it fails for the same reason.
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
        if told is not None:
            told(len(runs) / len(tasks))
    return [runs[k] for k in range(len(tasks))]


def waves(tasks: Sequence[Task]) -> list[list[tuple[int, int | None]]]:
    """Tasks by index, each with the one before it of the same case and method: first those without one."""
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
    """The runs with the least CPU time of several, all of a scene in one process, by turns."""
    places = [k for k, run in enumerate(runs) if run.finished and run.cpu <= LONG]
    if not places or rounds == 0:
        return list(runs)
    call = (by_turns, ([tasks[k] for k in places], [runs[k].cpu for k in places], rounds), TIMING_LIMIT)
    (found,) = work_off([call], 1)
    out = list(runs)
    if isinstance(found, Failure):
        raise UsageError(f"timing: {found.reason}")
    for k, cpu in zip(places, found, strict=True):
        out[k] = replace(out[k], cpu=cpu)
    return out


def by_turns(tasks: Sequence[Task], expected: Sequence[float], rounds: int) -> list[float]:
    """The least CPU time [s] of each task: one after the other, and all over again."""
    runners = [Runner(task) for task in tasks]
    least = [math.inf] * len(tasks)
    for _ in range(rounds):
        for k, runner in enumerate(runners):
            for _ in range(max(1, min(10, int(SHORT / max(expected[k], 1e-9))))):
                least[k] = min(least[k], runner.timed())
    return least


# --- what `auto` loses against the best ---


@dataclass(frozen=True)
class Regret:
    """CPU time of `auto` against the cheapest that is good. Times in s; NaN where there is none."""

    scene: str
    tolerance: float
    outcome: str
    cpu: float
    error: float
    best: str  # of the methods that were asked for this tolerance
    best_cpu: float
    best_of_all: str  # of those, and of any run with fixed steps that errs no more
    best_of_all_cpu: float

    @property
    def ratio(self) -> float:
        """To the best that was asked for this tolerance."""
        return self.cpu / self.best_cpu

    @property
    def ratio_of_all(self) -> float:
        """To the best, fixed steps included."""
        return self.cpu / self.best_of_all_cpu


def regrets(runs: Sequence[Run], tolerances: Sequence[float] = REGRETTED) -> list[Regret]:
    """Of `auto` on every scene among the runs, at every tolerance at which it was run."""
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
    """Its method and CPU time [s]."""
    best = min(runs, key=lambda run: run.cpu, default=None)
    return (best.method, best.cpu) if best else ("none", math.nan)


def observed_order(runs: Sequence[Run]) -> float:
    """Of a method with fixed steps: the median of log2(error(h) / error(h/2)) over neighbouring steps whose
    errors lie between rounding and the reference's digits below and 0.1 above. NaN where no two do.
    """
    clear = [r for r in runs if r.finished and max(1e-11, 30 * r.digits) < r.error < 0.1]
    usable = sorted(clear, key=lambda r: -r.step)
    orders = [math.log(a.error / b.error) / math.log(a.step / b.step) for a, b in itertools.pairwise(usable)]
    return statistics.median(orders) if orders else math.nan
