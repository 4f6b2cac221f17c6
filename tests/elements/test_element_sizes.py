# SPDX-License-Identifier: BSD-3-Clause
"""Scenes with each kind of element in other sizes: what is measured is multiplied by its unit."""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import Scene
from physics.methods.test_scaling import course, scales

import gelenk

from .scenes import JOINTS, Given, with_sensors
from .test_element_numbers import PLACES

pytestmark = pytest.mark.filterwarnings("ignore::gelenk.SceneWarning")


def mixes_units(given: Given) -> bool:
    """Whether a constraint ties meters to radians: which start is nearest then depends on their sizes."""
    joints = [p["fits"][0] for p in given.kind["ports"] if p["kind"] == "joint"]
    return given.kind["between_bodies"] or len({JOINTS[j]["v_units"][0] for j in joints}) > 1


AS_GIVEN = [p for p in PLACES if p[2][0] != "constraints" or not mixes_units(p[3])]


@warned.GUESSES
@pytest.mark.parametrize("source", [p[1][0] for p in AS_GIVEN], ids=[p[0] for p in AS_GIVEN])
def test_a_number_of_any_kind_is_converted_by_its_unit(source: Scene) -> None:
    """Of 37 times the size and an eleventh of the mass: 0.1 s at rtol 1e-10, errors 1000 rtol of the largest.

    A number that kept its value would be wrong by a factor of 11 or more.
    """
    source = with_sensors(source)
    found = course(source, 0.1, 1e-10, length=37.0, mass=1 / 11)
    exact = course(source, 0.1, 1e-10)
    # powers of joints along which nothing acts are rounding alone, of some W
    scale = np.maximum(scales(gelenk.Simulation(source), exact), 1e-3)
    assert (np.abs(found - exact) <= 1e-7 * scale).all()
