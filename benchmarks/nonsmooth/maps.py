# SPDX-License-Identifier: BSD-3-Clause
"""Failure maps: all trials in several ways, as a picture, as CSV and as tables."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Mapping, Sequence

from benchmarks.nonsmooth import draw, page
from benchmarks.nonsmooth.judge import Verdict
from benchmarks.nonsmooth.trial import Trial
from benchmarks.page_parts import NonsmoothStudy

from gelenk.chart.progress import status_line

COLUMNS = ("trials", "row", "column", "integrator", "outcome", "error", "events", "exact", "message")


def failure_map[T: Trial](
    study: NonsmoothStudy,
    picture_name: str,
    table_name: str,
    trials: Sequence[T],
    ways: Mapping[str, Callable[[T], Verdict | None]],
) -> dict[str, str]:
    """Return the parts of a page with a failure map: "map", "outcomes" and "findings".

    Args:
        study: where they belong.
        picture_name: file of the picture.
        table_name: file of all verdicts, as CSV.
        trials: the trials.
        ways: functions that run a trial, by the name of an integrator; None: not in this way.
    """
    verdicts: list[Verdict] = []
    with status_line(sys.stderr) as progress:
        for k, trial in enumerate(trials):
            progress(trial.family, k / len(trials))
            verdicts += [v for way in ways.values() if (v := way(trial)) is not None]
    draw.draw_map(verdicts, list(ways), study.pictures / picture_name)
    with (study.numbers / table_name).open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for v in verdicts:
            t = v.trial
            table.writerow(
                [t.family, t.row, t.column, v.integrator, v.outcome, v.error, v.events, t.events, v.words]
            )
    print(f"{picture_name}: {len(verdicts)} runs")
    return {
        "map": f"![outcomes of {len(trials)} trials](pictures/{picture_name})",
        "outcomes": page.outcomes(verdicts, list(ways)),
        "findings": page.findings(verdicts),
    }
