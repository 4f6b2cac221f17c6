# SPDX-License-Identifier: BSD-3-Clause
"""The motion of a four-bar does not depend on its pose in the world, the loop-closing joint, the parent side
of its joints, the order in the scene file, or planar or spatial algebra.
"""

from __future__ import annotations

import copy

import numpy as np
import pytest
from mechanisms import four_bar, placed, reordered
from models.running import Recording, assert_close, assert_same, run
from scipy.spatial.transform import Rotation

TIMES = np.linspace(0, 5, 51)
BOUND = 1e-9  # a thousand times the tolerance of the runs, see below
WHY = "the same motion, described in another way"
START = 1.1  # rad
TOLERANCE = 1e-12  # two runs differ by their integration errors: about 100 times this in 5 s


@pytest.fixture(scope="module")
def plain() -> Recording:
    return run(four_bar(START, torque=3.0), TIMES, tolerance=TOLERANCE)


def states(found: Recording, levels: tuple[str, ...] = ("phi", "w")) -> dict[str, np.ndarray]:
    return {f"{joint}.{level}": found[f"{joint}.{level}"] for joint in "ABCD" for level in levels}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_rotated_as_a_whole(plain: Recording, seed: int) -> None:
    """Mechanism, gravity and load are rotated by a random rotation and moved:
    joint coordinates are unchanged.
    """
    R = Rotation.random(random_state=seed).as_matrix()
    p = np.random.default_rng(seed).uniform(-3, 3, 3)
    found = run(placed(four_bar(START, torque=3.0), R, p), TIMES, tolerance=TOLERANCE)
    assert_same(states(found), states(plain), BOUND, WHY)


def test_upside_down(plain: Recording) -> None:
    """The normal of the plane is along -z: half a turn about x reverses every axis."""
    found = run(placed(four_bar(START, torque=3.0), np.diag([1.0, -1, -1])), TIMES, tolerance=TOLERANCE)
    assert_same(states(found), states(plain), BOUND, WHY)


@pytest.mark.parametrize("cut", "ABCD")
def test_cut_at_another_joint(plain: Recording, cut: str) -> None:
    """Joints with motors are tree joints, so idle motors on the other three joints cause `cut` to be cut."""
    scene = four_bar(START, torque=3.0)
    scene["motors"] = {f"m{joint}": {"joint": joint} for joint in "ABCD" if joint != cut}
    found = run(scene, TIMES, tolerance=TOLERANCE)
    assert_same(states(found), states(plain), BOUND, WHY)


@pytest.mark.parametrize("seed", range(4))
def test_listed_in_another_order(plain: Recording, seed: int) -> None:
    """Bodies and joints are listed in random order."""
    found = run(reordered(four_bar(START, torque=3.0), seed), TIMES, tolerance=TOLERANCE)
    assert_same(states(found), states(plain), BOUND, WHY)


@pytest.mark.parametrize("turned", ["A", "B", "C", "D", "ABCD"])
def test_parent_and_child_exchanged(plain: Recording, turned: str) -> None:
    """A joint with parent and child exchanged has the opposite angle; nothing else changes."""
    scene = four_bar(START, torque=3.0)
    for name in turned:
        entry = scene["joints"][name]
        entry["parent"], entry["child"] = entry["child"], entry["parent"]
        entry["start"]["phi"] *= -1
    found = run(scene, TIMES, tolerance=TOLERANCE)
    expected = states(plain)
    for name in turned:
        for level in ("phi", "w"):
            expected[f"{name}.{level}"] = -expected[f"{name}.{level}"]
    assert_same(states(found), expected, BOUND, WHY)


def test_axis_reversed(plain: Recording) -> None:
    """The rocker's pin is along -z in both bodies: its angle changes sign."""
    scene = four_bar(START, torque=3.0)
    scene["joints"]["D"]["axis"] = [0, 0, -1]
    scene["joints"]["D"]["start"]["phi"] *= -1
    found = run(scene, TIMES, tolerance=TOLERANCE)
    expected = states(plain)
    expected.update({"D.phi": -expected["D.phi"], "D.w": -expected["D.w"]})
    assert_same(states(found), expected, BOUND, WHY)


def test_axes_given_by_turned_joint_frames(plain: Recording) -> None:
    """The same axis is given as the x-axis of a frame rotated in both bodies."""
    scene = four_bar(START, torque=3.0)
    R = np.array([[0.0, 0.6, 0.8], [0, -0.8, 0.6], [1, 0, 0]])  # x column along z
    for entry in scene["joints"].values():
        entry["axis"] = [1, 0, 0]
        for side in ("parent", "child"):
            entry[side]["rotation"] = {"matrix": R.tolist()}
    found = run(scene, TIMES, tolerance=TOLERANCE)
    assert_same(states(found), states(plain), BOUND, WHY)


def test_redundant_constraints_in_space(plain: Recording) -> None:
    """A body that moves out of the plane requires spatial algebra: the loop then has 5 constraint equations
    of rank 2, and its motion must be the same as in the plane. The other body is an island and has no
    influence.
    """
    scene = copy.deepcopy(four_bar(START, torque=3.0))
    scene["bodies"]["stray"] = {"mass": 0.7, "com": [0, 0.2, 0.1], "inertia": [0.02, 0.03, 0.04, 0, 0, 0]}
    scene["joints"]["S"] = {
        "type": "revolute",
        "axis": [1, 0, 0],
        "parent": {"body": "ground", "position": [5, 0, 0]},
        "child": {"body": "stray", "position": [0, 0, 0]},
        "start": {"phi": 0.3},
    }
    found = run(scene, TIMES, tolerance=TOLERANCE)
    assert_same(states(found), states(plain), BOUND, WHY)
    assert_close("constraints.position", found["constraints.position"], 0, 1e-10, "closure")


@pytest.mark.parametrize("distance", [1e4])
def test_far_from_the_origin(plain: Recording, distance: float) -> None:
    """At 10 km, joint positions are rounded to 2e-12 m, which is about 1e-11 rad over bars of 0.5 m; the
    closure of the loop does not depend on the distance.
    """
    p = distance * np.array([0.6, -0.64, 0.48])
    R = Rotation.random(random_state=4).as_matrix()
    found = run(placed(four_bar(START, torque=3.0), R, p), TIMES, tolerance=TOLERANCE)
    assert_same(states(found), states(plain), BOUND, "round-off of 2e-12 m, amplified by the motion")
    assert_close(
        "constraints.position", found["constraints.position"], 0, 1e-13, "closure, some 1e-14 of the bars"
    )
