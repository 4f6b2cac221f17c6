# SPDX-License-Identifier: BSD-3-Clause
"""The car of the gallery as an FMU: its state in a skid, the cost of its steps."""

from __future__ import annotations

import fmpy
import pytest
from models.car import BRAKES, FILE

import gelenk

from .host import OK, Fmu, Slave
from .states import deserialize, everything, get_state, serialized, set_state

STEP = 1e-3


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Fmu:
    folder = tmp_path_factory.mktemp("car")
    return Fmu(fmpy.extract(str(gelenk.export_fmu(FILE, folder / "x.fmu")), str(folder / "x")))


def run(s: Slave, first: int, end: int) -> list[list[float]]:
    """Steps of 1 ms: it is steered, braked from 0.3 s on until its wheels lock, and released at 0.6 s."""
    rows = []
    for k in range(first, end):
        if k == 0:
            assert s.set({"column.tau": 8.0}) == OK, s.said
        if k in (300, 600):
            assert s.set(dict.fromkeys(BRAKES, 1.0 if k == 300 else 0.0)) == OK, s.said
        assert s.step(k * STEP, STEP) == OK, s.said
        rows.append(everything(s))
    return rows


@pytest.mark.parametrize("saved_at", [320, 500, 610])
def test_a_state_saved_in_a_skid_continues_with_the_same_bits(fmu: Fmu, saved_at: int) -> None:
    """While the wheels lock, while the car slides sideways, and while they turn again."""
    s = Slave(fmu).start()
    run(s, 0, saved_at)
    state = get_state(s)
    content = serialized(s, state)
    rest = run(s, saved_at, saved_at + 100)
    if saved_at == 500:
        assert s.get("hub_fl.w") == 0
        assert abs(s.get("tire_fl.slip_angle")) > 0.05
    set_state(s, state)
    assert run(s, saved_at, saved_at + 100) == rest
    other = Slave(fmu).start()
    run(other, 0, 7)
    restored = get_state(other)
    assert deserialize(other, content, restored) == OK
    set_state(other, restored)
    assert run(other, saved_at, saved_at + 100) == rest


def test_a_step_of_a_millisecond_costs_few_evaluations(fmu: Fmu) -> None:
    """Steered anew in each step on a level road: one step of the integrator, seven evaluations.

    This keeps it ten times faster than real time; the processor's time itself is not a measure here.
    """
    s = Slave(fmu).start()
    for k in range(400):  # up to the bump
        assert s.set({"column.tau": 2.0 + 0.1 * (k % 7)}) == OK, s.said
        assert s.step(k * STEP, STEP) == OK, s.said
    assert s.get("solver.steps") <= 450
    assert s.get("solver.evaluations") <= 3200
