# SPDX-License-Identifier: BSD-3-Clause
"""A state is restored in the same way wherever the plant was: nothing of a later time remains."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import Scene
from models.touching import box_on_a_cart

import gelenk

STEP = 0.01  # s


def shaken(integrator: str) -> Scene:
    """A box that sticks to and slides on a cart with a prescribed motion."""
    source: Scene = box_on_a_cart()
    del source["motors"]
    source["constraints"] = {
        "shake": {"type": "motion", "joint": "P", "sine": {"amplitude": 0.02, "frequency": 3.0}}
    }
    source["solver"] = {"integrator": integrator}
    return source


@pytest.mark.parametrize("integrator", ["cvode", "cvode-adams", "dirk", "auto", "ida"])
def test_earlier_states_are_restored_from_any_time(integrator: str) -> None:
    """Once `cvode` computed Jacobian matrices at other steps than in the saved run, and refused it."""
    plant = gelenk.Simulation(shaken(integrator))
    plant.initialize(0.0, 1e-8)
    saved, values = [], []
    for k in range(1, 53):
        plant.step_to(STEP * k)
        saved.append(plant.save())
        values.append(plant.values())
    for later in (37, 52):
        for k in (1, 5, 12, 25):
            plant.restore(saved[later - 1])
            plant.restore(saved[k - 1])
            assert plant.save() == saved[k - 1]
            plant.step_to(STEP * (k + 1))
            assert np.array_equal(plant.values(), values[k])
