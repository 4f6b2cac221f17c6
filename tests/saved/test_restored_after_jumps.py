# SPDX-License-Identifier: BSD-3-Clause
"""A run goes on from a restored state to the bit when an input has jumped shortly before."""

from __future__ import annotations

import numpy as np
import pytest
from fmu.plants import crank_rocker

import gelenk

STEP = 0.02  # s


@pytest.mark.parametrize("integrator", ["cvode", "ida", "dirk", "auto", "rk4"])
@pytest.mark.parametrize("formulation", ["projection", "independent"])
def test_a_run_goes_on_after_a_jump(formulation: str, integrator: str) -> None:
    """Once the first step after the starter's closed the loop with factors of the step before."""
    source = crank_rocker()
    source["solver"] = {"formulation": formulation, "integrator": integrator}
    for before in (5, 9):
        plant = gelenk.Simulation(source)
        plant.initialize(0.0, 1e-6)
        for k in range(before + 1):
            if k == before:
                plant.set_input("drive.tau", 0.4)
            plant.step_to(STEP * (k + 1))
        saved = plant.save()
        plant.step_to(STEP * (before + 2))
        values = plant.values()
        plant.restore(saved)
        plant.step_to(STEP * (before + 2))
        assert np.array_equal(plant.values(), values)
