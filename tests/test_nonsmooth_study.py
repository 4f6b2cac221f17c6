# SPDX-License-Identifier: BSD-3-Clause
"""The study of docs/nonsmooth-measurements.md: exact solutions, regularized laws, a sample of its trials."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from benchmarks.nonsmooth import exact, judge, laws, problems, runs, trials


def test_exact_motion_of_a_bouncing_ball() -> None:
    """Heights of successive apexes decrease by the square of the restitution; then it rests."""
    law, times = exact.Law(0.5, lower=0.0, restitution=0.5), [1.0, 2.0, 2.5, 3.1]
    found, events = exact.course(
        law, 1.0, 0.0, times, [-1.0] * 4
    )  # acceleration -2: impact at 1 s with 2 m/s
    assert found[0] == pytest.approx((0.0, 1.0), abs=1e-12)
    assert found[1] == pytest.approx((0.0, 0.5), abs=1e-12)
    assert found[2] == pytest.approx((0.0, 0.25), abs=1e-12)
    assert found[3] == (0.0, 0.0)
    assert math.isnan(events)


def test_exact_motion_with_friction() -> None:
    """Break away, stop, and rest below the static limit: three instants of events."""
    law = exact.Law(0.5, 1.0, 2.0)
    found, events = exact.course(law, 0.0, 0.0, [1.0, 2.0, 5.0, 6.0], [1.9, 2.5, 0.0, 1.9])
    assert found[0] == (0.0, 0.0)
    assert found[1] == pytest.approx((1.5, 3.0))
    assert found[2] == found[3] == pytest.approx((1.5 + 9 / 4, 0.0))
    assert events == 2


def test_exact_motion_of_a_spring_with_friction() -> None:
    """3.5 bends of friction: half oscillations end at -1.5 and -0.5 times the same, where it sticks."""
    found, events = exact.springy(exact.Law(0.5, 1.0, 1.0), 50.0, 3.5 / 50, [0.0, math.pi / 10, 1.0])
    assert [x * 50 for x, _ in found] == pytest.approx([3.5, -1.5, -0.5])
    assert events == 2


def test_closed_forms_of_the_problems() -> None:
    """The block slips first after 0.2943 s; its limit cycle has 0.72784 s. The clutch locks at 1.29 s."""
    stick, slip = problems.belt_phases(problems.BELT_SPEED, problems.STATIC)
    assert stick + slip == pytest.approx(0.7278369627704185, abs=1e-15)
    clutch = problems.clutch()
    assert clutch.positions["shaft.phi"][-1] == pytest.approx(324.41729581331504 - 55, abs=1e-11)
    relative = 178.89567604667124 - 324.41729581331504 + 55.625
    assert clutch.positions["clutch.phi"][-1] == pytest.approx(relative, abs=1e-11)
    assert [len(problem.times) for problem in problems.problems()] == [7, 9, 7, 8]


@pytest.mark.parametrize("law", laws.LAWS)
def test_regularized_laws_converge_to_the_exact_solution(law: str) -> None:
    """Their errors are proportional to the width."""
    problem = problems.clutch()
    wide, narrow = (laws.smooth_run(problem, law, width, 1e-7) for width in (1e-2, 1e-3))
    assert narrow.error < 0.01
    assert wide.error / narrow.error == pytest.approx(10, rel=0.15)


def test_spring_stop_has_the_restitution_of_the_limit() -> None:
    """The error decreases with the square root of the stiffness, as the duration of contacts does."""
    problem = problems.pendulum()
    soft, stiff = (laws.stop_run(problem, stiffness, 1) for stiffness in (1e6, 1e8))
    assert stiff.error < 2e-3
    assert soft.error / stiff.error == pytest.approx(10, rel=0.1)


def run_of_auto(problem: problems.Problem) -> runs.Run:
    """The run at a tolerance of 1e-7."""
    (found,) = [
        run for run in runs.event_driven(problem, quick=True) if (run.series, run.setting) == ("auto", 1e-7)
    ]
    return found


def test_gelenk_solves_the_problems() -> None:
    """Bounds: 100 times the tolerance; 50 measured, for the four-bar."""
    for problem in problems.problems():
        found = run_of_auto(problem)
        assert found.error < 1e-5
        assert found.events == problem.events


@pytest.mark.parametrize(
    "family", [trials.breaking_away, trials.alternating, trials.stacks, trials.oscillating]
)
def test_a_sample_of_trials_is_right(family: trials.Family) -> None:
    for trial in list(family())[::7]:
        verdict = judge.judged(trial, "auto")
        assert verdict.outcome == "right", f"{trial.name}: {verdict}"


def test_wrong_motions_and_event_counts_are_noticed() -> None:
    trial = next(trials.oscillating())
    signals = {name: [x + 1e-5 for x in values] for name, values in trial.exact.items()}
    assert judge.judged(replace(trial, exact=signals), "auto").outcome == "wrong"
    assert judge.judged(replace(trial, events=trial.events + 1), "auto").outcome == "count"
    scene = {**trial.scene, "bodies": {}}
    assert judge.judged(replace(trial, scene=scene), "auto").outcome == "refused"
