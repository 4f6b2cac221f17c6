# SPDX-License-Identifier: BSD-3-Clause
"""Results in CSV files say that they are complete, in numbers that all programs read."""

from __future__ import annotations

import csv
import warnings
from pathlib import Path

import numpy as np
import pytest

import gelenk
from gelenk.simulation.csv_file import csv_table
from gelenk.simulation.inputs import read_csv

RESULTS = {
    "short": gelenk.Result(["A.phi"], np.array([[0.0, 6.789012345], [0.25, -1e-300], [1e-05, 1e22]]), {}),
    "one row": gelenk.Result(["A.phi", "B.phi"], np.array([[-1e-07, 1.25, 6.789012345]]), {}),
    "two rows": gelenk.Result(["A.phi"], np.array([[-2e300, 1.25], [123456789.0, 0.1]]), {}),
}


@pytest.fixture(params=RESULTS)
def result(request: pytest.FixtureRequest) -> gelenk.Result:
    return RESULTS[request.param]


def test_wherever_a_file_is_cut_off_it_is_noticed(result: gelenk.Result, tmp_path: Path) -> None:
    """It is refused, or read with a warning up to the last complete row."""
    path = tmp_path / "run.csv"
    whole = result.csv()
    for count in range(len(whole)):
        path.write_text(whole[:count])
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                found = gelenk.Result.read(path)
            except gelenk.UsageError:
                continue
        assert [w.category for w in caught] == [gelenk.FileWarning], whole[:count]
        assert str(caught[0].message) == (
            f"{path}: was cut off after line {len(found) + 1}; what follows is missing"
        )
        assert len(found) == whole[:count].count("\n") - 1
        assert found.table.tobytes() == result.table[: len(found)].tobytes()


def test_a_complete_file_is_read_in_silence(result: gelenk.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.csv")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert gelenk.Result.read(tmp_path / "run.csv").table.tobytes() == result.table.tobytes()
        assert read_csv(tmp_path / "run.csv").tobytes() == result.table.tobytes()


def test_a_table_of_inputs_that_was_cut_off_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(RESULTS["short"].csv().rpartition(".")[0])
    with pytest.warns(gelenk.FileWarning, match=r"run\.csv: was cut off after line 3;"):
        assert len(read_csv(path)) == 2


def test_other_programs_read_the_numbers(result: gelenk.Result, tmp_path: Path) -> None:
    """Without options, as numbers: to the bit where the reader rounds correctly."""
    path = tmp_path / "run.csv"
    result.save(path)
    rows = np.array([list(row) for row in result.table])
    with path.open(newline="") as file:
        [_, *lines] = csv.reader(file)
    assert np.array(lines, float).tobytes() == rows.tobytes()
    assert np.atleast_2d(np.loadtxt(path, delimiter=",", skiprows=1)).tobytes() == rows.tobytes()
    named = np.genfromtxt(path, delimiter=",", names=True, deletechars="")
    assert named.dtype.names == ("time", *result.names)
    assert np.atleast_1d(named)["time"].tobytes() == rows[:, 0].tobytes()
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    frame = pandas.read_csv(path)
    assert list(frame.columns) == ["time", *result.names]
    assert set(frame.dtypes) == {np.dtype(float)}
    # Its parser may be wrong by a unit in the last place.
    np.testing.assert_allclose(frame.to_numpy(), rows, rtol=2.3e-16, atol=0.0)
    arrow = pytest.importorskip("pyarrow.csv", reason="pyarrow is not installed")
    table = arrow.read_csv(path)
    assert {str(column) for column in table.schema.types} == {"double"}
    assert table["time"].to_numpy().tobytes() == rows[:, 0].tobytes()
    for engine in ("python", "pyarrow"):
        assert pandas.read_csv(path, engine=engine)["time"].to_numpy().tobytes() == rows[:, 0].tobytes()


@pytest.mark.parametrize(
    "text",
    [
        "time,x\n0,1\n1,2",
        "time,x\n0.0,1.0\n0.1,2.0",
        "time,x\r\n0.0,1.0\r\n0.1,2.0\r\n",
        "time,x\n0.0E+00,1\n1.0E+00,2\n",
        "time,x\n0.000000E+00,1.000000E+00\n1.000000E-01,2.000000E+00",
        "time,x\n0e0,1\n1e-3,2\n",
        '"time","x"\n0,1\n',
        "\ufefftime,x\n0,1\n",
        "time,x\n\n0,1\n\n\n",
    ],
)
def test_tables_of_others_are_not_warned_of(text: str, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text(text, encoding="utf-8", newline="")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        names, rows = csv_table(tmp_path / "x.csv")
        assert names == ["x"]
        assert read_csv(tmp_path / "x.csv")["x"].tobytes() == rows[:, 1].tobytes()


def test_a_command_says_on_one_line_what_is_missing(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from gelenk.cli.commands import app

    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    path = tmp_path / "run.csv"
    path.write_text(RESULTS["short"].csv()[:-4])
    done = CliRunner().invoke(app, ["plot", str(path), "A.phi", "-o", str(tmp_path / "x.png")])
    assert done.exit_code == 0
    said = [
        line for line in done.output.splitlines() if str(path) in line
    ]  # older versions of click mix both
    assert said == [f"{path}: was cut off after line 3; what follows is missing"]
