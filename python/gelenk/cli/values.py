# SPDX-License-Identifier: BSD-3-Clause
"""Values as they are given on the command line: NAME=VALUE, lists, files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import gelenk
from gelenk.errors import UsageError
from gelenk.model.values import Value, number

if TYPE_CHECKING:
    from gelenk.simulation.inputs import Input

AssemblyTolerance = Annotated[
    float | None,
    typer.Option(
        "--assembly-tolerance",
        metavar="X",
        help="Move joint frames by up to this [rad, lengths] so that loops with rounded numbers close.",
    ),
]


def scene_given(path: str, assembly_tolerance: float | None = None) -> gelenk.Scene:
    """The scene of a file, with this `assembly.tolerance` if one is given."""
    scene = gelenk.load(Path(path))
    return scene.with_parameters(settings_with([], assembly_tolerance)) if assembly_tolerance else scene


def settings_with(given: list[str], assembly_tolerance: float | None) -> dict[str, Value]:
    """Values by name, `assembly.tolerance` among them if one is given. Raises UsageError."""
    settings = settings_given(given)
    if assembly_tolerance is None:
        return settings
    if "assembly.tolerance" in settings:
        raise UsageError("--assembly-tolerance: assembly.tolerance is set twice")
    return {**settings, "assembly.tolerance": assembly_tolerance}


def point_given(at: list[str]) -> float | dict[str, Value] | None:
    """A point: a time [s], or values by name; None where nothing is given. Raises UsageError."""
    if len(at) == 1 and "=" not in at[0]:
        return number("--at", at[0], "real")
    return settings_given(at, "--at") or None


def input_values_given(given: list[str]) -> dict[str, Input] | str:
    """Inputs: constants by name, or the file of a table. Raises UsageError."""
    if len(given) == 1 and "=" not in given[0]:
        return given[0]
    return {**numbers_given(given, "--input")}


def numbers_given(given: list[str], option: str) -> dict[str, float]:
    """Numbers by name. Raises UsageError."""
    values = settings_given(given, option)
    return {name: number(name, value, "real") for name, value in values.items()}


def table_file(output: Path | None) -> None:
    """Raises UsageError where a result cannot be written so: before the run, not after it."""
    if output is None or str(output) == "-" or output.suffix.lower() == ".csv":
        return
    found = f"the ending {output.suffix}" if output.suffix else "no ending"
    raise UsageError(f"--output {output}: found {found}, expected FILE.csv, or - for stdout")


def listed(text: str | None) -> list[str] | None:
    """Names with commas between; None where nothing is given."""
    return None if text is None else [name.strip() for name in text.split(",") if name.strip()]


def all_listed(texts: list[str] | None) -> list[str] | None:
    """Names of an option that may be repeated; None where it is not given."""
    return None if texts is None else [name for text in texts for name in listed(text) or ()]


def settings_given(given: list[str], option: str = "--set") -> dict[str, Value]:
    """Values by name. Raises UsageError: not NAME=VALUE, or a name twice."""
    settings: dict[str, Value] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals and value.strip()):
            raise UsageError(f"{option} {text}: expected NAME=VALUE")
        if name.strip() in settings:
            raise UsageError(f"{option} {text}: {name.strip()} is set twice")
        settings[name.strip()] = value.strip()
    return settings
