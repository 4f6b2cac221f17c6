# SPDX-License-Identifier: BSD-3-Clause
"""Any text for a name: taken and found again everywhere, or refused where it stands in the file."""

from __future__ import annotations

import json
import re
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mechanisms import Scene, body, frame, joint, scene

import gelenk
from gelenk import _core

from .bounds import examples

# Of hypothesis's own making, with what XML, YAML, JSON, shells and Python take for something else.
TEXT = st.text(max_size=20) | st.text(
    st.sampled_from(" \t\n\r\x00\x0b\x85\u2028\ufeff\"'\\&<>]:#-{}[],.%$*?é漢😀a1_"), max_size=8
)
IDENTIFIER = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,20}", fullmatch=True)
WORDS = [
    "on",
    "no",
    "y",
    "null",
    "true",
    "ground",
    "time",
    "der",
    "nan",
    "e1",
    "_",
    "phi",
    "1e5",
    "0x1",
    "~",
    "ｘ",
]  # that a reader knows
SHORT = st.sampled_from([*WORDS, "", "x" * 200])
NAME = TEXT | IDENTIFIER | SHORT


def named(place: str, name: str) -> Scene:
    """A pendulum with a motor; what `place` says goes by that name."""
    names = {"bodies": "bob", "joints": "pin", "motors": "drive", "sensors": "meter"} | {place: name}
    out = scene({names["bodies"]: body(1.0, (0.3, 0, 0), (0.1, 0.1, 0.1))}, {names["joints"]: joint(
        "revolute", frame("ground"), frame(names["bodies"]), axis=[0, 1, 0])})  # fmt: skip
    out["motors"] = {names["motors"]: {"joint": names["joints"]}}
    out["sensors"] = {names["sensors"]: {"type": "energy"}}
    return out


def read(data: dict[str, Any], path: Path) -> tuple[gelenk.Scene | None, str]:
    """From a file with each name on a line of its own: the scene, or why it is refused."""
    path.write_text(json.dumps(data, indent=1, ensure_ascii=False), "utf-8")
    try:
        return gelenk.load(path), ""
    except gelenk.SceneError as error:
        return None, str(error)


def lines_of(name: str, depth: int, path: Path) -> list[int]:
    """Where a name stands so far within."""
    start = " " * depth + json.dumps(name, ensure_ascii=False) + ": "
    return [k for k, line in enumerate(path.read_text("utf-8").split("\n"), 1) if line.startswith(start)]


@pytest.mark.parametrize("place", ["bodies", "joints", "motors", "sensors"])
@examples(60)
@given(name=NAME)
@example(name="x" * 201)
def test_a_name_is_found_again_or_refused_by_its_line(place: str, name: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    loaded, said = read(named(place, name), path)
    if loaded is None:
        assert any(said.startswith(f"{path}:{k}: {place}.") for k in lines_of(name, 2, path)), said
        assert name == "ground" or len(name) > 200 or not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII)
        return
    assert list(loaded.to_dict()[place]) == [name]
    for ending in ("yaml", "json"):
        again = tmp_path / f"again.{ending}"
        loaded.save(again)
        assert gelenk.load(again).to_dict() == loaded.to_dict()
    assert _core.input_names(loaded._core) == [f"{name}.tau" if place == "motors" else "drive.tau"]


@examples(60)
@given(name=TEXT | SHORT)
@example(name="]]>")
def test_a_scene_of_any_name_has_a_page_that_can_be_read(name: str, tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    loaded, said = read(named("bodies", "bob") | {"name": name}, path)
    if loaded is None:
        (at,) = lines_of("name", 1, path)
        assert said.startswith(f"{path}:{at}: name: found "), said
        return
    assert loaded.name == name
    with zipfile.ZipFile(gelenk.export_fmu(loaded, tmp_path / "x.fmu")) as archive:
        page = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert page.get("modelName") == name
