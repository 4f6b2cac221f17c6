# SPDX-License-Identifier: BSD-3-Clause
"""`solver.worst_step_evaluations` is the most evaluations in one communication step of a run."""

from __future__ import annotations

from itertools import pairwise

import pytest
from mechanisms import body, frame, joint, scene

import gelenk
from gelenk import StepBudgetError, UsageError

WORST = "solver.worst_step_evaluations"


def dropped(**solver: object) -> gelenk.Simulation:
    """A mass that falls onto a limit at 0.45 s and bounces."""
    source = scene(
        {"mass": body(1.0)},
        {
            "S": joint(
                "prismatic",
                frame("ground"),
                frame("mass"),
                axis=[0, 0, 1],
                limit={"lower": -1.0, "restitution": 0.8},
            )
        },
        gravity=[0, 0, -9.81],
        solver=solver,
    )
    simulation = gelenk.Simulation(gelenk.load(source))
    simulation.initialize()
    return simulation


def counts(simulation: gelenk.Simulation, first: int, last: int) -> list[float]:
    evaluations = [simulation.diagnostic("solver.evaluations")]
    for k in range(first, last):
        simulation.step_to(0.01 * (k + 1))
        evaluations.append(simulation.diagnostic("solver.evaluations"))
    return [after - before for before, after in pairwise(evaluations)]


@pytest.mark.parametrize("integrator", ["auto", "rk4", "erk", "ida", "moreau-jean"])
def test_worst_step_is_the_largest_of_all(integrator: str) -> None:
    simulation = dropped(integrator=integrator, step=0.01)
    assert simulation.diagnostic(WORST) == 0
    steps = counts(simulation, 0, 40)
    assert simulation.diagnostic(WORST) == max(steps)
    steps += counts(simulation, 40, 100)  # with impacts
    assert simulation.diagnostic("solver.impacts") >= 1 or integrator == "moreau-jean"
    assert simulation.diagnostic(WORST) == max(steps)


@pytest.mark.parametrize("integrator", ["rk4", "ida"])
def test_worst_step_belongs_to_the_state(integrator: str) -> None:
    simulation = dropped(integrator=integrator, step=0.01)
    counts(simulation, 0, 40)
    before = simulation.diagnostic(WORST)
    saved = simulation.save()
    counts(simulation, 40, 60)
    after = simulation.diagnostic(WORST)
    assert after > before  # the impact
    simulation.restore(saved)
    assert simulation.diagnostic(WORST) == before
    counts(simulation, 40, 60)
    assert simulation.diagnostic(WORST) == after
    simulation.initialize()
    assert simulation.diagnostic(WORST) == 0


def test_step_that_ends_early_counts() -> None:
    simulation = dropped(integrator="rk4", step=0.001, max_evaluations=50)
    with pytest.raises(StepBudgetError):
        simulation.step_to(0.4)
    assert simulation.diagnostic(WORST) == simulation.diagnostic("solver.evaluations") >= 50


def test_refused_call_does_not_count() -> None:
    simulation = dropped()
    simulation.step_to(0.01)
    before = simulation.diagnostic(WORST)
    with pytest.raises(UsageError, match="before the present time"):
        simulation.step_to(0.0)
    assert simulation.diagnostic(WORST) == before
