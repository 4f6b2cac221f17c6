# SPDX-License-Identifier: BSD-3-Clause
"""The commands that draw: `gelenk plot` and `gelenk view`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import gelenk
from gelenk.cli import completion
from gelenk.cli.arguments import (
    AssemblyTolerance,
    InputTable,
    ParametersAndInputs,
    parse_camera,
    parse_parameters,
    parse_settings,
    parse_size,
    parse_span,
)
from gelenk.cli.command import Report, command
from gelenk.errors import StepError, UsageError
from gelenk.file_writing import writing
from gelenk.simulation.progress import terminal_bar
from gelenk.viewer.file_types import PICTURES, is_picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gelenk.model.values import Value
    from gelenk.viewer import View


Degrees = Annotated[
    bool, typer.Option("--degrees", help="Plot angles and their derivatives in degrees instead of radians.")
]


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
    degrees: Degrees = False,
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
    save_figure(result.plot(signals or (), degrees=degrees), file)
    return Report(
        f"{file}: {len(result)} rows, to {result.time[-1]:g} s",
        {"file": str(file), "rows": len(result), "stop": float(result.time[-1])},
    )


def save_figure(figure: Figure, file: Path) -> None:
    """Write a figure of matplotlib in the format of the file's ending. Raises OSError."""
    with writing(file) as picture:
        figure.savefig(picture, format=file.suffix.lower()[1:], dpi=150)


@command
def view(
    plant: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE|FMU|RUN", help="Scene file, .fmu file, or results of `gelenk simulate`."
        ),
    ],
    stop: Annotated[
        float | None, typer.Option(help="End of the simulation [s]; 0 shows the start only.")
    ] = None,
    inputs: InputTable = None,
    settings: ParametersAndInputs = None,
    assembly_tolerance: AssemblyTolerance = None,
    scene: Annotated[
        Path | None,
        typer.Option(metavar="SCENE|FMU", help="The mechanism of results in a CSV file, which lacks it."),
    ] = None,
    other: Annotated[
        Path | None,
        typer.Option(
            "--with",
            metavar="SCENE|FMU",
            help="A second run, simulated with the same options, which is laid over the first.",
        ),
    ] = None,
    other_settings: Annotated[
        list[str] | None,
        typer.Option(
            "--with-set", metavar="NAME=VALUE", help="As --set, for the second run only; repeatable."
        ),
    ] = None,
    reactions: Annotated[
        bool, typer.Option("--reactions", help="Record the reactions of all joints, to be shown as arrows.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Write a page (.html), a picture (.png) or a film (.gif); do not open the browser.",
        ),
    ] = None,
    png: Annotated[
        Path | None, typer.Option("--png", metavar="FILE.png", help="Write a picture, without a browser.")
    ] = None,
    gif: Annotated[
        Path | None, typer.Option("--gif", metavar="FILE.gif", help="Write a film, without a browser.")
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="Pixels of pictures; default: 960x720, of films 480x360."),
    ] = None,
    camera: Annotated[
        str | None,
        typer.Option(
            metavar="VIEW",
            help="In pictures: start, front, side, top, or AZIMUTH,ELEVATION in degrees (-90,0: front).",
        ),
    ] = None,
    span: Annotated[
        str | None,
        typer.Option(metavar="FROM:TO", help="Times that a film shows [s]; a picture shows the first one."),
    ] = None,
    frame_rate: Annotated[
        float | None, typer.Option("--fps", help="Frames per second of films; default: 20.")
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(help="Of films, relative to real time; default: 1, or what takes 2 to 10 s."),
    ] = None,
    trails: Annotated[bool, typer.Option("--trails", help="Draw paths of points in pictures.")] = False,
    time_stamp: Annotated[bool, typer.Option("--time", help="Write the time into pictures.")] = False,
    dark: Annotated[bool, typer.Option("--dark", help="Draw pictures in dark colors.")] = False,
    degrees: Degrees = False,
    replay: Annotated[
        bool, typer.Option("--replay", help="Show a run, on a page that does not compute itself.")
    ] = False,
) -> Report:
    """Simulate a scene or an FMU, or take results, and show the motion in the browser.

    The page is one file, which can be mailed and needs no network. If this installation has the core for
    pages, the page of a scene simulates it, with sliders for inputs and parameters; otherwise, with --replay
    and for results, it shows a run. With --output, --png or --gif files are written instead.
    """
    files = _files(output, png, gif)
    choices = {
        "size": parse_size(size), "camera": parse_camera(camera), "span": parse_span(span),
        "frame_rate": frame_rate, "speed": speed, "trails": trails or None,
        "time_stamp": time_stamp or None, "dark": dark or None,
    }  # fmt: skip
    if not any(map(is_picture, files)):
        options = {"frame_rate": "fps", "time_stamp": "time"}
        given = [f"--{options.get(name, name)}" for name, value in choices.items() if value is not None]
        if given:
            raise UsageError(f"{', '.join(given)}: only for pictures, expected --png or --gif, too")
    if reactions and files and all(map(is_picture, files)):
        raise UsageError("--reactions: pictures have no arrows, expected a page: -o FILE.html")
    parameters = parse_parameters(settings or [], assembly_tolerance)
    from gelenk.simulation.files import ENDINGS

    if plant.suffix.lower() in ENDINGS or scene is not None:
        simulated = {"--stop": stop, "--input": inputs, "--with": other, "--with-set": other_settings}
        given = [name for name, value in simulated.items() if value is not None]
        if given or reactions:
            names = ", ".join([*given, *(["--reactions"] if reactions else [])])
            raise UsageError(f"{names}: only for simulations, found results in {plant}")
        return _put(_turned(_view_of_file(plant, scene, parameters), degrees), files, choices)
    try:
        with terminal_bar(sys.stderr) as progress:
            common: dict[str, Any] = {
                "stop": stop,
                "inputs": inputs,
                "reactions": reactions,
                "progress": progress,
            }
            shows_run = replay or reactions or stop == 0 or other is not None or bool(other_settings)
            computes = not shows_run and _computes(files, inputs)
            page = gelenk.view(plant, parameters=parameters, computes=computes, **common)
            if other is not None or other_settings:
                more = parse_settings(other_settings or [], "--with-set")
                page = page.overlay(gelenk.view(other or plant, parameters={**parameters, **more}, **common))
    except StepError as e:
        if e.view is None:
            raise
        return _put(_turned(e.view, degrees), files, choices, e)
    return _put(_turned(page, degrees), files, choices)


def _computes(files: Sequence[Path], inputs: object) -> bool:
    """Whether a page can compute, and is wanted."""
    from gelenk.simulation.computing import has_constant_inputs
    from gelenk.viewer.computing import has_core

    return has_core() and has_constant_inputs(inputs) and (not files or not all(map(is_picture, files)))


def _turned(page: View, degrees: bool) -> View:
    return page.in_degrees() if degrees else page


def _view_of_file(run: Path, scene: Path | None, parameters: Mapping[str, Value]) -> View:
    from gelenk.simulation.recording import scene_of

    result = gelenk.Result.read(run)
    if scene is None and result.scene is None:
        raise UsageError(f"{run}: found no mechanism in it, expected its scene, too: --scene FILE")
    loaded = scene_of(scene if scene is not None else result.scene or {})
    return result.view(scene=loaded.with_parameters(parameters))


def _files(output: Path | None, png: Path | None, gif: Path | None) -> list[Path]:
    """Return the files to write. Raises UsageError for wrong endings."""
    expected: dict[str, tuple[Path | None, tuple[str, ...]]] = {
        "--output": (output, (".html", ".htm", *PICTURES)),
        "--png": (png, (".png",)),
        "--gif": (gif, (".gif",)),
    }
    for option, (file, endings) in expected.items():
        if file is not None and file.suffix.lower() not in endings:
            allowed = " or ".join(f"FILE{ending}" for ending in endings if ending != ".htm")
            raise UsageError(f"{option} {file}: expected {allowed}")
    return [file for file, _ in expected.values() if file is not None]


def _put(
    page: View, files: Sequence[Path], choices: Mapping[str, Any], failure: StepError | None = None
) -> Report:
    written = [page.save(file, **(choices if is_picture(file) else {})) for file in files] or [page.show()]
    sizes = [file.stat().st_size for file in written]
    lines = [
        f"{file}: {size / 1e6:.1f} MB" if size >= 1e6 else f"{file}: {size / 1e3:.0f} kB"
        for file, size in zip(written, sizes, strict=True)
    ]
    data = [{"file": str(file), "bytes": size} for file, size in zip(written, sizes, strict=True)]
    return Report("\n".join(lines), data[0] if len(data) == 1 else {"files": data}, failure)


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    for function in (plot, view):
        app.command()(function)
