# SPDX-License-Identifier: BSD-3-Clause
"""The `gelenk` command. Errors that a user can cause are lines on stderr, with exit code 1.

Modules for computations are imported by the commands that need them, so that help is printed at once.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import gelenk
from gelenk.cli import analysis, completion, equation_text, pictures, runs, sweep
from gelenk.cli.arguments import (
    AssemblyTolerance,
    Outputs,
    Parameters,
    Without,
    load_scene,
    parse_settings,
    split_all_names,
)
from gelenk.cli.chart import app as chart_app
from gelenk.cli.command import Report, command, document, error_data
from gelenk.errors import UsageError
from gelenk.model.defaults import STARTS

app = typer.Typer(
    help="Check, simulate, analyze and export mechanisms described by scene files.",
    no_args_is_help=True,
    rich_markup_mode=None,  # "[s]" in a help text would be taken for markup
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(chart_app, name="chart")

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
@command
def export(
    scene: SceneFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="X.fmu", help="File; default: NAME.fmu, or NAME.ssp, in this folder."
        ),
    ] = None,
    without: Without = None,
    platforms: Annotated[
        str | None,
        typer.Option(
            metavar="LIST",
            help="Platforms, separated by commas: linux64, aarch64-linux, win64, darwin64, or all; "
            "default: that of this machine.",
            autocompletion=completion.platforms,
        ),
    ] = None,
    outputs: Outputs = None,
    view: Annotated[
        bool, typer.Option("--view/--no-view", help="Show the mechanism in 3-D in the FMU's documentation.")
    ] = True,
    fmi: Annotated[
        int,
        typer.Option(
            metavar="2|3",
            help="Version of FMI: 2.0 or 3.0, both with co-simulation and, if possible, model exchange.",
            autocompletion=completion.fmi_versions,
        ),
    ] = 2,
    ssp: Annotated[
        bool, typer.Option("--ssp", help="An SSP archive: FMU, parameters, and the place of a controller.")
    ] = False,
    assembly_tolerance: AssemblyTolerance = None,
) -> Report:
    """Export a scene as an FMU (FMI 2.0 or 3.0), or as an SSP archive with one.

    Libraries for platforms other than this one are built by `make runtimes`.
    """
    from gelenk.io.export import default_file, file_name_notes, platform_names

    if ssp and fmi != 2:
        raise UsageError(f"--fmi: found {fmi}, expected 2 with --ssp: SSP 1.0 is for FMUs of FMI 2.0")
    ending = ".ssp" if ssp else ".fmu"

    wanted = platform_names([name.strip() for name in platforms.split(",")] if platforms else None)
    loaded = load_scene(scene, assembly_tolerance).without(without or [])
    target = output or default_file(loaded.name, ending)
    requested = split_all_names(outputs)
    if ssp:
        out = gelenk.export_ssp(loaded, target, wanted, requested, view=view)
    else:
        out = gelenk.export_fmu(loaded, target, wanted, requested, view=view, fmi=fmi)
    notes = file_name_notes(loaded.name, output, ending)
    for sentence in notes:
        print(sentence, file=sys.stderr)
    size = out.stat().st_size
    return Report(
        f"{out}: {size / 1e6:.2f} MB, {loaded.name}",
        {
            "file": str(out),
            "bytes": size,
            "name": loaded.name,
            "platforms": wanted,
            "fmi": fmi,
            "notes": notes,
        },
    )


@app.command()
@command
def check(scene: SceneFile, assembly_tolerance: AssemblyTolerance = None) -> Report:
    """Check a scene, close its loops, and print its size."""
    plant = gelenk.Simulation(load_scene(scene, assembly_tolerance))
    plant.initialize()
    size = plant.size
    algebra = "planar" if size.planar else "spatial"
    n = size.degrees_of_freedom
    dof = "1 degree of freedom" if n == 1 else f"{n} degrees of freedom"
    equations = _count(size.constraint_equations, "constraint equation")
    if size.constraint_equations:
        equations += f" of rank {size.rank}"
    bodies = _count(size.bodies, "moving body")
    assembly = plant.assembly_report()
    lines = [
        repr(plant.scene),
        f"{dof}: {_count(size.velocities, 'velocity')}, {equations}, {bodies}, {algebra}",
        f"inputs: {', '.join(s.name for s in plant.inputs) or 'none'}",
        assembly,
    ]
    return Report(
        "\n".join(line for line in lines if line),
        {
            "name": plant.scene.name, "degrees_of_freedom": n, "coordinates": size.coordinates,
            "velocities": size.velocities, "constraint_equations": size.constraint_equations,
            "rank": size.rank, "bodies": size.bodies, "islands": size.islands, "algebra": algebra,
            "inputs": {s.name: s.unit for s in plant.inputs},
            "outputs": {s.name: s.unit for s in plant.outputs}, "assembly": assembly,
        },
    )  # fmt: skip


@app.command()
@command
def inspect(
    scene: SceneFile,
    without: Without = None,
    outputs: Outputs = None,
    assembly_tolerance: AssemblyTolerance = None,
) -> Report:
    """Print the reductions of a model and their effects.

    For each reduction, the cost of an evaluation with and without it is measured.
    """
    report = gelenk.inspect(load_scene(scene, assembly_tolerance), without or [], split_all_names(outputs))
    return Report(str(report), report.to_dict())


@app.command()
@command
def assemblies(
    scene: SceneFile,
    settings: Parameters = None,
    bodies: Annotated[
        list[str] | None,
        typer.Option(
            "--body",
            metavar="NAME",
            help="Distinguish branches by the pose of this body only; repeatable.",
            autocompletion=completion.bodies,
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
) -> Report:
    """List the branches in which a scene can be assembled.

    Fixed start values are kept; the branch nearest to the initial guesses is listed first.
    """
    source = gelenk.load(Path(scene)).with_parameters(parse_settings(settings or []))
    found = gelenk.assemblies(source, bodies=bodies or [], starts=starts)
    if (take is None) != (output is None):
        raise UsageError("--take and --output: found one of them, expected both or none")
    if take is None or output is None:
        return Report(str(found), found.to_dict())
    if not 1 <= take <= len(found):
        raise UsageError(f"--take {take}: expected 1 to {len(found)}")
    found[take - 1].apply_to(source).save(output)
    return Report(
        f"{output}: branch {take} of {len(found)}",
        {"file": str(output), "branch": take, "branches": len(found)},
    )


@app.command("import")
@command
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
) -> Report:
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
    return Report(
        f"{output}: {scene!r}", {"file": str(output), "name": scene.name, "report": list(scene.report)}
    )


runs.register(app)
sweep.register(app)
analysis.register(app)
equation_text.register(app)
pictures.register(app)


def _count(n: int, what: str) -> str:
    plural = f"{what[:-1]}ies" if what.endswith("y") else f"{what}s"
    return f"{n} {what if n == 1 else plural}"


def main() -> None:
    """Run the `gelenk` command with the arguments of the process."""
    if "--json" not in sys.argv:
        app(prog_name="gelenk")
        return
    try:
        code = app(prog_name="gelenk", standalone_mode=False)
    except Exception as e:
        if not hasattr(e, "format_message"):  # one of typer, which vendors its classes: a wrong option
            raise
        print(document(error_data("UsageError", tuple(e.format_message().splitlines()))))
        code = getattr(e, "exit_code", 2)
    sys.exit(code or 0)


if __name__ == "__main__":
    main()
