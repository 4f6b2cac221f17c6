# SPDX-License-Identifier: BSD-3-Clause
"""The `auto` integrator selects the cheaper method during a run.
Evaluations are compared, not times, which vary.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.chart.mechanisms import governor

Scene = dict[str, Any]


def driven_governor() -> Scene:
    source = governor()
    source["motors"] = {"drive": {"joint": next(iter(source["joints"]))}}
    return source


def cost(source: Scene, integrator: str, stop: float, points: int, torque: float = 0.0) -> dict[str, float]:
    """Return the diagnostics of a run whose torque changes at each communication point."""
    plant = gelenk.Simulation({**source, "solver": {"integrator": integrator}})
    plant.initialize(0.0, 1e-6)
    for k in range(points):
        if torque:
            plant.set_input("drive.tau", torque * math.sin(2.1 * k * k))
        plant.step_to(stop * (k + 1) / points)
    return {**plant.diagnostics, "P.s": plant.output("P.s")}


def evaluations(health: dict[str, float]) -> float:
    """Evaluations as counted in methods.md; the governor has 8 unknowns."""
    return health["solver.evaluations"] + 2 * 8 * health["solver.jacobians"] + 2 * health["solver.steps"]


def free(source: Scene, integrator: str) -> dict[str, float]:
    plant = gelenk.Simulation({**source, "solver": {"integrator": integrator}})
    plant.initialize(0.0, 1e-6)
    plant.step_to(5.0)
    return plant.diagnostics


@pytest.mark.parametrize(
    ("points", "torque", "better"),
    [(5, 0.0, "cvode"), (400, 0.0, "cvode"), (80, 5.0, "cvode")],
    ids=["free", "outputs", "a new torque every 50 ms"],
)
def test_stiff_governor_costs_as_much_as_with_the_better_method(
    points: int, torque: float, better: str
) -> None:
    runs = {m: cost(driven_governor(), m, 4.0, points, torque) for m in ("auto", "erk", "cvode")}
    counted = {m: evaluations(health) for m, health in runs.items()}
    assert min(counted["erk"], counted["cvode"]) == counted[better]
    assert max(counted["erk"], counted["cvode"]) > 2 * counted[better], "otherwise the choice is irrelevant"
    assert counted["auto"] < 1.5 * counted[better], counted
    assert runs["auto"]["P.s"] == pytest.approx(runs["erk"]["P.s"], abs=1e-4)  # 100 times the tolerance


def test_explicit_method_is_kept_for_torque_jumps_every_millisecond() -> None:
    """After each jump `cvode` starts explicitly, too; neither costs more than when used alone."""
    runs = {m: cost(driven_governor(), m, 4.0, 4000, 5.0) for m in ("auto", "erk", "cvode")}
    counted = {m: evaluations(health) for m, health in runs.items()}
    assert max(counted.values()) < 1.1 * counted["erk"], counted
    assert runs["auto"]["P.s"] == pytest.approx(runs["erk"]["P.s"], abs=1e-4)  # 100 times the tolerance


def test_explicit_method_is_kept_for_nonstiff_scenes(four_bar: gelenk.Scene) -> None:
    source = four_bar.to_dict()
    auto, erk = (free(source, m) for m in ("auto", "erk"))
    assert auto["solver.evaluations"] <= 1.05 * erk["solver.evaluations"]  # 8 for each hundred steps of 9
    assert auto["solver.jacobians"] == 0


def test_onset_of_stiffness_is_detected_during_the_run() -> None:
    """A pendulum falls freely, then rests on a soft stop with damping of 2e4 1/s."""
    source: Scene = {
        "gelenk": 1,
        "gravity": [0, -9.81, 0],
        "bodies": {"bob": {"mass": 1, "com": [1, 0, 0]}},
        "joints": {
            "A": {"type": "revolute", "parent": "ground", "child": "bob",
                  "start": {"phi": 1.5, "fixed": True},
                  "stop": {"lower": 0.0, "stiffness": 2e3, "damping": 2e4}},
        },
    }  # fmt: skip
    found = {m: free(source, m) for m in ("auto", "erk", "cvode")}
    assert found["erk"]["solver.steps"] > 10 * found["cvode"]["solver.steps"], "limited by stability"
    assert found["auto"]["solver.steps"] < 3 * found["cvode"]["solver.steps"]
    assert found["auto"]["solver.jacobians"] > 0


def test_results_are_bitwise_reproducible_across_method_changes() -> None:
    first, second = (cost(driven_governor(), "auto", 1.0, 200, 5.0) for _ in range(2))
    assert first == second


def test_run_continues_after_a_refused_step() -> None:
    """A torque of excessive size makes the accelerations overflow: the step is refused,
    and the run can continue.
    """
    plant = gelenk.Simulation(driven_governor())
    plant.initialize(0.0, 1e-6)
    plant.step_to(0.1)
    before = plant.values()
    plant.set_input("drive.tau", 1e308)
    with pytest.raises(gelenk.StepError, match=r"state is unchanged at t = 0\.1 s"):
        plant.step_to(0.2)
    assert np.array_equal(plant.values(["P.s"]), before[[s.name for s in plant.outputs].index("P.s")][None])
    plant.set_input("drive.tau", 0.0)
    plant.step_to(0.2)
    assert math.isfinite(plant.output("P.s"))
