# SPDX-License-Identifier: BSD-3-Clause
"""The failure map of contacts in docs/contact.md: `python -m benchmarks.contacts.failure_map`.

Located events are right if errors stay below 100 times the tolerance and the size of the motion; steps with
impulses if they stay below the way that the fastest point makes in two steps.
"""

from __future__ import annotations

import csv
import math
import sys
import warnings
from dataclasses import dataclass
from typing import Any

from benchmarks.contacts.trial import ContactTrial
from benchmarks.contacts.trials import trials
from benchmarks.nonsmooth.draw import draw_map
from benchmarks.nonsmooth.judge import BOUND, TOLERANCE, Verdict
from benchmarks.nonsmooth.page import findings, outcomes
from benchmarks.page_parts import NonsmoothStudy, quick_parser

import gelenk
from gelenk.chart.progress import status_line
from gelenk.errors import GelenkError, SceneWarning, StartWarning

MAKER = "benchmarks/contacts/failure_map.py"
EVALUATIONS = 50_000  # in a communication step; what is right takes some hundreds
EVENTS = 1000


@dataclass(frozen=True)
class Way:
    """A way to simulate a trial; step: of steps with impulses [s]; None: located events."""

    name: str
    integrator: str
    step: float | None = None

    def solver(self) -> dict[str, Any]:
        """Return the section `solver` of a scene."""
        step = {} if self.step is None else {"step": self.step}
        return {"integrator": self.integrator, "max_evaluations": EVALUATIONS, "max_events": EVENTS, **step}

    def bound(self, trial: ContactTrial) -> float:
        """Return the largest error of a run that is right [m]."""
        return BOUND * TOLERANCE * trial.bound if self.step is None else 2 * self.step * trial.speed


WAYS = (
    Way("auto", "auto"),
    Way("erk", "erk"),
    Way("cvode", "cvode"),
    Way("dirk", "dirk"),
    Way("steps of 10 ms", "moreau-jean", 1e-2),
    Way("steps of 1 ms", "moreau-jean", 1e-3),
)


def judged(trial: ContactTrial, way: Way) -> Verdict:
    """Run a trial. One without an exact solution has none, and is right if it is refused."""
    try:
        plant = gelenk.Simulation(gelenk.load({**trial.scene, "solver": way.solver()}))
        plant.initialize(0.0, TOLERANCE)
        error = 0.0
        for k, t in enumerate(trial.times):
            plant.step_to(t)
            found = plant.values(list(trial.exact))
            differences = [abs(x - values[k]) for x, values in zip(found, trial.exact.values(), strict=True)]
            error = max([error, *differences])
    except GelenkError as reason:
        return Verdict(trial, way.name, "refused" if trial.exact else "right", words=str(reason))
    if not trial.exact:
        return Verdict(trial, way.name, "wrong", math.inf)
    outcome = "right" if error <= way.bound(trial) else "wrong"
    return Verdict(trial, way.name, outcome, error / trial.bound)


def main() -> None:
    study = NonsmoothStudy("contact.md", quick_parser(__doc__).parse_args().quick)
    for expected in (SceneWarning, StartWarning):
        warnings.simplefilter("ignore", expected)
    chosen = trials()[:: 12 if study.quick else 1]
    verdicts = []
    with status_line(sys.stderr) as progress:
        for k, trial in enumerate(chosen):
            progress(trial.family, k / len(chosen))
            verdicts += [judged(trial, way) for way in WAYS]
    names = [way.name for way in WAYS]
    picture = study.pictures / "contact-map.png"
    draw_map(verdicts, names, picture)
    with (study.numbers / "contact-map.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["trials", "row", "column", "integrator", "outcome", "error", "message"])
        for v in verdicts:
            table.writerow(
                [v.trial.family, v.trial.row, v.trial.column, v.integrator, v.outcome, v.error, v.words]
            )
    shown = f"![outcomes of {len(chosen)} trials](pictures/{picture.name})"
    parts = [shown, outcomes(verdicts, names), findings(verdicts)]
    study.put(MAKER, {"map": "\n\n".join(parts)})


if __name__ == "__main__":
    main()
