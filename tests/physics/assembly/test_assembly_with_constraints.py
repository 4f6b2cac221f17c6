# SPDX-License-Identifier: BSD-3-Clause
"""Assembly with prescribed motions and gears, which constrain coordinates in addition to loops."""

from __future__ import annotations

import re

import numpy as np
import pytest
import warned
from mechanisms import Scene, frame, joint, rod

import gelenk
from physics.assembly.test_assembly import ROUNDING, angles, assembled, bare, rates
from physics.assembly.test_fixed_starts import refusal

RATIO = 3.0


def geared(**starts: dict[str, object]) -> Scene:
    """Two arms on the ground, phi_a = 3 phi_b."""
    return {
        "gelenk": 1,
        "bodies": {"one": rod(1, 1.0), "other": rod(1, 0.5)},
        "joints": {
            "a": joint("revolute", frame("ground"), frame("one"), start=starts.get("a", {})),
            "b": joint("revolute", frame("ground", (2, 0, 0)), frame("other"), start=starts.get("b", {})),
        },
        "constraints": {"mesh": {"type": "gear", "joint": "a", "with": "b", "ratio": RATIO}},
    }


def started(source: Scene, *names: str) -> list[float]:
    plant = gelenk.Simulation(source)
    plant.initialize()
    return [plant.output(name) for name in names]


@warned.TURNS
def test_gears_count_revolutions() -> None:
    """The start is more than one revolution away from the assembly without a guess."""
    source = geared(a={"phi": 31.0, "w": 6.0, "fixed": True})
    a, b, w = started(source, "a.phi", "b.phi", "b.w")
    assert a == 31.0
    assert b == pytest.approx(31.0 / RATIO, abs=ROUNDING)
    assert w == pytest.approx(2.0, abs=ROUNDING)


@warned.GUESSES
def test_guesses_on_both_sides_of_a_gear_are_met_by_least_squares() -> None:
    """On the line a = 3 b: b = (3 u A + v B) / (9 u + v) with weights u, v."""
    source = geared(a={"phi": 7.0, "weight": 2}, b={"phi": 2.0, "weight": 5})
    a, b = started(source, "a.phi", "b.phi")
    assert b == pytest.approx((RATIO * 2 * 7.0 + 5 * 2.0) / (RATIO**2 * 2 + 5), abs=ROUNDING * 10)
    assert a == pytest.approx(RATIO * b, abs=ROUNDING * 10)


def test_fixed_angles_that_contradict_a_gear_are_named() -> None:
    text = refusal(geared(a={"phi": 7.0, "fixed": True}, b={"phi": 2.0, "fixed": True}))
    assert "constraints.mesh cannot be satisfied at the start: smallest error 1 rad" in text.replace(
        "0 m and ", ""
    )
    assert "The fixed values of a.phi, b.phi contradict each other." in text
    assert "b.phi, for instance, would then be 2.33333 rad instead of 2 rad." in text


@warned.GUESSES
@warned.TURNS
def test_loop_is_closed_at_the_start_of_a_prescribed_motion() -> None:
    """The motion starts beyond one revolution: the crank is at that angle and has the motion's velocity."""
    source = bare()
    source["constraints"] = {"shaft": {"type": "motion", "joint": "A", "polynomial": [10.0, 2.0]}}
    source["joints"]["C"]["start"] = {"phi": 1.0}
    found = assembled(source)
    apart = np.remainder(found - angles(10.0) + np.pi, 2 * np.pi) - np.pi
    assert found[0] == pytest.approx(10.0, abs=ROUNDING * 10)
    assert np.abs(apart).max() < ROUNDING * 10
    assert np.abs(assembled(source, "w") - 2.0 * rates(10.0)).max() < ROUNDING * 10
    both = gelenk.assemblies(source)
    assert len(both) == 2
    assert [branch.degrees_of_freedom for branch in both] == [0, 0]


def test_fixed_velocity_that_contradicts_a_motion_is_named() -> None:
    source = bare()
    source["constraints"] = {"shaft": {"type": "motion", "joint": "A", "polynomial": [1.1, 2.0]}}
    source["joints"]["D"]["start"] = {"w": 5.0, "fixed": ["w"]}
    source["joints"]["C"]["start"] = {"phi": 1.0}
    text = refusal(source)
    assert "the fixed start velocities of D contradict the loops" in text
    printed = re.search(r"it would then be ([-0-9.]+) rad/s instead of 5 rad/s", text)
    assert printed, text
    assert float(printed[1]) == pytest.approx(2.0 * rates(1.1)[3], abs=1e-5)  # six digits are printed
