# SPDX-License-Identifier: BSD-3-Clause
"""A lock in an FMU: its engagement is an input, its variables are the same in both conditions."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from models.locks import ENGAGEMENT, LOCK, docking

import gelenk

from .host import OK, Fmu, Slave
from .states import deserialize, get_state, serialized, set_state

STEP = 0.1
ENGAGED = (7, 15)  # steps between which it is


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Fmu:
    folder = tmp_path_factory.mktemp("lock")
    return Fmu(fmpy.extract(str(gelenk.export_fmu(docking(LOCK), folder / "x.fmu")), str(folder / "x")))


def run(s: Slave, first: int, end: int) -> list[list[float]]:
    rows = []
    for k in range(first, end):
        assert s.set({ENGAGEMENT: float(ENGAGED[0] <= k < ENGAGED[1])}) == OK, s.said
        assert s.step(k * STEP, STEP) == OK, s.said
        rows.append(s.outputs())
    return rows


@pytest.mark.parametrize("saved_at", [3, 7, 11, 18])
def test_its_mode_is_part_of_the_state(fmu: Fmu, saved_at: int) -> None:
    """Saved before, at the impact, while it is engaged, and after: the rest has the same bits."""
    s = Slave(fmu).start()
    run(s, 0, saved_at)
    state = get_state(s)
    content = serialized(s, state)
    rest = run(s, saved_at, 20)
    set_state(s, state)
    assert run(s, saved_at, 20) == rest
    other = Slave(fmu).start()
    run(other, 0, 9)
    restored = get_state(other)
    assert deserialize(other, content, restored) == OK
    set_state(other, restored)
    assert run(other, saved_at, 20) == rest


@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange_docks_as_co_simulation_does(tmp_path: Path, fmi: int) -> None:
    """The input jumps at an event, at which velocities change."""
    packed = gelenk.export_fmu(docking(LOCK), tmp_path / "x.fmu", fmi=fmi)
    ends = [
        gelenk.simulate(
            packed,
            stop=2.0,
            step=STEP,
            tolerance=1e-9,
            kind=kind,
            inputs={ENGAGEMENT: lambda t: float(0.7 - 1e-9 <= t < 1.5 - 1e-9)},
        )
        for kind in ("cs", "me")
    ]
    for name in ("port.r[1]", "port.v[2]", "port.w[3]", "port.lock.mode"):
        np.testing.assert_allclose(ends[1][name][-1], ends[0][name][-1], atol=1e-6, err_msg=name)
    together = slice(9, 14)
    for end in ends:
        assert np.all(end["port.w[1]"][together] == 0)
        assert np.all(end["port.lock.mode"][together] == 1)
