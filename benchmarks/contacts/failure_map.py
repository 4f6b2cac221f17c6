# SPDX-License-Identifier: BSD-3-Clause
"""The failure map of contacts in docs/nonsmooth-measurements.md: part of `make nonsmooth`.

Located events are right if errors stay below 100 times the tolerance and the size of the motion; steps with
impulses if they stay below the way that the fastest point makes in two steps.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

from benchmarks.contacts.trial import ContactTrial
from benchmarks.contacts.trials import trials
from benchmarks.nonsmooth import maps
from benchmarks.nonsmooth.judge import Verdict, judged
from benchmarks.page_parts import NonsmoothStudy, quick_parser

from gelenk.errors import SceneWarning, StartWarning

MAKER = "benchmarks/contacts/failure_map.py"
EVALUATIONS = 50_000  # in a communication step; what is right takes some hundreds


@dataclass(frozen=True)
class Way:
    """A way to simulate a trial; step: of steps with impulses [s]; None: located events."""

    name: str
    integrator: str
    step: float | None = None

    def __call__(self, trial: ContactTrial) -> Verdict | None:
        """Run a trial; None where there is no motion, but impulses, with which auto continues, have one."""
        if trial.refused and (self.step is not None or self.integrator == "auto"):
            return None
        solver: dict[str, object] = {"integrator": self.integrator, "max_evaluations": EVALUATIONS}
        if self.step is None:
            return judged(trial, self.name, solver)
        largest = 2 * self.step * trial.speed / trial.bound
        return judged(trial, self.name, solver | {"step": self.step}, largest)


WAYS = (
    Way("auto", "auto"),
    Way("erk", "erk"),
    Way("cvode", "cvode"),
    Way("dirk", "dirk"),
    Way("steps of 10 ms", "moreau-jean", 1e-2),
    Way("steps of 1 ms", "moreau-jean", 1e-3),
)


def main() -> None:
    study = NonsmoothStudy("nonsmooth-measurements.md", quick_parser(__doc__).parse_args().quick)
    for expected in (SceneWarning, StartWarning):
        warnings.simplefilter("ignore", expected)
    chosen = trials()[:: 12 if study.quick else 1]
    ways = {way.name: way for way in WAYS}
    study.put(MAKER, maps.failure_map(study, "contact-map.png", "contact-map.csv", chosen, ways))


if __name__ == "__main__":
    main()
