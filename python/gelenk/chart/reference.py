# SPDX-License-Identifier: BSD-3-Clause
"""Reference solutions: computed by one method, checked by others as different as the scene allows.

The difference between them is the accuracy of the reference. Where the scene has no friction, limits,
contacts or rolling, the others solve the equations in independent coordinates. Where it has, which only the
formulation `projection` handles, their integrators differ, and their models are not reduced. What has no
located events is solved by time steps, and checked by steps twice as long.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gelenk.chart.case import Array, Case
from gelenk.chart.measure import Course, Reference, Runner, Task, difference, scales_of
from gelenk.chart.methods import Method, registered
from gelenk.chart.workers import Failure, work_off
from gelenk.errors import GelenkError

MAIN = Method("projection", "erk")
TIGHTEST = (1e-13, 1e-12, 1e-11, 1e-10)
WITNESSES = ("cvode-adams", "ida", "dirk")  # in independent coordinates, if the scene allows these
EVENT_WITNESSES = ("cvode", "dirk", "ida")  # otherwise with the formulation of the main run
CHECK_TOLERANCE = 1e-12
FIXED_STEPS = 2**15  # number of steps of the check with fixed steps
TIME_STEPPING = Method("projection", "moreau-jean")
NOT_REDUCED = "without reductions"
TIME_STEPS = 2**14  # at least, of a run with time stepping
ROUNDING = 1e-14


@dataclass(frozen=True)
class Recording:
    """The result of a run, the names of its states and its method."""

    course: Course
    names: tuple[str, ...]
    by: str


def recorded(task: Task) -> Recording | Failure:
    """Run a task and record its states; return a Failure if it is refused or diverges."""
    try:
        runner = Runner(task)
        course = runner.record()
    except GelenkError as e:
        return Failure(e.lines[0])
    asked = f"{task.tolerance:.0e}" if task.tolerance else f"{task.step:.1e} s"
    if not np.isfinite(course.states).all():
        return Failure("the states are not finite")
    model = f", {task.case.about}" if task.case.about == NOT_REDUCED else ""
    return Recording(course, tuple(runner.names), f"{task.method.name} at {asked}{model}")


def main_recording(case: Case) -> Recording | Failure:
    """Run the main method at the tightest tolerance at which it finishes, or time steps if it is refused."""
    result: Recording | Failure = Failure("not tried")
    if not admits(case, MAIN) and admits(case, TIME_STEPPING):
        return recorded(Task(case, TIME_STEPPING, None, time_step(case)))
    for tolerance in TIGHTEST:
        result = recorded(Task(case, MAIN, tolerance))
        if isinstance(result, Recording):
            return result
    return result


def admits(case: Case, method: Method) -> bool:
    """Whether the method can start a run of the scene."""
    try:
        Runner(Task(case, method, CHECK_TOLERANCE)).start()
    except GelenkError:
        return False
    return True


def time_step(case: Case) -> float:
    """Return the length of the time steps of a main run [s], a communication step divided by a power of 2."""
    parts = 1.0
    while parts * case.stop / case.step < TIME_STEPS:
        parts *= 2
    return case.step / parts


def unreduced(case: Case) -> Case:
    """Return the case with all reductions off, and named so."""
    solver = {**case.scene.get("solver", {}), "reductions": {"all": False}}
    return replace(case, scene={**case.scene, "solver": solver}, about=NOT_REDUCED)


def checks(case: Case, quick: bool) -> list[Task]:
    """Return the runs that check the accuracy of the main one; fewer if `quick`."""
    if not admits(case, MAIN):
        return [Task(case, TIME_STEPPING, None, 2 * time_step(case))]
    formulations, integrators = registered()
    others = [Method("independent", name) for name in WITNESSES if name in integrators]
    known = [method for method in others if "independent" in formulations and admits(case, method)]
    formulation = "independent" if known else MAIN.formulation
    if known:
        tasks = [Task(case, method, CHECK_TOLERANCE) for method in known]
    else:
        known = [Method(formulation, name) for name in EVENT_WITNESSES if name in integrators]
        tried = [(of, method) for method in known for of in (unreduced(case), case)]
        found = {method: of for of, method in reversed(tried) if admits(of, method)}
        tasks = [Task(found[method], method, CHECK_TOLERANCE) for method in known if method in found]
    if quick:
        return tasks[:2]
    parts = max(1, math.ceil(FIXED_STEPS * case.step / case.stop))
    return [*tasks, Task(case, Method(formulation, "rk4"), None, case.step / parts)]


def references(
    cases: Sequence[Case],
    jobs: int,
    limit: float,
    quick: bool = False,
    done: Callable[[], None] | None = None,
) -> dict[str, Reference | Failure]:
    """Return the reference solutions of the cases by name, or a Failure if there is none.

    Cases that must be refused have no entry.

    Args:
        cases: Test cases.
        jobs: Number of concurrent processes.
        limit: Wall-clock limit of each run [s].
        quick: Use fewer checks.
        done: Called after each run.
    """
    calls: list[tuple[Callable[..., Any], tuple[Any, ...], float]] = []
    owners: list[str] = []
    for case in cases:
        if case.expected == "refused":
            continue
        calls.append((main_recording, (case,), limit))
        owners.append(case.name)
        if case.truth is None and not case.by_energy:
            tasks = checks(case, quick)
            calls += [(recorded, (task,), limit) for task in tasks]
            owners += [case.name] * len(tasks)
    results = work_off(calls, jobs, None if done is None else lambda _i, _r: done())
    found: dict[str, Reference | Failure] = {}
    for case in cases:
        mine = [result for owner, result in zip(owners, results, strict=True) if owner == case.name]
        if mine:
            found[case.name] = (kept if case.by_energy else closed if case.truth else agreed)(case, mine)
    return found


def agreed(case: Case, results: Sequence[Recording | Failure]) -> Reference | Failure:
    """Return the first result as reference; its accuracy is the difference to the closest of the others."""
    main, *others = results
    if isinstance(main, Failure):
        return Failure(f"no reference: {main.reason}")
    scales = scales_of(main.course.states)
    found: list[tuple[float, str]] = [
        (difference(other.course.states, main.course.states, scales), other.by)
        for other in others
        if isinstance(other, Recording)
    ]
    published = against_published(case, main)
    if not found and published is not None:
        found, published = [published], None
    if not found:
        why = "; ".join(other.reason for other in others if isinstance(other, Failure))
        return Failure(f"no reference: nothing to check {main.by} with: {why}")
    agreement, by = min(found)
    words = f"{main.by}, checked by {by}: they agree to {agreement:.1e}"
    if published is not None:
        words += f"; {published[1]}: to {published[0]:.1e}"
    digits = max(agreement, ROUNDING)
    return Reference(main.course.states, scales, main.course.kinetic, main.course.total, digits, words)


def closed(case: Case, results: Sequence[Recording | Failure]) -> Reference | Failure:
    """Return the closed form as reference, with the energies of the run."""
    assert case.truth is not None
    main = results[0]
    if isinstance(main, Failure):
        return Failure(f"no reference: {main.reason}")
    times = case.grid[case.samples()]
    columns = case.truth(times)
    states = np.array([columns[name] for name in main.names]).T
    scales = scales_of(states)
    agreement = difference(main.course.states, states, scales)
    words = f"closed form; {main.by} agrees to {agreement:.1e}"
    published = against_published(case, Recording(replace(main.course, states=states), main.names, ""))
    if published is not None:
        words += f"; {published[1]}: to {published[0]:.1e}"
    # Quadrature and Newton's method are accurate to rounding, which grows with the angle.
    digits = 100 * float(np.finfo(float).eps) * float(np.abs(states).max())
    return Reference(states, scales, main.course.kinetic, main.course.total, digits, words)


def kept(case: Case, results: Sequence[Recording | Failure]) -> Reference | Failure:
    """Return a reference for the conservation of energy only; its states are those of the run."""
    main = results[0]
    if isinstance(main, Failure):
        return Failure(f"no reference: {main.reason}")
    course = main.course
    drift = float(np.abs(course.total - course.total[0]).max() / course.kinetic.max())
    words = f"initial energy; {main.by} changes it by {drift:.1e} in {case.stop:g} s"
    return Reference(
        course.states, scales_of(course.states), course.kinetic, np.full_like(course.total, course.total[0]),
        ROUNDING, words, by_energy=True,
    )  # fmt: skip


def against_published(case: Case, main: Recording) -> tuple[float, str] | None:
    """Return (largest error against published values at samples, their source), or None without any."""
    times: Array = case.grid[case.samples()]
    seen = [p for p in case.published if np.abs(times - p[0]).min() < 1e-9 * case.stop]
    if not seen:
        return None
    worst = 0.0
    for t, name, value in seen:
        row = int(np.argmin(np.abs(times - t)))
        found = main.course.states[row, main.names.index(name)]
        worst = max(worst, abs(float(found) - value) / max(1.0, abs(value)))
    return worst, case.source
