# SPDX-License-Identifier: BSD-3-Clause
"""A block that slides up an incline, stops and slides back.

The slower a motion is, the faster friction turns it. Where the block stops, methods may therefore amplify
rounding: into steps that are as short, into a turn of the block, or into corners that stop one by one.
"""

from __future__ import annotations

from math import cos, radians, sin

import pytest
from benchmarks.contacts.engines import scene
from benchmarks.contacts.problems import GRAVITY, Problem, problems

import gelenk

(PROBLEM,) = (problem for problem in problems() if problem.name == "back")
ANGLE = radians(30)
STOP = 3 / (GRAVITY * (sin(ANGLE) + PROBLEM.friction * cos(ANGLE)))  # s
INTEGRATORS = ["auto", "erk", "dirk", "cvode", "cvode-adams"]


def run(
    problem: Problem, integrator: str, tolerance: float, steps: int
) -> tuple[list[tuple[float, str]], dict[str, float]]:
    plant = gelenk.Simulation(gelenk.load(scene(problem, {"integrator": integrator})))
    plant.initialize(tolerance=tolerance)
    events = []
    for k in range(steps):
        plant.step_to(2 * (k + 1) / steps)
        events += plant.events
    return events, plant.diagnostics


@pytest.mark.parametrize("steps", [1, 30])
@pytest.mark.parametrize("tolerance", [1e-8, 1e-10])
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.filterwarnings("ignore:.*below the accuracy:gelenk.StartWarning")
def test_four_corners_stop_in_one_event(integrator: str, tolerance: float, steps: int) -> None:
    [(time, text)], counts = run(PROBLEM, integrator, tolerance, steps)
    assert time == pytest.approx(STOP, abs=100 * tolerance)
    assert text == "c: b slides on the ground"
    assert counts["solver.events"] == 1


def test_the_step_after_the_stop_is_as_long_as_the_one_before() -> None:
    """Some 370 evaluations in 24 steps; 80 steps if they grow from rounding."""
    _, counts = run(PROBLEM, "erk", 1e-8, 1)
    assert counts["solver.steps"] <= 32
    assert counts["solver.evaluations"] <= 500


def test_a_box_that_lands_on_its_face_touches_once() -> None:
    source = scene(PROBLEM, {"integrator": "erk"})
    source["ground"]["shapes"]["s"]["plane"] = [0, 0, 1]
    source["joints"]["J"]["start"] = {"r": [0, 0, 1.05], "fixed": True}
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(tolerance=1e-8)
    plant.step_to(1.0)
    [(time, text)] = plant.events
    assert time == pytest.approx((2 / GRAVITY) ** 0.5, abs=1e-8)
    assert text == "c: b touches the ground"


def test_each_corner_counts_towards_the_limit_of_events() -> None:
    """So that modes cannot alternate forever at one time."""
    for most, ends in ((3, False), (4, True)):
        source = scene(PROBLEM, {"integrator": "erk", "max_events": most})
        plant = gelenk.Simulation(gelenk.load(source))
        plant.initialize(tolerance=1e-8)
        if ends:
            plant.step_to(1.0)
            continue
        with pytest.raises(gelenk.StepError, match="more than 3 events"):
            plant.step_to(1.0)


@pytest.mark.parametrize("integrator", [*INTEGRATORS, "moreau-jean"])
def test_friction_that_is_set_to_none_while_a_block_slides(integrator: str) -> None:
    """It slides on at its speed, until there is friction again."""
    source = {
        "gelenk": 1,
        "gravity": [0, 0, -GRAVITY],
        "bodies": {
            "b": {"mass": 1, "inertia": [0.01] * 3, "shapes": {"x": {"box": [0.2] * 3, "surface": "b"}}}
        },
        "ground": {"shapes": {"p": {"plane": [0, 0, 1], "surface": "floor"}}},
        "joints": {
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "b",
                "start": {"r": [0, 0, 0.1], "v": [1, 0, 0], "fixed": True},
            }
        },
        "contacts": {"k": {"between": ["b", "floor"], "friction": 0.3}},
        "solver": {"integrator": integrator, "step": 1e-3},
        "parameters": ["k.friction"],
    }
    plant = gelenk.Simulation(source)
    plant.initialize(0, 1e-9)
    plant.step_to(0.1)
    plant._core.tune(gelenk.load(source).with_parameters({"k.friction": 0.0})._core)
    plant.step_to(0.2)
    speed = 1 - 0.3 * GRAVITY * 0.1
    assert plant.values(["J.v[1]"]) == pytest.approx([speed], abs=1e-8)
    plant._core.tune(gelenk.load(source)._core)
    plant.step_to(0.3)
    assert plant.values(["J.v[1]"]) == pytest.approx([speed - 0.3 * GRAVITY * 0.1], abs=1e-8)
