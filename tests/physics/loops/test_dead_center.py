# SPDX-License-Identifier: BSD-3-Clause
"""A prescribed motion that leads a loop beyond its dead center is refused there
instead of switching to another assembly.
"""

from __future__ import annotations

import math

import pytest
from mechanisms import four_bar

import gelenk

CRANK, COUPLER, ROCKER, GROUND = 0.5, 1.75, 1.5, 2.0


def dead_centers() -> tuple[float, float]:
    """Return D.phi [rad] where crank and coupler are in line, extended and folded:
    the limits of the rocker.
    """
    return tuple(  # type: ignore[return-value]
        math.pi - math.acos((GROUND**2 + ROCKER**2 - reach**2) / (2 * GROUND * ROCKER))
        for reach in (COUPLER + CRANK, COUPLER - CRANK)
    )


@pytest.mark.parametrize("integrator", ["erk", "ida", "rk4", "cvode"])
def test_prescribed_rocker_motion_is_refused_at_the_dead_center(integrator: str) -> None:
    source = four_bar(1.1)
    source["joints"]["A"]["start"] = {"phi": 1.1}
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    start = plant.output("D.phi")
    least, most = dead_centers()
    assert least < start < most
    source["constraints"] = {"follow": {"type": "motion", "joint": "D", "polynomial": [start, 0.5]}}
    source["solver"] = {"integrator": integrator, "step": 1e-3}
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    before = plant.output("A.phi")
    for k in range(1, 1000):
        try:
            plant.step_to(0.005 * k)
        except gelenk.StepError as refused:
            words = str(refused)
            break
        # The crank moves continuously: 0.005 s at a speed that grows as the root of the remaining distance.
        assert abs(plant.output("A.phi") - before) < 0.3
        before = plant.output("A.phi")
        assert plant.diagnostics["constraints.position"] < 1e-9  # closed to round-off
    assert "dead center of its driven joint, beyond which the prescribed motion cannot be followed" in words
    # The plant remains at the last time reached: at most 0.5 rad/s times 0.005 s before the dead center.
    assert most - 0.0026 < plant.output("D.phi") < most
