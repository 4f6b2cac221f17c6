# SPDX-License-Identifier: BSD-3-Clause
"""All runs of a scene and their reference solutions."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from benchmarks.accuracy.scenes import Plant, with_saving

from gelenk.chart import methods
from gelenk.chart.case import Array, Case
from gelenk.chart.measure import Reference, Run, Task
from gelenk.chart.methods import Method
from gelenk.chart.reference import Recording, agreed, closed, main_recording, recorded
from gelenk.chart.stability import without_truth
from gelenk.chart.work_precision import run_all
from gelenk.chart.workers import Failure, work_off

INTEGRATORS = ("auto", "erk", "dirk", "ida", "cvode", "cvode-adams")
TOLERANCES = tuple(10.0**-k for k in range(4, 11))
# Checks of erk at 1e-13; the closest counts. `independent` cannot solve wheels.
CHECKS = (
    Method("independent", "cvode-adams"),
    Method("independent", "erk"),
    Method("projection", "cvode-adams"),
)
CHECK_TOLERANCE = 1e-12
REFERENCE_LIMIT = 120.0  # s


@dataclass(frozen=True)
class Settings:
    """Extent of the study; one of `every` runs is made, `limit` is the wall-clock time of one [s]."""

    tolerances: tuple[float, ...] = TOLERANCES
    integrators: tuple[str, ...] = INTEGRATORS
    every: int = 1
    limit: float = 20.0
    jobs: int = 2


def reference_of(case: Case) -> Reference | Failure:
    """Return the closed form, or erk at 1e-13 checked by another method, as reference."""
    main = main_recording(case)
    if case.truth is not None:
        return closed(case, [main])
    checked: list[Recording | Failure] = []
    for way in CHECKS:
        checked.append(recorded(Task(case, way, CHECK_TOLERANCE)))
        if isinstance(checked[-1], Recording):
            break
    return agreed(case, [main, *checked])


def references_of(cases: Sequence[Case], jobs: int) -> dict[str, Reference | Failure]:
    """Return the references of the cases by name.

    The scale of a signal is its largest value in all cases, since it may be near zero at a run's only sample.
    """
    results = work_off([(reference_of, (case,), REFERENCE_LIMIT) for case in cases], jobs)
    known = [result.scales for result in results if isinstance(result, Reference)]
    scales: Array = np.max(np.array(known), axis=0) if known else np.array([])
    return {
        case.name: replace(result, scales=scales) if isinstance(result, Reference) else result
        for case, result in zip(cases, results, strict=True)
    }


def runs_of(plant: Plant, settings: Settings, progress: Callable[[float], None] | None = None) -> list[Run]:
    """Make all runs of a scene, with and without saving states; return them with their errors."""
    cases = list(plant.cases())
    truth = references_of(cases, settings.jobs)
    tasks = []
    for case in cases:
        for ran in (case, with_saving(case)):
            truth[ran.name] = truth[case.name]
            tasks += [
                Task(ran, method, tolerance)
                for method in methods.chosen(settings.integrators)
                for tolerance in settings.tolerances
            ]
    # Weyl's sequence samples tolerances and integrators evenly, and differently for each scene.
    phase = zlib.crc32(plant.name.encode()) / 2**32
    tasks = [
        task for k, task in enumerate(tasks) if (phase + k * 0.6180339887498949) % 1.0 < 1 / settings.every
    ]
    runs = run_all(tasks, truth, settings.jobs, settings.limit, progress)
    return [without_truth(run, truth[run.scene]) for run in runs]
