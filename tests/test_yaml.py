# SPDX-License-Identifier: BSD-3-Clause
"""Scene files in YAML mean what they look like: YAML 1.2's core schema, not 1.1's surprises."""

from __future__ import annotations

import json
import math
import re
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

import gelenk
from gelenk import SceneError
from gelenk.model import yaml12


def read(text: str) -> Any:
    return json.loads(yaml12.to_json(text, "s.yaml"))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-6", 1e-6),  # a string in YAML 1.1, which wants a point and a sign
        ("-2E3", -2000.0),
        (".5", 0.5),
        ("3.", 3.0),
        ("+7", 7),
        ("010", 10),  # eight in YAML 1.1
        ("0o17", 15),
        ("0x1F", 31),
        ("1:30", "1:30"),  # ninety in YAML 1.1
        ("1_000", "1_000"),  # a thousand in YAML 1.1
        ("2026-11-21", "2026-11-21"),  # a date in YAML 1.1
        ("-.inf", -math.inf),
        ("on", "on"),  # true in YAML 1.1
        ("No", "No"),
        ("TRUE", True),
        ("false", False),
        ("~", None),
        ("", None),
        ("'1'", "1"),
        ("!!float 1", 1.0),
        ("µ", "µ"),
    ],
)
def test_scalar_means_what_it_looks_like(text: str, value: Any) -> None:
    found = read(f"[{text}]" if text else "[~]")[0]
    assert found == value
    assert type(found) is type(value)


def test_nan_is_passed_on_for_the_reader_to_report_with_its_path() -> None:
    assert math.isnan(read("a: .nan")["a"])


def test_keys_are_names_as_written() -> None:
    assert read("{on: 1, 1: 2, 1e3: 3, null: 4}") == {"on": 1, "1": 2, "1e3": 3, "null": 4}


def test_key_given_twice_reaches_the_reader_twice() -> None:
    assert yaml12.to_json("a: 1\na: 2\n", "s.yaml") == '{"a":1,"a":2}'


def test_alias_repeats_what_its_anchor_holds() -> None:
    assert read("a: &x [1, {b: 2}]\nc: *x") == {"a": [1, {"b": 2}], "c": [1, {"b": 2}]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "a: [1, 2",
            "s.yaml:1:9: found the end of the file after '2', expected ',' or ']' of the '[' of line 1; "
            "a comma or a bracket is missing",
        ),
        (
            "a: 1\n b: 2",
            "s.yaml:2:2: found 'b: 2' indented by 1, expected 0 as the line above; "
            "indent entries of one block equally",
        ),
        ("a: &x [*x]", "s.yaml:1:4: contains itself through an alias"),
        (
            "a: *y",
            "s.yaml:1:4: found '*y', expected a value; & and * name anchors of YAML, put text in quotes",
        ),
        ("{[1]: 2}", "s.yaml:1:2: found a list or mapping as key, expected a name"),
        ("a: !rod {l: 1}", "s.yaml:1:4: found the tag !rod, expected a plain value"),
        (
            "a: [1,, 2]",
            "s.yaml:1:7: found ',' in 'a: [1,, 2]', expected a value; "
            "remove the sign, or add the missing value",
        ),
        ("a: |x", "s.yaml:1:4: found '|x', expected a value; put text that begins like this in quotes"),
        ("{a: 1}\nb: 2", "s.yaml:2:1: found 'b: 2' after the end of the scene, expected nothing more"),
        ("a: !!int x", "s.yaml:1:4: found 'x', expected int"),
        (
            "--- 1\n--- 2",
            "s.yaml:2:1: found a second document after '---', expected one scene; use a file for each scene",
        ),
    ],
)
def test_mistake_is_told_with_line_and_column(text: str, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        yaml12.to_json(text, "s.yaml")
    assert caught.value.lines == (message,)


def test_depth_without_end_is_refused() -> None:
    with pytest.raises(SceneError, match=r"s\.yaml: nested too deeply for a scene"):
        yaml12.to_json("[" * 5000 + "]" * 5000, "s.yaml")


def test_aliases_that_multiply_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten lines that each name the one before ten times stand for ten thousand million values."""
    lines = ["a0: &a0 x"] + [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 11)]
    monkeypatch.setattr(yaml12, "MAX_VALUES", 10_000)
    with pytest.raises(SceneError, match="aliases expand to more than 10000 values"):
        yaml12.to_json("\n".join(lines), "s.yaml")


@pytest.mark.parametrize("more", [0, 1])
def test_as_many_values_as_allowed_are_read(more: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A list of n - 1 values is a value itself."""
    monkeypatch.setattr(yaml12, "MAX_VALUES", 100)
    text = "[" + ", ".join("x" for _ in range(99 + more)) + "]"
    if more:
        with pytest.raises(SceneError, match="more than 100 values"):
            yaml12.to_json(text, "s.yaml")
    else:
        assert read(text) == ["x"] * 99


def test_both_readers_allow_the_same_number_of_values(root: Path) -> None:
    """As shipped: 25 times what a scene of 10 000 bodies has."""
    native = (root / "src" / "scene_file" / "yaml.cpp").read_text("utf-8")
    (allowed,) = re.findall(r"max_values =\s*([0-9']+);", native)
    assert yaml12.MAX_VALUES == int(allowed.replace("'", "")) == 25 * 200_000


def test_what_is_dumped_is_read_back() -> None:
    data = {"a": 1e-06, "b": [1, 2.5, "on", "1e3", "0o7", "~", True, None], "c": {"d": "x: y"}}
    assert read(yaml12.dump(data)) == data


def test_yaml_takes_a_few_times_the_time_of_json(tmp_path: Path) -> None:
    """At most ten times, in processor time, for a scene of 3000 bodies: 3.5 to 4.5 times with libyaml."""
    bodies = {f"b{k}": {"mass": 1.0} for k in range(3000)}
    joints = {
        f"J{k}": {
            "type": "prismatic",
            "axis": [1, 0, 0],
            "parent": {"body": "ground"},
            "child": {"body": body},
        }
        for k, body in enumerate(bodies)
    }
    scene = {"gelenk": 1, "name": "Many", "bodies": bodies, "joints": joints}
    (tmp_path / "many.json").write_text(json.dumps(scene))
    if not yaml.__with_libyaml__:
        pytest.skip("PyYAML was built without libyaml")
    (tmp_path / "many.yaml").write_text(yaml.dump(scene, Dumper=yaml.CSafeDumper, sort_keys=False))

    def seconds(name: str) -> float:
        start = time.process_time()
        gelenk.load(tmp_path / name)
        return time.process_time() - start

    found = {name: min(seconds(name) for _ in range(3)) for name in ("many.json", "many.yaml")}
    assert found["many.yaml"] < 10 * found["many.json"], found


def test_aliases_cost_no_time() -> None:
    """What grows exponentially is refused before it is written."""
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, 200)]
    start = time.process_time()
    with pytest.raises(SceneError, match="aliases expand to more than"):
        gelenk.load("\n".join(lines))
    assert time.process_time() - start < 1.0
    text = "x" * 100_000
    with pytest.raises(SceneError, match="aliases expand to more than"):
        gelenk.load(f"a: &a [{text}]\nb: [{', '.join(['*a'] * 1000)}]\n")
