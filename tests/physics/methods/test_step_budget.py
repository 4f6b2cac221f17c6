# SPDX-License-Identifier: BSD-3-Clause
"""A step that exhausts `solver.max_evaluations` ends early,
with the constraints satisfied, and can be continued.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, body, four_bar, frame, joint, rod, scene

import gelenk
from gelenk import StepBudgetError, StepError

STOP = 1.0  # s, in one communication step
ADAPTIVE = ("auto", "erk", "ida", "cvode", "cvode-adams", "dirk")
FIXED = ("rk4", "euler", "generalized-alpha", "hht", "newmark")
METHODS = [
    *((integrator, "projection") for integrator in (*ADAPTIVE, *FIXED)),
    *(("erk", formulation) for formulation in ("baumgarte", "augmented-lagrangian", "independent")),
    *(("ida", formulation) for formulation in ("index3", "stabilized-index2")),
    ("generalized-alpha", "index3"),
]
# Maximum number of evaluations of one integration step, rejected attempts included, for all of these methods.
LONGEST_STEP = 60


def start(source: dict[str, Any], tolerance: float = 1e-8, **solver: Any) -> gelenk.Simulation:
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": solver}))
    simulation.initialize(0.0, tolerance)
    return simulation


def stiff() -> dict[str, Any]:
    """The four-bar with a spring of 1e5 N/m at its coupler, which oscillates at 30 Hz."""
    source = four_bar(1.1)
    source["forces"] = {
        "tie": {
            "type": "spring_damper",
            "from": frame("ground", (1.0, 1.0, 0)),
            "to": frame("coupler", (0.9, 0, 0)),
            "stiffness": 1e5,
            "damping": 30.0,
            "length": 1.0,
        }
    }
    return source


def sled(mass: float = 2.0) -> dict[str, Any]:
    return scene(
        {"sled": body(mass)},
        {"S": joint("prismatic", frame("ground"), frame("sled"), axis=[1, 0, 0])},
        motors={"push": {"joint": "S"}},
    )


def continue_to(plant: gelenk.Simulation, stop: float = STOP) -> list[float]:
    """Request the remainder of the step until it is complete;
    return the times at which it was interrupted.
    """
    left = [plant.time]
    while plant.time < stop:
        said = ""
        try:
            plant.step_to(stop)
        except StepBudgetError as e:
            said = str(e)
        if said:
            assert left[-1] < plant.time < stop
            assert f"the step to {stop:g} s ended here" in said
            assert "(solver.max_evaluations). The simulation can continue from the state at t = " in said
            left.append(plant.time)
    return left[1:]


def angles(plant: gelenk.Simulation) -> Any:
    return plant.values([f"{joint}.{x}" for joint in "ABCD" for x in ("phi", "w")])


@pytest.mark.parametrize(("integrator", "formulation"), METHODS)
def test_interrupted_step_ends_like_an_uninterrupted_one(integrator: str, formulation: str) -> None:
    choice: dict[str, Any] = {"integrator": integrator, "formulation": formulation, "step": 2e-4}
    whole = start(stiff(), **choice)
    whole.step_to(STOP)
    budget = 300
    parts = start(stiff(), **choice, max_evaluations=budget)
    left = continue_to(parts)
    assert len(left) > 5
    # Interrupted steps end at integration steps, so adaptive methods take exactly the same steps. Fixed steps
    # divide the remainder of the step again, with different round-off; multipliers amplify it.
    bound = 0.0 if integrator in ADAPTIVE else 1e-8
    assert np.abs(angles(parts) - angles(whole)).max() <= bound


@pytest.mark.parametrize(("integrator", "formulation"), METHODS)
def test_interrupted_steps_respect_budget_and_constraints(integrator: str, formulation: str) -> None:
    plant = start(stiff(), integrator=integrator, formulation=formulation, step=2e-4, max_evaluations=150)
    holds = formulation in ("projection", "independent")
    for _ in range(5):
        before = plant.diagnostics["solver.evaluations"]
        with pytest.raises(StepBudgetError):
            plant.step_to(STOP)
        spent = plant.diagnostics["solver.evaluations"] - before
        assert 150 <= spent < 150 + LONGEST_STEP
        if holds:
            assert plant.diagnostics["constraints.position"] < 1e-12
            assert plant.diagnostics["constraints.velocity"] < 1e-11


@pytest.mark.parametrize("integrator", [*ADAPTIVE, *FIXED])
def test_smallest_budget_still_advances(integrator: str) -> None:
    plant = start(four_bar(1.1), 1e-6, integrator=integrator, max_evaluations=1, step=0.01)
    left = continue_to(plant, 0.1)
    assert len(left) >= 2


@pytest.mark.parametrize("integrator", [*ADAPTIVE, "rk4"])
def test_unexhausted_budget_does_not_change_results(integrator: str) -> None:
    ends = []
    for budget in ({}, {"max_evaluations": 10_000}):
        plant = start(stiff(), integrator=integrator, **budget)
        for k in range(20):
            plant.set_input("drive.tau", 3.0 * (-1) ** k)
            plant.step_to((k + 1) * 0.005)
        ends.append([*plant.values(), *plant.diagnostics.values()])
    assert ends[0] == ends[1]  # bitwise


def test_interruption_times_are_reproducible() -> None:
    times = [continue_to(start(stiff(), max_evaluations=170)) for _ in range(2)]
    assert times[0] == times[1]


@pytest.mark.parametrize("stiff_first", [False, True])
@pytest.mark.parametrize("integrator", ["auto", "erk", "ida", "rk4"])
def test_all_islands_are_at_the_interruption_time(integrator: str, stiff_first: bool) -> None:
    """A pendulum that takes long steps beside a spring that takes short ones, in both orders."""
    spring = joint(
        "prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], stiffness=1e5, start={"s": 0.1}
    )
    hinge = joint("revolute", frame("ground"), frame("rod"), axis=[0, 0, 1], start={"phi": 1.0})
    joints = {"S": spring, "P": hinge} if stiff_first else {"P": hinge, "S": spring}
    source = scene({"mass": body(1.0), "rod": rod(1.0, 1.0)}, joints, gravity=[0, -GRAVITY, 0])
    plant = start(source, integrator=integrator, max_evaluations=400, step=2e-4)
    assert plant.size.islands == 2
    alone = start(source, integrator=integrator, step=2e-4)
    with pytest.raises(StepBudgetError):
        plant.step_to(STOP)
    assert 0.0 < plant.time < STOP
    alone.step_to(plant.time)
    # 1e5 N/m and 1 kg oscillate at 316 rad/s, so the error of speeds is larger by that: 300 x 100 x
    # tolerance.
    assert np.abs(plant.values() - alone.values())[[0, 3]].max() < 1e-6
    total = start(source, integrator=integrator, step=2e-4)
    total.step_to(STOP)
    continue_to(plant)
    names = ["S.s", "P.phi"]
    assert np.abs(plant.values(names) - total.values(names)).max() < 1e-5


def test_inputs_are_extrapolated_by_their_derivatives() -> None:
    plant = start(sled(), integrator="rk4", step=1e-3, max_evaluations=100)
    plant.set_input("push.f", 1.0)
    for order, d in ((1, -2.0), (3, 30.0)):
        plant.set_input_derivative("push.f", order, d)
    left = continue_to(plant, 0.2)
    assert len(left) > 5
    t = 0.2
    assert plant.input("push.f") == pytest.approx(1 - 2 * t + 5 * t**3, rel=1e-14)
    assert plant.output("S.s") == pytest.approx((t**2 / 2 - t**3 / 3 + t**5 / 4) / 2.0, rel=1e-11)
    assert plant.input_derivative("push.f", 3) == 0.0


def test_inputs_have_their_values_at_the_interruption_time() -> None:
    plant = start(sled(), integrator="rk4", step=1e-3, max_evaluations=100)
    plant.set_input_derivative("push.f", 2, 4.0)
    with pytest.raises(StepBudgetError):
        plant.step_to(STOP)
    t = plant.time
    assert t == pytest.approx(0.025)
    assert plant.input("push.f") == pytest.approx(2 * t * t, rel=1e-14)
    assert plant.input_derivative("push.f", 1) == pytest.approx(4 * t, rel=1e-14)
    assert plant.output("S.a") == pytest.approx(t * t, rel=1e-14)
    plant.set_input("push.f", 7.0)  # a jump; the derivatives keep their values until they are set
    plant.set_input_derivative("push.f", 1, 0.0)
    plant.set_input_derivative("push.f", 2, 0.0)
    with pytest.raises(StepBudgetError):
        plant.step_to(STOP)
    assert plant.output("S.a") == pytest.approx(3.5, rel=1e-14)


def test_failed_continuation_restores_the_interrupted_state() -> None:
    plant = start(four_bar(1.1), integrator="rk4", step=1e-3, max_evaluations=100)
    with pytest.raises(StepBudgetError):
        plant.step_to(STOP)
    time, values = plant.time, plant.values().tolist()
    plant.set_input("drive.tau", 1e300)
    with pytest.raises(StepError, match="state is unchanged at t = ") as caught:
        plant.step_to(STOP)
    assert not isinstance(caught.value, StepBudgetError)
    plant.set_input("drive.tau", 0.0)
    assert (plant.time, plant.values().tolist()) == (time, values)
    continue_to(plant)
