# SPDX-License-Identifier: BSD-3-Clause
"""Tables of files: columns by name and number, two arguments, other folders, and files that are no tables."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import gelenk

from .test_law_branches import slide


def test_table_of_a_file_in_the_folder_of_the_scene(tmp_path: Path) -> None:
    """Columns by name and by number, tables over two arguments, and what is saved elsewhere."""
    (tmp_path / "gas.csv").write_text("# measured\nangle;time;force\n0;9;100\n0.1;9;50\n0.2;9;1\n")
    (tmp_path / "map.csv").write_text("x\\y,0,1,2\n0,0,1,2\n1,10,11,12\n")
    (tmp_path / "two.txt").write_text("0 0\n1 2\n")
    description = slide(
        "table(gas, s) - table(map, s, v) + table(two, s) + table(third, s)", {"s": 0.1},
        tables={
            "gas": {"file": "gas.csv", "columns": ["angle", "force"], "extrapolation": "linear"},
            "third": {"file": "gas.csv", "columns": [1, 3]},
            "map": {"file": "map.csv"},
            "two": {"file": "two.txt"},
        },
    )  # fmt: skip
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(description))
    loaded = gelenk.load(file)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    loaded.save(elsewhere / "scene.yaml")
    for one in (loaded, gelenk.load(elsewhere / "scene.yaml")):
        simulation = gelenk.Simulation(one)
        simulation.initialize(0.0, 1e-8)
        assert simulation.output("S.a") == pytest.approx(50 - 1 + 0.2 + 50, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("0,nan\n1,2\n2,3\n", "'nan' in line 1"),
        ("0;7,5\n1;2\n2;3\n", "the decimal point is '.'"),
        ("0,7 N\n1,2\n2,3\n", "'7 N' in line 1"),
        ("1_0,2\n3,4\n5,6\n", "'1_0' in line 1"),
        ("a,b\n1,2\n", "1 lines of numbers"),
        ("1,2\n3\n", "1 numbers in line 2"),
        ("a,b,c\n1,2,3\n2,3,4\n", "the columns a, b, c"),
        ("1\n2\n", "a single column"),
        ("", "0 lines of numbers"),
    ],
)
def test_files_that_are_no_tables(tmp_path: Path, text: str, answer: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    description = slide("table(p, s)", {"s": 0.0}, tables={"p": {"file": "a.csv"}})
    (tmp_path / "scene.json").write_text(json.dumps(description))
    with pytest.raises(gelenk.SceneError, match=answer):
        gelenk.load(tmp_path / "scene.json")
