# SPDX-License-Identifier: BSD-3-Clause
"""Results in files of other tools, read back by these: the same bits, and the units."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import gelenk
from gelenk.cli.arguments import check_output_file
from gelenk.simulation.files import ENDINGS

UNITS = {"A.phi": "rad", "pose.r[1]": "m", "ratio": "1"}


@pytest.fixture
def result() -> gelenk.Result:
    """Numbers that need all of their bits, of all sizes."""
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(50, 4)) * 10.0 ** rng.integers(-300, 300, (50, 4))
    rows[:, 0] = np.arange(50) * 0.1
    return gelenk.Result(list(UNITS), rows, UNITS)


@pytest.mark.parametrize("ending", ENDINGS)
def test_results_are_read_back(ending: str, result: gelenk.Result, tmp_path: Path) -> None:
    if ending in (".parquet", ".nc"):
        pytest.importorskip({".parquet": "pyarrow", ".nc": "h5netcdf"}[ending], reason="not installed")
    path = tmp_path / f"run{ending}"
    result.save(path)
    again = gelenk.Result.read(path)
    assert again.names == result.names
    assert again.time.tobytes() == result.time.tobytes()
    for name in result:
        assert again[name].tobytes() == result[name].tobytes()
    assert again.units == ({} if ending == ".csv" else UNITS)


# What it asks for is the default since pandas 3.
@pytest.mark.filterwarnings("ignore:The 'float_precision' argument is deprecated")
def test_pandas_reads_parquet_and_csv(result: gelenk.Result, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    result.save(tmp_path / "run.parquet")
    result.save(tmp_path / "run.csv")
    columns = pandas.read_parquet(tmp_path / "run.parquet")
    assert columns.attrs["units"] == {"time": "s"} | UNITS
    rows = pandas.read_csv(tmp_path / "run.csv", index_col="time", float_precision="round_trip")
    for frame in (columns, rows, result.to_pandas()):
        assert list(frame.columns) == list(UNITS)
        assert frame.index.to_numpy().tobytes() == result.time.tobytes()
        for name in UNITS:
            assert frame[name].to_numpy().tobytes() == result[name].tobytes()


def test_xarray_reads_netcdf(result: gelenk.Result, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    pytest.importorskip("h5netcdf", reason="h5netcdf is not installed")
    result.save(tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", decode_times=False) as dataset:
        assert dataset["time"].attrs["units"] == "s"
        for name, unit in UNITS.items():
            assert dataset[name].attrs["units"] == unit
            assert dataset[name].to_numpy().tobytes() == result[name].tobytes()
    assert list(result.to_xarray().data_vars) == list(UNITS)


def test_scipy_reads_mat(result: gelenk.Result, tmp_path: Path) -> None:
    from scipy.io import loadmat

    result.save(tmp_path / "run.mat")
    content = loadmat(tmp_path / "run.mat", simplify_cells=True)
    assert list(content["names"]) == list(UNITS)
    assert list(content["units"]) == list(UNITS.values())
    assert content["time"].tobytes() == result.time.tobytes()
    assert content["values"][:, 1].tobytes() == result["pose.r[1]"].tobytes()


def test_one_signal_and_none(tmp_path: Path) -> None:
    for names in ([], ["A.phi"]):
        result = gelenk.Result(names, np.zeros((3, 1 + len(names))), dict.fromkeys(names, "rad"))
        for ending in (".csv", ".mat"):
            result.save(tmp_path / f"run{ending}")
            assert gelenk.Result.read(tmp_path / f"run{ending}").names == tuple(names)


def test_errors(result: gelenk.Result, tmp_path: Path) -> None:
    with pytest.raises(
        gelenk.UsageError, match=r"run\.xls: found the ending \.xls, expected \.csv, \.parquet"
    ):
        result.save(tmp_path / "run.xls")
    other = tmp_path / "other.csv"
    other.write_text("t,x\n0,1\n")
    with pytest.raises(gelenk.UsageError, match=r"other\.csv: .*found no column named time first"):
        gelenk.Result.read(other)
    other.write_text("time,x\n0,one\n")
    with pytest.raises(
        gelenk.UsageError, match=r"other\.csv:2: could not convert string to float: 'one'; expected"
    ):
        gelenk.Result.read(other)
    with pytest.raises(FileNotFoundError):
        gelenk.Result.read(tmp_path / "missing.csv")


def test_plots_have_a_panel_for_each_unit(result: gelenk.Result) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    figure = result.plot(["A.phi", "pose.r[1]"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["rad", "m"]
    assert [len(axes.lines) for axes in figure.axes] == [1, 1]
    assert len(result.plot().axes) == 2  # positions
    assert len(result.plot(["A.*", "ratio"]).axes) == 2
    with pytest.raises(gelenk.UsageError, match=r"A\.psi: no such signal; did you mean A\.phi"):
        result.plot(["A.psi"])


def test_missing_packages_are_named_before_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(
        gelenk.UsageError, match=r"\.parquet files are read and written with pyarrow.*gelenk\[tables"
    ):
        check_output_file(Path("run.parquet"))
    check_output_file(Path("run.csv"))
