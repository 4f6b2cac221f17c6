# SPDX-License-Identifier: BSD-3-Clause
"""The warning of a guess that is changed states the value that is used, also where full turns count."""

from __future__ import annotations

import math
from typing import Any

import pytest
from mechanisms import body, frame, joint, scene

import gelenk


def screwed(travel: float) -> dict[str, Any]:
    """A nut on a spindle with 0.1 m per radian: phi = travel / 0.1."""
    return scene(
        {name: body(1.0) for name in ("nut", "spindle")},
        {
            "slide": joint("prismatic", frame("ground"), frame("nut"), start={"s": travel, "fixed": True}),
            "bearing": joint("revolute", frame("ground"), frame("spindle")),
            "thread": joint("screw", frame("spindle"), frame("nut"), pitch=0.1, start={"phi": 0.0}),
        },
        gravity=[0, 0, 0],
    )


@pytest.mark.parametrize("travel", [1.0, 0.2 * math.pi, -3.0])
def test_turns_of_a_screw_count(travel: float) -> None:
    """Also exactly one turn, which is another position of a screw."""
    plant = gelenk.Simulation(screwed(travel))
    with pytest.warns(gelenk.StartWarning, match="thread.start.phi: found 0 rad") as warned:
        plant.initialize()
    phi = plant.output("thread.phi")
    assert phi == pytest.approx(travel / 0.1, rel=1e-12)
    assert f"expected one near {phi:.6g} rad, which is used" in str(warned[0].message)


def test_motion_that_starts_beyond_a_turn() -> None:
    source = scene(
        {"arm": body(1.0)},
        {"A": joint("revolute", frame("ground"), frame("arm"), start={"phi": 0.5})},
        constraints={"turn": {"type": "motion", "joint": "A", "polynomial": [9.0, 1.0]}},
        gravity=[0, 0, 0],
    )
    plant = gelenk.Simulation(source)
    with pytest.warns(gelenk.StartWarning, match="found 0.5 rad.* expected one near 9 rad"):
        plant.initialize()
    assert plant.output("A.phi") == 9.0
