# SPDX-License-Identifier: BSD-3-Clause
"""Runs by programs that are made for a scene (`solver.equations: traced`) are those by the general kernels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from physics.loops.test_parallelograms import four_bar_chain
from special.drawn import drawn

import gelenk
from gelenk.errors import AssemblyError, SceneError

ROOT = Path(__file__).resolve().parents[3]
SCENES = {path.stem: path for path in sorted(ROOT.glob("scenes/*.yaml"))}
FAST = {"andrews": 1e-4}  # s: of mechanisms that turn several times in 0.01 s
# Both compute the same operations in another order; errors of some thousand roundings, which motions magnify.
ROUNDING = 1e-12


def plant_of(scene: Any, **solver: Any) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(scene).with_parameters({f"solver.{k}": v for k, v in solver.items()}))
    plant.initialize()
    return plant


def states(plant: gelenk.Simulation) -> dict[str, float]:
    return {s.name: plant.output(s.name) for s in plant.outputs if s.level <= 1}


def share(plant: gelenk.Simulation) -> float:
    """Of the evaluations, those by a program."""
    found = plant.diagnostics
    return float(found["solver.traced_evaluations"] / max(1, found["solver.evaluations"]))


def difference(scene: Any, steps: int, step: float, **solver: Any) -> tuple[float, float]:
    """After some steps, relative to the largest number of the state or 1; and the share of the program."""
    plants = [plant_of(scene, step=step, equations=kind, **solver) for kind in ("general", "traced")]
    for plant in plants:
        for k in range(steps):
            for i, signal in enumerate(plant.inputs):
                plant.set_input(signal.name, 0.2 * math.sin(0.9 * k + i))
            plant.step_to((k + 1) * step)
    expected, found = (states(plant) for plant in plants)
    assert share(plants[0]) == 0
    size = max(1.0, *(abs(x) for x in expected.values()))
    return max(abs(found[name] - x) for name, x in expected.items()) / size, share(plants[1])


# Scenes of which the equations are smooth, and no larger than what pays.
TRACED: set[str] = set()


@pytest.mark.parametrize("name", SCENES)
def test_shipped_scenes_move_alike(name: str) -> None:
    found, traced = difference(SCENES[name], 60, FAST.get(name, 1e-3), integrator="rk4")
    assert found < ROUNDING
    assert (traced > 0.99) == (name in TRACED), traced
