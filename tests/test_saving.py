# SPDX-License-Identifier: BSD-3-Clause
"""Saving a run's state does nothing to the run: with every formulation and integrator, and at stops."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import pytest
from looped import looped
from mechanisms import four_bar
from physics.nonsmooth.test_stops import ball

import gelenk

ODE = ("projection", "udwadia-kalaba", "baumgarte", "penalty", "augmented-lagrangian", "independent")
ADAPTIVE = ("auto", "erk", "dirk", "ida", "cvode", "cvode-adams")
INTEGRATORS = (*ADAPTIVE, "rk4", "euler", "generalized-alpha", "hht", "newmark")
DAE = ("index3", "stabilized-index2")
EVERY = {"never": 0, "now and then": 20, "often": 1}  # communication steps from one jump to the next
STEP = 2e-3  # s


def rows(source: dict[str, Any], drive: str, jumps: str, tolerance: float, saving: bool) -> list[list[float]]:
    """Outputs over 150 steps."""
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, tolerance)
    found = []
    for k in range(150):
        if EVERY[jumps] and k % EVERY[jumps] == 0:
            plant.set_input(drive, 3 * math.sin(2.1 * k * k))
        plant.step_to(STEP * (k + 1))
        found.append(plant.values().tolist())
        if saving:
            plant.save()
    return found


def assert_saving_does_nothing(source: dict[str, Any], drive: str, jumps: str, tolerance: float) -> None:
    plain, saved = (rows(source, drive, jumps, tolerance, saving) for saving in (False, True))
    assert saved == plain


@pytest.mark.thorough
@looped(("formulation", "integrator"), [*product(ODE, INTEGRATORS), *product(DAE, ("auto", "ida"))])
@looped("jumps", EVERY)
def test_with_every_formulation_and_integrator(formulation: str, integrator: str, jumps: str) -> None:
    """With `penalty` explicit steps meet a stiff oscillation: they shrink to a tenth, or are tried again."""
    source = four_bar() | {"solver": {"integrator": integrator, "formulation": formulation}}
    source["motors"] = {"drive": {"joint": "A"}}
    for tolerance in (1e-6, 1e-8):
        assert_saving_does_nothing(source, "drive.tau", jumps, tolerance)


@looped("integrator", ADAPTIVE)
@looped("jumps", EVERY)
def test_while_a_stop_is_met(integrator: str, jumps: str) -> None:
    """Between the bounces of a ball too, and with a jump of its motor's force shortly before one."""
    source = ball(0.03, -1.0, lower=0.0, damping=3.0) | {"solver": {"integrator": integrator}}
    source["motors"] = {"drive": {"joint": "J"}}
    assert_saving_does_nothing(source, "drive.f", jumps, 1e-8)


def stiff_row(n: int) -> dict[str, Any]:
    """Sliders, each on the one before by a spring and a strong damper: 2 n states."""
    joints: dict[str, Any] = {}
    for k in range(n):
        parent = {"body": f"b{k - 1}"} if k else "ground"
        slide = {"type": "prismatic", "axis": [1, 0, 0], "stiffness": 100.0, "damping": 200.0}
        joints[f"j{k}"] = {**slide, "parent": parent, "child": f"b{k}"}
    joints["j0"]["start"] = {"s": 0.1}
    bodies = {f"b{k}": {"mass": 0.01, "inertia": [0, 0, 0]} for k in range(n)}
    return {"gelenk": 1, "name": "Row", "gravity": [0, 0, 0], "bodies": bodies, "joints": joints}


def test_what_auto_makes_only_when_it_needs_it_is_not_left_over_from_a_later_time() -> None:
    """With more than 1000 states the implicit method is made at the first change to it. A record of a time
    before that, read after it, leads the same way with the same counts.
    """
    plant = gelenk.Simulation(stiff_row(505))
    plant.initialize(0.0, 1e-4)
    plant.step_to(0.003)
    early = plant.save()

    def go_on() -> tuple[list[float], dict[str, float]]:
        for k in range(4, 9):
            plant.step_to(0.001 * k)
        return plant.values().tolist(), dict(plant.diagnostics)

    first, counts = go_on()
    assert counts["solver.jacobians"] > 0, "the implicit method has taken over"
    plant.restore(early)
    assert plant.diagnostics["solver.jacobians"] == 0
    assert go_on() == (first, counts)
