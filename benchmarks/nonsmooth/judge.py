# SPDX-License-Identifier: BSD-3-Clause
"""Runs of the trials and their outcomes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from benchmarks.nonsmooth.trial import Trial

import gelenk
from gelenk.errors import GelenkError

TOLERANCE = 1e-8
BOUND = 100  # times the tolerance and the scale of the motion
PARADOX = ("no motion, or more than one", "no contact forces were found")  # in messages
EVENTS = 1000  # in a communication step; no trial has more than some tens


@dataclass(frozen=True)
class Verdict:
    """The outcome of a trial: "right", "wrong", "count" (right, but another number of events), "refused"."""

    trial: Trial
    integrator: str
    outcome: str
    error: float = math.nan  # over the scale of the motion
    events: float = math.nan  # instants
    words: str = ""


def _set_slope(plant: gelenk.Simulation, trial: Trial, k: int) -> None:
    if trial.slopes:
        plant.set_input_derivative(trial.force, 1, trial.slopes[k])


def judged(
    trial: Trial,
    integrator: str,
    solver: Mapping[str, object] | None = None,
    largest: float = BOUND * TOLERANCE,
) -> Verdict:
    """Run a trial.

    Args:
        trial: the trial.
        integrator: what the verdict says.
        solver: more fields of the scene's section `solver`.
        largest: error of a run that is right, over the scale of the motion.
    """
    solver = {"integrator": integrator, "max_events": EVENTS, **(solver or {})}
    try:
        plant = gelenk.Simulation(gelenk.load({**trial.scene, "solver": solver}))
        if trial.force:
            plant.set_input(trial.force, trial.forces[0])
            _set_slope(plant, trial, 0)
        plant.initialize(0.0, TOLERANCE)
        error, instants = 0.0, 0
        for k, t in enumerate(trial.times):
            if trial.force:
                plant.set_input(trial.force, trial.forces[k])
                _set_slope(plant, trial, k)
            plant.step_to(t)
            instants += len({time for time, text in plant.events if "singular" not in text})
            if trial.refused:
                continue
            found = plant.values(list(trial.exact))
            differences = [abs(x - values[k]) for x, values in zip(found, trial.exact.values(), strict=True)]
            error = max(error, *differences)
    except GelenkError as reason:
        told = trial.refused and any(words in str(reason) for words in PARADOX)
        return Verdict(trial, integrator, "right" if told else "refused", words=str(reason))
    if trial.refused:
        return Verdict(trial, integrator, "wrong", math.inf, words="not refused")
    error /= trial.bound
    right = error <= largest
    counted = math.isnan(trial.events) or instants == trial.events
    return Verdict(
        trial, integrator, ("right" if counted else "count") if right else "wrong", error, instants
    )
