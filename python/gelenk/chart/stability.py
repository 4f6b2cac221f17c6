# SPDX-License-Identifier: BSD-3-Clause
"""The stability map: all methods on scenes that provoke failures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gelenk.chart.case import Case
from gelenk.chart.measure import Reference, Run, Task, blank
from gelenk.chart.methods import DEFAULT, Method, all_methods
from gelenk.chart.outcome import Outcome
from gelenk.chart.reference import references
from gelenk.chart.scenes import QUICK_CASES, stability_cases
from gelenk.chart.work_precision import run_all
from gelenk.chart.workers import Failure
from gelenk.errors import SceneError
from gelenk.model.scene import load

TOLERANCES = (1e-6, 1e-8)
STEP = 1e-3  # s, step size of methods with fixed steps
SKIPPED = "skipped"  # outcome for a scene that this version cannot read


@dataclass(frozen=True)
class Settings:
    """Settings of the map; `limit` is the wall-clock time of one run [s]."""

    tolerances: tuple[float, ...] = TOLERANCES
    jobs: int = 1
    limit: float = 60.0
    quick: bool = False


QUICK = Settings((1e-6,), limit=5.0, quick=True)


@dataclass(frozen=True)
class Map:
    """Cases, methods and all runs; `words` describes the reference of each case by its name."""

    cases: list[Case]
    methods: list[Method]
    runs: list[Run]
    words: dict[str, str]

    def cell(self, case: Case, method: Method, tolerance: float) -> Run | None:
        """Return the run of a method on a case; methods with fixed steps have one run for all tolerances."""
        for run in self.runs:
            same = run.scene == case.name and run.method == method.name
            if same and (run.asked is None or run.asked == tolerance):
                return run
        return None


def natural_methods() -> list[Method]:
    """Return `auto`, projection with every integrator, and the other formulations with their first one."""
    chosen: list[Method] = []
    for method in all_methods():
        alternative = not method.automatic and method.formulation != DEFAULT and not method.fixed_step
        if alternative and any(m.formulation == method.formulation for m in chosen):
            continue
        chosen.append(method)
    return chosen


def stability(
    methods: Sequence[Method],
    settings: Settings,
    names: Sequence[str] | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Map:
    """Run every method on every scene.

    Args:
        methods: Methods to be compared.
        settings: Tolerances, processes and limits.
        names: Names of scenes; None: all, or the quick selection.
        progress: Called with the current activity and the completed fraction.

    Returns:
        The map with all runs.
    """
    report = progress or (lambda _activity, _fraction: None)
    cases = cases_of(names or (QUICK_CASES if settings.quick else None))
    reasons = {case.name: unreadable(case) for case in cases}
    runnable = [case for case in cases if not reasons[case.name]]
    report("references", 0.0)
    truth = references(runnable, settings.jobs, 5 * settings.limit, settings.quick)
    tasks = [task for case in runnable for task in tasks_of(case, methods, settings.tolerances)]
    runs = run_all(tasks, truth, settings.jobs, settings.limit, lambda fraction: report("runs", fraction))
    runs = [without_truth(run, truth.get(run.scene)) for run in runs]
    words = {}
    for case in cases:
        reason = reasons[case.name]
        if reason:
            runs += skipped(case, methods, settings.tolerances, reason)
        words[case.name] = f"not read by this version: {reason}" if reason else words_on(truth.get(case.name))
    return Map(cases, list(methods), runs, words)


def cases_of(names: Sequence[str] | None) -> list[Case]:
    """Return the cases with these names; None: all."""
    return [case for case in stability_cases() if names is None or case.name in names]


def tasks_of(case: Case, methods: Sequence[Method], tolerances: Sequence[float]) -> list[Task]:
    """Return the runs of a case: one per tolerance, and one for each method with fixed steps.

    A fixed step is not longer than the communication step.
    """
    return [
        Task(case, method, tolerance, min(STEP, case.step) if method.fixed_step else None)
        for method in methods
        for tolerance in ((None,) if method.fixed_step else tolerances)
    ]


def skipped(case: Case, methods: Sequence[Method], tolerances: Sequence[float], reason: str) -> list[Run]:
    """Return skipped runs for a scene that cannot be read."""
    return [
        replace(blank(task), outcome=SKIPPED, reason=reason) for task in tasks_of(case, methods, tolerances)
    ]


def unreadable(case: Case) -> str:
    """Return why this version cannot read the scene; an empty string if it can."""
    try:
        load(case.scene)
    except SceneError as e:
        return e.lines[0]
    return ""


def words_on(found: Reference | Failure | None) -> str:
    """Describe the reference of a case."""
    if found is None:
        return "must be refused"
    return found.words if isinstance(found, Reference) else found.reason


def without_truth(run: Run, found: Reference | Failure | None) -> Run:
    """Return the run; if it finished without a reference, it is wrong or failed instead of good."""
    if isinstance(found, Reference) or not run.finished:
        return run
    if found is None:
        return replace(run, outcome=Outcome.WRONG, reason="finished although no motion exists")
    return replace(run, outcome=Outcome.FAILED, reason=found.reason)
