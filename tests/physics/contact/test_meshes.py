# SPDX-License-Identifier: BSD-3-Clause
"""Meshes as shapes: masses against closed forms, contact as their convex hull, files, errors."""

from __future__ import annotations

import sys
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from models import polyhedra

import gelenk

ROUNDING = 1e-14  # of sums of some tens of terms of similar size
TETRAHEDRON = {
    "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}


def scene_with(mesh: Any, **shape: Any) -> dict[str, Any]:
    return {
        "gelenk": 1,
        "bodies": {"b": {"mass": {"density": 1}, "shapes": {"s": {"mesh": mesh, **shape}}}},
        "joints": {"j": {"type": "free", "parent": "ground", "child": "b"}},
    }


def moments(body: dict[str, Any]) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = body["inertia"]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@pytest.mark.parametrize(
    ("mesh", "boxes"),
    [
        (polyhedra.box(), [((0, 0, 0), (1, 2, 3))]),
        (polyhedra.l_shape(), polyhedra.L_BOXES),
    ],
    ids=["box", "L"],
)
def test_masses_are_those_of_the_boxes_of_which_a_part_consists(mesh: dict[str, Any], boxes: Any) -> None:
    volume, center, about = polyhedra.of_boxes(boxes)
    body = gelenk.load(scene_with(mesh)).to_dict()["bodies"]["b"]
    assert body["mass"] == pytest.approx(volume, rel=ROUNDING)
    assert body["com"] == pytest.approx(center, rel=ROUNDING)
    assert moments(body) == pytest.approx(about, rel=ROUNDING, abs=ROUNDING * about.max())


def test_mass_of_a_tetrahedron() -> None:
    """Of the unit corner: V = 1/6, center at 1/4, moments 1/80, products 1/480 (of the matrix: +)."""
    body = gelenk.load(scene_with(TETRAHEDRON)).to_dict()["bodies"]["b"]
    assert body["mass"] == pytest.approx(1 / 6, rel=ROUNDING)
    assert body["com"] == pytest.approx([0.25] * 3, rel=ROUNDING)
    assert body["inertia"] == pytest.approx([1 / 80] * 3 + [1 / 480] * 3, rel=ROUNDING)


@warned.IN_STEPS
def test_a_notch_is_filled_in_contact() -> None:
    """The hull of the L has the side x + y = 4. Above it, a ball in the notch has its gap to this side."""
    p = np.array([2.5, 2.5, 1.0])
    scene = {
        "gelenk": 1,
        "bodies": {"ball": {"mass": 1, "inertia": [1] * 3, "shapes": {"s": {"sphere": 0.2, "surface": "a"}}}},
        "ground": {"shapes": {"part": {"mesh": polyhedra.l_shape(), "surface": "b"}}},
        "joints": {"j": {"type": "free", "parent": "ground", "child": "ball", "start": {"r": p.tolist()}}},
        "contacts": {"c": {"between": ["a", "b"]}},
    }
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    assert plant.output("c.gap") == pytest.approx((p[0] + p[1] - 4) / sqrt(2) - 0.2, rel=1e-12)


@warned.IN_STEPS
def test_a_mesh_rests_like_the_box_that_it_is() -> None:
    """On a plane with its weight as contact force, without creep."""
    scene = scene_with(polyhedra.box(), surface="a", position=[-0.5, -1, 0])
    scene |= {
        "gravity": [0, 0, -9.81],
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "b"}}},
        "contacts": {"c": {"between": ["a", "b"], "friction": 0.5}},
    }
    run = gelenk.simulate(scene, stop=0.5, step=0.1)
    assert run["c.f[3]"][-1] == pytest.approx(6 * 9.81, rel=1e-9)
    assert abs(run["j.r[3]"][-1]) < 1e-10


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with part.stl, and scene.yaml that refers to it."""
    (tmp_path / "part.stl").write_text(polyhedra.ascii_stl(polyhedra.l_shape()))
    (tmp_path / "scene.yaml").write_text(
        "gelenk: 1  # a part\nbodies:\n  b:\n    mass: {density: 7800}\n"
        "    shapes: {s: {mesh: part.stl, surface: steel}}\n"
        "joints:\n  j: {type: free, parent: ground, child: b}\n"
    )
    return tmp_path


def test_a_file_is_read_from_the_folder_of_the_scene(folder: Path) -> None:
    mesh = gelenk.load(folder / "scene.yaml").to_dict()["bodies"]["b"]["shapes"]["s"]["mesh"]
    expected = polyhedra.l_shape()
    assert sorted(mesh["points"]) == sorted(expected["points"])
    assert len(mesh["triangles"]) == len(expected["triangles"])


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "off"])
def test_formats_of_files(ending: str, folder: Path) -> None:
    """Binary files have numbers in single precision: those of the L are exact in it."""
    import trimesh

    part = polyhedra.l_shape()
    trimesh.Trimesh(part["points"], part["triangles"], process=False).export(folder / f"other.{ending}")
    text = (folder / "scene.yaml").read_text().replace("part.stl", f"other.{ending}")
    (folder / "scene.yaml").write_text(text)
    body = gelenk.load(folder / "scene.yaml").to_dict()["bodies"]["b"]
    volume, center, _ = polyhedra.of_boxes(polyhedra.L_BOXES)
    assert body["mass"] == pytest.approx(7800 * volume, rel=ROUNDING)
    assert body["com"] == pytest.approx(center, rel=ROUNDING)


def test_a_unit_of_length_other_than_meters(folder: Path) -> None:
    text = (folder / "scene.yaml").read_text().replace("part.stl", "{file: part.stl, scale: 0.001}")
    (folder / "scene.yaml").write_text(text)
    volume, center, _ = polyhedra.of_boxes(polyhedra.L_BOXES)
    body = gelenk.load(folder / "scene.yaml").to_dict()["bodies"]["b"]
    assert body["mass"] == pytest.approx(7800 * volume * 1e-9, rel=ROUNDING)
    assert body["com"] == pytest.approx(1e-3 * center, rel=ROUNDING)


def test_saving_keeps_the_name_in_its_folder_and_writes_points_elsewhere(folder: Path) -> None:
    scene = gelenk.load(folder / "scene.yaml")
    scene.save(folder / "again.yaml")
    assert (folder / "again.yaml").read_text() == (folder / "scene.yaml").read_text()
    scene.with_outputs(["j.r[1]"]).save(folder / "changed.yaml")
    assert "mesh: part.stl" in (folder / "changed.yaml").read_text()
    assert "outputs" in (folder / "changed.yaml").read_text()
    (folder / "below").mkdir()
    for ending in ("yaml", "json"):
        target = folder / "below" / f"scene.{ending}"
        scene.save(target)
        assert "part.stl" not in target.read_text()
        assert gelenk.load(target).to_dict() == scene.to_dict()
    assert "# a part" in (folder / "below" / "scene.yaml").read_text()


@warned.STILL
def test_an_fmu_does_not_need_the_file(folder: Path) -> None:
    gelenk.export_fmu(folder / "scene.yaml", folder / "Part.fmu")
    before = gelenk.simulate(folder / "scene.yaml", stop=0.1, step=0.05)
    (folder / "part.stl").unlink()
    after = gelenk.simulate(folder / "Part.fmu", stop=0.1, step=0.05)
    assert np.array_equal(after["j.r[3]"], before["j.r[3]"])


OPEN = {**polyhedra.box(), "triangles": polyhedra.box()["triangles"][1:]}
INWARD = {**polyhedra.box(), "triangles": [t[::-1] for t in polyhedra.box()["triangles"]]}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            polyhedra.ascii_stl(OPEN),
            "not closed: the edge between vertices .* from .* to .*one triangle only",
        ),
        (polyhedra.ascii_stl(INWARD), "oriented inward"),
        ("solid part\nendsolid part\n", "contains no triangles"),
        ("", "contains no triangles"),
        (polyhedra.ascii_stl(polyhedra.box()).replace("3.0", "nan"), "not finite"),
    ],
    ids=["open", "inward", "empty solid", "empty file", "nan"],
)
def test_faulty_files_are_named_with_their_line(content: str, message: str, folder: Path) -> None:
    (folder / "part.stl").write_text(content)
    with pytest.raises(gelenk.SceneError, match=message) as caught:
        gelenk.load(folder / "scene.yaml")
    assert f"{folder / 'scene.yaml'}:5: bodies.b.shapes.s.mesh" in str(caught.value)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        ("gone.stl", "found 'gone.stl', which cannot be read .No such file"),
        ("../part.stl", "found '../part.stl', expected a file in the folder of the scene"),
        ("below/../../part.stl", "expected a file in the folder of the scene"),
        ("/part.stl", "expected a file in the folder of the scene"),
        ("C:\\part.stl", "expected a file in the folder of the scene"),
        ("part.step", "found 'part.step', expected a file of triangles: .stl"),
        ({"file": "part.stl", "scale": 0}, "mesh.scale: found 0, expected a positive number"),
        ({"file": "part.stl", "scael": 1}, "found 'scael', expected file and scale"),
        ({"scale": 1}, "mesh.file: found nothing"),
        ({"points": [[0, 0, 0]]}, "triangles"),
        ({"points": [[0, 0, 0]], "triangles": [[0, 1]]}, "three numbers of points"),
        ({"points": [[0, 0, 0]], "triangles": [[0, 0.5, 1]]}, "three numbers of points"),
        ({"points": [[0, 0, 0]], "triangles": [[0, 1, 2]]}, "vertex 1, but there are 1"),
        (5, "found 5, expected a mapping with points and triangles"),
    ],
)
def test_mistakes_are_named(mesh: Any, message: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(scene_with(mesh))


def test_all_faults_are_reported_together(folder: Path) -> None:
    """Those of meshes, and those of the rest, repeated keys included."""
    text = (folder / "scene.yaml").read_text().replace("part.stl", "gone.stl").replace("free", "fre")
    (folder / "scene.yaml").write_text(text + "name: A\nname: B\n")
    with pytest.raises(gelenk.SceneError) as caught:
        gelenk.load(folder / "scene.yaml")
    for part in ("gone.stl", "fre", "twice"):
        assert part in str(caught.value)


def test_without_trimesh_its_extra_is_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(gelenk.SceneError, match=r"pip install 'gelenk\[mesh\]'"):
        gelenk.load(folder / "scene.yaml")
