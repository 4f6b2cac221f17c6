# SPDX-License-Identifier: BSD-3-Clause
"""Runs as a CSV file with one line for each."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path

from gelenk.chart.measure import Run
from gelenk.file_writing import write_text

COLUMNS = tuple(field.name for field in fields(Run))
WORDS = ("scene", "method", "formulation", "integrator", "outcome", "reason")


def write(runs: Iterable[Run], path: Path) -> None:
    """Write runs; missing numbers are empty cells. Raises OSError."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for run in runs:
        writer.writerow([_cell(getattr(run, name)) for name in COLUMNS])
    write_text(path, text.getvalue())


def read(path: Path) -> list[Run]:
    """Read runs that `write` has written. Raises OSError."""
    with path.open(encoding="utf-8", newline="") as file:
        return [
            Run(**{k: v if k in WORDS else float(v) if v else math.nan for k, v in row.items()})  # type: ignore[arg-type]
            for row in csv.DictReader(file)
        ]


def _cell(value: str | float) -> str:
    if isinstance(value, str):
        return str(value)
    return "" if math.isnan(value) else repr(float(f"{value:.6g}"))
