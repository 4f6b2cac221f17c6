# SPDX-License-Identifier: BSD-3-Clause
"""Exporting: quick, whole or not at all, and what lies in the file."""

from __future__ import annotations

import json
import time
import zipfile
from pathlib import Path

import pytest

import gelenk

from .plants import crank_rocker, gyroscope


def test_export_takes_less_than_a_second(tmp_path: Path) -> None:
    begin = time.perf_counter()
    gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")
    assert time.perf_counter() - begin < 1.0


def test_the_fmu_holds_scene_page_licences_and_library(tmp_path: Path) -> None:
    found = gelenk.export_fmu(gyroscope(), tmp_path / "x.fmu")
    with zipfile.ZipFile(found) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        assert names[:5] == [
            "modelDescription.xml",
            "model.png",
            "binaries/linux64/Gyroscope.so",
            "resources/scene.json",
            "documentation/index.html",
        ]
        assert any(n.startswith("documentation/licenses/") for n in names)
        carried = json.loads(archive.read("resources/scene.json"))
        page = archive.read("documentation/index.html").decode()
    assert list(carried["joints"]) == ["S", "F"]
    for name in ("push.f[1]", "S.Q[4]", "tie.stiffness", "solver.steps"):
        assert f"<td>{name}</td>" in page


def test_names_that_are_no_identifiers_and_markup_are_escaped(tmp_path: Path) -> None:
    source = crank_rocker()
    source["name"] = '4-bar <"A" & B>'
    found = gelenk.export_fmu(source, tmp_path / "x.fmu")
    with zipfile.ZipFile(found) as archive:
        assert "binaries/linux64/_4_bar___A____B_.so" in archive.namelist()
    run = gelenk.simulate(found, stop=0.1, step=0.01)
    assert len(run) == 11


def test_a_failed_export_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    old = tmp_path / "x.fmu"
    old.write_bytes(b"old")
    torn = crank_rocker()
    torn["joints"]["D"]["parent"]["position"] = [50.0, 0.0, 0.0]
    with pytest.raises(gelenk.AssemblyError, match="cannot be closed: smallest gap"):
        gelenk.export_fmu(torn, old)
    assert old.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["x.fmu"]


def test_an_unwritable_place_is_named(tmp_path: Path) -> None:
    place = tmp_path / "missing" / "x.fmu"
    with pytest.raises(gelenk.ExportError, match=r"x\.fmu: the FMU could not be written: No such file"):
        gelenk.export_fmu(crank_rocker(), place)
    (tmp_path / "folder.fmu").mkdir()
    with pytest.raises(gelenk.ExportError, match=r"folder\.fmu: the FMU could not be written"):
        gelenk.export_fmu(crank_rocker(), tmp_path / "folder.fmu")
    assert [p.name for p in tmp_path.iterdir()] == ["folder.fmu"]
