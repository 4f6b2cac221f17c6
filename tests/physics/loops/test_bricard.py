# SPDX-License-Identifier: BSD-3-Clause
"""The rectangular Bricard mechanism (IFToMM benchmark A04): six revolute joints in a closed loop, movable
although the mobility formula (Grübler) predicts a rigid structure. One constraint equation is redundant at
every position.
"""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import Scene, frame_sensor, reordered, with_sensors
from models.bricard import P3
from models.running import INTEGRATORS, Recording, assert_close, run

import gelenk
from gelenk.chart import mechanisms

pytestmark = warned.TIGHT

TIMES = np.array([0.0, *P3])


def bricard() -> Scene:
    """The mechanism with a sensor at its third point and an energy sensor."""
    return with_sensors(mechanisms.bricard(), P3=frame_sensor("rod3"), E={"type": "energy"})


@pytest.fixture(scope="module", params=INTEGRATORS)
def swing(request: pytest.FixtureRequest) -> Recording:
    return run(bricard(), TIMES, tolerance=1e-11, integrator=request.param)


def test_bricard_mechanism_has_one_degree_of_freedom() -> None:
    """The mobility formula gives 6 - 6 = 0; the rank of the constraint equations at
    random assembled positions gives 1 DOF.
    """
    simulation = gelenk.Simulation(gelenk.load(bricard()))
    simulation.initialize()
    assert simulation.size.degrees_of_freedom == 1
    assert not simulation.size.planar


def test_motion_matches_independent_integration(swing: Recording) -> None:
    """Agreement to eight digits over 10 s, including the turning points at 2.5, 5 and 7.5 s,
    where the mechanism is at rest.
    """
    assert_close("P3", swing.vector("P3.r")[1:], list(P3.values()), 2e-7, "eight printed digits; 10^4 rtol")


def test_energy_is_conserved(swing: Recording) -> None:
    """There is no drive and no friction; 20 J are exchanged between kinetic and potential energy."""
    total = swing["E.total"]
    assert_close("energy", total, total[0], 1e-7, "rtol 1e-11 over 10 s x 20 J x 500")


def test_loop_remains_closed(swing: Recording) -> None:
    """The redundant constraint equation that was removed remains satisfied as well,
    according to the reported residual.
    """
    assert_close("constraints.position", swing["constraints.position"], 0, 1e-10, "closure")
    assert_close("constraints.velocity", swing["constraints.velocity"], 0, 1e-9, "closure")


@pytest.mark.parametrize("cut", range(1, 7))
def test_motion_does_not_depend_on_the_loop_closing_joint(cut: int) -> None:
    """Idle motors on the other five joints keep them in the tree."""
    source = bricard()
    source["motors"] = {f"m{i}": {"joint": f"J{i}"} for i in range(1, 7) if i != cut}
    found = run(reordered(source, cut), [0.0, 0.5, 1.0, 2.0], tolerance=1e-11)
    expected = [P3[t] for t in (0.5, 1.0, 2.0)]
    assert_close("P3", found.vector("P3.r")[1:], expected, 2e-8, "eight printed digits")
