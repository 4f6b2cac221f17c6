# SPDX-License-Identifier: BSD-3-Clause
"""Runs of the trials and their outcomes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks.nonsmooth.trials import Trial

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


def judged(trial: Trial, integrator: str) -> Verdict:
    """Run a trial."""
    solver: dict[str, object] = {"integrator": integrator, "max_events": EVENTS}
    try:
        plant = gelenk.Simulation(gelenk.load({**trial.scene, "solver": solver}))
        if trial.force:
            plant.set_input(trial.force, trial.forces[0])
        plant.initialize(0.0, TOLERANCE)
        error, instants = 0.0, 0
        for k, t in enumerate(trial.times):
            if trial.force:
                plant.set_input(trial.force, trial.forces[k])
            plant.step_to(t)
            instants += len({time for time, text in plant.events if "singular" not in text})
            found = plant.values(list(trial.exact))
            differences = [abs(x - values[k]) for x, values in zip(found, trial.exact.values(), strict=True)]
            error = max(error, *differences)
    except GelenkError as reason:
        return Verdict(trial, integrator, "refused", words=str(reason))
    error /= trial.bound
    right = error <= BOUND * TOLERANCE
    counted = math.isnan(trial.events) or instants == trial.events
    return Verdict(
        trial, integrator, ("right" if counted else "count") if right else "wrong", error, instants
    )
