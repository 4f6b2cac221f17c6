# SPDX-License-Identifier: BSD-3-Clause
"""A singular position is told where loops come near enough to take another branch, and no farther away."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from mechanisms import Scene, frame, joint, rod, scene

import gelenk

CRANK, BASE = 0.5, 1.0  # m; the coupler is as long as the base


def nearly_parallelogram(longer: float) -> Scene:
    """Its rocker is so much longer [m] than its crank: both turn round, the bars come nearly into line."""
    rocker, phi = CRANK + longer, 1.0
    pin = cmath.rect(CRANK, phi)
    line = BASE - pin  # from the crank's end to the rocker's foot
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


def nearest(longer: float) -> float:
    """The angle [rad] that the coupler keeps from the base where the crank lies along it: of the triangle of
    coupler, rocker and what is left of the base; the larger of the two positions.
    """
    rocker = CRANK + longer
    left = []
    for side in (BASE - CRANK, BASE + CRANK):
        cosine = (BASE**2 + side**2 - rocker**2) / (2 * BASE * side)
        left.append(math.acos(min(1.0, cosine)))
    return max(left)


@pytest.mark.parametrize(
    ("longer", "angle", "told"),
    [(0.0, 0.0, True), (1e-4, 0.0141, True), (1e-3, 0.0447, False), (1e-2, 0.142, False)],
)
def test_passages_are_told_within_a_hundredth(longer: float, angle: float, told: bool) -> None:
    """A share of 0.02 of the soundest pivot counts as zero (singularity_monitor.cpp): bars that lean by some
    0.01 rad are in line, and those that lean by several are not. The crank passes each half turn.
    """
    found = gelenk.simulate(nearly_parallelogram(longer), stop=2.0, step=0.01)
    assert nearest(longer) == pytest.approx(angle, rel=0.01)
    passed = math.floor(found["A.phi"][-1] / math.pi) - math.floor(found["A.phi"][0] / math.pi)
    assert passed >= 4
    assert len(found.singular_positions) == (passed if told else 0)
    if told:
        places = np.interp(found.singular_positions, found.time, found["A.phi"]) / math.pi
        assert np.abs(places - np.round(places)).max() < 0.05  # between communication points: 6 rad/s, 0.01 s
