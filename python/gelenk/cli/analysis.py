# SPDX-License-Identifier: BSD-3-Clause
"""Commands for operating points: linear models, equilibria, modes."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Annotated

import typer

import gelenk
from gelenk.cli import completion
from gelenk.cli.arguments import (
    AssemblyTolerance,
    Parameters,
    parse_input_values,
    parse_numbers,
    parse_operating_point,
    parse_parameters,
    split_all_names,
    split_names,
)
from gelenk.cli.command import Report, command
from gelenk.errors import UsageError

# Options that these commands share.
Plant = Annotated[Path, typer.Argument(metavar="SCENE|FMU", help="Scene file or .fmu file.")]
Given = Annotated[
    list[str] | None,
    typer.Option(
        "--input",
        metavar="NAME=VALUE|FILE.csv",
        help="Inputs at the operating point; repeatable.",
        autocompletion=completion.input_values,
    ),
]
States = Annotated[
    str | None,
    typer.Option(
        metavar="LIST",
        help="Coordinates that are states, separated by commas; default: the plant's.",
        autocompletion=completion.signals,
    ),
]


def register(app: typer.Typer) -> None:
    """Add the commands to an application."""
    for function in (linearize, equilibrium, modes):
        app.command()(function)


@command
def linearize(
    plant: Plant,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="T|NAME=VALUE",
            help="Operating point: a time [s], or values of states and parameters; repeatable.",
            autocompletion=completion.signal_values,
        ),
    ] = None,
    given: Annotated[
        list[str] | None,
        typer.Option(
            "--input",
            metavar="NAME=VALUE|FILE.csv",
            help="Inputs at the operating point and before it; repeatable.",
            autocompletion=completion.input_values,
        ),
    ] = None,
    inputs: Annotated[
        str | None,
        typer.Option(
            metavar="LIST",
            help="Inputs of the model, separated by commas; default: all.",
            autocompletion=completion.inputs,
        ),
    ] = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option(
            metavar="LIST",
            help="Outputs of the model, names or patterns; repeatable.",
            autocompletion=completion.signals,
        ),
    ] = None,
    states: States = None,
    settings: Parameters = None,
    assembly_tolerance: AssemblyTolerance = None,
    tolerance: Annotated[
        float | None, typer.Option(help="Relative tolerance of the integrator if --at is a time.")
    ] = None,
    friction: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="What joints with dry friction do: present, locked, sliding or off.",
            autocompletion=completion.frictions,
        ),
    ] = "present",
) -> Report:
    """Print the linear model of a scene or an FMU.

    It consists of states, inputs, outputs and the matrices A, B, C, D. Rates of states that are not in
    equilibrium are reported on stderr.
    """
    model = gelenk.linear.linear_model(
        plant, at=parse_operating_point(at or []), input_values=parse_input_values(given or []),
        inputs=split_names(inputs), outputs=split_all_names(outputs), states=split_names(states),
        parameters=parse_parameters(settings or [], assembly_tolerance), tolerance=tolerance,
        friction=friction,
    )  # fmt: skip
    if model.residual_rates:
        print(model.residual_rates, file=sys.stderr)
    return Report(str(model), model.to_dict())


@command
def modes(
    plant: Plant,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="T|NAME=VALUE",
            help="Operating point, as for linearize; repeatable.",
            autocompletion=completion.signal_values,
        ),
    ] = None,
    given: Given = None,
    states: States = None,
    settings: Parameters = None,
    assembly_tolerance: AssemblyTolerance = None,
    animate: Annotated[
        int | None, typer.Option(metavar="MODE", help="Number of a mode whose shape is drawn into --output.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help=".gif, .html or .mp4.")
    ] = None,
    view: Annotated[
        bool,
        typer.Option("--view", help="Show the mode shapes in the browser, or write the page to --output."),
    ] = False,
) -> Report:
    """Print the modes of a scene or an FMU and its stability.

    Each mode has an eigenvalue, a frequency, a damping ratio and a shape.
    """
    if not view and (animate is None) != (output is None):
        raise UsageError("--animate and --output: found one of them, expected both or none")
    if view and animate is not None:
        raise UsageError("--animate and --view: found both, expected one of them")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", gelenk.OperatingPointWarning)
        found = gelenk.modes(
            plant, at=parse_operating_point(at or []), input_values=parse_input_values(given or []),
            states=split_names(states), parameters=parse_parameters(settings or [], assembly_tolerance),
        )  # fmt: skip
    for warning in caught:
        print(warning.message, file=sys.stderr)
    if animate is not None and output is not None:
        found.animate(animate, output)
    if view:
        page = found.view()
        file = page.show() if output is None else page.save(output)
        print(f"{file}: {file.stat().st_size / 1e6:.1f} MB", file=sys.stderr)
    return Report(str(found), found.to_dict())


@command
def equilibrium(
    plant: Plant,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="T|NAME=VALUE",
            help="Initial pose, as for linearize; repeatable.",
            autocompletion=completion.signal_values,
        ),
    ] = None,
    hold: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Coordinate to be held at a value; repeatable.",
            autocompletion=completion.signal_values,
        ),
    ] = None,
    steady: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME[=VALUE]",
            help="Velocity that remains constant, at a value if given; repeatable.",
            autocompletion=completion.signals,
        ),
    ] = None,
    solve_for: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="Input to be determined; repeatable.", autocompletion=completion.inputs
        ),
    ] = None,
    given: Given = None,
    settings: Parameters = None,
    assembly_tolerance: AssemblyTolerance = None,
    friction: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What dry friction does: off, or present, which asks whether it holds the pose.",
        ),
    ] = None,
) -> Report:
    """Find an equilibrium or a steady motion.

    With --solve-for, inputs that hold the mechanism are determined, too (trim).
    """
    free_velocities = [text for text in steady or [] if "=" not in text]
    velocities = parse_numbers([text for text in steady or [] if "=" in text], "--steady")
    found = gelenk.equilibrium(
        plant, at=parse_operating_point(at or []), solve_for=solve_for or [],
        hold=parse_numbers(hold or [], "--hold"),
        steady={**dict.fromkeys(free_velocities), **velocities} if steady else None,
        input_values=parse_input_values(given or []),
        parameters=parse_parameters(settings or [], assembly_tolerance), friction=friction,
    )  # fmt: skip
    return Report(str(found), found.to_dict())
