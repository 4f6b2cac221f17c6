# SPDX-License-Identifier: BSD-3-Clause
"""What inspection counts: freedoms, rows that repeat others, reactions left open, and why."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, four_bar, matrix
from models import reducible
from models.running import assert_close, record

import gelenk
from physics.loops.test_bricard import bricard
from physics.loops.test_parallelograms import four_bar_chain

HINGES = "ABCD"


def told(source: Scene, *without: str) -> gelenk.Inspection:
    return gelenk.inspect(source, without)


def open_reactions(joints: str, *components: str) -> set[str]:
    return {f"{j}.{c}" for j in joints for c in components}


def end_of(source: Scene, *without: str, stop: float = 1.0) -> dict[str, float]:
    plant = gelenk.Simulation(gelenk.load(source).without(without))
    plant.initialize(0.0, 1e-11)
    plant.step_to(stop)
    return {signal.name: plant.output(signal.name) for signal in plant.outputs}


# --- planar loops told in space ---


def test_four_bar_in_space_has_three_repeated_rows() -> None:
    """Issue 3: 3 coordinates, 2 rows, 1 freedom, wherever the plane lies. What the cut hinge forbids
    across the plane is forbidden already; forces across it and torques in it are anyone's guess.
    """
    report = told(reducible.tilted_four_bar())
    assert (report.described.constraint_equations, report.counted_degrees_of_freedom) == (5, -2)
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.degrees_of_freedom) == (3, 2, 1)
    assert report.reduced.planar
    assert {motion for _, motion in report.redundant_constraints} == {
        "sliding along z",
        "turning about x",
        "turning about y",
    }
    assert len({joint for joint, _ in report.redundant_constraints}) == 1
    assert set(report.undetermined_reactions) == open_reactions(HINGES, "f[3]", "t[1]", "t[2]")
    assert any("3 constraint equations are redundant at every position" in cause for cause in report.mobility)


def test_four_bar_told_by_turned_frames_has_the_same_counts() -> None:
    """One hinge's frames are turned so that its axis is their x; its reactions are told along them."""
    source = reducible.tilted_four_bar()
    R = np.array([[0.0, 0.6, 0.8], [0, -0.8, 0.6], [1, 0, 0]])  # x column along z
    B = source["joints"]["B"]
    B["axis"] = [1, 0, 0]
    B["parent"]["rotation"] = B["child"]["rotation"] = matrix(R)
    report = told(source)
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.degrees_of_freedom) == (3, 2, 1)
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
def test_four_bar_moves_alike_with_more_rows(off: list[str], rows: int, planar: bool) -> None:
    """In space the repeated rows are found by their rank; if they stay, the solver finds the rank."""
    source = reducible.tilted_four_bar()
    report = told(source, *off)
    assert (report.reduced.constraint_equations, report.reduced.planar) == (rows, planar)
    assert (report.reduced.rank, report.degrees_of_freedom) == (2, 1)
    assert len(report.redundant_constraints) == 3
    expected, found = end_of(source), end_of(source, *off)
    for name, value in expected.items():
        assert_close(name, found[name], value, 1e-9 * max(1.0, abs(value)), "one motion")


def test_ball_joint_in_a_planar_loop_has_one_repeated_row() -> None:
    """Its frames lie askew, so no single row of it is repeated but a combination of all three; along the
    plane's normal the force is open.
    """
    source = reducible.ball_four_bar()
    report = told(source)
    assert (report.described.constraint_equations, report.counted_degrees_of_freedom) == (3, 0)
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.degrees_of_freedom) == (3, 2, 1)
    assert [joint for joint, _ in report.redundant_constraints] == ["C"]
    assert set(report.undetermined_reactions) == (
        open_reactions("ABD", "f[3]", "t[1]", "t[2]") | open_reactions("C", "f[1]", "f[2]", "f[3]")
    )
    plain = end_of(reducible.tilted_four_bar())
    for off in ([], ["redundant_rows"]):
        found = end_of(source, *off)
        for name in (f"{j}.{level}" for j in "ABD" for level in ("phi", "w", "a")):
            assert_close(name, found[name], plain[name], 1e-9 * max(1.0, abs(plain[name])), "one motion")


# --- loops whose rows repeat others with changing factors ---


def test_bricard_has_a_freedom_that_counting_does_not_see() -> None:
    """Issue 3. All five rows stay: which of them is spare changes on the way."""
    report = told(bricard())
    assert (report.counted_degrees_of_freedom, report.degrees_of_freedom, report.initial_degrees_of_freedom) == (0, 1, 1)
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


@pytest.mark.parametrize(
    ("n", "start"),
    # Among 41 ways on from rest in line the search for one that is nowhere singular takes 10 s.
    [(n, start) for n in (1, 2, 4, 5, 12, 40) for start in STARTS if (n, start) != (40, "at rest")],
)
def test_windows_keep_the_rows_they_need(n: int, start: str) -> None:
    """Issue 3: two for each of N parallelograms, also if started where all bars lie in one line: each window
    could fold there, so n more freedoms open for a moment. From there ways lead on along which some four-bars
    stay in line; rows that do nothing on these are needed on the others.
    """
    upright, rate = STARTS[start]
    report = told(four_bar_chain(n, upright, rate))
    assert (report.reduced.constraint_equations, report.reduced.rank, report.degrees_of_freedom) == (2 * n, 2 * n, 1)
    in_space = gelenk.Simulation(gelenk.load(four_bar_chain(n, upright, rate)).without(["planar"]))
    in_space.initialize()
    assert (in_space.size.constraint_equations, in_space.size.degrees_of_freedom) == (2 * n, 1)
    assert report.initial_degrees_of_freedom == (1 + n if upright == SINGULAR else 1)
    assert any("singular" in cause for cause in report.mobility) == (upright == SINGULAR)
    assert len(report.redundant_constraints) == 3 * n


@pytest.mark.parametrize(("coupler_is_parent", "rows"), [(False, 3), (True, 4)])
def test_third_crank_of_a_parallelogram_adds_no_freedom(coupler_is_parent: bool, rows: int) -> None:
    """Rows are resolved in the parent. Along and across its crank a row of one cut is the same as one of the
    other, everywhere, and is left out; along the coupler they differ by sines and cosines: all stay.
    """
    report = told(reducible.triple_crank(coupler_is_parent))
    assert (report.reduced.coordinates, report.reduced.constraint_equations, report.reduced.rank) == (4, rows, 3)
    assert (report.counted_degrees_of_freedom, report.degrees_of_freedom) == (-6, 1)
    assert len(report.redundant_constraints) == 10 - rows
    changing = any("with coefficients that vary" in cause for cause in report.mobility)
    assert changing == coupler_is_parent


@pytest.mark.parametrize("coupler_is_parent", [False, True])
def test_triple_crank_turns_round_through_its_change_points(coupler_is_parent: bool) -> None:
    """16 rad, five change points. The tolerance is the usual one: passing is a matter of steps that do not
    end beside the change point, and finer ones end there more easily (README).
    """
    source = reducible.triple_crank(coupler_is_parent)
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, 1e-6)
    found = record(plant, np.linspace(0, 1.6, 161))
    assert found["A0.phi"][-1] - found["A0.phi"][0] > 10  # rad
    for i in (1, 2):
        assert_close(f"A{i}.phi", found[f"A{i}.phi"], found["A0.phi"], 1e-9, "parallel cranks: closure")
    energy = found["E.total"]
    assert_close("energy", energy, energy[0], 1e-5, "rtol of 15 J to and fro")


# --- parts held twice ---


@pytest.mark.parametrize(
    ("make", "open_components"),
    [
        (reducible.door, ("f[1]", "f[2]", "f[3]", "t[1]", "t[2]")),
        # The rails slope in their frames, so all components but a force along them have a share.
        (reducible.guided, ("f[1]", "f[2]", "f[3]", "t[1]", "t[2]", "t[3]")),
    ],
    ids=["door", "guided"],
)
@pytest.mark.parametrize("off", [[], ["planar"]], ids=["in the plane", "in space"])
def test_second_guide_repeats_the_first(make: Any, open_components: tuple[str, ...], off: list[str]) -> None:
    """Two hinges in line, or two rails: 5 rows more, all repeated, and still 1 freedom."""
    report = told(make(), *off)
    assert (report.counted_degrees_of_freedom, report.degrees_of_freedom) == (-4, 1)
    assert (report.described.constraint_equations, report.reduced.constraint_equations, report.reduced.rank) == (5, 0, 0)
    assert len(report.redundant_constraints) == 5
    joints = make()["joints"]
    assert set(report.undetermined_reactions) == {f"{j}.{c}" for j in joints for c in open_components}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("off", [[], ["planar"]], ids=["in the plane", "in space"])
def test_second_guide_repeats_the_first_but_for_rounding(kind: str, seed: int, off: list[str]) -> None:
    """Along an axis of no simple numbers the two guides agree to rounding only, and must not jam."""
    source = reducible.held_twice(kind, seed)
    report = told(source, *off)
    assert (report.reduced.constraint_equations, report.degrees_of_freedom) == (0, 1)
    end = end_of(source, *off, stop=0.2)
    single = reducible.held_twice(kind, seed)
    del single["joints"]["upper"]
    for name, value in end_of(single, *off, stop=0.2).items():
        assert_close(name, end[name], value, 1e-9 * max(1.0, abs(value)), "the other guide does nothing")


def test_counts_agree_with_gruebler_where_nothing_is_special() -> None:
    """A pendulum and a platform on six legs; and a plane's count is not space's."""
    report = told(reducible.platform_on_balls())
    assert (report.counted_degrees_of_freedom, report.degrees_of_freedom, report.mobility) == (6, 6, ())
    assert "as counted" in str(report)
    assert "counting" in str(told(four_bar(1.1)))
