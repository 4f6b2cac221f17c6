# SPDX-License-Identifier: BSD-3-Clause
"""With `solver.corrections` each step has a bounded cost;
these tests measure the cost and the loss of accuracy.
"""

from __future__ import annotations

import math
from typing import Any

import pytest
from mechanisms import four_bar

import gelenk

STEP = 1e-3
STEPS = 20_000


def driven(**solver: Any) -> gelenk.Simulation:
    plant = gelenk.Simulation(four_bar() | {"solver": {"step": STEP, **solver}})
    plant.initialize()
    return plant


def run(plant: gelenk.Simulation, steps: int = STEPS) -> tuple[list[float], float, set[float]]:
    """Return the crank angle after each step, the largest closure error during the run,
    and the evaluations per step.
    """
    angles, gap, costs = [], 0.0, set()
    before = plant.diagnostics["solver.evaluations"]
    for k in range(steps):
        plant.set_input("drive.tau", 2.0 * math.sin(9 * k * STEP) * (1 if k % 7 else -1))
        plant.step_to((k + 1) * STEP)
        evaluations = plant.diagnostics["solver.evaluations"]
        costs.add(evaluations - before)
        before = evaluations
        angles.append(plant.output("A.phi"))
        gap = max(gap, plant.diagnostics["constraints.position"])
    return angles, gap, costs


@pytest.mark.parametrize(("integrator", "evaluations"), [("rk4", 4), ("euler", 1)])
def test_each_step_has_the_same_cost(integrator: str, evaluations: int) -> None:
    _, _, costs = run(driven(integrator=integrator, corrections=2), 500)
    assert costs == {evaluations}


def test_two_corrections_close_the_loops_to_round_off() -> None:
    """After a step of 1 ms the first correction leaves the square of the error, the second only round-off."""
    closed, _, _ = run(driven(integrator="rk4"))
    angles, gap, _ = run(driven(integrator="rk4", corrections=2))
    assert gap < 1e-12
    assert max(abs(a - b) for a, b in zip(angles, closed, strict=True)) < 1e-9


def test_one_correction_leaves_a_larger_closure_error() -> None:
    _, gap, _ = run(driven(integrator="euler", corrections=1), 2000)
    _, closer, _ = run(driven(integrator="euler", corrections=3), 2000)
    assert closer < 0.1 * gap
