# SPDX-License-Identifier: BSD-3-Clause
"""Exporting: quick, whole or not at all, and what lies in the file."""

from __future__ import annotations

import gzip
import json
import math
import shutil
import struct
import time
import zipfile
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import scene_files
from numpy.typing import NDArray

import gelenk
from gelenk import _core
from gelenk.io import export

from .plants import crank_rocker, gyroscope


@pytest.mark.clock
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
        picture = archive.read("model.png")
    assert list(carried["joints"]) == ["S", "F"]
    for name in ("push.f[1]", "S.Q[4]", "tie.stiffness", "solver.steps"):
        assert f"<td>{name}</td>" in page
    assert pixels(picture).shape == (360, 480, 3)


def test_what_can_be_smaller_is_deflated(tmp_path: Path) -> None:
    with zipfile.ZipFile(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")) as archive:
        members = archive.infolist()
    assert all(m.compress_size <= m.file_size for m in members)
    assert {m.compress_type for m in members if m.filename != "model.png"} == {zipfile.ZIP_DEFLATED}
    assert sum(m.compress_size for m in members) < 0.5 * sum(m.file_size for m in members)


def stored_member(archive: zipfile.ZipFile, name: str) -> bytes:
    assert archive.getinfo(name).compress_type == zipfile.ZIP_STORED
    return archive.read(name)


def test_a_library_compressed_by_others_is_taken(tmp_path: Path) -> None:
    """With the file's name in its head, as the program gzip leaves it there."""
    library, fmu = tmp_path / "other.so.gz", tmp_path / "x.fmu"
    with library.open("wb") as file, gzip.GzipFile("named.so", "wb", fileobj=file) as compressing:
        compressing.write(b"library" * 9)
    _core.export_fmu(gelenk.load(crank_rocker())._core, [("linux64", library)], fmu, export.licenses(), None)
    with zipfile.ZipFile(fmu) as archive:
        assert archive.read("binaries/linux64/FourBar.so") == b"library" * 9


def test_without_a_compressor_members_are_stored(tmp_path: Path) -> None:
    """But for a library that comes compressed. The picture, 500 kB of pixels, is left out."""
    small, large = tmp_path / "small.fmu", tmp_path / "large.fmu"
    library = tmp_path / "library.so"
    shutil.copytree(export.runtime_library().parent / "licenses", tmp_path / "licenses")
    library.write_bytes(gzip.decompress(export.runtime_library().read_bytes()))
    scene = gelenk.load(crank_rocker())._core
    _core.export_fmu(scene, [("linux64", export.runtime_library())], small, export.licenses(), None)
    _core.export_fmu(scene, [("linux64", library)], large, export.licenses(), None)
    usual = gelenk.export_fmu(crank_rocker(), tmp_path / "usual.fmu")
    with zipfile.ZipFile(small) as a, zipfile.ZipFile(large) as b, zipfile.ZipFile(usual) as c:
        extra = ("model.png", "documentation/view.html")
        assert a.namelist() == b.namelist() == [name for name in c.namelist() if name not in extra]
        binary = "binaries/linux64/FourBar.so"
        assert a.getinfo(binary).compress_type == zipfile.ZIP_DEFLATED
        page = "documentation/index.html"  # mentions the view
        assert all(stored_member(b, name) == c.read(name) for name in b.namelist() if name != page)
        assert all(
            stored_member(a, name) == c.read(name) for name in a.namelist() if name not in (binary, page)
        )
    run, same = (gelenk.simulate(fmu, stop=0.1, step=0.01) for fmu in (large, usual))
    assert all(np.array_equal(run[name], same[name]) for name in same.names)


NAMED = b"\x1f\x8b\x08\x08" + bytes(6)
NO_LIBRARIES = {
    "nothing": b"",
    "not compressed": b"\x7fELF" + bytes(60),
    "cut off": gzip.compress(b"library")[:18],
    "a name without end": NAMED + b"library" * 9,
    "a checksum of the head": b"\x1f\x8b\x08\x02" + gzip.compress(b"library")[4:],
}


@pytest.mark.parametrize("content", NO_LIBRARIES.values(), ids=NO_LIBRARIES)
def test_a_library_that_is_no_gzip_file_is_refused(content: bytes, tmp_path: Path) -> None:
    library = tmp_path / "gelenk_fmu.so.gz"
    library.write_bytes(content)
    scene = gelenk.load(crank_rocker())._core
    with pytest.raises(
        gelenk.ExportError,
        match=r"gelenk_fmu\.so\.gz: the FMU runtime: found a file that is not in plain gzip format",
    ):
        _core.export_fmu(scene, [("linux64", library)], tmp_path / "x.fmu", export.licenses(), zlib.compress)
    assert not (tmp_path / "x.fmu").exists()


def pixels(png: bytes) -> NDArray[np.uint8]:
    """Rows, columns, colors of a PNG of 8-bit colors without filters; all its checksums checked."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(png):
        (size,) = struct.unpack(">I", png[at : at + 4])
        kind, content = png[at + 4 : at + 8], png[at + 8 : at + 8 + size]
        assert struct.unpack(">I", png[at + 8 + size : at + 12 + size]) == (zlib.crc32(kind + content),)
        chunks[kind] = content
        at += 12 + size
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    width, height, *form = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert form == [8, 2, 0, 0, 0]
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, 3 * width + 1)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, 3)


@pytest.mark.parametrize("file", scene_files.good(), ids=lambda file: file.stem)
def test_every_scene_has_a_picture(file: Path, tmp_path: Path) -> None:
    source = gelenk.load(file).to_dict()
    with zipfile.ZipFile(gelenk.export_fmu(source, tmp_path / "x.fmu")) as archive:
        image = pixels(archive.read("model.png"))
        page = archive.read("documentation/index.html").decode()
    drawn = (image < 255).any(axis=2)
    assert 0.005 < drawn.mean() < 0.6
    assert not drawn[:, [0, 1, -2, -1]].any()  # all of it is inside
    assert not drawn[[0, 1, -2, -1], :].any()
    svg = ElementTree.fromstring(page[page.index("<svg") : page.index("</svg>") + 6])
    circles = [e for e in svg if e.tag.endswith("circle")]
    assert len(circles) >= len(source["bodies"])  # each has its center of mass
    if len(source["joints"]) <= 12:
        assert {e.text for e in svg if e.tag.endswith("text")} >= set(source["bodies"])


def test_the_picture_of_a_link_reaches_both_of_its_joints(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    """Also of a vertical one with its center of mass between them, three points in line."""
    with zipfile.ZipFile(gelenk.export_fmu(four_bar, tmp_path / "x.fmu")) as archive:
        page = archive.read("documentation/index.html").decode()
    svg = ElementTree.fromstring(page[page.index("<svg") : page.index("</svg>") + 6])
    joints = {(e.get("cx"), e.get("cy")) for e in svg if e.tag.endswith("circle") and e.get("r") == "6"}
    lines = [e.get("points", "").split() for e in svg if e.tag.endswith("polyline")]
    ends = {tuple(point.split(",")) for points in lines for point in (points[0], points[-1])}
    assert len(joints) == 4
    assert joints <= ends


def test_the_picture_shows_where_bodies_start(tmp_path: Path) -> None:
    """A rod that leans to the right by 0.3 rad, driven at its lower end: red below on the left."""
    rod = {"mass": 1.0, "com": [0.5, 0, 0], "inertia": [0, 0.1, 0.1]}
    pin = {"type": "revolute", "axis": [0, -1, 0], "parent": "ground", "child": "rod"}
    start = {"phi": math.pi / 2 - 0.3, "fixed": True}
    source = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {"rod": rod},
        "joints": {"pin": pin | {"start": start}},
        "motors": {"drive": {"joint": "pin"}},
    }
    with zipfile.ZipFile(gelenk.export_fmu(source, tmp_path / "x.fmu")) as archive:
        image = pixels(archive.read("model.png")).astype(int)
    red = np.argwhere(image[:, :, 0] - image[:, :, 1] > 100).mean(axis=0)
    black = np.argwhere(image.max(axis=2) < 70)
    tip = black[black[:, 0].argmin()]  # the center of mass is the highest mark
    up, right = red[0] - tip[0], tip[1] - red[1]
    assert math.atan2(right, up) == pytest.approx(0.3, abs=0.02)  # pixels: 2 of 280


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
    with pytest.raises(gelenk.AssemblyError, match="cannot be closed: smallest closure error"):
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
