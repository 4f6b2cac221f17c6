# SPDX-License-Identifier: BSD-3-Clause
"""The `gelenk` command. Errors that a user can cause are lines on stderr, with exit code 1.

Modules for computations are imported by the commands that need them, so that help is printed at once.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import gelenk
from gelenk.cli import analysis, pictures
from gelenk.cli.arguments import (
    AssemblyTolerance,
    InputTable,
    ParametersAndInputs,
    check_output_file,
    load_scene,
    parse_parameters,
    parse_settings,
    split_all_names,
)
from gelenk.cli.chart import app as chart_app
from gelenk.cli.errors import report_user_errors
from gelenk.cli.progress import progress_bar
from gelenk.errors import StepError, UsageError
from gelenk.model.defaults import STARTS

if TYPE_CHECKING:
    from gelenk.simulation.result import Result

app = typer.Typer(
    help="Check, simulate, analyze and export mechanisms described by scene files.",
    no_args_is_help=True,
    rich_markup_mode=None,  # "[s]" in a help text would be taken for markup
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(chart_app, name="chart")

Without = Annotated[
    list[str] | None,
    typer.Option("--without", metavar="NAME", help="Switch off a reduction, or `all`; repeatable."),
]
Outputs = Annotated[
    list[str] | None,
    typer.Option("--outputs", metavar="NAME", help="Requested output, or a pattern: 'crank.*'; repeatable."),
]
SceneFile = Annotated[str, typer.Argument(metavar="SCENE", help="Scene file: .yaml, .yml or .json.")]


def _version(asked: bool) -> None:
    if asked:
        print(f"gelenk {gelenk.__version__}")
        raise typer.Exit


@app.callback()
def main_options(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Check, simulate, analyze and export mechanisms described by scene files."""


@app.command()
@report_user_errors
def export(
    scene: SceneFile,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="X.fmu", help="FMU file; default: NAME.fmu in this folder."),
    ] = None,
    without: Without = None,
    platforms: Annotated[
        str, typer.Option(metavar="LIST", help="Platforms: linux64, win64 or both, separated by a comma.")
    ] = "linux64",
    outputs: Outputs = None,
    assembly_tolerance: AssemblyTolerance = None,
) -> None:
    """Export a scene as an FMU (FMI 2.0 co-simulation).

    Missing platforms are reported on stderr.
    """
    from gelenk.io.export import file_name_notes, fmu_file, missing_platforms

    wanted = [name.strip() for name in platforms.split(",")]
    missing = missing_platforms(wanted)
    available = [name for name in wanted if name not in missing]
    loaded = load_scene(scene, assembly_tolerance).without(without or [])
    # If none is available, the export reports the reason.
    out = gelenk.export_fmu(
        loaded, output or fmu_file(loaded.name), available or wanted, split_all_names(outputs)
    )
    for sentence in [*missing.values(), *file_name_notes(loaded.name, output)]:
        print(sentence, file=sys.stderr)
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB, {loaded.name}")


@app.command()
@report_user_errors
def check(scene: SceneFile, assembly_tolerance: AssemblyTolerance = None) -> None:
    """Check a scene, close its loops, and print its size."""
    plant = gelenk.Simulation(load_scene(scene, assembly_tolerance))
    plant.initialize()
    size = plant.size
    algebra = "planar" if size.planar else "spatial"
    print(f"{plant.scene!r}")
    n = size.degrees_of_freedom
    dof = "1 degree of freedom" if n == 1 else f"{n} degrees of freedom"
    equations = _count(size.constraint_equations, "constraint equation")
    if size.constraint_equations:
        equations += f" of rank {size.rank}"
    print(f"{dof}: {_count(size.velocities, 'velocity')}, {equations}, "
          f"{_count(size.bodies, 'moving body')}, {algebra}")  # fmt: skip
    print(f"inputs: {', '.join(s.name for s in plant.inputs) or 'none'}")
    report = plant.assembly_report()
    if report:
        print(report)


@app.command()
@report_user_errors
def inspect(
    scene: SceneFile,
    without: Without = None,
    outputs: Outputs = None,
    assembly_tolerance: AssemblyTolerance = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Print the reductions of a model and their effects.

    For each reduction, the cost of an evaluation with and without it is measured.
    """
    report = gelenk.inspect(load_scene(scene, assembly_tolerance), without or [], split_all_names(outputs))
    print(json.dumps(report.to_dict(), indent=2) if as_json else report)


@app.command()
@report_user_errors
def assemblies(
    scene: SceneFile,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A parameter; repeatable.")
    ] = None,
    bodies: Annotated[
        list[str] | None,
        typer.Option(
            "--body", metavar="NAME", help="Distinguish branches by the pose of this body only; repeatable."
        ),
    ] = None,
    starts: Annotated[int, typer.Option(help="Maximum number of searches for each island.")] = STARTS,
    take: Annotated[
        int | None,
        typer.Option("--take", metavar="NUMBER", help="Write the scene in this branch to --output."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="SCENE", help="Scene file for --take.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List the branches in which a scene can be assembled.

    Fixed start values are kept; the branch nearest to the initial guesses is listed first.
    """
    source = gelenk.load(Path(scene)).with_parameters(parse_settings(settings or []))
    found = gelenk.assemblies(source, bodies=bodies or [], starts=starts)
    if (take is None) != (output is None):
        raise UsageError("--take and --output: found one of them, expected both or none")
    if take is None or output is None:
        print(json.dumps(found.to_dict(), indent=2) if as_json else found)
        return
    if not 1 <= take <= len(found):
        raise UsageError(f"--take {take}: expected 1 to {len(found)}")
    found[take - 1].apply_to(source).save(output)
    print(f"{output}: branch {take} of {len(found)}")


@app.command("import")
@report_user_errors
def import_(
    robot: Annotated[Path, typer.Argument(metavar="ROBOT.urdf", help="URDF robot description.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="SCENE", help="Scene file: .yaml, .yml or .json.")
    ],
    floating: Annotated[bool, typer.Option("--floating", help="Let the root link move freely.")] = False,
    repair_inertia: Annotated[
        bool,
        typer.Option(
            "--repair-inertia", help="Replace physically impossible inertias by the nearest possible ones."
        ),
    ] = False,
    limits: Annotated[
        bool, typer.Option("--limits/--no-limits", help="Convert limits of position to hard limits.")
    ] = True,
    assembly_tolerance: AssemblyTolerance = None,
) -> None:
    """Convert a URDF robot description to a scene.

    What is not converted is listed on stderr.
    """
    scene = gelenk.import_urdf(
        robot, floating=floating, repair_inertia=repair_inertia, limits=limits,
        assembly_tolerance=assembly_tolerance,
    )  # fmt: skip
    scene.save(output)
    for line in scene.report:
        print(line, file=sys.stderr)
    print(f"{output}: {scene!r}")


@app.command()
@report_user_errors
def simulate(
    plant: Annotated[Path, typer.Argument(metavar="SCENE|FMU", help="Scene file or .fmu file.")],
    stop: Annotated[float | None, typer.Option(help="End of the simulation [s].")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s].")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative tolerance of the integrator.")] = None,
    integrator: Annotated[
        str | None,
        typer.Option(
            help="Integrator: auto, ida, erk, rk4, generalized-alpha, ...: see docs/scene-format.md."
        ),
    ] = None,
    formulation: Annotated[
        str | None,
        typer.Option(
            help="Constraint formulation: projection, baumgarte, index3, ...: see docs/scene-format.md."
        ),
    ] = None,
    inputs: InputTable = None,
    settings: ParametersAndInputs = None,
    assembly_tolerance: AssemblyTolerance = None,
    without: Without = None,
    outputs: Outputs = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Results: .csv, .parquet, .nc or .mat; - for CSV on stdout.",
        ),
    ] = None,
) -> None:
    """Simulate a scene or an FMU.

    Without --output, the range of every output is printed.
    """
    check_output_file(output)
    try:
        with progress_bar(sys.stderr) as progress:
            result = gelenk.simulate(
                plant, stop=stop, step=step, tolerance=tolerance, integrator=integrator,
                formulation=formulation, inputs=inputs,
                parameters=parse_parameters(settings or [], assembly_tolerance),
                outputs=split_all_names(outputs), without=without or [], progress=progress,
            )  # fmt: skip
    except StepError as e:
        if e.result is not None and output is not None:
            _write(e.result, output)
        raise
    _write(result, output)
    _report_singular_crossings(result)


analysis.register(app)
pictures.register(app)


def _report_singular_crossings(result: Result) -> None:
    if not result.singular_positions:
        return
    times = ", ".join(f"{t:g}" for t in result.singular_positions[:5])
    more = len(result.singular_positions) - 5
    print(
        f"crossed singular configurations, where motion on another branch is possible, before t = {times}"
        f"{f' and {more} more' if more > 0 else ''} s",
        file=sys.stderr,
    )


def _write(result: Result, output: Path | None) -> None:
    if output is None:
        _summary(result)
    elif str(output) == "-":
        print(result.csv(), end="")
    else:
        result.save(output)
        print(f"{output}: {len(result)} rows, {len(result.names)} outputs, to {result.time[-1]:g} s")


def _summary(result: Result) -> None:
    print(f"0 to {result.time[-1]:g} s, {len(result)} rows; --output FILE.csv writes them")
    if not result.names:
        return
    width = max(map(len, result.names))
    print(f"{'':{width}}  {'start':>12} {'min':>12} {'max':>12} {'end':>12}")
    for name in result.names:
        x = result[name]
        cells = " ".join(f"{value:12.6g}" for value in (x[0], x.min(), x.max(), x[-1]))
        unit = result.units[name]
        print(f"{name:{width}}  {cells}{'' if unit in ('', '1') else '  ' + unit}")


def _count(n: int, what: str) -> str:
    plural = f"{what[:-1]}ies" if what.endswith("y") else f"{what}s"
    return f"{n} {what if n == 1 else plural}"


def main() -> None:
    """Run the `gelenk` command with the arguments of the process."""
    app(prog_name="gelenk")


if __name__ == "__main__":
    main()
