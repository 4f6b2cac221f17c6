# SPDX-License-Identifier: BSD-3-Clause
"""Runs of the trials and their outcomes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks.nonsmooth.trial import Trial

import gelenk
from gelenk.errors import GelenkError

TOLERANCE = 1e-8
BOUND = 100  # times the tolerance and the scale of the motion
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


def judged(trial: Trial, integrator: str) -> Verdict:
    """Run a trial."""
    solver: dict[str, object] = {"integrator": integrator, "max_events": EVENTS}
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
        told = trial.refused and "no motion, or more than one" in str(reason)
        return Verdict(trial, integrator, "right" if told else "refused", words=str(reason))
    if trial.refused:
        return Verdict(trial, integrator, "wrong", math.inf, words="not refused")
    error /= trial.bound
    right = error <= BOUND * TOLERANCE
    counted = math.isnan(trial.events) or instants == trial.events
    return Verdict(
        trial, integrator, ("right" if counted else "count") if right else "wrong", error, instants
    )
