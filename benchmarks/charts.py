# SPDX-License-Identifier: BSD-3-Clause
"""Make the charts and tables of docs/work-precision.md and docs/stability.md: `make charts`.

Pictures are written to docs/pictures/, all figures as CSV to out/charts/. The text between the markers of a
page is replaced; the rest, including the discussion of each chart, is written by hand.

`--quick` runs a small part of everything and writes to out/charts/ only, as a test. With `--only` and
`--scenes`, a part is measured; rows of other scenes remain in the table of `auto`.
"""

from __future__ import annotations

import argparse
import math
import platform
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks import draw_poles, poles
from benchmarks.page_parts import merged_tables, part, put

from gelenk.chart import draw_stability, draw_work_precision, master, published, runs_csv, stability, tables
from gelenk.chart import work_precision as wp
from gelenk.chart.case import Case
from gelenk.chart.methods import all_methods
from gelenk.chart.outcome import Outcome
from gelenk.chart.progress import status_line
from gelenk.chart.reference_set import reference_set

ROOT = Path(__file__).resolve().parent.parent
NUMBERS = ROOT / "out" / "charts"
MAKER = "benchmarks/charts.py"
QUICK_SCENES = ("four_bar", "andrews", "speed-drive")


def machine() -> str:
    """Return a description of the machine."""
    return f"{platform.machine().replace('_', '-')}, Python {platform.python_version()}"


def milliseconds(cpu: float) -> str:
    return "not finished" if math.isnan(cpu) else f"{1e3 * cpu:.3g}"


def regret_table(regrets: Sequence[wp.Regret]) -> str:
    """Return the CPU time of `auto` and its ratio to the best method, by scene and tolerance."""
    tolerances = list(dict.fromkeys(r.tolerance for r in regrets))
    header = ["scene"]
    for tolerance in tolerances:
        header += [f"`auto` at {tolerance:.0e} [ms]", "best", "ratio", "ratio incl. fixed steps"]
    lines = []
    for scene in dict.fromkeys(r.scene for r in regrets):
        cells = [scene]
        for tolerance in tolerances:
            r = next(r for r in regrets if r.scene == scene and r.tolerance == tolerance)
            outcome = "" if r.outcome == Outcome.GOOD else f" {r.outcome}"
            cells += [milliseconds(r.cpu) + outcome, r.best, ratio(r.ratio), ratio(r.ratio_of_all)]
        lines.append(cells)
    return tables.rows(header, lines)


def ratio(x: float) -> str:
    return "" if math.isnan(x) else f"{x:.2f}" if x <= 2 else f"**{x:.2f}**"


def study_part(study: wp.Study, picture: Path) -> str:
    """Return a chart with the description of its scene and the outcomes of its runs."""
    counts = Counter(run.outcome for run in study.runs)
    outcomes = ", ".join(f"{counts[o]} {o}" for o in Outcome if counts[o])
    name = study.case.name
    return (
        f"![{name}: CPU time and evaluations against error](pictures/{picture.name})\n\n"
        f"{study.case.about} {study.case.stop:g} s, {len(study.runs)} runs: {outcomes}.\n"
        f"Reference: {study.reference.words}."
    )


def orders_table(cases: Sequence[Case], settings: wp.Settings) -> str:
    """Return the observed orders of the methods with fixed steps over the first 5 % of each case."""
    methods = [method for method in all_methods() if method.fixed_step]
    short = [replace(c, stop=c.stop / 20, step=c.stop / 20, published=(), truth=None) for c in cases]
    studies = wp.study(short, methods, replace(settings, rounds=0))
    lines = []
    for study in studies:
        runs = [[r for r in study.runs if r.method == method.name] for method in methods]
        orders = [wp.observed_order(mine) for mine in runs]
        lines.append([study.case.name, *("" if math.isnan(x) else f"{x:.2f}" for x in orders)])
    return tables.rows(["scene", *(method.name for method in methods)], lines)


def work_precision(pictures: Path, jobs: int, quick: bool, scenes: Sequence[str]) -> dict[str, str]:
    """Return the parts of docs/work-precision.md on these scenes; none: on all, or the quick selection."""
    wanted = scenes or (QUICK_SCENES if quick else ())
    cases = [case for case in reference_set() if case.name in wanted or not wanted]
    settings = replace(wp.QUICK, jobs=jobs) if quick else wp.Settings(jobs=jobs)
    parts, studies = {}, []
    for case in cases:
        with status_line(sys.stderr) as progress:
            (study,) = wp.study([case], all_methods(), settings, progress)
        studies.append(study)
        runs_csv.write(study.runs, NUMBERS / f"work-precision-{study.case.name}.csv")
        picture = pictures / f"work-precision-{study.case.name}.png"
        draw_work_precision.draw(study, picture)
        parts[study.case.name] = study_part(study, picture)
        print(f"{picture.relative_to(ROOT)}: {len(study.runs)} runs", flush=True)
    regrets = wp.regrets([run for study in studies for run in study.runs])
    parts["regret"] = (
        regret_table(regrets) + f"\nCPU time of the steps, minimum of {settings.rounds} rounds; {machine()}."
    )
    parts["orders"] = orders_table(cases if quick else reference_set(), settings)
    return parts


def masters(jobs: int, quick: bool) -> dict[str, str]:
    """Return the cost per communication step and the comparison with published figures."""
    case = master.master_case()
    case = replace(case, stop=0.2) if quick else case
    runs, reference = master.master_runs(all_methods(), jobs=jobs, case=case)
    runs_csv.write(runs, NUMBERS / "master.csv")
    steps = len(case.grid) - 1
    cpu, error = master.ida_fraction(runs, 1e-6)
    text = (
        master.master_table(runs, steps)
        + f"\nPer communication step of 1 ms, {steps} steps; {machine()}. At 1e-6 `auto` takes {cpu:.2f} of "
        f"the CPU time of projection+ida with {error:.1e} of its error. Reference: {reference.words}."
    )
    andrews = published.andrews_table(published.andrews_efforts())
    pole = published.cart_pole_table(published.cart_pole_efforts(0.01), published.cart_pole_efforts(0.5))
    return {"master": text, "published-andrews": andrews, "published-light-cart-pole": pole}


def stability_map(pictures: Path, jobs: int, quick: bool) -> dict[str, str]:
    """Return the parts of docs/stability.md."""
    settings = replace(stability.QUICK if quick else stability.Settings(), jobs=jobs)
    with status_line(sys.stderr) as progress:
        found = stability.stability(stability.natural_methods(), settings, None, progress)
    runs_csv.write(found.runs, NUMBERS / "stability.csv")
    parts = {}
    for tolerance in settings.tolerances:
        label = f"{tolerance:.0e}".replace("e-0", "e-")
        picture = pictures / f"stability-{label}.png"
        draw_stability.draw(found, tolerance, picture)
        parts[f"map-{label}"] = f"![methods against scenes at {label}](pictures/{picture.name})"
    parts["tables"] = tables.stability(found, settings.tolerances)
    parts["scenes"] = tables.rows(
        ["scene", "description", "reference"],
        [[case.name, case.about, found.words[case.name]] for case in found.cases],
    )
    parts["words"] = tables.reasons(found)
    return parts


def pole_maps(pictures: Path, jobs: int, quick: bool) -> dict[str, str]:
    """Return the maps of stiff poles in docs/stability.md."""
    parts = {}
    for name, jumps in (("poles", False), ("poles-jumps", True)):
        settings = replace(poles.QUICK if quick else poles.Settings(), jumps=jumps, jobs=jobs)
        with status_line(sys.stderr) as progress:
            found = poles.pole_map(settings, partial(progress, name))
        runs_csv.write(found.runs, NUMBERS / f"stability-{name}.csv")
        picture = pictures / f"stability-{name}.png"
        draw_poles.draw(found, picture)
        text = "with a voltage that jumps" if jumps else "at a constant voltage"
        parts[name] = f"![methods against time constants of the armature, {text}](pictures/{picture.name})"
    return parts


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", choices=["work-precision", "master", "stability", "poles"])
    parser.add_argument(
        "--scenes", nargs="+", default=[], help="of the work-precision diagrams; default: all"
    )
    given = parser.parse_args()
    pictures = NUMBERS if given.quick else ROOT / "docs" / "pictures"
    for folder in (NUMBERS, pictures):
        folder.mkdir(parents=True, exist_ok=True)
    pages: dict[str, dict[str, str]] = {"work-precision.md": {}, "stability.md": {}}
    if given.only in (None, "work-precision"):
        pages["work-precision.md"] |= work_precision(pictures, given.jobs, given.quick, given.scenes)
    if given.only in (None, "master"):
        pages["work-precision.md"] |= masters(given.jobs, given.quick)
    if given.only in (None, "stability"):
        pages["stability.md"] |= stability_map(pictures, given.jobs, given.quick)
    if given.only in (None, "poles"):
        pages["stability.md"] |= pole_maps(pictures, given.jobs, given.quick)
    for name, parts in pages.items():
        page = ROOT / "docs" / name
        if given.quick:
            page = NUMBERS / name
            page.write_text("", encoding="utf-8")
        if given.scenes and "regret" in parts:
            parts["regret"] = merged_tables(part(page, MAKER, "regret"), parts["regret"])
        put(page, MAKER, parts, "\n*Not discussed yet.*\n")
        print(f"{page.relative_to(ROOT)}: {len(parts)} parts updated")


if __name__ == "__main__":
    main()
