# SPDX-License-Identifier: BSD-3-Clause
"""Runs of Gelenk on the problems, with their errors and their cost."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from benchmarks.nonsmooth.problems import Problem, Scene

import gelenk
from gelenk.errors import GelenkError

INTEGRATORS = ("auto", "erk", "cvode", "ida", "dirk")
TOLERANCES = tuple(10.0**-k for k in range(4, 12))
STEPS = (1e-2, 1e-3, 1e-4)  # s, of rk4
ROUNDS = 3


@dataclass(frozen=True)
class Run:
    """A run of one setting: tolerance, step [s], or width of a regularized law. NaN: unknown."""

    problem: str
    group: str  # "gelenk", "regularized" or "engine"
    series: str
    setting: float
    error: float = math.nan  # largest error of the positions at the reference times [m, rad]
    cpu: float = math.nan  # per simulated second
    evaluations: float = math.nan  # of the equations of motion, per simulated second
    events: float = math.nan
    reason: str = ""  # why it did not finish


def error_of(problem: Problem, found: Mapping[str, Sequence[float]]) -> float:
    """Return the largest error of the positions."""
    return max(float(np.max(np.abs(np.subtract(found[name], x)))) for name, x in problem.positions.items())


def once(problem: Problem, scene: Scene, tolerance: float) -> tuple[float, float, float, float]:
    """Return error, CPU time of the steps, evaluations and events of a run. Raises GelenkError."""
    plant = gelenk.Simulation(gelenk.load(scene))
    for name, value in problem.inputs.get(problem.start, {}).items():
        plant.set_input(name, value)
    plant.initialize(problem.start, tolerance)
    found: dict[str, list[float]] = {name: [] for name in problem.positions}
    begin, cpu = plant.diagnostic("solver.evaluations"), 0.0
    for t in sorted({*problem.times, *problem.inputs} - {problem.start}):
        before = time.process_time()
        plant.step_to(t)
        cpu += time.process_time() - before
        for name, value in problem.inputs.get(t, {}).items():
            plant.set_input(name, value)
        if t in problem.times:
            for name, values in found.items():
                values.append(plant.output(name))
    evaluations = plant.diagnostic("solver.evaluations") - begin
    return error_of(problem, found), cpu, evaluations, plant.diagnostic("solver.events")


def run(problem: Problem, series: str, setting: float, scene: Scene, tolerance: float, rounds: int) -> Run:
    """Return the run with the least CPU time of several."""
    group = "gelenk" if series in (*INTEGRATORS, "rk4") else "regularized"
    span = problem.times[-1] - problem.start
    try:
        results = [once(problem, scene, tolerance) for _ in range(rounds)]
    except GelenkError as reason:
        return Run(problem.name, group, series, setting, reason=str(reason))
    error, _, evaluations, events = results[0]
    cpu = min(result[1] for result in results)
    return Run(problem.name, group, series, setting, error, cpu / span, evaluations / span, events)


def with_solver(scene: Scene, **solver: object) -> Scene:
    return {**scene, "solver": solver}


def event_driven(problem: Problem, quick: bool) -> list[Run]:
    """Return the runs of all integrators over their tolerances and steps."""
    rounds = 1 if quick else ROUNDS
    found = []
    for name in INTEGRATORS[:2] if quick else INTEGRATORS:
        scene = with_solver(problem.scene, integrator=name)
        for tolerance in TOLERANCES[::3] if quick else TOLERANCES:
            found.append(run(problem, name, tolerance, scene, tolerance, rounds))
    for step in STEPS[:1] if quick else STEPS:
        scene = with_solver(problem.scene, integrator="rk4", step=step)
        found.append(run(problem, "rk4", step, scene, 1e-8, 1))
    return found
