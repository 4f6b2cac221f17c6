# SPDX-License-Identifier: BSD-3-Clause
"""Exact derivatives by states, inputs and time of scenes with each kind of element."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from models.derivative_cases import assert_relative
from models.differences import Assembler, in_time, linearized, output_derivatives

import gelenk

from .scenes import with_sensors
from .test_element_numbers import PLACES

pytestmark = pytest.mark.filterwarnings("ignore::gelenk.SceneWarning")
every_place = pytest.mark.parametrize(
    "source", [variants[0] for _, variants, _, _ in PLACES], ids=[p[0] for p in PLACES]
)
# Where states can be set one by one in plants set beside: wheels tie those of a free body together, and a
# coordinate that an input gives is not free to be set, nor the speed that a one-way clutch or a lock holds.
# Time derivatives are looked at there, too.
SET_BESIDE = [
    pytest.param(variants[0], id=name)
    for name, variants, at, given in PLACES
    if given.kind["name"] not in ("one_way", "lock")
    and (
        at[0] != "constraints" or not (given.kind["between_bodies"] or gelenk.Simulation(variants[0]).inputs)
    )
]
START, STEP = 0.13, 2e-3  # s; nothing changes its mode within eight steps of it


def started(source: Any, end: float = START) -> gelenk.Simulation:
    plant = gelenk.Simulation(source)
    plant.initialize(tolerance=1e-12)
    for i, signal in enumerate(plant.inputs):
        plant.set_input(signal.name, 0.3 + 0.2 * i)
    plant.step_to(end)
    return plant


@warned.GUESSES
@pytest.mark.parametrize("source", SET_BESIDE)
def test_derivatives_are_those_of_plants_set_beside(source: Any) -> None:
    """Differences of fourth order over 1 ms: h^4 f5 / 30, far below 1e-7."""
    source = with_sensors(source)
    plant = started(source)
    found = linearized(plant)
    beside = Assembler(source, plant)
    for matrix, names in ((found.C, found.states), (found.D, [s.name for s in plant.inputs])):
        for k, known in enumerate(names):
            assert_relative(f"by {known}", matrix[:, k], beside.column(known, 1e-3), 1e-7)


@warned.GUESSES
@every_place
def test_time_derivatives_are_those_along_the_motion(source: Any) -> None:
    """First ones are C xdot; both are differences of eighth order: h^8 f10 / 3150, rounding over h^2."""
    source = with_sensors(source)
    plant = started(source)
    found = linearized(plant)
    first, second = output_derivatives(plant)
    if not any(source.get("constraints", {}).values()):  # what is given by time changes without the states
        assert_relative("first", first, found.C @ found.xdot, 1e-9)
    expected = in_time(lambda t: np.array(started(source, t).values()), START, STEP)
    assert_relative("first", first, expected[0], 1e-6)
    assert_relative("second", second, expected[1], 1e-4)
