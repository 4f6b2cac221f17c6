# SPDX-License-Identifier: BSD-3-Clause
"""The command `gelenk sweep`."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import gelenk
from gelenk.cli import completion
from gelenk.cli.arguments import InputTable, ParametersAndInputs, Without, parse_settings
from gelenk.cli.command import Report, command
from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.file_writing import writing

if TYPE_CHECKING:
    import xarray as xr

_RANGE = re.compile(r"([^:]+):([^:]+):(\d+)")
_ENDINGS = (".nc", ".csv", ".parquet")


@command
def sweep(
    plant: Annotated[Path, typer.Argument(metavar="SCENE|FMU", help="Scene file or .fmu file.")],
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="NAME=VALUES",
            help="What differs between runs: A,B,C or FROM:TO:COUNT, or a distribution such as "
            "'normal(1, 0.01)'; repeatable.",
            autocompletion=completion.settings,
        ),
    ] = None,
    settings: ParametersAndInputs = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option(
            "--outputs",
            metavar="NAME:REDUCTION",
            help="What is kept of each run: last, max, min, mean, rms, 'first>NUMBER', or trajectory, the "
            "default; repeatable.",
        ),
    ] = None,
    design: Annotated[
        str, typer.Option(metavar="NAME", help="Design: grid, list, latin, sobol, random or saltelli.")
    ] = "grid",
    samples: Annotated[
        int | None,
        typer.Option(help="Number of runs of latin, sobol and random, of base points of saltelli."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of their random numbers.")] = 0,
    stop: Annotated[float | None, typer.Option(help="End of each run [s].")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s].")] = None,
    inputs: InputTable = None,
    without: Without = None,
    store: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="Keep outcomes here; the same command continues after an interruption."
        ),
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option(metavar="local|ADDRESS", help="Make the runs in processes of Dask, or on its cluster."),
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Number of threads or processes.")] = None,
    isolate: Annotated[
        bool, typer.Option("--isolate", help="Make runs in processes of their own, which may crash.")
    ] = False,
    max_time: Annotated[float | None, typer.Option(help="Time after which the sweep ends [s].")] = None,
    max_run_time: Annotated[float | None, typer.Option(help="Time that a run may take [s].")] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="Results: .nc, or tables: .csv, .parquet."),
    ] = None,
) -> Report:
    """Simulate a scene or an FMU many times with different parameters.

    Without --output, the range of every output over the runs is printed.
    """
    if output is not None and output.suffix.lower() not in _ENDINGS:
        raise UsageError(f"--output {output}: expected a file that ends with {', '.join(_ENDINGS)}")
    varied = {
        name: parse_values(name, str(text)) for name, text in parse_settings(vary or [], "--vary").items()
    }
    fixed = parse_settings(settings or [])
    twice = [name for name in varied if name in fixed]
    if twice:
        raise UsageError(f"--set {twice[0]}: the parameter is varied by --vary")
    found = gelenk.sweep(
        plant, {**fixed, **varied}, outputs=parse_outputs(outputs), inputs=inputs, design=design,
        samples=samples, seed=seed, stop=stop, step=step, without=without or [], store=store, cluster=cluster,
        workers=workers, isolate=isolate, max_time=max_time, max_run_time=max_run_time,
        progress=sys.stderr.isatty(),
    )  # fmt: skip
    if output is not None:
        write(found, output)
    return Report(_text(found, output), _data(found, output))


def parse_values(name: str, text: str) -> Any:
    """Return a list of values, or a distribution as text, from A,B,C, FROM:TO:COUNT or NAME(...).

    Raises:
        UsageError: the text is none of them.
    """
    text = text.strip()
    if text.endswith(")"):
        return text
    import numpy as np

    if found := _RANGE.fullmatch(text):
        try:
            return np.linspace(float(found[1]), float(found[2]), int(found[3]))
        except ValueError:
            raise UsageError(f"--vary {name}={text}: expected FROM:TO:COUNT") from None
    values = [value.strip() for value in text.split(",")]
    try:
        return [float(value) for value in values]
    except ValueError:
        return values


def parse_outputs(given: list[str] | None) -> Any:
    """Return the argument `outputs` of `gelenk.sweep` from NAME:REDUCTION texts."""
    if given is None:
        return None
    found: dict[str, list[str]] = {}
    for text in given:
        name, _, reduction = text.partition(":")
        found.setdefault(name.strip(), []).append(reduction.strip() or "trajectory")
    return found


def write(found: xr.Dataset, output: Path) -> None:
    """Write the result of a sweep; tables have a row for each run, or for each run and time.

    Raises:
        UsageError: a package is not installed.
        OSError: the file cannot be written.
    """
    if output.suffix.lower() == ".nc":
        extra("h5netcdf", "NetCDF files are written with h5netcdf")
        with writing(output) as file:
            found.to_netcdf(file, engine="h5netcdf")
        return
    extra("pandas", "tables are written with pandas")
    table = found.to_dataframe().reset_index()
    with writing(output) as file:
        if output.suffix.lower() == ".csv":
            table.to_csv(file, index=False)
        else:
            table.to_parquet(file, index=False)


def _failures(found: xr.Dataset) -> list[str]:
    return [text for text in found["error"].values.ravel().tolist() if text]


def _text(found: xr.Dataset, output: Path | None) -> str:
    failures = _failures(found)
    runs = found["error"].size
    lines = [f"{runs} runs, {len(failures)} failed"]
    if failures:
        lines.append(f"the first failure: {failures[0]}")
    if output is not None:
        return "\n".join([f"{output}: {lines[0]}", *lines[1:]])
    ranges = _ranges(found)
    width = max(map(len, ranges))
    lines.append(f"{'':{width}}  {'min':>12} {'mean':>12} {'max':>12}")
    for name, row in ranges.items():
        unit = found[name].attrs.get("units", "")
        cells = " ".join(f"{x:12.6g}" for x in row.values())
        lines.append(f"{name:{width}}  {cells}{'' if unit in ('', '1') else '  ' + unit}")
    return "\n".join(lines)


def _ranges(found: xr.Dataset) -> dict[str, dict[str, float]]:
    names = [str(name) for name in found.data_vars if name not in ("error", "warning")]
    reductions = ("min", "mean", "max")
    return {name: {how: float(getattr(found[name], how)()) for how in reductions} for name in names}


def _data(found: xr.Dataset, output: Path | None) -> dict[str, Any]:
    return {
        "file": None if output is None else str(output), "runs": found["error"].size,
        "failed": len(_failures(found)), "errors": sorted(set(_failures(found)))[:20],
        "outputs": {
            name: {"unit": found[name].attrs.get("units", ""), **row} for name, row in _ranges(found).items()
        },
        "provenance": dict(found.attrs),
    }  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(sweep)
