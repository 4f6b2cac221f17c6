# SPDX-License-Identifier: BSD-3-Clause
"""All assemblies of a mechanism are found, each of them once, and can be reproduced from start values."""

from __future__ import annotations

import copy
import itertools
import json
import math
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import programs
import pytest
import warned
from mechanisms import Scene, frame, joint, reordered, rod
from scipy.optimize import brentq, fsolve
from scipy.spatial.transform import Rotation

import gelenk
from gelenk.chart import mechanisms as shipped
from physics.assembly.test_assembly import JOINTS, LINKS, angles, bare, with_starts
from physics.assembly.test_fixed_starts import held

TURN = 2 * math.pi


def led_back(branch: gelenk.Branch, source: Any) -> float:
    """The distance from a branch at which the scene is assembled with it as guesses, and as parameters."""
    farthest = 0.0
    for scene in (branch.apply_to(source), gelenk.load(source).with_parameters(branch.parameters)):
        plant = gelenk.Simulation(scene)
        plant.initialize()
        farthest = max(farthest, *(abs(plant.output(name) - x) for name, x in branch.values.items()))
    return farthest


def angle_difference(a: Any, b: Any) -> float:
    """Largest difference between angles modulo one revolution."""
    return float(np.abs(np.remainder(np.asarray(a) - np.asarray(b) + math.pi, TURN) - math.pi).max())


@pytest.mark.parametrize("seed", [None, 3, 4])
def test_four_bar_with_a_fixed_crank_has_two_assemblies(seed: int | None) -> None:
    source = held({"A": 1.1})
    if seed is not None:
        source = reordered(source, seed)
    found = gelenk.assemblies(source)
    assert len(found) == 2
    assert found.settled == (True,)
    assert [branch.degrees_of_freedom for branch in found] == [0, 0]
    for truth in (angles(1.1), angles(1.1, open_branch=False)):
        at = [angle_difference([branch.values[f"{j}.phi"] for j in JOINTS], truth) for branch in found]
        assert min(at) < 1e-12  # closed to some tens of roundings
        assert led_back(found[at.index(min(at))], source) < 1e-12
    assert sum(branch.is_default for branch in found) == 1


@warned.GUESSES
def test_applied_branch_leaves_free_coordinates_free() -> None:
    """Its angles become guesses, except for the fixed crank angle, for which another value can be set."""
    source = held({"A": 1.1}, B={"phi": -0.2}, D={"phi": 1.5, "weight": 3})
    branch = gelenk.assemblies(source)[0]
    data = branch.apply_to(source).to_dict()
    fixed = {name: entry["start"].get("fixed", False) for name, entry in data["joints"].items()}
    assert fixed.pop("A") in (True, ["phi"])
    assert not any(fixed.values()), fixed
    guessed = {name: entry["start"]["phi"] for name, entry in data["joints"].items()}
    assert guessed == {name: branch.values[f"{name}.phi"] for name in guessed}
    data["joints"]["A"]["start"]["phi"] = 1.2
    plant = gelenk.Simulation(data)
    plant.initialize()
    found = [plant.output(f"{name}.phi") for name in JOINTS]
    assert (
        min(angle_difference(found, angles(1.2)), angle_difference(found, angles(1.2, open_branch=False)))
        < 1e-12
    )


def test_branches_that_meet_at_a_dead_center_count_as_one() -> None:
    """Crank and coupler in line: 1e-12 rad inside the rocker's limit, the branches differ by 1e-6 rad."""
    crank, coupler, rocker, ground = LINKS
    limit = math.pi - math.acos((rocker**2 + ground**2 - (crank + coupler) ** 2) / (2 * rocker * ground))
    assert len(gelenk.assemblies(held({"D": limit + 1e-12}))) == 1
    assert len(gelenk.assemblies(held({"D": limit + 1e-4}))) == 2


def test_slider_crank_and_five_bar_have_two_assemblies_each() -> None:
    """The pin is at an intersection of two circles, or of a circle and a line."""
    for name in ("slider_crank", "five_bar"):
        source = shipped.shipped(name)
        found = gelenk.assemblies(source)
        assert len(found) == 2
        assert max(led_back(branch, source) for branch in found) < 1e-12
    one, other = gelenk.assemblies(shipped.shipped("five_bar"))
    tips = [five_bar_tip(branch) for branch in (one, other)]
    assert tips[0] != pytest.approx(tips[1], abs=0.1)
    for branch, tip in zip((one, other), tips, strict=True):
        elbow = 0.15 + 0.25 * np.exp(1j * branch.values["right.phi"])
        assert abs(tip - elbow) == pytest.approx(0.35, abs=1e-12)


def five_bar_tip(branch: gelenk.Branch) -> complex:
    """Position of the tip in the plane of the five-bar, along its left arm."""
    left = branch.values["left.phi"]
    lower = left + branch.values["elbow_left.phi"]
    return complex(-0.15 + 0.25 * np.exp(1j * left) + 0.35 * np.exp(1j * lower))


def two_arms() -> Scene:
    """Two arms of two links each, whose tips are pinned to two points of the ground: elbows up or down."""
    bodies: dict[str, Any] = {}
    joints: dict[str, Any] = {}
    for side, x in (("l", -1.0), ("r", 1.0)):
        bodies |= {f"{side}1": rod(1, 1.0), f"{side}2": rod(1, 0.8)}
        tip = frame("ground", (x + 1.2, 0.3, 0))
        joints |= {
            f"{side}A": joint("revolute", frame("ground", (x, 0, 0)), frame(f"{side}1")),
            f"{side}B": joint("revolute", frame(f"{side}1", (1.0, 0, 0)), frame(f"{side}2")),
            f"{side}C": joint("revolute", tip, frame(f"{side}2", (0.8, 0, 0))),
        }
    return {"gelenk": 1, "bodies": bodies, "joints": joints}


def test_branches_of_independent_islands_are_listed_separately() -> None:
    source = two_arms()
    found = gelenk.assemblies(source)
    assert [branch.island for branch in found] == [0, 0, 1, 1]
    # Any of one goes with any of the other.
    for left in found.branches[:2]:
        for right in found.branches[2:]:
            plant = gelenk.Simulation(right.apply_to(left.apply_to(source)))
            plant.initialize()
            for name, x in {**left.values, **right.values}.items():
                assert plant.output(name) == pytest.approx(x, abs=1e-12)
    cosine = (1.0 + 0.64 - 1.2**2 - 0.3**2) / (2 * 0.8)
    assert sorted(branch.values["lB.phi"] for branch in found.branches[:2]) == pytest.approx(
        [math.acos(cosine) - math.pi, math.pi - math.acos(cosine)], abs=1e-12
    )


GUESSES = np.array([1.3, -0.1, 1.0, 2.1])


def minimum_distances(guesses: Any) -> list[float]:
    """All local minima of the distance of a four-bar from guessed angles [rad], in both circuits."""
    found = []
    for open_branch in (True, False):

        def squared(phi: float, branch: bool = open_branch) -> float:
            off = np.remainder(angles(phi, branch) - guesses + math.pi, TURN) - math.pi
            return float(off @ off)

        def gradient(phi: float, of: Any = squared) -> float:
            return float(of(phi + 1e-6) - of(phi - 1e-6))

        grid = np.linspace(0, TURN, 721)
        for a, b in itertools.pairwise(grid):
            if gradient(a) < 0 < gradient(b):
                found.append(math.sqrt(squared(brentq(gradient, a, b, xtol=1e-12))))
    return sorted(found)


def test_local_minima_of_the_distance_are_listed_if_a_degree_of_freedom_is_left() -> None:
    """Against scans of both circuits of the closed form. Distances are stationary there: 1e-9 is ample."""
    source = with_starts(bare(), **{j: {"phi": GUESSES[i]} for i, j in enumerate(JOINTS)})
    found = gelenk.assemblies(source)
    truth = minimum_distances(GUESSES)
    assert len(truth) == 3
    assert [branch.distance for branch in found] == pytest.approx(truth, abs=1e-9)
    assert {branch.degrees_of_freedom for branch in found} == {1}
    assert found[0].is_default
    assert max(led_back(branch, source) for branch in found) < 1e-12
    assert "fixed values leave 1 degree of freedom: local minima of the distance" in str(found)


def test_one_of_a_continuum_of_assemblies_is_listed_and_marked_as_such() -> None:
    source = with_starts(bare(), **{j: {"phi": GUESSES[i], "weight": 0} for i, j in enumerate(JOINTS)})
    (only,) = gelenk.assemblies(source)
    assert only.is_not_isolated
    assert only.distance == 0
    assert "one of many at this distance" in str(gelenk.assemblies(source))


def platform_poses(source: Scene, rng: np.random.Generator) -> list[np.ndarray[Any, np.dtype[np.float64]]]:
    """Poses (x, y, z, rotation vector) of the Stewart platform from its leg lengths, by random starts."""
    joints = source["joints"]
    base = np.array([joints[f"base{k}"]["parent"]["position"] for k in range(1, 7)])
    ball = np.array([joints[f"ball{k}"]["child"]["position"] for k in range(1, 7)])
    start = np.array([0.0, 0.0, 1.1])
    lengths = np.linalg.norm(ball + start - base, axis=1)
    lengths += [joints[f"leg{k}"]["start"]["s"] for k in range(1, 7)]

    def excess(x: Any) -> Any:
        tips = x[:3] + Rotation.from_rotvec(x[3:]).apply(ball)
        return ((tips - base) ** 2).sum(axis=1) - lengths**2

    found: list[np.ndarray[Any, np.dtype[np.float64]]] = []
    for _ in range(150):
        guess = np.concatenate([rng.uniform(-1.5, 1.5, 3), Rotation.random(rng=rng).as_rotvec()])
        x, _, ended, _ = fsolve(excess, guess, full_output=True, xtol=1e-13)
        if ended != 1 or np.abs(excess(x)).max() > 1e-9:
            continue
        if all(pose_distance(x, other) > 1e-4 for other in found):
            found.append(x)
    return found


def pose_distance(a: Any, b: Any) -> float:
    turn = Rotation.from_rotvec(a[3:]).inv() * Rotation.from_rotvec(b[3:])
    return float(np.linalg.norm(np.asarray(a[:3]) - b[:3]) + turn.magnitude())


def test_stewart_platform_has_all_poses_that_its_leg_lengths_permit() -> None:
    rng = np.random.default_rng(5)
    source = shipped.shipped("stewart")
    for k in range(1, 7):
        source["joints"][f"leg{k}"]["start"]["s"] = float(rng.uniform(-0.15, 0.15))
    truth = platform_poses(source, rng)
    found = gelenk.assemblies(source, bodies=["platform"])
    assert len(found) == len(truth) == 8
    unmatched = list(range(len(truth)))
    for branch in found:
        assert led_back(branch, source) < 1e-12
        plant = gelenk.Simulation(branch.apply_to(source))
        plant.initialize()
        pose = [plant.output(f"pose.r[{i}]") for i in (1, 2, 3)]
        turn = Rotation.from_quat([plant.output(f"pose.Q[{i}]") for i in (1, 2, 3, 4)]).as_rotvec()
        near = min(unmatched, key=lambda i: pose_distance(truth[i], [*pose, *turn]))
        assert pose_distance(truth[near], [*pose, *turn]) < 1e-8  # fsolve's tolerance times the condition
        unmatched.remove(near)
    assert unmatched == []


def test_bricard_linkage_with_a_fixed_hinge_has_two_assemblies() -> None:
    """Overconstrained: it has redundant constraints, and a fixed hinge leaves no degree of freedom."""
    source = shipped.bricard()
    source["joints"][next(iter(source["joints"]))]["start"] = {"phi": 0.5, "fixed": True}
    found = gelenk.assemblies(source)
    assert [branch.degrees_of_freedom for branch in found] == [0, 0]
    assert max(led_back(branch, source) for branch in found) < 1e-12


def test_results_are_reproducible_and_other_seeds_find_the_same_branches() -> None:
    source = shipped.shipped("andrews")
    one, again, other = (gelenk.assemblies(source, seed=seed) for seed in (1, 1, 2))
    assert one == again
    assert [branch.distance for branch in other] == pytest.approx([b.distance for b in one], abs=1e-9)


def test_mechanism_without_loops_has_no_branches() -> None:
    found = gelenk.assemblies(shipped.shipped("double_pendulum"))
    assert len(found) == 0
    assert str(found) == "DoublePendulum has no closed loops: its start values are used as they are"


def test_invalid_calls_are_rejected_with_the_reason() -> None:
    with pytest.raises(gelenk.AssemblyError, match=r"The fixed values of A\.phi, D\.phi contradict"):
        gelenk.assemblies(held({"A": 1.1, "D": angles(1.1)[3] + 0.1}))
    with pytest.raises(gelenk.UsageError, match="wheel: no such body"):
        gelenk.assemblies(held({"A": 1.1}), bodies=["wheel"])
    with pytest.raises(gelenk.UsageError, match="starts = -1"):
        gelenk.assemblies(held({"A": 1.1}), starts=-1)


def test_too_few_searches_are_reported() -> None:
    found = gelenk.assemblies(held({"A": 1.1}), starts=3)
    assert found.starts == (3,)
    assert found.settled == (False,)
    assert "there may be more" in str(found)


def test_applied_branch_keeps_fixed_values_and_weights() -> None:
    source = held({"A": 1.1}, B={"phi": 0.2, "w": 3.0, "weight": {"phi": 7, "w": 2}})
    changed = gelenk.assemblies(source)[1].apply_to(source).to_dict()["joints"]
    assert changed["A"]["start"] == {"phi": 1.1, "fixed": True}
    assert changed["B"]["start"]["weight"] == {"phi": 7, "w": 2}
    assert changed["B"]["start"]["w"] == 3.0
    assert "fixed" not in changed["C"]["start"]


def test_command_lists_and_writes_branches(tmp_path: Path) -> None:
    source = copy.deepcopy(held({"A": 1.1}))
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(source))

    def call(*arguments: object) -> subprocess.CompletedProcess[str]:
        return programs.gelenk("assemblies", file, *arguments)

    listed = json.loads(call("--json").stdout)
    expected = gelenk.assemblies(source)
    assert listed == json.loads(json.dumps(expected.to_dict()))
    other = tmp_path / "other.yaml"
    assert call("--take", 2, "-o", other).stdout == f"{other}: branch 2 of 2\n"
    plant = gelenk.Simulation(other)
    plant.initialize()
    assert plant.output("C.phi") == pytest.approx(expected[1].values["C.phi"], abs=1e-12)
    assert "expected 1 to 2" in call("--take", 3, "-o", other).stderr
    assert "--take and --output: found one of them" in call("--take", 1).stderr
    (turned,) = json.loads(call("--set", "A.phi_start=2", "--json", "--body", "crank").stdout)["islands"]
    assert [branch["values"]["A.phi"] for branch in turned["branches"]] == [2]
