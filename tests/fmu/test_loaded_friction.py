# SPDX-License-Identifier: BSD-3-Clause
"""Friction of a bearing in an FMU: its numbers are parameters, and its run agrees with that of the scene."""

from __future__ import annotations

import fmpy
import pytest
from models.bearing_friction import four_bar_with_bearings

import gelenk

from .host import OK, Fmu, Slave
from .states import get_state, set_state

STEP = 0.05
COEFFICIENT = "A.bearing.coefficient"


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Fmu:
    folder = tmp_path_factory.mktemp("bearing")
    scene = {**four_bar_with_bearings(), "parameters": [COEFFICIENT]}
    file = gelenk.export_fmu(scene, folder / "x.fmu")
    return Fmu(fmpy.extract(str(file), str(folder / "x")))


def test_the_run_is_that_of_the_scene(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    s.run(30, STEP)
    plant = gelenk.Simulation(gelenk.load(four_bar_with_bearings()))
    plant.initialize(0.0)
    for k in range(30):
        plant.step_to((k + 1) * STEP)
    # The same code, compiled twice.
    assert s.get("A.phi") == pytest.approx(plant.output("A.phi"), abs=1e-10)
    assert s.get("C.friction.tau") == pytest.approx(plant.output("C.friction.tau"), abs=1e-9)


def test_a_state_continues_to_the_same_bits(fmu: Fmu) -> None:
    s = Slave(fmu).start()
    s.run(13, STEP)
    state = get_state(s)
    rest = s.run(27, STEP, 13)
    set_state(s, state)
    assert s.run(27, STEP, 13) == rest


def test_coefficients_are_tunable_parameters(fmu: Fmu) -> None:
    """Without friction in A, the torque there vanishes, at once."""
    s = Slave(fmu).start()
    s.run(4, STEP)
    assert s.get("A.friction.tau") != 0
    assert s.set({COEFFICIENT: 0.0}) == OK, s.said
    assert s.step(4 * STEP, STEP) == OK, s.said
    assert s.get("A.friction.tau") == 0
