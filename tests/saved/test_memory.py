# SPDX-License-Identifier: BSD-3-Clause
"""The future of a run depends on its saved state and the calls since then alone: on no other memory."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest
from models.remembering import ADAPTIVE, DRIVE, INTEGRATORS, SCENES, STEP, plant_of, rows

import gelenk

MOVING = [False, True]
EVERY = [*product(SCENES, ADAPTIVE), *product(["smooth", "loop"], INTEGRATORS[len(ADAPTIVE) :])]
STEPPED = [(kind, "moreau-jean") for kind in ("friction", "limit", "contact")]


@pytest.mark.parametrize("moving", MOVING, ids=["held", "moving"])
@pytest.mark.parametrize(("kind", "integrator"), [*EVERY, *STEPPED])
def test_saving_changes_no_bit(kind: str, integrator: str, moving: bool) -> None:
    """At each communication point, or at a single one: neither outputs nor counts."""
    found = []
    for saves in (range(0), range(40), range(7, 8)):
        plant = plant_of(kind, integrator)
        run = []
        for k in range(40):
            if k in saves:
                plant.save()
            run += rows(plant, k, 1, moving)
        found.append(run)
    assert found[1] == found[0]
    assert found[2] == found[0]


@pytest.mark.parametrize("moving", MOVING, ids=["held", "moving"])
@pytest.mark.parametrize(("kind", "integrator"), [*EVERY, *STEPPED])
def test_a_used_plant_goes_on_as_a_fresh_one(kind: str, integrator: str, moving: bool) -> None:
    """Restored from states in the midst of a run, after it has gone elsewhere and refused a step there."""
    plant, fresh = plant_of(kind, integrator), plant_of(kind, integrator)
    states, expected = {}, rows(plant_of(kind, integrator), 0, 45, moving)
    for k in range(40):
        if k % 9 == 4:
            states[k] = plant.save()
        assert rows(plant, k, 1, moving) == [expected[k]]
    for k, state in reversed(states.items()):
        plant.restore(state)
        fresh = plant_of(kind, integrator)
        fresh.restore(state)
        assert rows(fresh, k, 5, moving) == expected[k : k + 5]
        assert rows(plant, k, 5, moving) == expected[k : k + 5]
        plant.set_input(DRIVE, -7.0)
        plant.step_to(plant.time + 0.37)
        refuse(plant)


def refuse(plant: gelenk.Simulation) -> None:
    """A step with a torque that no number can follow."""
    plant.set_input(DRIVE, 1.7e308)
    with pytest.raises(gelenk.StepError):
        plant.step_to(plant.time + STEP)


@pytest.mark.parametrize("moving", MOVING, ids=["held", "moving"])
@pytest.mark.parametrize(("kind", "integrator"), EVERY)
def test_a_discarded_step_leaves_no_trace(kind: str, integrator: str, moving: bool) -> None:
    """The run goes on as if the step had not been tried: with its counts, and its history if it has one."""
    expected = rows(plant_of(kind, integrator), 0, 40, moving)
    plant = plant_of(kind, integrator)
    found = []
    for k in range(40):
        if k % 6 == 5 and k > 12:  # friction no longer holds the wheel
            before = plant.input(DRIVE)
            refuse(plant)
            plant.set_input(DRIVE, before)
        found += rows(plant, k, 1, moving)
    assert found == expected


@pytest.mark.parametrize("kind", ["smooth", "limit", "contact", "loop"])
@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_restored_at_each_step_while_the_input_stays(kind: str, integrator: str) -> None:
    """`erk` starts its steps with the derivative from the end of the last one, also where it was restored."""
    plain, restored = plant_of(kind, integrator), plant_of(kind, integrator)
    state = restored.save()
    for k in range(30):
        plain.step_to((k + 1) * STEP)
        restored.restore(state)
        restored.step_to((k + 1) * STEP)
        assert restored.values().tolist() == plain.values().tolist()
        assert restored.diagnostics == plain.diagnostics
        state = restored.save()


def test_restores_are_not_counted(root: Path) -> None:
    """A step of eleven integrator steps, made again until there are more of these in all than may fail to
    advance the time (20,000).
    """
    plant = gelenk.Simulation(gelenk.load(root / "scenes" / "cart_pole.yaml"))
    plant.initialize()
    start = plant.save()
    found = set()
    for _ in range(3000):
        plant.restore(start)
        plant.set_input("drive.f", -9.4)
        plant.step_to(0.02)
        found.add((plant.output("hinge.w"), plant.output("track.s")))
    assert len(found) == 1


@pytest.mark.study
@pytest.mark.parametrize("moving", MOVING, ids=["held", "moving"])
@pytest.mark.parametrize("integrator", ADAPTIVE)
@pytest.mark.parametrize("kind", ["smooth", "friction", "limit", "contact"])
def test_ten_thousand_restores(kind: str, integrator: str, moving: bool) -> None:
    plant = plant_of(kind, integrator)
    rows(plant, 0, 11, moving)
    state = plant.save()
    expected = rows(plant, 11, 1, moving)
    for k in range(10_000):
        plant.restore(state)
        assert rows(plant, 11, 1, moving) == expected
        if k % 1000 == 999:
            refuse(plant)
