# SPDX-License-Identifier: BSD-3-Clause
"""A clutch in an FMU: its engagement is an input, and its mode is part of the state."""

from __future__ import annotations

import fmpy
import pytest
from models.drive_line import ENGAGEMENT, ENGINE, LOAD, SLIDING, drive_line

import gelenk

from .host import OK, Fmu, Slave
from .states import deserialize, get_state, serialized, set_state

STEP = 0.05
RATE = 0.5 * SLIDING * (1 / ENGINE + 1 / LOAD)  # rad/s2, of the slip


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Fmu:
    folder = tmp_path_factory.mktemp("clutch")
    return Fmu(fmpy.extract(str(gelenk.export_fmu(drive_line(-50), folder / "x.fmu")), str(folder / "x")))


def run(s: Slave, first: int, end: int) -> list[list[float]]:
    """Steps of 50 ms; the clutch is half engaged from 0.1 s on, released at 2 s and fully engaged at 3 s."""
    engagements = {2: 0.5, 40: 0.0, 60: 1.0}
    rows = []
    for k in range(first, end):
        if k in engagements:
            assert s.set({ENGAGEMENT: engagements[k]}) == OK, s.said
        assert s.step(k * STEP, STEP) == OK, s.said
        rows.append(s.outputs())
    return rows


def test_the_engagement_is_an_input(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    run(s, 0, 100)
    slipped = RATE * (2.0 - 0.1)
    assert s.get("clutch.w") == 0
    assert s.get("clutch.friction.mode") == 0
    # The rest of the slip ends at twice the rate.
    assert (50 - slipped) / (2 * RATE) < 2.0
    # All torques are between the two: their momentum remains.
    assert s.get("shaft.w") == pytest.approx(50 * ENGINE / (ENGINE + LOAD), abs=1e-4)


@pytest.mark.parametrize("saved_at", [1, 20, 50, 90])
def test_its_mode_is_part_of_the_state(fmu: Fmu, saved_at: int) -> None:
    """Saved while it is released, slips, slips freely, is locked: the rest of the run has the same bits."""
    s = Slave(fmu).start()
    run(s, 0, saved_at)
    state = get_state(s)
    content = serialized(s, state)
    rest = run(s, saved_at, 100)
    set_state(s, state)
    assert run(s, saved_at, 100) == rest
    other = Slave(fmu).start()
    run(other, 0, 7)
    restored = get_state(other)
    assert deserialize(other, content, restored) == OK
    set_state(other, restored)
    assert run(other, saved_at, 100) == rest
