# SPDX-License-Identifier: BSD-3-Clause
"""Values of command-line arguments: NAME=VALUE, lists, files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import gelenk
from gelenk.cli import completion
from gelenk.errors import UsageError
from gelenk.model.values import Value, number

if TYPE_CHECKING:
    from gelenk.simulation.inputs import Input

AssemblyTolerance = Annotated[
    float | None,
    typer.Option(
        "--assembly-tolerance",
        metavar="X",
        help="Largest correction of joint frames [rad, lengths] to close loops with rounded dimensions.",
    ),
]

InputTable = Annotated[
    Path | None,
    typer.Option("--input", metavar="FILE.csv", help="Inputs: a column `time` and a column for each input."),
]
ParametersAndInputs = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Value of a parameter or of a constant input; repeatable.",
        autocompletion=completion.settings,
    ),
]
Parameters = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="A parameter; repeatable.",
        autocompletion=completion.settings,
    ),
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        "--without",
        metavar="NAME",
        help="Switch off a reduction, or `all`; repeatable.",
        autocompletion=completion.reductions,
    ),
]
Outputs = Annotated[
    list[str] | None,
    typer.Option(
        "--outputs",
        metavar="NAME",
        help="Requested output, or a pattern: 'crank.*'; repeatable.",
        autocompletion=completion.signals,
    ),
]


def load_scene(path: str, assembly_tolerance: float | None = None) -> gelenk.Scene:
    """Load a scene file, with `assembly.tolerance` if it is given. Raises SceneError, UsageError, OSError."""
    scene = gelenk.load(Path(path))
    return scene.with_parameters(parse_parameters([], assembly_tolerance)) if assembly_tolerance else scene


def parse_parameters(given: list[str], assembly_tolerance: float | None) -> dict[str, Value]:
    """Return values by name from NAME=VALUE texts, with `assembly.tolerance` if given. Raises UsageError."""
    settings = parse_settings(given)
    if assembly_tolerance is None:
        return settings
    if "assembly.tolerance" in settings:
        raise UsageError("--assembly-tolerance: assembly.tolerance is set twice")
    return {**settings, "assembly.tolerance": assembly_tolerance}


def parse_operating_point(at: list[str]) -> float | dict[str, Value] | None:
    """Return an operating point: a time [s], values by name, or None without arguments. Raises UsageError."""
    if len(at) == 1 and "=" not in at[0]:
        return number("--at", at[0], "real")
    return parse_settings(at, "--at") or None


def parse_input_values(given: list[str]) -> dict[str, Input] | str:
    """Return inputs: constants by name, or the name of a CSV file. Raises UsageError."""
    if len(given) == 1 and "=" not in given[0]:
        return given[0]
    return {**parse_numbers(given, "--input")}


def parse_numbers(given: list[str], option: str) -> dict[str, float]:
    """Return numbers by name from NAME=VALUE texts. Raises UsageError."""
    values = parse_settings(given, option)
    return {name: number(name, value, "real") for name, value in values.items()}


def parse_size(text: str | None) -> tuple[int, int] | None:
    """Return width and height from WxH; None if nothing is given. Raises UsageError."""
    if text is None:
        return None
    sides = text.lower().split("x")
    if len(sides) != 2 or not all(side.strip().isdecimal() for side in sides):
        raise UsageError(f"--size {text}: expected WIDTHxHEIGHT in pixels, such as 480x360")
    return int(sides[0]), int(sides[1])


def parse_camera(text: str | None) -> str | tuple[float, ...] | None:
    """Return the name of a view, or angles [deg] from AZIMUTH,ELEVATION. Raises UsageError."""
    if text is None or "," not in text:
        return text
    return tuple(number("--camera", part, "real") for part in text.split(","))


def parse_span(text: str | None) -> tuple[float, float] | None:
    """Return two times [s] from FROM:TO, or one time twice; None if nothing is given. Raises UsageError."""
    if text is None:
        return None
    times = [number("--span", part, "real") for part in text.split(":")]
    if len(times) > 2:
        raise UsageError(f"--span {text}: expected FROM:TO in seconds, or one time")
    return times[0], times[-1]


def check_output_file(output: Path | None) -> None:
    """Check the name of a result file before the simulation. Raises UsageError."""
    from gelenk.simulation.files import ENDINGS, check_format

    if output is None or str(output) == "-":
        return
    if output.suffix.lower() in ENDINGS:
        check_format(output)
        return
    found = f"the ending {output.suffix}" if output.suffix else "no ending"
    expected = ", ".join(f"FILE{ending}" for ending in ENDINGS)
    raise UsageError(f"--output {output}: found {found}, expected {expected}, or - for stdout")


def split_names(text: str | None) -> list[str] | None:
    """Split names separated by commas; None if nothing is given."""
    return None if text is None else [name.strip() for name in text.split(",") if name.strip()]


def split_all_names(texts: list[str] | None) -> list[str] | None:
    """Split the names of an option that may be repeated; None if it is not given."""
    return None if texts is None else [name for text in texts for name in split_names(text) or ()]


def parse_settings(given: list[str], option: str = "--set") -> dict[str, Value]:
    """Return values by name from NAME=VALUE texts. Raises UsageError for other texts and repeated names."""
    settings: dict[str, Value] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals and value.strip()):
            raise UsageError(f"{option} {text}: expected NAME=VALUE")
        if name.strip() in settings:
            raise UsageError(f"{option} {text}: {name.strip()} is set twice")
        settings[name.strip()] = value.strip()
    return settings
