# SPDX-License-Identifier: BSD-3-Clause
"""A singular configuration is reported where a loop passes close enough to
change branches, and not farther away.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from mechanisms import Scene, frame, joint, rod, scene

import gelenk

CRANK, BASE = 0.5, 1.0  # m; the coupler is as long as the base


def nearly_parallelogram(longer: float) -> Scene:
    """A linkage whose rocker is longer [m] than its crank by this much: both make full turns,
    the bars come nearly into line.
    """
    rocker, phi = CRANK + longer, 1.0
    pin = cmath.rect(CRANK, phi)
    line = BASE - pin  # from the end of the crank to the foot of the rocker
    lean = math.acos((BASE**2 + abs(line) ** 2 - rocker**2) / (2 * BASE * abs(line)))
    along = cmath.phase(line) + lean
    swing = cmath.phase(pin + cmath.rect(BASE, along) - BASE)
    hinge = {"axis": [0, 0, 1]}
    joints = {
        "A": joint(
            "revolute", frame("ground"), frame("crank"), **hinge, start={"phi": phi, "w": 6, "fixed": True}
        ),
        "B": joint(
            "revolute", frame("crank", (CRANK, 0, 0)), frame("coupler"), **hinge, start={"phi": along - phi}
        ),
        "C": joint("revolute", frame("coupler", (BASE, 0, 0)), frame("rocker", (rocker, 0, 0)), **hinge),
        "D": joint("revolute", frame("ground", (BASE, 0, 0)), frame("rocker"), **hinge, start={"phi": swing}),
    }
    lengths = {"crank": CRANK, "coupler": BASE, "rocker": rocker}
    return scene({name: rod(1, length) for name, length in lengths.items()}, joints)


def smallest_coupler_angle(longer: float) -> float:
    """The angle [rad] between coupler and base with the crank along the base, from the triangle of coupler,
    rocker and the remaining part of the base; the larger of the two positions.
    """
    rocker = CRANK + longer
    left = []
    for side in (BASE - CRANK, BASE + CRANK):
        cosine = (BASE**2 + side**2 - rocker**2) / (2 * BASE * side)
        left.append(math.acos(min(1.0, cosine)))
    return max(left)


@pytest.mark.parametrize(
    ("longer", "angle", "reported"),
    [(0.0, 0.0, True), (1e-4, 0.0141, True), (1e-3, 0.0447, False), (1e-2, 0.142, False)],
)
def test_crossings_are_reported_within_a_hundredth_radian(
    longer: float, angle: float, reported: bool
) -> None:
    """A ratio of 0.02 to the largest pivot counts as zero (singularity_monitor.cpp): bars inclined by about
    0.01 rad are in line, and those inclined by several hundredths are not. The crank passes each half turn.
    """
    found = gelenk.simulate(nearly_parallelogram(longer), stop=2.0, step=0.01)
    assert smallest_coupler_angle(longer) == pytest.approx(angle, rel=0.01)
    passed = math.floor(found["A.phi"][-1] / math.pi) - math.floor(found["A.phi"][0] / math.pi)
    assert passed >= 4
    assert len(found.singular_positions) == (passed if reported else 0)
    if reported:
        places = np.interp(found.singular_positions, found.time, found["A.phi"]) / math.pi
        assert np.abs(places - np.round(places)).max() < 0.05  # between communication points: 6 rad/s, 0.01 s
