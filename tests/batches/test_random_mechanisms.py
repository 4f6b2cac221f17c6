# SPDX-License-Identifier: BSD-3-Clause
"""Random mechanisms, many of them in special positions: a lane is a simulation, or says that it is none."""

from __future__ import annotations

import numpy as np
import pytest
from special.drawn import drawn

import gelenk
from gelenk.errors import AssemblyError, SceneError

STEP, STEPS = 1e-3, 20  # s
TOGETHER = 40  # in one test
ALL = 2000


def compared(seed: int) -> bool:
    """Whether there is something to compare; what is compared agrees within 1e-12 of the largest state."""
    try:
        scene = gelenk.load(drawn(seed).source)
        batch = gelenk.batch(scene, 2, step=STEP)
    except (SceneError, AssemblyError):
        return False  # at a start that simulations refuse, too
    batch.step(STEPS)
    if batch.errors:  # near a singular position: both lanes, and with a reason
        assert sorted(batch.errors) == [0, 1]
        assert "near a singular configuration" in batch.errors[0] or "vanishes" in batch.errors[0]
        return False
    fixed = scene.with_parameters({"solver.step": STEP})
    result = gelenk.simulate(fixed, stop=STEPS * STEP, step=STEP, integrator="rk4", formulation="projection")
    expected = {name: float(np.asarray(result[name])[-1]) for name in batch.states}
    size = max(1.0, *(abs(value) for value in expected.values()))
    for name, row in batch.states.items():
        assert np.abs(row - expected[name]).max() < 1e-12 * size, (seed, name)
    return True


@pytest.mark.filterwarnings("ignore::gelenk.StartWarning")
@pytest.mark.filterwarnings("ignore::gelenk.SceneWarning")
@pytest.mark.parametrize(
    "first",
    [k if k == 0 else pytest.param(k, marks=pytest.mark.study) for k in range(0, ALL, TOGETHER)],
)
def test_random_mechanisms_move_alike(first: int) -> None:
    """Nine of ten are compared; the others start at a singular position or at none."""
    seeds = range(first, first + TOGETHER)
    assert sum(compared(seed) for seed in seeds) > 0.75 * TOGETHER
