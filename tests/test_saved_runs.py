# SPDX-License-Identifier: BSD-3-Clause
"""A run goes on from what was saved, to the bit: shipped scenes, change points, stops that are met."""

from __future__ import annotations

import contextlib
import math
import struct
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import warned
from mechanisms import four_bar
from physics.loops.test_parallelograms import four_bar_chain
from physics.nonsmooth.test_stops import ball

import gelenk
from gelenk.chart.mechanisms import governor

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


@warned.TIGHT
@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
@pytest.mark.parametrize("integrator", ["auto", "ida", "generalized-alpha"])
def test_shipped_scenes(path: Path, integrator: str) -> None:
    goes_on_to_the_bit(path, 6, 8, 1e-2, integrator=integrator)


@pytest.mark.parametrize("before", range(60, 80, 2))
def test_about_a_change_point(before: int) -> None:
    """Before it, in it and after it: bars in line at about 0.7 s."""
    plant = goes_on_to_the_bit(four_bar_chain(2, 0.0, 1.0), before, 40, 1e-2)
    assert plant.diagnostics["solver.singular_positions"] > 0


@pytest.mark.parametrize("before", range(60, 80, 4))
def test_about_a_change_point_under_a_torque(before: int) -> None:
    source = four_bar_chain(2, 0.0, 1.0)
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


def driven(plant: gelenk.Simulation, k: int, jumps: str) -> None:
    if jumps == "often" or (jumps == "now and then" and k % 40 == 7):
        plant.set_input("drive.tau", 3 * math.sin(2.1 * k * k))


@pytest.mark.parametrize("jumps", ["never", "now and then", "often"])
@pytest.mark.parametrize("integrator", ["auto", "ida", "cvode", "cvode-adams", "erk", "dirk", "hht"])
def test_saving_changes_no_bit_of_a_run(integrator: str, jumps: str) -> None:
    """At each of 600 steps: more than the methods with a history go without beginning anew. On a stiff
    governor, so that `auto` has one, too.
    """
    source = governor()
    source["motors"] = {"drive": {"joint": next(iter(source["joints"]))}}
    source["solver"] = {"integrator": integrator}
    plain, saving = gelenk.Simulation(source), gelenk.Simulation(source)
    states: dict[int, bytes] = {}
    rows: list[list[list[float]]] = []
    for plant in (plain, saving):
        plant.initialize(0.0, 1e-7)
        rows.append([])
        for k in range(600):
            driven(plant, k, jumps)
            plant.step_to(2e-3 * (k + 1))
            rows[-1].append(plant.values().tolist())
            if plant is saving:
                states[k] = plant.save()
    assert rows[0] == rows[1]
    if jumps == "never":
        return
    other = gelenk.Simulation(source)
    other.initialize(0.0, 1e-7)
    for k in (6, 7, 8, 255, 300, 511):
        other.restore(states[k])
        for i in range(k + 1, k + 60):
            driven(other, i, jumps)
            other.step_to(2e-3 * (i + 1))
            assert other.values().tolist() == rows[0][i], (k, i)


@pytest.mark.parametrize("integrator", ["ida", "cvode", "cvode-adams"])
def test_forged_ways_do_no_harm(integrator: str) -> None:
    """Of a method with a history a record holds the way from where it began. Each number of it in turn
    replaced: taken or refused, the plant goes on from its own state as before.
    """
    source = four_bar() | {"solver": {"integrator": integrator}}
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, 1e-5)
    run(plant, 0, 1, 1e-2)
    for k in range(1, 8):
        plant.step_to(1e-2 * (k + 1))
    saved = plant.save()
    plant.step_to(0.1)
    expected = plant.values().tolist()
    refused = 0
    forgeries = (struct.pack("<q", -1), struct.pack("<q", 2**40), struct.pack("<d", math.nan), bytes(8))
    for k, word in product(range(0, len(saved), 8), forgeries):
        try:
            plant.restore(saved[:k] + word + saved[k + 8 :])
            with contextlib.suppress(gelenk.StepError, gelenk.UsageError):
                plant.step_to(plant.time + 1e-3)
        except gelenk.UsageError as error:
            refused += "not of this plant, or damaged" in str(error)
        plant.restore(saved)
    assert refused > 20
    plant.step_to(0.1)
    assert plant.values().tolist() == expected


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
