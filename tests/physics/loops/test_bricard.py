# SPDX-License-Identifier: BSD-3-Clause
"""The rectangular Bricard mechanism (IFToMM benchmark A04): six hinges in a ring, movable although counting
freedoms says it is rigid. One row of the loop repeats the others at every position.
"""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import Scene, frame_sensor, reordered, with_sensors
from models.running import INTEGRATORS, Recording, assert_close, run

import gelenk
from gelenk.chart import mechanisms

# P3 from an independent integration (chain and closure, DOP853 at 1e-11, eight digits), which lies on the
# library's published plot.
P3 = {
    0.5: (0.77471781, -0.97981505, -0.19990616),
    1.0: (0.27448132, -0.88670794, -0.46233),
    1.25: (-0.0023061, -0.86602694, -0.49999734),
    1.5: (-0.27901758, -0.88736138, -0.4610746),
    2.0: (-0.77813537, -0.98035268, -0.19725267),
    2.5: (-0.999983185, -1.0, -1.68145719e-05),
    3.0: (-0.77128136, -0.97926933, -0.20256253),
    4.0: (0.28355108, -0.88802281, -0.45979939),
    5.0: (0.999932742, -0.999999998, -6.72554129e-05),
    7.5: (-0.999848674, -0.999999989, -0.000151314021),
    10.0: (0.999730987, -0.999999964, -0.000268975949),
}
TIMES = np.array([0.0, *P3])


def bricard() -> Scene:
    """With sensors on its third point and of its energy."""
    return with_sensors(mechanisms.bricard(), P3=frame_sensor("rod3"), E={"type": "energy"})


@pytest.fixture(scope="module", params=INTEGRATORS)
def swing(request: pytest.FixtureRequest) -> Recording:
    return run(bricard(), TIMES, tolerance=1e-11, integrator=request.param)


def test_ring_has_one_freedom() -> None:
    """Counting gives 6 - 6 = 0; the rank of the rows over random assembled positions gives 1."""
    simulation = gelenk.Simulation(gelenk.load(bricard()))
    simulation.initialize()
    assert simulation.size.degrees_of_freedom == 1
    assert not simulation.size.planar


def test_ring_swings_as_the_independent_integration(swing: Recording) -> None:
    """Eight digits, 10 s. The ends of the swing, where it rests, are passed at 2.5, 5 and 7.5 s."""
    assert_close("P3", swing.vector("P3.r")[1:], list(P3.values()), 2e-7, "eight printed digits; 10^4 rtol")


def test_ring_keeps_its_energy(swing: Recording) -> None:
    """No drive and no friction; 20 J go to and fro."""
    total = swing["E.total"]
    assert_close("energy", total, total[0], 1e-7, "rtol 1e-11 over 10 s x 20 J x 500")


def test_ring_stays_closed(swing: Recording) -> None:
    """The row left out as repeated stays fulfilled as well: told by the sensor-independent residual."""
    assert_close("constraints.position", swing["constraints.position"], 0, 1e-10, "closure")
    assert_close("constraints.velocity", swing["constraints.velocity"], 0, 1e-9, "closure")


@pytest.mark.parametrize("cut", range(1, 7))
def test_ring_swings_alike_wherever_it_is_cut(cut: int) -> None:
    """Idle motors on the other five joints keep them in the tree."""
    source = bricard()
    source["motors"] = {f"m{i}": {"joint": f"J{i}"} for i in range(1, 7) if i != cut}
    found = run(reordered(source, cut), [0.0, 0.5, 1.0, 2.0], tolerance=1e-11)
    expected = [P3[t] for t in (0.5, 1.0, 2.0)]
    assert_close("P3", found.vector("P3.r")[1:], expected, 2e-8, "eight printed digits")
