# SPDX-License-Identifier: BSD-3-Clause
"""Standard jobs cost no more than when figures.json was written: `make costs WHY="..."` writes it anew."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from .counting import (
    Prepared,
    counts_of,
    instructions_of,
    instructions_of_steps,
    machine,
    prepared,
    valgrind,
    written,
)
from .jobs import AT_REST, FALLING, FRICTION, HELD, JOBS, RESTING

# Rounding differs from compiler to compiler, alignment from build to build: counts follow by less than this.
MARGIN = 0.05


@pytest.fixture(params=JOBS)
def job(request: pytest.FixtureRequest, host: Path, tmp_path: Path) -> tuple[str, Prepared]:
    return request.param, prepared(JOBS[request.param], host, tmp_path / "job")


def judge(title: str, what: str, found: int) -> None:
    expected = written()["jobs"][title][what]
    line = f"{title}: {found} {what}, {expected} when figures.json was written"
    if found < (1 - MARGIN) * expected:
        warnings.warn(f"{line}; `make costs` would keep the gain", stacklevel=2)
    assert found <= (1 + MARGIN) * expected, line


def test_evaluations(job: tuple[str, Prepared]) -> None:
    title, ready = job
    for what, count in counts_of(ready).items():
        judge(title, what, count)


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux" or not valgrind(), reason="valgrind is not installed")
def test_instructions(job: tuple[str, Prepared]) -> None:
    title, ready = job
    here, there = machine(ready.library), written()["machine"]
    if here != there:
        pytest.skip(f"figures.json is of {there}, this is {here}")
    judge(title, "instructions", instructions_of(ready))


# Friction in all joints of a four-bar, away from events, may cost half as much as the rest of an evaluation.
COST_OF_FRICTION = 1.5


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux" or not valgrind(), reason="valgrind is not installed")
@pytest.mark.parametrize("pair", FRICTION)
def test_friction_costs_little(pair: str, host: Path, tmp_path: Path) -> None:
    jobs = [prepared(job, host, tmp_path / str(i)) for i, job in enumerate(FRICTION[pair])]
    ours, plain = (instructions_of(job) / counts_of(job)["evaluations"] for job in jobs)
    assert ours <= COST_OF_FRICTION * plain, f"{ours / plain:.3f} times the instructions of an evaluation"


# An evaluation of an arm of which six of seven joints rest is cheaper than one in which all move: they are
# left out of the recursion along the tree. As constraint equations they would cost what they save.
COST_AT_REST = 0.9


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux" or not valgrind(), reason="valgrind is not installed")
def test_rest_costs_less_than_motion(host: Path, tmp_path: Path) -> None:
    jobs = [prepared(job, host, tmp_path / str(i)) for i, job in enumerate(AT_REST)]
    at_rest, moving = (instructions_of(job) / counts_of(job)["evaluations"] for job in jobs)
    assert at_rest <= COST_AT_REST * moving, f"{at_rest / moving:.3f} times the instructions of an evaluation"


counted = pytest.mark.skipif(sys.platform != "linux" or not valgrind(), reason="valgrind is not installed")

# In units of a step in which the mechanism moves. Under another torque in each step, what is held costs the
# solution of its equations once; of the ten solutions of a step the others are the same (1.25, 1.22).
COST_OF_HELD = 1.3
# An impact takes two steps to its time, and some solutions more. Measured: 4.6 and 4.3.
COST_OF_AN_IMPACT = 8
# Ten impacts in one step that end in contact. Measured: 27 and 28.
COST_OF_A_SERIES = {"rk4": 30, "auto": 30}


@pytest.mark.thorough
@counted
@pytest.mark.parametrize("method", HELD)
def test_what_is_held_costs_little_more_than_what_moves(method: str, host: Path, tmp_path: Path) -> None:
    held, moving = (
        instructions_of_steps(prepared(job, host, tmp_path / str(i)))[5:]
        for i, job in enumerate(HELD[method])
    )
    assert sum(held) <= COST_OF_HELD * sum(moving), f"{sum(held) / sum(moving):.3f}"


@pytest.mark.thorough
@counted
@pytest.mark.parametrize("method", FALLING)
def test_impacts_cost_some_steps(method: str, host: Path, tmp_path: Path) -> None:
    steps = np.array(instructions_of_steps(prepared(FALLING[method], host, tmp_path / "job"))[5:])
    smooth = np.median(steps)
    assert steps.max() <= COST_OF_A_SERIES[method] * smooth, f"{steps.max() / smooth:.1f}"
    first = steps[:300].max()  # the first impact, in step 255
    assert 2 * smooth <= first <= COST_OF_AN_IMPACT * smooth, f"{first / smooth:.1f}"


@pytest.mark.thorough
@counted
def test_rest_on_a_contact_costs_no_more_than_a_time_step(host: Path, tmp_path: Path) -> None:
    """It is not decided on again; each time step solves a cone problem."""
    located, steps = (
        instructions_of_steps(prepared(job, host, tmp_path / str(i)))[5:] for i, job in enumerate(RESTING)
    )
    assert sum(located) <= sum(steps), f"{sum(located) / sum(steps):.2f}"


def test_figures_are_of_the_jobs() -> None:
    figures = written()
    assert figures["why"]
    assert {title: job.rounds for title, job in JOBS.items()} == {
        title: figure["rounds"] for title, figure in figures["jobs"].items()
    }
