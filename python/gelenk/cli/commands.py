# SPDX-License-Identifier: BSD-3-Clause
"""The `gelenk` command. What a user can cause goes to stderr, one line each, with exit code 1.

What computes is imported by the command that is given, so that help is there at once.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import gelenk
from gelenk.cli import points
from gelenk.cli.chart import app as chart_app
from gelenk.cli.progress import progress_bar
from gelenk.cli.told import told
from gelenk.cli.values import (
    AssemblyTolerance,
    all_listed,
    scene_given,
    settings_given,
    settings_with,
    table_file,
)
from gelenk.errors import StepError, UsageError
from gelenk.model.defaults import STARTS

if TYPE_CHECKING:
    from gelenk.simulation.result import Result

app = typer.Typer(
    help="From the description of a mechanism to a plant FMU.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(chart_app, name="chart")

Without = Annotated[
    list[str] | None,
    typer.Option("--without", metavar="NAME", help="Leave out a reduction, or `all`; repeatable."),
]
Outputs = Annotated[
    list[str] | None,
    typer.Option("--outputs", metavar="NAME", help="A wanted output, or a pattern: 'crank.*'; repeatable."),
]
SceneFile = Annotated[str, typer.Argument(metavar="SCENE", help="Scene file: .yaml, .yml or .json.")]


def _version(asked: bool) -> None:
    if asked:
        print(f"gelenk {gelenk.__version__}")
        raise typer.Exit


@app.callback()
def main_options(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """From the description of a mechanism to a plant FMU."""


@app.command()
@told
def export(
    scene: SceneFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="X.fmu", help="By default NAME.fmu, here.")
    ] = None,
    without: Without = None,
    platforms: Annotated[
        str, typer.Option(metavar="LIST", help="For whom: linux64, win64 or both, with a comma between.")
    ] = "linux64",
    outputs: Outputs = None,
    assembly_tolerance: AssemblyTolerance = None,
) -> None:
    """Export a scene as an FMU (FMI 2.0 co-simulation); platforms that are missing are told on stderr."""
    from gelenk.io.export import file_name_notes, fmu_file, missing_platforms

    wanted = [name.strip() for name in platforms.split(",")]
    missing = missing_platforms(wanted)
    there = [name for name in wanted if name not in missing]
    loaded = scene_given(scene, assembly_tolerance).without(without or [])
    # With none left, the export says why.
    out = gelenk.export_fmu(loaded, output or fmu_file(loaded.name), there or wanted, all_listed(outputs))
    for sentence in [*missing.values(), *file_name_notes(loaded.name, output)]:
        print(sentence, file=sys.stderr)
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB, {loaded.name}")


@app.command()
@told
def check(scene: SceneFile, assembly_tolerance: AssemblyTolerance = None) -> None:
    """Check a scene, close its loops, and say what it is."""
    plant = gelenk.Simulation(scene_given(scene, assembly_tolerance))
    plant.initialize()
    size = plant.size
    algebra = "planar" if size.planar else "spatial"
    print(f"{plant.scene!r}")
    rows = f"{_count(size.constraint_equations, 'loop row')} of rank {size.rank}"
    print(f"{_count(size.degrees_of_freedom, 'freedom')}: {_count(size.velocities, 'speed')}, {rows}, "
          f"{_count(size.bodies, 'moving body')}, {algebra}")  # fmt: skip
    print(f"inputs: {', '.join(s.name for s in plant.inputs) or 'none'}")
    report = plant.assembly_report()
    if report:
        print(report)


@app.command()
@told
def inspect(
    scene: SceneFile,
    without: Without = None,
    outputs: Outputs = None,
    assembly_tolerance: AssemblyTolerance = None,
    as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
) -> None:
    """Tell what the model is reduced to, why, and what an evaluation costs with and without."""
    report = gelenk.inspect(scene_given(scene, assembly_tolerance), without or [], all_listed(outputs))
    print(json.dumps(report.to_dict(), indent=2) if as_json else report)


@app.command()
@told
def assemblies(
    scene: SceneFile,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A parameter; repeatable.")
    ] = None,
    bodies: Annotated[
        list[str] | None,
        typer.Option("--body", metavar="NAME", help="Count branches by how this body stands; repeatable."),
    ] = None,
    starts: Annotated[int, typer.Option(help="Most searches, for each part that moves by itself.")] = STARTS,
    take: Annotated[
        int | None, typer.Option("--take", metavar="NUMBER", help="Put this branch into --output.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="SCENE", help="Scene file for --take.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
) -> None:
    """The ways in which a scene can be put together with its fixed start values."""
    source = gelenk.load(Path(scene)).with_parameters(settings_given(settings or []))
    found = gelenk.assemblies(source, bodies=bodies or [], starts=starts)
    if (take is None) != (output is None):
        raise UsageError("--take and --output go together: the branch, and the scene to be written")
    if take is None or output is None:
        print(json.dumps(found.to_dict(), indent=2) if as_json else found)
        return
    if not 1 <= take <= len(found):
        raise UsageError(f"--take {take}: expected 1 to {len(found)}")
    found[take - 1].put_into(source).save(output)
    print(f"{output}: branch {take} of {len(found)}")


@app.command("import")
@told
def import_(
    robot: Annotated[Path, typer.Argument(metavar="ROBOT.urdf", help="URDF robot description.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="SCENE", help="Scene file: .yaml, .yml or .json.")
    ],
    floating: Annotated[bool, typer.Option("--floating", help="Let the root link move freely.")] = False,
    repair_inertia: Annotated[
        bool,
        typer.Option("--repair-inertia", help="Take the nearest inertia where no body has the one given."),
    ] = False,
    assembly_tolerance: AssemblyTolerance = None,
) -> None:
    """Make a scene of a URDF robot description; what is not taken over is told on stderr."""
    scene = gelenk.import_urdf(
        robot, floating=floating, repair_inertia=repair_inertia, assembly_tolerance=assembly_tolerance
    )
    scene.save(output)
    for line in scene.report:
        print(line, file=sys.stderr)
    print(f"{output}: {scene!r}")


@app.command()
@told
def simulate(
    plant: Annotated[Path, typer.Argument(metavar="SCENE|FMU", help="Scene file or .fmu file.")],
    stop: Annotated[float | None, typer.Option(help="End of the run [s].")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s].")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative tolerance of the integrator.")] = None,
    integrator: Annotated[
        str | None,
        typer.Option(help="auto, ida, erk, rk4, generalized-alpha, ...: see docs/scene-format.md."),
    ] = None,
    formulation: Annotated[
        str | None, typer.Option(help="projection, baumgarte, index3, ...: how loops meet the integrator.")
    ] = None,
    inputs: Annotated[
        Path | None, typer.Option("--input", metavar="FILE.csv", help="Columns `time` and inputs by name.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="NAME=VALUE", help="A parameter, or an input as a constant; repeatable."
        ),
    ] = None,
    assembly_tolerance: AssemblyTolerance = None,
    without: Without = None,
    outputs: Outputs = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE.csv", help="Result table; - is stdout.")
    ] = None,
) -> None:
    """Run a scene or an FMU; without --output, tell the span of every output."""
    table_file(output)
    try:
        with progress_bar(sys.stderr) as progress:
            result = gelenk.simulate(
                plant, stop=stop, step=step, tolerance=tolerance, integrator=integrator,
                formulation=formulation, inputs=inputs,
                parameters=settings_with(settings or [], assembly_tolerance), outputs=all_listed(outputs),
                without=without or [], progress=progress,
            )  # fmt: skip
    except StepError as e:
        if e.result is not None and output is not None:
            _write(e.result, output)
        raise
    _write(result, output)
    _tell_passages(result)


points.register(app)


def _tell_passages(result: Result) -> None:
    if not result.singular_positions:
        return
    times = ", ".join(f"{t:g}" for t in result.singular_positions[:5])
    more = len(result.singular_positions) - 5
    print(
        f"passed singular positions, where loops could go on by another branch, before t = {times}"
        f"{f' and {more} more' if more > 0 else ''} s",
        file=sys.stderr,
    )


def _write(result: Result, output: Path | None) -> None:
    if output is None:
        _summary(result)
    elif str(output) == "-":
        print(result.csv(), end="")
    else:
        result.to_csv(output)
        print(f"{output}: {len(result)} rows, {len(result.names)} outputs, to {result.time[-1]:g} s")


def _summary(result: Result) -> None:
    print(f"0 to {result.time[-1]:g} s, {len(result)} rows; --output FILE.csv writes them")
    if not result.names:
        return
    width = max(map(len, result.names))
    print(f"{'':{width}}  {'start':>12} {'least':>12} {'most':>12} {'end':>12}")
    for name in result.names:
        x = result[name]
        cells = " ".join(f"{value:12.6g}" for value in (x[0], x.min(), x.max(), x[-1]))
        unit = result.units[name]
        print(f"{name:{width}}  {cells}{'' if unit in ('', '1') else '  ' + unit}")


def _count(n: int, what: str) -> str:
    plural = f"{what[:-1]}ies" if what.endswith("body") else f"{what}s"
    return f"{n} {what if n == 1 else plural}"


def main() -> None:
    """Entry point of the command."""
    app(prog_name="gelenk")


if __name__ == "__main__":
    main()
