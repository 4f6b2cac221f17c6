# SPDX-License-Identifier: BSD-3-Clause
"""Measure dry friction and hard limits for docs/nonsmooth-measurements.md: `make nonsmooth`.

Pictures are written to docs/pictures/, all figures as CSV to out/nonsmooth/. MuJoCo and EXUDYN run if
they are installed. `--quick` runs a small part of everything and writes to out/nonsmooth/ only, as a test.
"""

from __future__ import annotations

import csv
import dataclasses
import warnings
from collections.abc import Callable
from functools import partial

from benchmarks.nonsmooth import (
    draw,
    engines,
    judge,
    laws,
    loaded_problems,
    loaded_trials,
    maps,
    page,
    problems,
    runs,
    trials,
)  # fmt: skip
from benchmarks.nonsmooth.trial import Trial
from benchmarks.page_parts import NonsmoothStudy, quick_parser

from gelenk.errors import SceneWarning, StartWarning

MAKER = "benchmarks/nonsmooth"
INTEGRATORS = ("auto", "cvode", "ida", "dirk")  # of the map; fixed steps have no tolerance


@dataclasses.dataclass(frozen=True)
class Part:
    """Problems and trials of a section of the page; `suffix` of its parts, pictures and files."""

    problems: Callable[[], list[problems.Problem]]
    trials: Callable[[], list[Trial]]
    suffix: str = ""

    def named(self, name: str) -> str:
        """Return the name of one of its parts."""
        return f"{name}-{self.suffix}" if self.suffix else name


PARTS = {
    "friction": Part(problems.problems, trials.trials),
    "loads": Part(loaded_problems.loaded_problems, loaded_trials.trials, "loads"),
}


def charts(study: NonsmoothStudy, part: Part) -> dict[str, str]:
    """Return the parts of the page with the work-precision diagrams."""
    parts, found, chosen = {}, [], part.problems()
    for problem in chosen:
        mine = [
            *runs.event_driven(problem, study.quick),
            *laws.regularized(problem, study.quick),
            *engines.engines(problem, study.quick),
        ]
        picture = study.pictures / f"friction-{problem.name}.png"
        draw.draw(problem, mine, picture)
        parts[problem.name] = page.chart(problem, mine, picture.name)
        print(f"{picture.name}: {len(mine)} runs", flush=True)
        found += mine
    with (study.numbers / f"{part.named('runs')}.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, [field.name for field in dataclasses.fields(runs.Run)])
        table.writeheader()
        table.writerows(dataclasses.asdict(run) for run in found)
    return parts | {part.named("goals"): page.goals(chosen, found)} if not study.quick else parts


def failure_map(study: NonsmoothStudy, part: Part) -> dict[str, str]:
    """Return the parts of the page with the failure map."""
    chosen = part.trials()[:: 25 if study.quick else 1]
    integrators = INTEGRATORS[:2] if study.quick else INTEGRATORS
    ways = {name: partial(judge.judged, integrator=name) for name in integrators}
    found = maps.failure_map(
        study, f"friction-{part.named('map')}.png", f"{part.named('map')}.csv", chosen, ways
    )
    return {part.named(name): text for name, text in found.items()}


def main() -> None:
    parser = quick_parser(__doc__)
    parser.add_argument("--only", choices=["charts", "map"])
    parser.add_argument("--part", choices=PARTS)
    given = parser.parse_args()
    study = NonsmoothStudy("nonsmooth-measurements.md", given.quick)
    for expected in (SceneWarning, StartWarning):  # tolerances below those that ida and cvode achieve
        warnings.simplefilter("ignore", expected)
    warnings.filterwarnings("ignore", "lsoda", UserWarning)
    parts: dict[str, str] = {}
    for name, part in PARTS.items():
        if given.part not in (None, name):
            continue
        if given.only in (None, "charts"):
            parts |= charts(study, part)
        if given.only in (None, "map"):
            parts |= failure_map(study, part)
    study.put(MAKER, parts)


if __name__ == "__main__":
    main()
