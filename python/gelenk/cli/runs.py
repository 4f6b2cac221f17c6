# SPDX-License-Identifier: BSD-3-Clause
"""The command `gelenk simulate`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import gelenk
from gelenk.cli import completion
from gelenk.cli.arguments import (
    AssemblyTolerance,
    InputTable,
    Outputs,
    ParametersAndInputs,
    Without,
    check_output_file,
    parse_parameters,
    split_all_names,
)
from gelenk.cli.command import Report, command
from gelenk.errors import StepError
from gelenk.simulation.progress import terminal_bar

if TYPE_CHECKING:
    from gelenk.simulation.result import Result


@command
def simulate(
    plant: Annotated[Path, typer.Argument(metavar="SCENE|FMU", help="Scene file or .fmu file.")],
    stop: Annotated[float | None, typer.Option(help="End of the simulation [s].")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s].")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative tolerance of the integrator.")] = None,
    integrator: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Integrator: auto, ida, erk, rk4, generalized-alpha, ...: see docs/scene-format.md.",
            autocompletion=completion.integrators,
        ),
    ] = None,
    formulation: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Constraint formulation: projection, baumgarte, index3, ...: see docs/scene-format.md.",
            autocompletion=completion.formulations,
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
) -> Report:
    """Simulate a scene or an FMU.

    Without --output, the range of every output is printed.
    """
    check_output_file(output)
    try:
        with terminal_bar(sys.stderr) as progress:
            result = gelenk.simulate(
                plant, stop=stop, step=step, tolerance=tolerance, integrator=integrator,
                formulation=formulation, inputs=inputs,
                parameters=parse_parameters(settings or [], assembly_tolerance),
                outputs=split_all_names(outputs), without=without or [], progress=progress,
            )  # fmt: skip
    except StepError as e:
        if e.result is None:
            raise
        text = "" if output is None else _written(e.result, output)
        return Report(text, _data(e.result, output), e)
    text = _summary(result) if output is None else _written(result, output)
    if result.singular_positions:
        print(_singular_crossings(result), file=sys.stderr)
    for sentence in result.warnings:
        print(sentence, file=sys.stderr)
    return Report(text, _data(result, output))


def _singular_crossings(result: Result) -> str:
    times = ", ".join(f"{t:g}" for t in result.singular_positions[:5])
    more = len(result.singular_positions) - 5
    return (
        f"crossed singular configurations, where motion on another branch is possible, before t = {times}"
        f"{f' and {more} more' if more > 0 else ''} s"
    )


def _written(result: Result, output: Path) -> str:
    """Write a result, and return what is printed about it: with "-", the result itself."""
    if str(output) == "-":
        return result.csv()
    result.save(output)
    return f"{output}: {len(result)} rows, {len(result.names)} outputs, to {result.time[-1]:g} s"


def _summary(result: Result) -> str:
    lines = [f"0 to {result.time[-1]:g} s, {len(result)} rows; --output FILE.csv writes them"]
    if result.names:
        width = max(map(len, result.names))
        lines.append(f"{'':{width}}  {'start':>12} {'min':>12} {'max':>12} {'end':>12}")
    for name in result.names:
        cells = " ".join(f"{value:12.6g}" for value in _range(result, name).values())
        unit = result.units[name]
        lines.append(f"{name:{width}}  {cells}{'' if unit in ('', '1') else '  ' + unit}")
    return "\n".join(lines)


def _range(result: Result, name: str) -> dict[str, float]:
    x = result[name]
    return {"start": float(x[0]), "min": float(x.min()), "max": float(x.max()), "end": float(x[-1])}


def _data(result: Result, output: Path | None) -> dict[str, Any]:
    signals = ("time", *result.names) if str(output) == "-" else ()
    return {
        "file": None if output is None or signals else str(output), "rows": len(result),
        "stop": float(result.time[-1]),
        "outputs": {n: {"unit": result.units[n], **_range(result, n)} for n in result.names},
        "events": [{"t": t, "event": text} for t, text in result.events],
        "singular_positions": list(result.singular_positions), "warnings": list(result.warnings),
        **({"signals": {name: result[name].tolist() for name in signals}} if signals else {}),
    }  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(simulate)
