# SPDX-License-Identifier: BSD-3-Clause
"""The drawing in FMUs shows the shapes of bodies and of the ground."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import polyhedra
from numpy.typing import NDArray

import gelenk
from fmu.test_export import pixels

METAL, STONE = (200, 216, 232), (232, 232, 232)  # of bodies, of the ground
TOWARDS = np.array([0.5, -0.8, 0.45])  # the viewer


def picture(folder: Path, shapes: dict[str, Any], ground: dict[str, Any] | None = None) -> NDArray[np.uint8]:
    scene = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {"b": {"mass": {"density": 1}, "shapes": shapes}},
        "joints": {"j": {"type": "free", "parent": "ground", "child": "b", "start": {"r": [0, 0, 1]}}},
        "ground": {"shapes": ground or {}},
    }
    with zipfile.ZipFile(gelenk.export_fmu(scene, folder / "x.fmu", view=False)) as archive:
        return pixels(archive.read("model.png"))


def area(image: NDArray[np.uint8], color: tuple[int, int, int]) -> int:
    return int((image == color).all(axis=2).sum())


@pytest.mark.parametrize("diameter", [1e-3, 0.2, 50.0])
def test_a_sphere_fills_the_picture_up_to_its_margin(diameter: float, tmp_path: Path) -> None:
    """The circle of 280 pixels in 360, without its edge of 2 pixels and the center of mass of 4."""
    image = picture(tmp_path, {"s": {"sphere": diameter / 2}})
    assert area(image, METAL) == pytest.approx(np.pi / 4 * 278**2, rel=0.01)


def test_a_mesh_that_is_not_convex_is_seen_with_its_notch(tmp_path: Path) -> None:
    """An L whose outline is turned to the viewer covers 5 of the 7 m2 of its hull."""
    z = TOWARDS / np.linalg.norm(TOWARDS)
    x = np.cross([0, 0, 1], z) / np.linalg.norm(np.cross([0, 0, 1], z))
    turned = {"rotation": {"matrix": np.column_stack([x, np.cross(z, x), z]).tolist()}}
    part = polyhedra.l_shape()
    mesh = area(picture(tmp_path, {"s": {"mesh": part, **turned}}), METAL)
    hull = area(picture(tmp_path, {"s": {"hull": part["points"], **turned}}), METAL)
    assert mesh / hull == pytest.approx(5 / 7, abs=0.02)


def test_the_ground_is_drawn_with_a_piece_of_its_half_space(tmp_path: Path) -> None:
    """Below the box, in its color; everything is inside of the picture."""
    box = {"s": {"box": [0.4, 0.3, 0.2]}}
    ground = {"floor": {"plane": [0, 0, 1]}, "step": {"box": [0.5, 0.5, 0.2], "position": [1, 0, 0.1]}}
    image = picture(tmp_path, box, ground)
    rows = [np.argwhere((image == color).all(axis=2))[:, 0].mean() for color in (METAL, STONE)]
    assert rows[0] < rows[1]
    assert area(image, STONE) > 5 * area(image, METAL) > 0
    drawn = (image < 255).any(axis=2)
    assert not drawn[:, [0, 1, -2, -1]].any()
    assert not drawn[[0, 1, -2, -1], :].any()


def test_nearer_bodies_hide_farther_ones(tmp_path: Path) -> None:
    """A large cube in front of a sphere hides it, in either order of the file."""
    start = {"sphere": (-TOWARDS).tolist(), "cube": TOWARDS.tolist()}
    shapes = {"sphere": {"sphere": 0.2}, "cube": {"box": [1, 1, 1]}}
    found = []
    for names in (["sphere", "cube"], ["cube", "sphere"], ["cube"]):
        scene = {
            "gelenk": 1,
            "gravity": [0, 0, -9.81],
            "bodies": {n: {"mass": {"density": 1}, "shapes": {"s": shapes[n]}} for n in names},
            "joints": {
                f"to_{n}": {"type": "free", "parent": "ground", "child": n, "start": {"r": start[n]}}
                for n in names
            },
        }
        with zipfile.ZipFile(gelenk.export_fmu(scene, tmp_path / "x.fmu", view=False)) as archive:
            found.append(pixels(archive.read("model.png")))
    assert np.array_equal(found[0], found[1])
    # The disk of the center of mass of what is in front is seen; the sphere is not.
    assert area(found[0], METAL) == area(found[2], METAL)
