# SPDX-License-Identifier: BSD-3-Clause
"""Inspection reports: degrees of freedom, redundant constraints,
indeterminate reactions, and their causes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene, four_bar, matrix
from models import reducible
from models.running import assert_close, record

import gelenk
from physics.loops.test_bricard import bricard
from physics.loops.test_parallelograms import four_bar_chain

HINGES = "ABCD"


def inspect(source: Scene, *without: str) -> gelenk.Inspection:
    return gelenk.inspect(source, without)


def open_reactions(joints: str, *components: str) -> set[str]:
    return {f"{j}.{c}" for j in joints for c in components}


def end_of(source: Scene, *without: str, stop: float = 1.0) -> dict[str, float]:
    plant = gelenk.Simulation(gelenk.load(source).without(without))
    plant.initialize(0.0, 1e-11)
    plant.step_to(stop)
    return {signal.name: plant.output(signal.name) for signal in plant.outputs}


# --- planar loops described in space ---


def test_spatial_four_bar_has_three_redundant_constraints() -> None:
    """3 coordinates, 2 constraint equations, 1 degree of freedom, in any orientation of the plane. The
    out-of-plane constraints of the cut revolute joint are redundant; the out-of-plane force and the torques
    in it are indeterminate.
    """
    report = inspect(reducible.tilted_four_bar())
    assert (report.described.constraint_equations, report.counted_degrees_of_freedom) == (5, -2)
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.degrees_of_freedom) == (
        3,
        2,
        1,
    )
    assert report.reduced.planar
    assert {motion for _, motion in report.redundant_constraints} == {
        "sliding along z",
        "turning about x",
        "turning about y",
    }
    assert len({joint for joint, _ in report.redundant_constraints}) == 1
    assert set(report.undetermined_reactions) == open_reactions(HINGES, "f[3]", "t[1]", "t[2]")
    assert any("3 constraint equations are redundant at every position" in cause for cause in report.mobility)


def test_rotated_joint_frames_do_not_change_the_counts() -> None:
    """The frames of one revolute joint are rotated such that its axis is their x-axis;
    its reactions are reported in them.
    """
    source = reducible.tilted_four_bar()
    R = np.array([[0.0, 0.6, 0.8], [0, -0.8, 0.6], [1, 0, 0]])  # x column along z
    B = source["joints"]["B"]
    B["axis"] = [1, 0, 0]
    B["parent"]["rotation"] = B["child"]["rotation"] = matrix(R)
    report = inspect(source)
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.degrees_of_freedom) == (
        3,
        2,
        1,
    )
    assert len(report.redundant_constraints) == 3
    assert set(report.undetermined_reactions) == (
        open_reactions("ACD", "f[3]", "t[1]", "t[2]") | open_reactions("B", "f[1]", "t[2]", "t[3]")
    )


@pytest.mark.parametrize(
    ("off", "rows", "planar"),
    [
        (["planar"], 2, False),
        (["redundant_rows"], 2, True),
        (["planar", "redundant_rows"], 5, False),
        (["all"], 5, False),
    ],
)
def test_redundant_constraints_do_not_change_the_motion(off: list[str], rows: int, planar: bool) -> None:
    """In space redundant constraints are identified by the rank; if they are kept,
    the solver determines the rank.
    """
    source = reducible.tilted_four_bar()
    report = inspect(source, *off)
    assert (report.reduced.constraint_equations, report.reduced.planar) == (rows, planar)
    assert (report.reduced.rank, report.degrees_of_freedom) == (2, 1)
    assert len(report.redundant_constraints) == 3
    expected, found = end_of(source), end_of(source, *off)
    for name, value in expected.items():
        assert_close(name, found[name], value, 1e-9 * max(1.0, abs(value)), "same motion")


def test_ball_joint_in_a_planar_loop_has_one_redundant_constraint() -> None:
    """The joint frames are oblique, so no single constraint equation is redundant, but a combination of all
    three; the force along the normal of the plane is indeterminate.
    """
    source = reducible.ball_four_bar()
    report = inspect(source)
    assert (report.described.constraint_equations, report.counted_degrees_of_freedom) == (3, 0)
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.degrees_of_freedom) == (
        3,
        2,
        1,
    )
    assert [joint for joint, _ in report.redundant_constraints] == ["C"]
    assert set(report.undetermined_reactions) == (
        open_reactions("ABD", "f[3]", "t[1]", "t[2]") | open_reactions("C", "f[1]", "f[2]", "f[3]")
    )
    plain = end_of(reducible.tilted_four_bar())
    for off in ([], ["redundant_rows"]):
        found = end_of(source, *off)
        for name in (f"{j}.{level}" for j in "ABD" for level in ("phi", "w", "a")):
            assert_close(name, found[name], plain[name], 1e-9 * max(1.0, abs(plain[name])), "same motion")


# --- loops whose redundant constraint changes with the position ---


def test_bricard_mechanism_is_overconstrained() -> None:
    """All five constraint equations are kept: which of them is redundant depends on the position."""
    report = inspect(bricard())
    assert (
        report.counted_degrees_of_freedom,
        report.degrees_of_freedom,
        report.initial_degrees_of_freedom,
    ) == (0, 1, 1)
    assert (report.reduced.constraint_equations, report.reduced.rank) == (5, 4)
    assert report.redundant_constraints == ()
    assert any("with coefficients that vary" in cause and "J1" in cause for cause in report.mobility)


SINGULAR = math.pi / 2


STARTS = {
    "upright": (0.3, 1.0),
    "hanging": (2.5, 1.0),
    "in line": (SINGULAR, 1.0),
    "at rest": (SINGULAR, 0.0),
}


@warned.SINGULAR
@pytest.mark.parametrize(
    ("n", "start"),
    # Among 41 branches from rest in line the search for one that is nowhere singular takes 10 s.
    [(n, start) for n in (1, 2, 4, 5, 12, 40) for start in STARTS if (n, start) != (40, "at rest")],
)
def test_n_four_bar_keeps_its_independent_constraints(n: int, start: str) -> None:
    """Each of the N parallelograms requires two constraint equations, also if started with all bars in line:
    each four-bar could fold there, so n additional degrees of freedom exist at that position. Branches lead
    from there along which some four-bars remain in line; constraint equations without effect on these are
    required on the others.
    """
    upright, rate = STARTS[start]
    report = inspect(four_bar_chain(n, upright, rate))
    assert (report.reduced.constraint_equations, report.reduced.rank, report.degrees_of_freedom) == (
        2 * n,
        2 * n,
        1,
    )
    in_space = gelenk.Simulation(gelenk.load(four_bar_chain(n, upright, rate)).without(["planar"]))
    in_space.initialize()
    assert (in_space.size.constraint_equations, in_space.size.degrees_of_freedom) == (2 * n, 1)
    assert report.initial_degrees_of_freedom == (1 + n if upright == SINGULAR else 1)
    assert any("singular" in cause for cause in report.mobility) == (upright == SINGULAR)
    assert len(report.redundant_constraints) == 3 * n


@pytest.mark.parametrize(("coupler_is_parent", "rows"), [(False, 3), (True, 4)])
def test_third_crank_of_a_parallelogram_is_redundant(coupler_is_parent: bool, rows: int) -> None:
    """Constraint equations are resolved in the parent frame. Along and across its crank an equation of one
    cut equals one of the other at every position and is removed; along the coupler they differ by sines and
    cosines, and all are kept.
    """
    report = inspect(reducible.triple_crank(coupler_is_parent))
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.reduced.rank) == (
        4,
        rows,
        3,
    )
    assert (report.counted_degrees_of_freedom, report.degrees_of_freedom) == (-6, 1)
    assert len(report.redundant_constraints) == 10 - rows
    changing = any("with coefficients that vary" in cause for cause in report.mobility)
    assert changing == coupler_is_parent


@pytest.mark.parametrize("coupler_is_parent", [False, True])
def test_triple_crank_makes_full_turns_through_its_change_points(coupler_is_parent: bool) -> None:
    """16 rad, five change points. The tolerance is the default: change points are crossed in steps that do
    not end beside them, and smaller steps are more likely to end there (README).
    """
    source = reducible.triple_crank(coupler_is_parent)
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, 1e-6)
    found = record(plant, np.linspace(0, 1.6, 161))
    assert found["A0.phi"][-1] - found["A0.phi"][0] > 10  # rad
    for i in (1, 2):
        assert_close(f"A{i}.phi", found[f"A{i}.phi"], found["A0.phi"], 1e-9, "parallel cranks: closure")
    energy = found["E.total"]
    assert_close("energy", energy, energy[0], 1e-5, "rtol of 15 J exchanged")


# --- bodies held twice ---


@pytest.mark.parametrize(
    ("make", "open_components"),
    [
        (reducible.door, ("f[1]", "f[2]", "f[3]", "t[1]", "t[2]")),
        # The rails are inclined in their frames, so all components except a force along them are affected.
        (reducible.guided, ("f[1]", "f[2]", "f[3]", "t[1]", "t[2]", "t[3]")),
    ],
    ids=["door", "guided"],
)
@pytest.mark.parametrize("off", [[], ["planar"]], ids=["in the plane", "in space"])
def test_second_guide_is_redundant(make: Any, open_components: tuple[str, ...], off: list[str]) -> None:
    """Two coaxial revolute joints, or two rails: 5 more constraint equations, all redundant,
    and still 1 degree of freedom.
    """
    report = inspect(make(), *off)
    assert (report.counted_degrees_of_freedom, report.degrees_of_freedom) == (-4, 1)
    assert (
        report.described.constraint_equations,
        report.reduced.constraint_equations,
        report.reduced.rank,
    ) == (5, 0, 0)
    assert len(report.redundant_constraints) == 5
    joints = make()["joints"]
    assert set(report.undetermined_reactions) == {f"{j}.{c}" for j in joints for c in open_components}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("off", [[], ["planar"]], ids=["in the plane", "in space"])
def test_second_guide_is_redundant_up_to_round_off(kind: str, seed: int, off: list[str]) -> None:
    """Along an arbitrary axis the two guides agree only to round-off, and must not lock."""
    source = reducible.held_twice(kind, seed)
    report = inspect(source, *off)
    assert (report.reduced.constraint_equations, report.degrees_of_freedom) == (0, 1)
    end = end_of(source, *off, stop=0.2)
    single = reducible.held_twice(kind, seed)
    del single["joints"]["upper"]
    for name, value in end_of(single, *off, stop=0.2).items():
        assert_close(name, end[name], value, 1e-9 * max(1.0, abs(value)), "the other guide carries no load")


def test_degrees_of_freedom_agree_with_gruebler_in_regular_cases() -> None:
    """A pendulum, and a platform on six legs; the counts of a plane differ from those in space."""
    report = inspect(reducible.platform_on_balls())
    assert (report.counted_degrees_of_freedom, report.degrees_of_freedom, report.mobility) == (6, 6, ())
    assert "as counted" in str(report)
    assert "counting" in str(inspect(four_bar(1.1)))
