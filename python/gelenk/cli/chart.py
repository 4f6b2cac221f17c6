# SPDX-License-Identifier: BSD-3-Clause
"""The commands of `gelenk chart`."""

from __future__ import annotations

import math
import os
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gelenk.chart.progress import status_line
from gelenk.cli import completion
from gelenk.cli.command import Report, command
from gelenk.errors import UsageError
from gelenk.extras import pyplot
from gelenk.file_writing import write_text
from gelenk.model.values import number, unknown

if TYPE_CHECKING:
    from gelenk.chart import stability as stability_study
    from gelenk.chart import work_precision as work_precision_study

app = typer.Typer(
    help="Plot work-precision diagrams and stability maps of the solver methods, the work of cone solvers.",
    no_args_is_help=True,
    rich_markup_mode=None,  # as in the main application
    context_settings={"help_option_names": ["-h", "--help"]},
)

Methods = Annotated[
    list[str] | None,
    typer.Option(
        "--method",
        metavar="NAME",
        help="`auto`, `erk`, `baumgarte+ida`, ...; repeatable; default: all.",
        autocompletion=completion.methods,
    ),
]
Tolerances = Annotated[
    list[float] | None, typer.Option("--tolerance", metavar="X", help="Relative tolerance; repeatable.")
]
Output = Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Output folder.")]
Jobs = Annotated[
    int,
    typer.Option(
        "--jobs",
        min=1,
        show_default=False,
        help="Number of concurrent runs; default: one for each processor, 4 at most.",
    ),
]
Quick = Annotated[bool, typer.Option("--quick", help="Make a few runs only.")]
Limit = Annotated[
    float | None, typer.Option("--limit", metavar="S", help="Wall-clock limit of one run in seconds.")
]

SOME_JOBS = max(1, min(4, os.cpu_count() or 1))  # default number of concurrent runs


@app.command("work-precision")
@command
def work_precision(
    scenes: Annotated[
        list[str],
        typer.Argument(
            metavar="SCENE...", help="Scene files, or scenes of the documentation: four_bar, bricard, ..."
        ),
    ],
    methods: Methods = None,
    tolerances: Tolerances = None,
    inputs: Annotated[
        list[str] | None,
        typer.Option(
            "--input", metavar="NAME=VALUE", help="Constant value of an input; repeatable; default: 0."
        ),
    ] = None,
    output: Output = Path("charts"),
    jobs: Jobs = SOME_JOBS,
    quick: Quick = False,
    limit: Limit = None,
) -> Report:
    """Plot work-precision diagrams.

    They show CPU time and evaluations of every method against its error.
    """
    from gelenk.chart.case import case_of
    from gelenk.chart.methods import chosen
    from gelenk.chart.reference_set import reference_set
    from gelenk.chart.work_precision import QUICK, Settings, study

    pyplot()  # reports missing matplotlib before anything is run
    settings = _changed(QUICK if quick else Settings(), tolerances, jobs, limit)
    values = _values(inputs or [])
    ready = {case.name: case for case in reference_set()}
    cases = [ready[name] if name in ready and not values else case_of(name, values) for name in scenes]
    _require_distinct([case.name for case in cases])
    wanted = chosen(methods)
    with status_line(sys.stderr) as progress:
        studies = study(cases, wanted, settings, progress)
    output.mkdir(parents=True, exist_ok=True)
    reports = [_written(one, output) for one in studies]
    return Report(
        "\n".join(report.text for report in reports), {"studies": [report.data for report in reports]}
    )


def _changed[S: (work_precision_study.Settings, stability_study.Settings)](
    settings: S, tolerances: list[float] | None, jobs: int, limit: float | None
) -> S:
    """Return the settings with the options of the command line.

    Raises:
        UsageError: a tolerance or the limit is out of range.
    """
    if limit is not None and not limit > 0:
        raise UsageError(f"--limit: found {limit}, expected a number greater than 0")
    wrong = [x for x in tolerances or [] if not 0 < x < 1]
    if wrong:
        raise UsageError(f"--tolerance: found {wrong[0]}, expected a number between 0 and 1")
    return replace(
        settings,
        jobs=jobs,
        tolerances=tuple(sorted(set(tolerances), reverse=True)) if tolerances else settings.tolerances,
        limit=settings.limit if limit is None else limit,
    )


def _values(given: list[str]) -> dict[str, float]:
    values = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals):
            raise UsageError(f"--input {text}: expected NAME=VALUE")
        values[name.strip()] = number(name.strip(), value.strip(), "real")
    return values


def _require_distinct(names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{name}: two scenes with this name; their charts would have the same file name")


def _written(one: work_precision_study.Study, folder: Path) -> Report:
    from gelenk.chart import draw_work_precision, runs_csv
    from gelenk.chart.outcome import Outcome
    from gelenk.chart.work_precision import regrets

    name = one.case.name
    table, picture = (folder / f"work-precision-{name}.{ending}" for ending in ("csv", "png"))
    runs_csv.write(one.runs, table)
    draw_work_precision.draw(one, picture)
    count = Counter(str(run.outcome) for run in one.runs)
    counts = ", ".join(f"{count[outcome]} {outcome}" for outcome in Outcome if count[outcome])
    lines = [
        f"{name}: {len(one.runs)} runs, {counts}; reference {one.reference.words}",
        f"  {table}, {picture}",
    ]
    for regret in regrets(one.runs):
        cpu = "not finished" if math.isnan(regret.cpu) else f"{1e3 * regret.cpu:.3g} ms"
        best = "none" if math.isnan(regret.best_cpu) else f"{regret.best} {1e3 * regret.best_cpu:.3g} ms"
        lines.append(f"  tolerance {regret.tolerance:.0e}: auto {regret.outcome}, {cpu}; best {best}")
    data = {
        "name": name, "runs": len(one.runs), "outcomes": dict(count), "reference": one.reference.words,
        "files": [str(table), str(picture)],
    }  # fmt: skip
    return Report("\n".join(lines), data)


@app.command("stability")
@command
def stability(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Scenes of the map; default: all.")
    ] = None,
    methods: Methods = None,
    tolerances: Tolerances = None,
    output: Output = Path("charts"),
    jobs: Jobs = SOME_JOBS,
    quick: Quick = False,
    limit: Limit = None,
) -> Report:
    """Plot a stability map.

    It is a colored table with the outcome of every method on every scene.
    """
    from gelenk.chart import draw_stability, runs_csv, tables
    from gelenk.chart import stability as stability_study
    from gelenk.chart.methods import chosen
    from gelenk.chart.scenes import stability_cases

    pyplot()  # reports missing matplotlib before anything is run
    known = [case.name for case in stability_cases()]
    faults = [unknown(name, "scene of the map", known) for name in scenes or [] if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    settings = _changed(
        stability_study.QUICK if quick else stability_study.Settings(), tolerances, jobs, limit
    )
    wanted = chosen(methods) if methods else stability_study.natural_methods()
    with status_line(sys.stderr) as progress:
        found = stability_study.stability(wanted, settings, scenes, progress)
    output.mkdir(parents=True, exist_ok=True)
    table, page = output / "stability.csv", output / "stability.md"
    runs_csv.write(found.runs, table)
    write_text(page, tables.stability(found, settings.tolerances))
    pictures = []
    for tolerance in settings.tolerances:
        pictures.append(output / f"stability-{tolerance:.0e}.png".replace("e-0", "e-"))
        draw_stability.draw(found, tolerance, pictures[-1])
    files = [str(path) for path in (table, page, *pictures)]
    outcomes = dict(Counter(str(run.outcome) for run in found.runs))
    return Report(
        f"{tables.counts(found)}\n{', '.join(files)}",
        {"runs": len(found.runs), "outcomes": outcomes, "files": files},
    )


@app.command("cones")
@command
def cones(
    solvers: Annotated[
        list[str] | None,
        typer.Argument(metavar="[SOLVER]...", help="`hybrid`, `p-spg-fb`, ...; default: all."),
    ] = None,
    exact_coulomb: Annotated[
        bool, typer.Option("--coulomb", help="Solve Coulomb's law instead of the convex problems.")
    ] = False,
    output: Output = Path("charts"),
    quick: Annotated[bool, typer.Option("--quick", help="Solve 24 of the problems.")] = False,
) -> Report:
    """Plot the work of the cone solvers against their residual.

    They solve a hundred problems of frictional contact with known solutions, and 24 that are recorded from
    scenes: heaps of spheres, walls of boxes, boxes on a linkage.
    """
    from gelenk.chart import cones as cone_study
    from gelenk.chart import draw_cones
    from gelenk.chart.cone_problems import COUNT
    from gelenk.chart.recorded_cones import recorded_scenes

    pyplot()  # reports missing matplotlib before anything is run
    with status_line(sys.stderr) as progress:
        numbers, scenes = range(COUNT), recorded_scenes()
        if quick:
            numbers, scenes = numbers[:12], scenes[::2]
        runs = cone_study.study(solvers, numbers, exact_coulomb, scenes, progress)
    output.mkdir(parents=True, exist_ok=True)
    name = "cones-coulomb" if exact_coulomb else "cones"
    table, picture = output / f"{name}.csv", output / f"{name}.png"
    cone_study.write(runs, table)
    draw_cones.draw(runs, picture, exact_coulomb)
    return Report(
        f"{cone_study.table(runs)}\n{table}, {picture}",
        {"runs": len(runs), "files": [str(table), str(picture)]},
    )
