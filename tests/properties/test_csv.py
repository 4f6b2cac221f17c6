# SPDX-License-Identifier: BSD-3-Clause
"""CSV tables of inputs and results: numbers are restored exactly,
and invalid cells are reported with their line.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gelenk.errors import UsageError
from gelenk.simulation.inputs import read_csv
from gelenk.simulation.result import Result

from .bounds import examples

NUMBER = st.floats(allow_nan=False, allow_infinity=False)
NAME = st.from_regex(r"[A-Za-z_]\w{0,5}(\.\w{1,5})?(\[[1-9]\])?", fullmatch=True).filter(
    lambda name: name != "time"
)


@st.composite
def results(draw: st.DrawFn) -> Result:
    names = draw(st.lists(NAME, min_size=1, max_size=4, unique=True))
    rows = draw(st.lists(st.tuples(*[NUMBER] * (1 + len(names))), min_size=1, max_size=6))
    return Result(names, np.array(rows), dict.fromkeys(names, "1"))


@examples(100)
@given(result=results())
def test_written_tables_are_read_exactly(result: Result, tmp_path: Path) -> None:
    result.to_csv(tmp_path / "x.csv")
    table = read_csv(tmp_path / "x.csv")
    assert table.dtype.names == ("time", *result.names)
    assert table.tobytes() == result.table.tobytes()


def is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


@pytest.mark.filterwarnings("ignore:.* was cut off after line:gelenk.FileWarning")
@examples(100)
@given(result=results(), data=st.data())
def test_non_numeric_cell_is_refused_with_its_line(
    result: Result, data: st.DataObject, tmp_path: Path
) -> None:
    lines = result.csv().splitlines()
    at = data.draw(st.integers(1, len(lines) - 1))
    cells = lines[at].split(",")
    k = data.draw(st.integers(0, len(cells) - 1))
    cells[k] = data.draw(
        st.text(st.characters(exclude_categories=["Cs", "Zl", "Zp", "Cc"], exclude_characters='",')).filter(
            lambda text: not is_number(text)
        )
    )
    lines[at] = ",".join(cells)
    path = tmp_path / "x.csv"
    path.write_text("\n".join(lines) + "\n", "utf-8")
    with pytest.raises(UsageError) as error:
        read_csv(path)
    assert str(error.value).startswith(f"{path}:{at + 1}: {['time', *result.names][k]}: found ")


@examples(100)
@given(result=results(), more=st.booleans(), data=st.data())
def test_row_of_wrong_length_is_refused_with_its_line(
    result: Result, more: bool, data: st.DataObject, tmp_path: Path
) -> None:
    lines = result.csv().splitlines()
    at = data.draw(st.integers(1, len(lines) - 1))
    lines[at] = lines[at] + ",1" if more else lines[at].rpartition(",")[0]
    path = tmp_path / "x.csv"
    path.write_text("\n".join(lines) + "\n", "utf-8")
    with pytest.raises(UsageError) as error:
        read_csv(path)
    width = 1 + len(result.names)
    assert str(error.value) == f"{path}:{at + 1}: found {width + (1 if more else -1)} cells, expected {width}"


@examples(200)
@given(
    content=st.binary(max_size=60)
    | st.text(st.sampled_from('time,\n\r"0.1e-f '), max_size=40).map(str.encode)
)
@example(content=b"time,\n1,2\n")
@example(content=b"time,,f1\n1,2,3\n")
@example(content=b'"time\n1')
def test_arbitrary_bytes_are_a_table_or_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_bytes(content)
    try:
        table = read_csv(path)
    except UsageError as error:
        said = str(error)
    else:
        assert table.size > 0
        assert all(np.isfinite(table[name]).all() for name in table.dtype.names or ())
        return
    assert said.startswith(str(path))
