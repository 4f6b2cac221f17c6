# SPDX-License-Identifier: BSD-3-Clause
"""Commands about points of a motion: linear models, equilibria, modes."""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from typing import Annotated

import typer

import gelenk
from gelenk.cli.told import told
from gelenk.cli.values import (
    AssemblyTolerance,
    all_listed,
    input_values_given,
    listed,
    numbers_given,
    point_given,
    settings_with,
)
from gelenk.errors import UsageError

# What these commands share.
Plant = Annotated[Path, typer.Argument(metavar="SCENE|FMU", help="Scene file or .fmu file.")]
Given = Annotated[
    list[str] | None,
    typer.Option("--input", metavar="NAME=VALUE|FILE.csv", help="Inputs at the point; repeatable."),
]
States = Annotated[
    str | None, typer.Option(metavar="LIST", help="Coordinates to be states; by default the plant's.")
]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A parameter; repeatable.")
]
AsJson = Annotated[bool, typer.Option("--json", help="For programs.")]


def register(app: typer.Typer) -> None:
    """Makes commands of these functions."""
    for command in (linearize, equilibrium, modes):
        app.command()(command)


@told
def linearize(
    plant: Plant,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="T|NAME=VALUE", help="A time [s] on the motion; or a state or parameter, repeatable."
        ),
    ] = None,
    given: Annotated[
        list[str] | None,
        typer.Option(
            "--input", metavar="NAME=VALUE|FILE.csv", help="Inputs at the point and before; repeatable."
        ),
    ] = None,
    inputs: Annotated[
        str | None, typer.Option(metavar="LIST", help="Inputs of the model, commas between; by default all.")
    ] = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option(metavar="LIST", help="Outputs of the model, names or patterns; repeatable."),
    ] = None,
    states: States = None,
    settings: Settings = None,
    assembly_tolerance: AssemblyTolerance = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative tolerance on the way to a time.")] = None,
    as_json: AsJson = False,
) -> None:
    """Linear model of a scene or an FMU: states, A, B, C, D; what is no equilibrium is told on stderr."""
    model = gelenk.linear.linear_model(
        plant, at=point_given(at or []), input_values=input_values_given(given or []), inputs=listed(inputs),
        outputs=all_listed(outputs), states=listed(states),
        parameters=settings_with(settings or [], assembly_tolerance), tolerance=tolerance,
    )  # fmt: skip
    if model.unrest:
        print(model.unrest, file=sys.stderr)
    print(json.dumps(model.to_dict(), indent=2) if as_json else model)


@told
def modes(
    plant: Plant,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="T|NAME=VALUE", help="The point, as for linearize; repeatable."),
    ] = None,
    given: Given = None,
    states: States = None,
    settings: Settings = None,
    assembly_tolerance: AssemblyTolerance = None,
    animate: Annotated[
        int | None, typer.Option(metavar="MODE", help="Draw this mode's shape, into --output.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help=".gif, .html or .mp4.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Modes of a scene or an FMU: eigenvalues, frequencies, damping, shapes, and whether it is stable."""
    if (animate is None) != (output is None):
        raise UsageError("--animate and --output: found one of them, expected both or none")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", gelenk.OperatingPointWarning)
        found = gelenk.modes(
            plant, at=point_given(at or []), input_values=input_values_given(given or []),
            states=listed(states), parameters=settings_with(settings or [], assembly_tolerance),
        )  # fmt: skip
    for warning in caught:
        print(warning.message, file=sys.stderr)
    if animate is not None and output is not None:
        found.animate(animate, output)
    print(json.dumps(found.to_dict(), indent=2) if as_json else found)


@told
def equilibrium(
    plant: Plant,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="T|NAME=VALUE", help="The first pose, as for linearize; repeatable."),
    ] = None,
    hold: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="A coordinate that keeps this value; repeatable."),
    ] = None,
    steady: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME[=VALUE]", help="A speed that stays constant, at this value; repeatable."),
    ] = None,
    solve_for: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="An input to be found; repeatable.")
    ] = None,
    given: Given = None,
    settings: Settings = None,
    assembly_tolerance: AssemblyTolerance = None,
    as_json: AsJson = False,
) -> None:
    """Where a scene or an FMU stands still or moves steadily, or the inputs that hold it there."""
    open_speeds = [text for text in steady or [] if "=" not in text]
    speeds = numbers_given([text for text in steady or [] if "=" in text], "--steady")
    found = gelenk.equilibrium(
        plant, at=point_given(at or []), solve_for=solve_for or [], hold=numbers_given(hold or [], "--hold"),
        steady={**dict.fromkeys(open_speeds), **speeds} if steady else None,
        input_values=input_values_given(given or []),
        parameters=settings_with(settings or [], assembly_tolerance),
    )  # fmt: skip
    print(json.dumps(found.to_dict(), indent=2) if as_json else found)
