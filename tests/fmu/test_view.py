# SPDX-License-Identifier: BSD-3-Clause
"""The page of an FMU with the mechanism in three dimensions."""

from __future__ import annotations

import base64
import json
import logging
import re
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_files

import gelenk
from gelenk import _core
from gelenk.viewer import page

from .plants import crank_rocker

DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)


def documents(fmu: Path) -> tuple[str, str | None]:
    """The documentation page, and the page with the view."""
    with zipfile.ZipFile(fmu) as archive:
        has_view = "documentation/view.html" in archive.namelist()
        view = archive.read("documentation/view.html").decode() if has_view else None
        return archive.read("documentation/index.html").decode(), view


def data_of(view: str | None) -> Any:
    assert view is not None
    found = DATA.search(view)
    assert found
    return json.loads(found[1])


@pytest.mark.parametrize("file", scene_files.good(), ids=lambda file: file.stem)
def test_bodies_are_where_the_scene_starts(file: Path, tmp_path: Path) -> None:
    """Against the poses of a simulation; single precision. A start at an equilibrium is not searched for."""
    source = gelenk.load(file).to_dict()
    source.get("solver", {}).pop("start", None)
    data = data_of(documents(gelenk.export_fmu(source, tmp_path / "x.fmu"))[1])
    assert [body["name"] for body in data["bodies"]] == list(source["bodies"])
    poses = np.frombuffer(base64.b64decode(data["poses"]), "<f4").reshape(-1, 7)
    simulation = gelenk.Simulation(source)
    simulation.initialize()
    for name, pose in zip(source["bodies"], poses.astype(float), strict=True):
        R, p = simulation.pose(name)
        assert pose[:3] == pytest.approx(p, abs=1e-6)
        u, w = pose[3:6], pose[6]
        cross = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
        turned = np.eye(3) + 2 * w * cross + 2 * cross @ cross
        assert turned == pytest.approx(R, abs=1e-6)


def test_the_documentation_shows_the_view_and_stays_small(tmp_path: Path) -> None:
    with_view = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")
    without = gelenk.export_fmu(crank_rocker(), tmp_path / "y.fmu", view=False)
    index, view = documents(with_view)
    assert '<iframe src="view.html"' in index
    assert view is not None
    assert "https:" not in index
    assert with_view.stat().st_size - without.stat().st_size < 250_000  # bytes; three.js has 150,000 of them


def test_an_fmu_without_a_view_says_so(tmp_path: Path) -> None:
    index, view = documents(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu", view=False))
    assert view is None
    assert "<iframe" not in index
    assert "no view in three dimensions; <code>gelenk view</code> shows it" in index
    assert "<svg" in index


def test_without_a_viewer_an_fmu_is_exported_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Builds without trimesh have no three.js."""
    monkeypatch.setattr(page, "LIBRARY", "missing.js")
    with caplog.at_level(logging.WARNING, "gelenk"):
        index, view = documents(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu"))
    assert view is None
    assert "no view in three dimensions" in index
    assert "missing.js is missing" in caplog.text


def test_the_same_scene_gives_the_same_bytes(tmp_path: Path) -> None:
    """Also in another process."""
    first = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu").read_bytes()
    assert gelenk.export_fmu(crank_rocker(), tmp_path / "y.fmu").read_bytes() == first
    (tmp_path / "s.json").write_text(json.dumps(crank_rocker()))
    code = "import gelenk; gelenk.export_fmu('s.json', 'z.fmu')"
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, timeout=120)
    assert (tmp_path / "z.fmu").read_bytes() == first


def test_only_what_the_fmu_contains_is_shown(tmp_path: Path) -> None:
    source = crank_rocker()
    source["bodies"]["other"] = {"mass": 1.0}
    source["joints"]["slide"] = {"type": "prismatic", "parent": "ground", "child": "other"}
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu", outputs=["slide.*"])
    assert [body["name"] for body in data_of(documents(fmu)[1])["bodies"]] == ["other"]


def test_an_error_of_the_view_is_not_lost(tmp_path: Path) -> None:
    """No incomplete FMU remains."""

    def fails(scene: str, poses: list[float]) -> str:
        raise ZeroDivisionError(f"{len(json.loads(scene)['bodies'])} bodies, {len(poses)} numbers")

    scene = gelenk.load(crank_rocker())._core
    with pytest.raises(ZeroDivisionError, match="3 bodies, 21 numbers"):
        _core.export_fmu(
            scene,
            [("linux64", gelenk.io.export.runtime_library())],
            tmp_path / "x.fmu",
            tmp_path,
            None,
            fails,
        )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["four_bar", "stewart"])
def test_plates_and_links_need_no_scipy(name: str, root: Path, tmp_path: Path) -> None:
    """Its import takes longer than the export."""
    code = (
        f"import sys, gelenk; gelenk.export_fmu({str(root / 'scenes' / name)!r} + '.yaml', 'x.fmu')\n"
        "assert not {name for name in sys.modules if name.partition('.')[0] in ('scipy', 'fmpy', 'control')}"
    )
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, timeout=120)
