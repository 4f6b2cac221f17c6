# SPDX-License-Identifier: BSD-3-Clause
"""The commands that draw: `gelenk plot` and `gelenk view`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import gelenk
from gelenk.cli import completion
from gelenk.cli.arguments import AssemblyTolerance, InputTable, ParametersAndInputs, parse_parameters
from gelenk.cli.command import Report, command
from gelenk.errors import StepError, UsageError
from gelenk.simulation.progress import terminal_bar

if TYPE_CHECKING:
    from gelenk.viewer import View


@command
def plot(
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN|SCENE|FMU", help="Results of `gelenk simulate`, or what to simulate."),
    ],
    signals: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SIGNAL...",
            help="Signals, or patterns: 'crank.*'; default: all positions.",
            autocompletion=completion.signals,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="Picture: .png, .svg or .pdf; default: RUN.png."),
    ] = None,
) -> Report:
    """Plot results over time, with a panel for each unit."""
    from gelenk.simulation.files import ENDINGS

    file = output or Path(run.with_suffix(".png").name)
    if file.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise UsageError(f"--output {file}: expected FILE.png, FILE.svg or FILE.pdf")
    if run.suffix.lower() in ENDINGS:
        result = gelenk.Result.read(run)
    else:
        with terminal_bar(sys.stderr) as progress:
            result = gelenk.simulate(run, progress=progress)
    result.plot(signals or ()).savefig(file, dpi=150)
    return Report(
        f"{file}: {len(result)} rows, to {result.time[-1]:g} s",
        {"file": str(file), "rows": len(result), "stop": float(result.time[-1])},
    )


@command
def view(
    plant: Annotated[Path, typer.Argument(metavar="SCENE|FMU", help="Scene file or .fmu file.")],
    stop: Annotated[
        float | None, typer.Option(help="End of the simulation [s]; 0 shows the start only.")
    ] = None,
    inputs: InputTable = None,
    settings: ParametersAndInputs = None,
    assembly_tolerance: AssemblyTolerance = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.html", help="Write the page, do not open the browser."),
    ] = None,
) -> Report:
    """Simulate a scene or an FMU and show it in the browser.

    The page is one file, which can be mailed and needs no network.
    """
    if output is not None and output.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"--output {output}: expected FILE.html")
    try:
        with terminal_bar(sys.stderr) as progress:
            page = gelenk.view(
                plant, stop=stop, inputs=inputs,
                parameters=parse_parameters(settings or [], assembly_tolerance), progress=progress,
            )  # fmt: skip
    except StepError as e:
        if e.view is None:
            raise
        return _put(e.view, output, e)
    return _put(page, output)


def _put(page: View, output: Path | None, failure: StepError | None = None) -> Report:
    file = page.show() if output is None else page.save(output)
    size = len(page.html.encode())
    return Report(f"{file}: {size / 1e6:.1f} MB", {"file": str(file), "bytes": size}, failure)


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    for function in (plot, view):
        app.command()(function)
