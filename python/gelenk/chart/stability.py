# SPDX-License-Identifier: BSD-3-Clause
"""The stability map: methods against scenes where methods fail."""

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
STEP = 1e-3  # s, of methods with fixed steps
SKIPPED = "skipped"  # a scene that this version cannot read


@dataclass(frozen=True)
class Settings:
    """How the map is made. limit: wall time of one run [s]."""

    tolerances: tuple[float, ...] = TOLERANCES
    jobs: int = 1
    limit: float = 60.0
    quick: bool = False


QUICK = Settings((1e-6,), limit=5.0, quick=True)


@dataclass(frozen=True)
class Map:
    """Cases, methods and every run; words on each case's reference by its name."""

    cases: list[Case]
    methods: list[Method]
    runs: list[Run]
    words: dict[str, str]

    def cell(self, case: Case, method: Method, tolerance: float) -> Run | None:
        """The run of a method in a case; of fixed steps the one that stands for every tolerance."""
        for run in self.runs:
            same = run.scene == case.name and run.method == method.name
            if same and (run.asked is None or run.asked == tolerance):
                return run
        return None


def natural_methods() -> list[Method]:
    """`auto`, projection with every integrator, every other formulation with the first that suits it."""
    chosen: list[Method] = []
    for method in all_methods():
        rival = not method.automatic and method.formulation != DEFAULT and not method.fixed_step
        if rival and any(m.formulation == method.formulation for m in chosen):
            continue
        chosen.append(method)
    return chosen


def stability(
    methods: Sequence[Method],
    settings: Settings,
    names: Sequence[str] | None = None,
    told: Callable[[str, float], None] | None = None,
) -> Map:
    """Every method through every scene, or through those named."""
    tell = told or (lambda _words, _share: None)
    cases = cases_of(names or (QUICK_CASES if settings.quick else None))
    reasons = {case.name: unreadable(case) for case in cases}
    runnable = [case for case in cases if not reasons[case.name]]
    tell("references", 0.0)
    truth = references(runnable, settings.jobs, 5 * settings.limit, settings.quick)
    tasks = [task for case in runnable for task in tasks_of(case, methods, settings.tolerances)]
    runs = run_all(tasks, truth, settings.jobs, settings.limit, lambda share: tell("runs", share))
    runs = [without_truth(run, truth.get(run.scene)) for run in runs]
    words = {}
    for case in cases:
        reason = reasons[case.name]
        if reason:
            runs += skipped(case, methods, settings.tolerances, reason)
        words[case.name] = f"not read by this version: {reason}" if reason else words_on(truth.get(case.name))
    return Map(cases, list(methods), runs, words)


def cases_of(names: Sequence[str] | None) -> list[Case]:
    """Those of these names; None: all."""
    return [case for case in stability_cases() if names is None or case.name in names]


def tasks_of(case: Case, methods: Sequence[Method], tolerances: Sequence[float]) -> list[Task]:
    """A run per tolerance; one of a method with fixed steps, none longer than the communication step."""
    return [
        Task(case, method, tolerance, min(STEP, case.step) if method.fixed_step else None)
        for method in methods
        for tolerance in ((None,) if method.fixed_step else tolerances)
    ]


def skipped(case: Case, methods: Sequence[Method], tolerances: Sequence[float], reason: str) -> list[Run]:
    """In the place of its runs."""
    return [
        replace(blank(task), outcome=SKIPPED, reason=reason) for task in tasks_of(case, methods, tolerances)
    ]


def unreadable(case: Case) -> str:
    """Why the scene cannot be read by this version; empty where it can."""
    try:
        load(case.scene)
    except SceneError as e:
        return e.lines[0]
    return ""


def words_on(found: Reference | Failure | None) -> str:
    """What a case's runs are compared with."""
    if found is None:
        return "to be refused"
    return found.words if isinstance(found, Reference) else found.reason


def without_truth(run: Run, found: Reference | Failure | None) -> Run:
    """Where there is nothing to compare with, a run to the end is not called good."""
    if isinstance(found, Reference) or not run.finished:
        return run
    if found is None:
        return replace(run, outcome=Outcome.WRONG, reason="ran where there is no motion")
    return replace(run, outcome=Outcome.FAILED, reason=found.reason)
