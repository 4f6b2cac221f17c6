# SPDX-License-Identifier: BSD-3-Clause
"""The command that writes the equations of a scene."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

import gelenk
from gelenk.cli.arguments import Parameters, parse_settings
from gelenk.cli.command import Report, command
from gelenk.file_writing import write_text


class Language(StrEnum):
    """Languages of equations."""

    c = "c"
    numpy = "numpy"
    sympy = "sympy"
    latex = "latex"
    casadi = "casadi"


def register(app: typer.Typer) -> None:
    """Add the command to an application."""
    app.command()(equations)


@command
def equations(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file: .yaml, .yml or .json.")],
    language: Annotated[Language, typer.Option("--to", help="Language of the text.")] = Language.c,
    settings: Parameters = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="File to write; default: stdout.")
    ] = None,
) -> Report:
    """Print the equations of motion of a scene: mass matrix, forces, constraints, energies.

    What the equations leave out is listed on stderr, too.
    """
    found = gelenk.equations(gelenk.load(scene).with_parameters(parse_settings(settings or [])))
    text = {
        Language.c: found.to_c,
        Language.numpy: found.numpy_text,
        Language.sympy: found.sympy_text,
        Language.latex: found.to_latex,
        Language.casadi: found.casadi_text,
    }[language]()
    for note in found.notes:
        print(note, file=sys.stderr)
    data = {"language": str(language), "text": text, "notes": list(found.notes)}
    if output is None:
        return Report(text, data)
    write_text(output, text)
    return Report(str(output), {**data, "file": str(output)})
