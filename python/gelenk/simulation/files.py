# SPDX-License-Identifier: BSD-3-Clause
"""Results in files and tables of other tools: CSV, Parquet, NetCDF, MAT; pandas, xarray.

All numbers are kept to the bit, and all formats but CSV contain the units.
"""

from __future__ import annotations

import json
import math
import os
import struct
import zlib
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelenk.errors import GelenkError, UsageError
from gelenk.extras import extra
from gelenk.file_reading import check_file
from gelenk.file_writing import writing
from gelenk.model.scene import known_parameters
from gelenk.simulation.csv_file import csv_table
from gelenk.simulation.result import Result

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

DIMENSIONLESS = "1"
SCENE = "gelenk_scene"  # attribute, or variable of .mat files
_MAT_COMPRESSED = 15  # kind of an element
_MAT_VARIABLES = ("time", "values", "names", "units", SCENE)
FREE_SIZE = 50_000_000  # bytes of numbers that any compressed file may contain
MAX_COMPRESSION = 1000  # bytes of numbers for each byte of a larger file, as of many constant signals


def to_pandas(result: Result) -> pd.DataFrame:
    """Return a DataFrame with a column for each signal; the index is `time`, `attrs["units"]` the units.

    Raises:
        UsageError: pandas is not installed.
    """
    pandas = extra("pandas", "tables are made with pandas")
    frame: pd.DataFrame = pandas.DataFrame(
        {name: result[name] for name in result.names}, index=pandas.Index(result.time, name="time")
    )
    frame.attrs["units"] = {"time": "s"} | dict(result.units)
    return frame


def to_xarray(result: Result) -> xr.Dataset:
    """Return a Dataset with the dimension `time`; the attribute `units` of each signal is its unit.

    Raises:
        UsageError: xarray is not installed.
    """
    xarray = extra("xarray", "datasets are made with xarray")
    signals = {
        name: ("time", result[name], {"units": result.units.get(name, DIMENSIONLESS)})
        for name in result.names
    }
    dataset: xr.Dataset = xarray.Dataset(signals, {"time": ("time", result.time, {"units": "s"})})
    return dataset


def check_format(path: Path) -> None:
    """Check that a result can be written to a file with this name, or read from it.

    Raises:
        UsageError: the ending is unknown, or a package for its format is not installed.
    """
    for package in _format(path, _PACKAGES):
        extra(package, f"{path.suffix} files are read and written with {package}")


def write_result(result: Result, path: Path) -> None:
    """Write a result to a file: see `Result.save`."""
    check_format(path)
    _WRITERS[path.suffix.lower()](result, path)


def read_result(path: Path) -> Result:
    """Read a result that `Result.save` has written; CSV files contain no units.

    Raises:
        UsageError: the ending is unknown, the file is not such a result, or a package is not installed.
        OSError: the file cannot be read.

    Warns:
        FileWarning: it is a CSV file that was cut off.
    """
    check_format(path)
    check_file(path)
    try:
        return _READERS[path.suffix.lower()](path)
    except GelenkError:
        raise
    except KeyError as e:
        raise UsageError(f"{path}: found no {e.args[0]}; expected a result with `time` and signals") from None
    except Exception as e:  # readers of the formats raise anything for faulty files, MemoryError included
        why = " ".join(str(e).split()) or type(e).__name__
        raise UsageError(f"{path}: {why}; expected a result with `time` and signals") from None


def _format[T](path: Path, formats: Mapping[str, T]) -> T:
    ending = path.suffix.lower()
    if ending not in formats:
        found = f"the ending {path.suffix}" if ending else "no ending"
        raise UsageError(f"{path}: found {found}, expected {', '.join(formats)}")
    return formats[ending]


def _write_parquet(result: Result, path: Path) -> None:
    frame = to_pandas(result)
    frame.attrs |= _scene_text(result)
    with writing(path) as file:
        frame.to_parquet(file, engine="pyarrow")


def _read_parquet(path: Path) -> Result:
    parquet = import_module("pyarrow.parquet")
    with parquet.ParquetFile(path) as file:
        _check_size(path, 8 * file.metadata.num_rows * file.metadata.num_columns)
    frame = extra("pandas", "tables are read with pandas").read_parquet(path, engine="pyarrow")
    if frame.index.name != "time":
        raise KeyError("index named time")
    rows = np.column_stack([frame.index.to_numpy(float), frame.to_numpy(float)])
    return _with_scene(
        Result(list(frame.columns), rows, _without_time(frame.attrs.get("units", {}))), frame.attrs.get(SCENE)
    )


def _write_netcdf(result: Result, path: Path) -> None:
    dataset = to_xarray(result).assign_attrs(_scene_text(result))
    with writing(path) as file:
        dataset.to_netcdf(file, engine="h5netcdf")


def _read_netcdf(path: Path) -> Result:
    xarray = extra("xarray", "NetCDF files are read with xarray")
    with xarray.open_dataset(path, engine="h5netcdf", decode_times=False) as dataset:
        names = [str(name) for name in dataset.data_vars]
        _check_size(path, sum(8 * dataset[name].size for name in (*names, "time")))
        columns = [dataset["time"].to_numpy(), *(dataset[name].to_numpy() for name in names)]
        units = {name: str(dataset[name].attrs.get("units", DIMENSIONLESS)) for name in names}
        scene = dataset.attrs.get(SCENE)
    return _with_scene(Result(names, np.column_stack(columns), units), scene)


def _check_size(path: Path, size: int) -> None:
    """Check that the numbers of a file are in proportion to it.

    Args:
        path: the file, which may be compressed.
        size: of the numbers that it states to contain [bytes].
    """
    if size > max(FREE_SIZE, MAX_COMPRESSION * path.stat().st_size):
        raise ValueError(f"found {size / 1e6:.0f} MB of numbers in a file of {path.stat().st_size} bytes")


def _size_in_mat(path: Path) -> int:
    """Return the size of the variables in a .mat file of version 5 [bytes], which may be compressed."""
    size = 0
    with path.open("rb") as file:
        order = {b"IM": "<", b"MI": ">"}.get(file.read(128)[126:])
        while order and len(head := file.read(8)) == 8:
            kind, count = struct.unpack(f"{order}2I", head)
            after = file.seek(0, os.SEEK_CUR) + count
            if kind == _MAT_COMPRESSED:
                head = zlib.decompressobj().decompress(file.read(min(count, 1000)), 8)
                count = struct.unpack(f"{order}2I", head)[1]
            size += count
            file.seek(after)
    return size


# Names of signals are no names of variables in MATLAB: they are strings, in the order of the columns.
def _write_mat(result: Result, path: Path) -> None:
    from scipy.io import savemat

    names = list(result.names)
    values = np.column_stack([result[name] for name in names]) if names else np.empty((len(result), 0))
    units = [result.units.get(name, DIMENSIONLESS) for name in names]
    content = {
        "time": result.time[:, None], "values": values,
        "names": np.array(names, dtype=object), "units": np.array(units, dtype=object),
    }  # fmt: skip
    with writing(path) as file:
        savemat(file, content | _scene_text(result), oned_as="row")


def _read_mat(path: Path) -> Result:
    from scipy.io import loadmat, whosmat

    _check_size(path, _size_in_mat(path))
    variables = [(name, shape) for name, shape, _ in whosmat(path) if name in _MAT_VARIABLES]
    _check_size(path, sum(8 * math.prod(shape) for _, shape in variables))
    content: Mapping[str, Any] = loadmat(path, variable_names=list(_MAT_VARIABLES))

    def strings(key: str) -> list[str]:
        return [str(np.ravel(cell)[0]) for cell in np.ravel(content[key])]

    names = strings("names")
    rows = np.column_stack([content["time"], content["values"]])
    units = dict(zip(names, strings("units"), strict=True))
    return _with_scene(Result(names, rows, units), strings(SCENE)[0] if SCENE in content else None)


def _write_csv(result: Result, path: Path) -> None:
    result.to_csv(path)


def _read_csv(path: Path) -> Result:
    return Result(*csv_table(path), {})


def _scene_text(result: Result) -> dict[str, str]:
    """Return the scene of a result with the parameters of its run, as JSON, so that the file can be viewed.

    Empty if there is none: of an FMU that was not made by Gelenk, of a run that failed.
    """
    from gelenk.simulation.recording import scene_of

    if result.scene is not None:
        return {SCENE: json.dumps(result.scene)}
    if result.run is None:
        return {}
    plant, arguments = result.run
    try:
        scene = scene_of(plant)
        scene = scene.with_parameters(known_parameters(scene, arguments.get("parameters") or {}))
    except (GelenkError, OSError):  # the file has been changed or removed since
        return {}
    return {SCENE: json.dumps(scene.to_dict())}


def _with_scene(result: Result, text: Any) -> Result:
    if text:
        scene = json.loads(str(text))
        if not isinstance(scene, Mapping):
            raise ValueError(f"found {SCENE} that is not a scene")
        result.scene = scene
    return result


def _without_time(units: Mapping[str, str]) -> dict[str, str]:
    return {name: unit for name, unit in units.items() if name != "time"}


_WRITERS: dict[str, Callable[[Result, Path], None]] = {
    ".csv": _write_csv, ".parquet": _write_parquet, ".nc": _write_netcdf, ".mat": _write_mat,
}  # fmt: skip
_READERS: dict[str, Callable[[Path], Result]] = {
    ".csv": _read_csv, ".parquet": _read_parquet, ".nc": _read_netcdf, ".mat": _read_mat,
}  # fmt: skip
_PACKAGES: dict[str, tuple[str, ...]] = {
    ".csv": (), ".parquet": ("pandas", "pyarrow"), ".nc": ("xarray", "h5py", "h5netcdf"), ".mat": (),
}  # fmt: skip
ENDINGS = tuple(_PACKAGES)
