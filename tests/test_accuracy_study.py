# SPDX-License-Identifier: BSD-3-Clause
"""The study of docs/accuracy.md makes the runs that the page describes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warned
from benchmarks.accuracy import page, scenes
from benchmarks.accuracy.runs import INTEGRATORS, TOLERANCES, Settings, references_of, runs_of

from gelenk.chart.case import Smooth
from gelenk.chart.measure import Reference, Runner, Task, difference
from gelenk.chart.methods import Method
from gelenk.chart.outcome import Outcome

ERK = Method("projection", "erk")


@warned.TURNS
def test_the_study_covers_the_conditions_of_the_page() -> None:
    """At least 40 scenes load under all conditions: 5 sets of communication points, 3 kinds of inputs."""
    plants = scenes.plants()
    assert len({plant.name for plant in plants}) == len(plants) >= 40
    assert (len(TOLERANCES), len(scenes.GRIDS), len(scenes.INPUTS), len(INTEGRATORS)) == (7, 5, 3, 6)
    for plant in plants:
        for case in plant.cases():
            assert case.grid[0] == 0
            assert case.grid[-1] == pytest.approx(plant.stop, rel=1e-12)
            assert (np.diff(case.grid) > 0).all()
        Runner(Task(case, ERK, 1e-6))
        assert set(plant.drives) <= {
            signal.name for signal in Runner(Task(case, ERK, 1e-6)).simulation.inputs
        }


def test_smooth_inputs_are_given_with_their_derivatives() -> None:
    """Central differences, h = 1e-4: errors of h^2 times the third derivative, 1e-8 of each."""
    wave, h = Smooth(0.3, 2.0, 3.0), 1e-4
    for order in range(3):
        derivative = (wave.at(0.7 + h)[order] - wave.at(0.7 - h)[order]) / (2 * h)
        assert derivative == pytest.approx(wave.at(0.7)[order + 1], rel=1e-6)


@warned.TURNS
def test_smooth_inputs_move_within_a_communication_step() -> None:
    """A disk without spring: w is the integral of the sine over its moment of inertia. The cubic polynomials
    have an error of 5 7^4 h^5 / 120 / 0.02 per step of 1 ms: 5e-9 of 1000; held inputs one of about 0.1.
    """
    plant = next(p for p in scenes.plants() if p.name == "torsion-soft")
    scene = {**plant.scene, "joints": {"A": {**plant.scene["joints"]["A"], "stiffness": 0, "damping": 0}}}
    (case,) = (c for c in replace(plant, scene=scene).cases() if c.name.endswith("smooth/fine"))
    runner = Runner(Task(case, ERK, 1e-10))
    found = runner.record().states[:, runner.names.index("A.w")]
    mean, amplitude, rate = plant.drives["drive.tau"]
    exact = (mean * case.grid[1:] + amplitude / rate * (1 - np.cos(rate * case.grid[1:]))) / 0.02
    assert np.ptp(exact) > 50
    assert difference(found[:, None], exact[:, None], np.ones(1)) < 100 * 1e-10 * 50  # solver


def test_outcomes_and_conditions_are_in_the_tables() -> None:
    """Sampled runs of one scene: their counts add up and include saved and irregular ones."""
    plant = next(p for p in scenes.plants() if p.name == "torsion-overdamped")
    runs = runs_of(
        replace(plant, drives={}), Settings(tolerances=(1e-4, 1e-6), integrators=("erk", "dirk"), jobs=1)
    )
    assert len(runs) == 5 * 2 * 2 * 2
    assert {page.way_of(run).saved for run in runs} == {True, False}
    assert all(run.outcome == Outcome.GOOD for run in runs)
    spoiled = [replace(runs[0], outcome=Outcome.WRONG, error=1.0), *runs[1:]]
    assert "1 wrong | 1.0e4" in page.outliers(spoiled).replace("1e+04", "1.0e4")
    assert page.outliers(runs).count("\n") == 2  # only the header


def test_signals_are_measured_by_their_largest_value_in_any_run() -> None:
    """At the end of a run, its only sample, a spring may be near zero."""
    plant = next(p for p in scenes.plants() if p.name == "torsion-soft")
    found = references_of([c for c in plant.cases() if "constant" in c.name], 1)
    scales = [reference.scales for reference in found.values() if isinstance(reference, Reference)]
    assert len(scales) == 5
    assert all((s == scales[0]).all() for s in scales)
    assert scales[0].max() > 1000  # rad/s: 95 rad times 12 rad/s
