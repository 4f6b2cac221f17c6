# SPDX-License-Identifier: BSD-3-Clause
"""Limits beside a prescribed motion whose value jumps: what they let through is determined by geometry.

A slider on a carriage whose position is given by values. Where the carriage jumps, the slider stays behind as
far as its limits permit, and is carried along from there.
"""

from __future__ import annotations

from typing import Any

import pytest

import gelenk

INTEGRATORS = ["auto", "erk", "cvode", "ida", "dirk", "rk4"]
TRAVEL = 0.02  # m


def carriage(integrator: str, **slider: Any) -> gelenk.Simulation:
    start = {"s": 0, "v": 0, "fixed": True}
    plant = gelenk.Simulation({
        "gelenk": 1,
        "gravity": [0, 0, 0],
        "bodies": {"carriage": {"mass": 1}, "slider": {"mass": 2}},
        "joints": {
            "X": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "carriage",
                  "start": start},
            "S": {"type": "prismatic", "axis": [1, 0, 0], "parent": "carriage", "child": "slider",
                  "start": start, "limit": {"lower": -TRAVEL, "upper": TRAVEL}, **slider},
        },
        "constraints": {"move": {"type": "motion", "joint": "X", "input": "position"}},
        "solver": {"integrator": integrator, "step": 1e-3},
    })  # fmt: skip
    plant.initialize(tolerance=1e-8)
    return plant


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("jump", [0.015, 0.05, -0.05])
def test_a_jump_carries_along_what_its_limits_do_not_let_behind(integrator: str, jump: float) -> None:
    plant = carriage(integrator)
    for k in range(4):
        plant.set_input("move.s_ref", 0.0)
        plant.step_to(0.01 * (k + 1))
    plant.set_input("move.s_ref", jump)
    plant.step_to(0.05)
    expected = max(-TRAVEL, min(TRAVEL, -jump))
    assert plant.output("S.s") == pytest.approx(expected, abs=1e-10)
    assert plant.output("X.s") == pytest.approx(jump, abs=1e-12)
    plant.step_to(0.5)
    assert -TRAVEL - 1e-10 <= plant.output("S.s") <= TRAVEL + 1e-10


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_what_is_pushed_by_a_limit_follows_its_motion(integrator: str) -> None:
    """Accelerated at 2 m/s2, given every 10 ms: the slider, left behind, is pushed by its lower limit."""
    plant = carriage(integrator)
    for k in range(100):
        t = 0.01 * k
        plant.set_input("move.s_ref", t * t)
        plant.step_to(t + 0.01)
    assert plant.output("S.s") == pytest.approx(-TRAVEL, abs=1e-9)
    assert plant.output("S.v") == pytest.approx(0, abs=1e-9)
    assert plant.output("S.limit.f") == pytest.approx(2 * 2, rel=1e-6)
