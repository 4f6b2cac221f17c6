# SPDX-License-Identifier: BSD-3-Clause
"""A run goes on from what was saved, to the bit: shipped scenes, change points, stops that are met."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path
from typing import Any

import pytest
from mechanisms import four_bar
from physics.test_parallelograms import windows
from physics.test_stops import ball

import gelenk

SCENES = sorted((Path(__file__).resolve().parent.parent / "scenes").glob("*.yaml"))


def run(plant: gelenk.Simulation, first: int, steps: int, size: float) -> list[list[float]]:
    rows = []
    for k in range(first, first + steps):
        for i, signal in enumerate(plant.inputs):
            plant.set_input(signal.name, 0.2 * math.sin(0.9 * k + i))
        plant.step_to((k + 1) * size)
        rows.append([plant.output(s.name) for s in plant.outputs])
    return rows


def goes_on_to_the_bit(scene: Any, before: int, after: int, size: float, **solver: str) -> gelenk.Simulation:
    loaded = gelenk.load(scene).with_parameters({f"solver.{k}": v for k, v in solver.items()})
    plant = gelenk.Simulation(loaded)
    plant.initialize()
    run(plant, 0, before, size)
    saved = plant.save()
    expected = run(plant, before, after, size)
    diagnostics = plant.diagnostics
    other = gelenk.Simulation(loaded)
    other.initialize()
    for again in (plant, other):
        again.restore(saved)
        assert run(again, before, after, size) == expected
        assert again.diagnostics == diagnostics
    return plant


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
@pytest.mark.parametrize("integrator", ["auto", "ida", "generalized-alpha"])
def test_shipped_scenes(path: Path, integrator: str) -> None:
    goes_on_to_the_bit(path, 6, 8, 1e-2, integrator=integrator)


@pytest.mark.parametrize("before", range(60, 80, 2))
def test_about_a_change_point(before: int) -> None:
    """Before it, in it and after it: bars in line at about 0.7 s."""
    plant = goes_on_to_the_bit(windows(2, 0.0, 1.0), before, 40, 1e-2)
    assert plant.diagnostics["solver.singular_positions"] > 0


@pytest.mark.parametrize("before", range(60, 80, 4))
def test_about_a_change_point_under_a_torque(before: int) -> None:
    source = windows(2, 0.0, 1.0)
    source["motors"] = {"drive": {"joint": "A0"}}
    plant = goes_on_to_the_bit(source, before, 40, 1e-2)
    assert plant.diagnostics["solver.singular_positions"] > 0


@pytest.mark.parametrize("integrator", ["auto", "ida", "cvode-adams", "rk4"])
def test_within_a_step_cut_short_while_the_torque_moves(integrator: str) -> None:
    source = four_bar() | {"solver": {"integrator": integrator, "max_evaluations": 30}}

    def go_on(plant: gelenk.Simulation) -> list[tuple[float, ...]]:
        rows = []
        while plant.time < 0.4:
            with contextlib.suppress(gelenk.StepBudgetError):
                plant.step_to(0.4)
            rows.append((plant.time, plant.input("drive.tau"), *plant.values()))
        plant.set_input("drive.tau", math.nextafter(plant.input("drive.tau"), 9.0))  # rounding is no jump
        with contextlib.suppress(gelenk.StepBudgetError):
            plant.step_to(0.5)
        return [*rows, (plant.time, *plant.values())]

    plant, other = gelenk.Simulation(source), gelenk.Simulation(source)
    for p in (plant, other):
        p.initialize()
    plant.set_input_derivative("drive.tau", 1, 9.0)
    plant.set_input_derivative("drive.tau", 3, -70.0)
    with pytest.raises(gelenk.StepBudgetError):
        plant.step_to(0.4)
    saved = plant.save()
    expected = go_on(plant)
    assert len(expected) > 3
    for again in (plant, other):
        again.restore(saved)
        assert go_on(again) == expected


def test_in_contact_with_a_stop() -> None:
    goes_on_to_the_bit(ball(lower=0.0, damping=3.0), 31, 60, 1e-2)


def test_bytes_of_something_else_are_refused() -> None:
    plant = gelenk.Simulation(four_bar())
    with pytest.raises(gelenk.UsageError):
        plant.save()  # of a run that has not begun
    plant.initialize()
    run(plant, 0, 3, 1e-2)
    saved = plant.save()
    there = [plant.output(s.name) for s in plant.outputs]
    pendulum = gelenk.Simulation(SCENES[[p.stem for p in SCENES].index("pendulum")])
    pendulum.initialize()
    for other in (b"", saved[:-8], saved[:-3], saved + bytes(8), pendulum.save()):
        with pytest.raises(gelenk.UsageError, match="not of this plant, or damaged"):
            plant.restore(other)
        assert [plant.output(s.name) for s in plant.outputs] == there
