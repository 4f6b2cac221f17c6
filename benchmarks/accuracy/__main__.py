# SPDX-License-Identifier: BSD-3-Clause
"""Measure the error of adaptive integrators relative to the tolerance, for docs/accuracy.md: `make accuracy`.

The runs of each scene are written to out/accuracy/NAME.csv; scenes with such a file are not run again.
`--fresh` deletes the files; `--page` makes the tables from the files without running anything.
`--quick` runs a small part and writes to out/accuracy-quick/ only, as a test.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from functools import partial
from pathlib import Path

from benchmarks.accuracy import page, scenes
from benchmarks.accuracy.runs import Settings, runs_of
from benchmarks.page_parts import put

from gelenk.chart import runs_csv
from gelenk.chart.progress import status_line

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "accuracy.md"
MAKER = "benchmarks/accuracy"


def asked() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--fresh", action="store_true")
    parser.add_argument("--page", action="store_true", help="update the page without running anything")
    parser.add_argument("--scenes", help="comma-separated names; default: all")
    parser.add_argument("--integrators", help="comma-separated names; default: all")
    parser.add_argument("--every", type=int, default=1, help="run one of so many runs, evenly distributed")
    parser.add_argument("--jobs", type=int, default=2)
    return parser.parse_args()


def sampled(count: int, found: list[scenes.Plant]) -> str:
    """Return the number of runs, and of how many they are a sample."""
    ways = 2 * len(Settings.integrators) * len(Settings.tolerances)  # saved or not
    whole = ways * sum(len(list(plant.cases())) for plant in found)
    part = "" if count == whole else f", a sample of {whole}"
    return f"{count} runs of {len(found)} scenes{part}."


def main() -> None:
    given = asked()
    numbers = ROOT / "out" / ("accuracy-quick" if given.quick else "accuracy")
    if given.fresh:
        shutil.rmtree(numbers, ignore_errors=True)
    numbers.mkdir(parents=True, exist_ok=True)
    names = given.scenes.split(",") if given.scenes else list(scenes.QUICK) if given.quick else None
    settings = Settings(every=10 * given.every if given.quick else given.every, jobs=given.jobs)
    if given.integrators:
        settings = Settings(
            integrators=tuple(given.integrators.split(",")), every=given.every, jobs=given.jobs
        )
    plants = scenes.chosen(names)
    for plant in [] if given.page else plants:
        file = numbers / f"{plant.name}.csv"
        if file.exists():
            continue
        with status_line(sys.stderr) as progress:
            runs = runs_of(plant, settings, partial(progress, plant.name))
        runs_csv.write(runs, file)
        wrong = sum(run.outcome == "wrong" for run in runs)
        print(f"{file.relative_to(ROOT)}: {len(runs)} runs, {wrong} wrong", flush=True)
    found = [plant for plant in plants if (numbers / f"{plant.name}.csv").exists()]
    runs = [run for plant in found for run in runs_csv.read(numbers / f"{plant.name}.csv")]
    parts = {
        "tolerances": page.by_tolerance(runs) + "\n" + sampled(len(runs), found),
        "ways": page.by_way(runs),
        "outliers": page.outliers(runs),
        "scenes": page.scenes(runs, [scenes.described(plant) for plant in found]),
    }
    target = numbers / "accuracy.md" if given.quick else PAGE
    put(target, MAKER, parts)
    print(f"{target.relative_to(ROOT)}: {len(runs)} runs of {len(found)} scenes")


if __name__ == "__main__":
    main()
