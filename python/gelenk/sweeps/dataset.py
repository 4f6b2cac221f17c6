# SPDX-License-Identifier: BSD-3-Clause
"""The result of a sweep as an xarray.Dataset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gelenk.extras import extra
from gelenk.sweeps.design import Design
from gelenk.sweeps.driver import Range
from gelenk.sweeps.plan import Chunk, Plan

if TYPE_CHECKING:
    import xarray as xr

RUN = "run"
TIME = "time"
MAX_MEMORY = 1_000_000_000  # bytes of trajectories; more than that remain in the store


def gathered(plan: Plan, runs: int, chunks: Iterable[Chunk], missing: str, *, lazily: bool) -> Chunk:
    """Return one chunk with all runs.

    Args:
        plan: the plan of the sweep.
        runs: number of runs.
        chunks: in any order.
        missing: the error of runs that are in none of them.
        lazily: whether trajectories are left out.
    """
    variables = [v for v in plan.variables if not (lazily and v.is_trajectory)]
    shapes = {v.name: (runs, len(plan.times)) if v.is_trajectory else (runs,) for v in variables}
    out = Chunk(
        0, {name: np.full(shape, np.nan) for name, shape in shapes.items()}, [missing] * runs, [""] * runs
    )
    for chunk in chunks:
        part = slice(chunk.first, chunk.last)
        for name, values in out.values.items():
            values[part] = chunk.values[name]
        out.errors[part] = chunk.errors
        out.warnings[part] = chunk.warnings
    return out


def lazy_trajectories(plan: Plan, runs: int, parts: list[tuple[Range, Path]]) -> dict[str, Any]:
    """Return the trajectories of a store as arrays of Dask, which read a part when it is needed.

    Args:
        plan: the plan of the sweep.
        runs: number of runs.
        parts: ranges of runs and their files, in order.
    """
    da = import_module("dask.array")
    delayed = import_module("dask").delayed
    found = {}
    points = len(plan.times)
    for variable in plan.variables:
        if not variable.is_trajectory:
            continue
        blocks, at = [], 0
        for (first, last), path in [*parts, ((runs, runs), Path())]:
            if first > at:
                blocks.append(da.full((first - at, points), np.nan))
            if last > first:
                values = delayed(_trajectory)(path, variable.name)
                blocks.append(da.from_delayed(values, (last - first, points), np.float64))
            at = last
        found[variable.name] = da.concatenate(blocks)
    return found


def _trajectory(path: Path, name: str) -> NDArray[np.float64]:
    from gelenk.sweeps.store import read_part

    return read_part(path, 0, [name]).values[name]


def dataset(
    plan: Plan,
    design: Design,
    outcome: Mapping[str, Any],
    errors: list[str],
    warnings: list[str],
    units: Mapping[str, str],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Return the result.

    Args:
        plan: the plan of the sweep.
        design: its runs.
        outcome: of each variable its values, shape (runs,) or (runs, times).
        errors: of all runs.
        warnings: of all runs.
        units: of parameters.
        attributes: of the Dataset.
    """
    xarray = extra("xarray", "results of sweeps are Datasets of xarray")
    grid = design.axes
    dims: tuple[str, ...] = (RUN,) if grid is None else tuple(grid)
    shape = (design.runs,) if grid is None else tuple(map(len, grid.values()))
    coordinates: dict[str, Any] = {}
    for name, values in (design.columns if grid is None else grid).items():
        unit = units.get(name, "")
        coordinates[name] = ((RUN,) if grid is None else (name,), values, {"units": unit} if unit else {})
    if grid is None:
        coordinates[RUN] = ((RUN,), np.arange(design.runs))
    data: dict[str, Any] = {}
    for variable in plan.variables:
        values = outcome[variable.name]
        own = {"units": variable.unit} if variable.unit else {}
        if variable.is_trajectory:
            data[variable.name] = ((*dims, TIME), values.reshape((*shape, len(plan.times))), own)
            coordinates[TIME] = ((TIME,), plan.times, {"units": "s"})
        else:
            data[variable.name] = (dims, values.reshape(shape), own)
    for name, texts in (("error", errors), ("warning", warnings)):
        data[name] = (dims, np.array(texts, dtype=object).reshape(shape))
    found: xr.Dataset = xarray.Dataset(data, coordinates, dict(attributes))
    return found
