# SPDX-License-Identifier: BSD-3-Clause
"""More fixed values than degrees of freedom: accepted if consistent, otherwise rejected with their names."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint

import gelenk
from physics.assembly.test_assembly import JOINTS, LINKS, angles, assembled, bare, rates, with_starts

PHI = 1.1
TRUTH = angles(PHI)


def held(values: Any, **others: dict[str, Any]) -> Scene:
    """The four-bar with these joint angles fixed."""
    return with_starts(bare(), **{j: {"phi": float(x), "fixed": True} for j, x in values.items()}, **others)


def refusal(source: Scene) -> str:
    with pytest.raises(gelenk.AssemblyError) as caught:
        gelenk.Simulation(source).initialize()
    return str(caught.value)


def with_a_pendulum(source: Scene) -> Scene:
    """The scene with a pendulum on the rocker, whose fixed values contradict nothing."""
    source["bodies"]["bob"] = body(0.3, (0, -0.2, 0), (0.01, 0.01, 0.01))
    source["joints"]["P"] = joint(
        "revolute", frame("rocker"), frame("bob"), start={"phi": 0.4, "w": 0.7, "fixed": True}
    )
    return source


def test_all_angles_of_a_loop_may_be_fixed_if_they_are_consistent() -> None:
    """Consistent within 1e-9; they are kept bit for bit."""
    noise = np.array([1, -1, 2, -2]) * 1e-10
    given = dict(zip(JOINTS, TRUTH + noise, strict=True))
    found = assembled(held(given))
    assert found[[0, 1, 3]].tolist() == [given[j] for j in "ABD"]
    assert found[2] == pytest.approx(given["C"], abs=1e-9)  # computed from the bodies it connects
    for wrong in JOINTS:  # a wrong angle contradicts each of the others
        printed = re.search(
            r"The fixed values of (\w)\.phi, (\w)\.phi contradict",
            refusal(held({**given, wrong: given[wrong] + 1e-6})),
        )
        assert printed
        assert wrong in printed.groups()


@pytest.mark.parametrize("wrong", ["B", "C", "D"])
def test_two_contradicting_fixed_angles_are_named_with_a_consistent_value(wrong: str) -> None:
    """The crank and one other joint; the advice names one of them, with the value of the closed form."""
    at = JOINTS.index(wrong)
    text = refusal(with_a_pendulum(held({"A": PHI, wrong: TRUTH[at] + 0.02})))
    assert re.search(r"cannot be closed: smallest closure error [0-9.]+ m", text)
    assert f"The fixed values of A.phi, {wrong}.phi contradict each other." in text
    assert "P.phi" not in text
    printed = re.search(
        r"(\w)\.phi, for instance, would then be ([-0-9.]+) rad instead of ([-0-9.]+) rad\.", text
    )
    assert printed, text
    if printed[1] == wrong:
        assert float(printed[2]) == pytest.approx(TRUTH[at], abs=1e-5)  # six digits are printed
        assert float(printed[3]) == pytest.approx(TRUTH[at] + 0.02, abs=1e-5)
    else:
        fits = angles(float(printed[2]))
        assert printed[1] == "A"
        assert fits[at] == pytest.approx(TRUTH[at] + 0.02, abs=1e-4)
    released = held({"A": PHI}, **{wrong: {"phi": TRUTH[at] + 0.02}})
    assert np.abs(assembled(with_a_pendulum(released)) - TRUTH).max() < 1e-12


def test_fixed_angle_out_of_reach_is_reported_with_the_closest_reachable_one() -> None:
    """The rocker reaches its limit when crank and coupler are in line."""
    crank, coupler, rocker, ground = LINKS
    stretched = crank + coupler
    limit = math.pi - math.acos((rocker**2 + ground**2 - stretched**2) / (2 * rocker * ground))
    text = refusal(held({"D": limit - 0.1}))
    assert "The fixed value of D.phi contradicts the loops." in text
    printed = re.search(r"guess \(fixed: false\): it would then be ([-0-9.]+) rad", text)
    assert printed, text
    assert float(printed[1]) == pytest.approx(limit, abs=1e-3)  # ill-conditioned near a dead center


def test_contradicting_fixed_velocities_are_named_with_a_consistent_value() -> None:
    s = rates(PHI)
    source = with_a_pendulum(bare())
    source["joints"]["A"]["start"] = {"phi": PHI, "w": 2.0, "fixed": True}
    source["joints"]["D"]["start"] = {"w": 2.0 * s[3] + 0.01, "fixed": True}
    source["joints"]["B"]["start"] = {"phi": TRUTH[1]}
    text = refusal(source)
    assert "the fixed start velocities of A, D contradict the loops: smallest velocity error" in text
    printed = re.search(r"(\w)\.w, for instance, would then be ([-0-9.]+) rad/s", text)
    assert printed, text
    expected = 2.0 * s[3] if printed[1] == "D" else (2.0 * s[3] + 0.01) / s[3]
    assert float(printed[2]) == pytest.approx(expected, abs=1e-5)


def test_redundant_consistent_fixed_velocities_are_kept() -> None:
    s = rates(PHI)
    source = held(dict(zip("AB", TRUTH, strict=False)))
    for j, x in zip(JOINTS, s, strict=True):
        source["joints"][j]["start"] |= {"w": 2.0 * float(x), "fixed": True}
    assert np.abs(assembled(source, "w") - 2.0 * s).max() < 1e-9


def test_fixed_values_are_not_blamed_for_loops_that_cannot_close() -> None:
    source = held({"A": PHI})
    source["joints"]["D"]["parent"]["position"] = [9.0, 0.0, 0.0]
    assert "Check the positions in joints A, B, C, D, and the fixed start of A." in refusal(source)
