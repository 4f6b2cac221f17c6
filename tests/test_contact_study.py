# SPDX-License-Identifier: BSD-3-Clause
"""The study of contacts in docs/nonsmooth-measurements.md: closed forms, errors, orders, piles."""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned
from benchmarks.contacts import __main__ as study
from benchmarks.contacts import engines, failure_map, piles, problems, tipping, trials

PROBLEMS = {problem.name: problem for problem in problems.problems()}


@pytest.mark.parametrize(
    ("name", "row", "expected"),
    [
        # Computed with 40 digits.
        ("sticks", -1, [0.0]),
        ("slides", -1, [3.217688126732515]),
        ("back", 0, [-0.41694290788874655]),
        ("back", -1, [0.4271591504097631]),
        ("bounces", 0, [0.65855]),
        ("bounces", 1, [0.32070222626301814]),
        ("bounces", 5, [0.10001271342505208]),
        ("bounces", -1, [0.1]),
        ("rolls", 0, [0.19028859546718396, 0.048612656495312]),
        ("rolls", -1, [2.25742929269934, 0.7510613275284772]),
        ("upright", -1, [2.19, 0.0]),
    ],
)
def test_closed_forms(name: str, row: int, expected: list[float]) -> None:
    assert PROBLEMS[name].exact[row] == pytest.approx(expected, abs=1e-14)


# The smallest error of MuJoCo 4.0, Drake 1.58 and EXUDYN 1.13 with steps of 1 ms, each with default and
# tightened settings: the table of docs/nonsmooth-measurements.md.
BEST = {
    "sticks": 3.4e-6, "slides": 2.5e-4, "back": 1.7e-3, "bounces": 3.6e-2, "rolls": 4.9e-4, "upright": 5.0e-4,
    "tips": 2.2e-3, "edge": 6.1e-4,
}  # fmt: skip


@pytest.mark.parametrize("name", PROBLEMS)
def test_errors_are_smaller_than_those_of_other_engines(name: str) -> None:
    problem = PROBLEMS[name]
    poses, _ = engines.gelenk_steps(problem, 1e-3)
    assert problem.error(poses) < BEST[name]


@pytest.mark.parametrize("name", [name for name in PROBLEMS if name not in ("sticks", "slides", "upright")])
def test_errors_are_at_least_of_first_order(name: str) -> None:
    """From 10 ms to 0.1 ms they decrease by 100, up to 10 for where in its step an event is."""
    problem = PROBLEMS[name]
    coarse, fine = (problem.error(engines.gelenk_steps(problem, h)[0]) for h in (1e-2, 1e-4))
    assert coarse / fine > 9


def test_runs_without_events_are_exact() -> None:
    """Up to the residual of the cone solver over 2000 steps, 4e-12 m."""
    for name in ("sticks", "slides", "upright"):
        assert PROBLEMS[name].error(engines.gelenk_steps(PROBLEMS[name], 1e-3)[0]) < 5e-11


def test_what_is_shown_of_poses() -> None:
    """Positions along the slope, and the tilt of the box, also beyond half a turn."""
    back = PROBLEMS["back"]
    p, Q = back.start
    moved = np.array(p) + 0.5 * np.array([math.cos(back.angle), 0, -math.sin(back.angle)])
    assert back.shown_of(np.array([[*moved, *Q]])) == pytest.approx(np.array([[0.5]]), abs=1e-15)
    half = -math.pi + 0.1
    pose = np.array([[0.3, 0, 0.3, 0, math.sin(half / 2), 0, math.cos(half / 2)]])
    assert PROBLEMS["tips"].shown_of(pose) == pytest.approx(np.array([[0.3, half]]))


def test_orders_and_the_table() -> None:
    steps = (1e-2, 1e-3, 1e-4)
    own = [study.Run("sticks", "Gelenk, steps", h, 3 * h**2, 2e-6 / h) for h in steps]
    others = [study.Run("sticks", "A", 1e-3, 0.1, 0.01), study.Run("sticks", "B", 1e-3, 0.01, 0.05)]
    assert study.order(own) == "2.0"
    assert study.order([study.Run("sticks", "Gelenk, steps", h, 1e-12, 1) for h in steps]) == "exact"
    row = study.table([PROBLEMS["sticks"]], [*own, *others, study.Run("sticks", "C", 1e-3, reason="no")])
    assert row.splitlines()[-1].split(" | ")[1:] == ["3.0e-06", "2.0", "2.0", "B", "1.0e-02", "50.0 |"]


@pytest.mark.parametrize("name", PROBLEMS)
def test_errors_of_located_events_follow_the_tolerance(name: str) -> None:
    problem = PROBLEMS[name]
    for tolerance in (1e-6, 1e-8, 1e-10):
        assert problem.error(engines.gelenk_events(problem, tolerance)[0]) < 100 * tolerance


def test_the_table_of_events() -> None:
    own = [study.Run("sticks", engines.EVENTS, t, t, 2e-3) for t in (1e-6, 1e-8)]
    others = [study.Run("sticks", "A", 1e-3, 0.1, 0.01), study.Run("sticks", "B", 1e-2, 0.01, 0.05)]
    lines = study.table_of_events([PROBLEMS["sticks"]], [*own, *others]).splitlines()
    assert "error at 1e-08 [m, rad]" in lines[0]
    assert lines[-1].split(" | ")[1:] == ["1.0e-06", "1.0e-08", "2.0 / 2.0", "B", "1.0e-02", "50.0 |"]


def test_spheres_of_a_pile_begin_apart_and_inside() -> None:
    for count in (8, 100):
        places, half = piles.lattice(count)
        assert len(places) == count
        assert np.abs(places[:, :2]).max() < half - piles.RADIUS
        assert len(piles.gaps(places, half)) == 0


def test_touching_pairs_are_counted() -> None:
    """Two spheres that overlap by 1 mm, one of which touches the floor and one a wall."""
    R = piles.RADIUS
    places = np.array([[0, 0, R], [2 * R - 1e-3, 0, 2 * R]])
    places[1, 2] = R
    found = np.sort(piles.gaps(places, places[1, 0] + R))
    assert found == pytest.approx([-1e-3, 0, 0, 0], abs=1e-15)


def test_a_small_pile_is_measured() -> None:
    row = piles.measured("Gelenk", 8, 60.0)
    assert row["settled contacts"] >= 8
    assert row["settled overlap"] < 1e-7
    assert row["settled ms"] > 0
    assert math.isnan(piles.measured("Gelenk", 8, 0.0)["falling ms"])
    assert "| 8 | Gelenk |" in piles.table([row])


AUTO, ERK = failure_map.WAYS[:2]


def test_a_reference_whose_edge_slides_back_is_refused() -> None:
    """A box that tips pushes its edge back; here from 0.15 s on."""
    force = 1.2 * tipping.BOX_FRICTION * tipping.BOX_MASS * 9.81
    lift = (1.05 * 0.1 - tipping.BOX_FRICTION * 0.3) * tipping.BOX_MASS * 9.81 / force
    assert tipping.tipping_box(force, lift, [0.1]).shape == (1, 2)
    with pytest.raises(ValueError, match="slides back"):
        tipping.tipping_box(force, lift, [0.1, 0.2])


@warned.IN_STEPS
@pytest.mark.parametrize("family", dict.fromkeys(trial.family for trial in trials.trials()))
def test_trials_of_the_failure_map_are_right(family: str) -> None:
    """Each third one; and where Painleve's rod has no motion, erk says so."""
    chosen = [trial for trial in trials.trials() if trial.family == family]
    for trial in [*chosen[::3], *(trial for trial in chosen if trial.refused)]:
        verdict = ERK(trial) if trial.refused else AUTO(trial)
        assert verdict is not None
        assert verdict.outcome == "right", (trial.row, trial.column, verdict.error, verdict.words)
