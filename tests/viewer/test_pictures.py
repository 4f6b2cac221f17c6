# SPDX-License-Identifier: BSD-3-Clause
"""Pictures without a browser: bodies are where the run has them, and look as on the page."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Array, body, frame, joint, scene
from PIL import Image
from scipy.spatial.transform import Rotation

import gelenk
from gelenk.simulation.recording import record
from gelenk.viewer.data import page_data
from gelenk.viewer.drawing.camera import HALF_ANGLE, MARGIN, Camera
from gelenk.viewer.drawing.colors import LEAST_CONTRAST, color_of, luminance, readable
from gelenk.viewer.drawing.options import PictureOptions
from gelenk.viewer.drawing.painter import OVERSAMPLING, Painter
from gelenk.viewer.interpolation import interpolated

SCENES = sorted(path.stem for path in (Path(__file__).parent.parent.parent / "scenes").glob("*.yaml"))
SIZE = (240, 180)


def pixels(picture: Image.Image) -> Array:
    return np.asarray(picture.convert("RGB"), float)


def pinhole(camera: Camera, points: Array) -> Array:
    """Pixels of points, by the rule of three: x / depth = pixel / focal length."""
    right, up, back = camera.axes
    eye = camera.target + camera.distance * back
    depth = np.full(len(points), camera.distance) if camera.flat else (eye - points) @ back
    focal = camera.height / 2 / np.tan(HALF_ANGLE)
    x = camera.width / 2 + focal * (points - eye) @ right / depth
    return np.column_stack([x, camera.height / 2 - focal * (points - eye) @ up / depth])


@warned.STILL
@pytest.mark.parametrize("name", SCENES)
def test_every_body_is_drawn_where_it_is(name: str, root: Path) -> None:
    """At the start and the end: alone, it differs from the background in the box of its projected points."""
    recording = record(gelenk.load(root / "scenes" / f"{name}.yaml"))
    painter = Painter(page_data(recording), PictureOptions(size=SIZE))
    parts = painter.model.parts
    painter.model.springs = []
    for frame_number in (0, -1):
        time = float(recording.time[frame_number])
        painter.model.parts = []
        background = pixels(painter.frame(time))
        for number in range(len(recording.scene["bodies"])):
            painter.model.parts = [part for part in parts if part.body == number]
            pose = recording.poses[frame_number, number]
            own = np.vstack([part.solid.points for part in painter.model.parts])
            world = Rotation.from_quat(pose[3:]).apply(own) + pose[:3]
            box = pinhole(painter.camera, world) / OVERSAMPLING
            differs = np.abs(pixels(painter.frame(time)) - background).max(axis=2) > 0
            rows, columns = np.nonzero(differs)
            # Less than a pixel is seen of the pixels at the edges of the box.
            low, high = np.clip([box.min(axis=0), box.max(axis=0)], 0, SIZE)
            assert columns.min() == pytest.approx(low[0], abs=1.0)
            assert columns.max() + 1 == pytest.approx(high[0], abs=1.0)
            assert rows.min() == pytest.approx(low[1], abs=1.0)
            assert rows.max() + 1 == pytest.approx(high[1], abs=1.0)


@pytest.mark.parametrize("flat", [True, False])
@pytest.mark.parametrize("view", ["start", "front", "side", "top", (30.0, 20.0)])
def test_the_mechanism_fills_the_picture(flat: bool, view: Any) -> None:
    cloud = np.random.default_rng(1).normal(size=(50, 3)) * [1.0, 2.0, 0.5] + [5.0, 6.0, 7.0]
    camera = Camera((0, 0, 1), (0.5, -0.8, 0.45), flat=flat, size=(400, 300))
    camera.set_view(view)
    camera.fit(cloud)
    reached = np.abs(camera.project(cloud)[:, :2] - [200, 150]) / [200, 150]
    assert reached.max() == pytest.approx(1 / MARGIN, rel=0.01)  # perspective: the middle is iterated
    assert camera.project(cloud)[:, :2] == pytest.approx(pinhole(camera, cloud), abs=1e-9)


def test_directions_of_views() -> None:
    """Pixels of unit vectors from the target, in pixels of the picture: y is downwards."""
    for view, right, up in (("front", 0, 2), ("side", 1, 2), ("top", 0, 1)):
        camera = Camera((0, 0, 1), (0.5, -0.8, 0.45), flat=True, size=(400, 300))
        camera.set_view(view)
        moved = camera.project(np.eye(3))[:, :2] - camera.project(np.zeros((1, 3)))[:, :2]
        assert moved[right] == pytest.approx([1 / camera.pixel, 0], abs=1e-9)
        assert moved[up] == pytest.approx([0, -1 / camera.pixel], abs=1e-9)


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 1, 0), (1, 0, 0), (0, -1, 0), (0.6, 0, 0.8)])
def test_mechanisms_in_space_stand_upright_and_are_seen_from_above(up: tuple[float, float, float]) -> None:
    """Whatever the direction of gravity; before, the grid was tilted, and with y upwards seen from below."""
    source = scene(
        {"top": body(1.0, com=(0.1, 0.2, 0.3), inertia=(0.1, 0.12, 0.15))},
        {"J": joint("spherical", frame("ground"), frame("top"))},
        gravity=(-9.81 * np.array(up)).tolist(),
    )
    data = page_data(record(gelenk.load(source), stop=0.3, step=0.01))
    assert data["up"] == pytest.approx(up, abs=1e-12)
    camera = Camera(data["up"], data["towards"], flat=data["flat"], size=(400, 300))
    assert np.degrees(np.arcsin(camera.axes[2] @ up)) == pytest.approx(25.5, abs=0.1)


def test_a_planar_mechanism_is_seen_in_its_plane(four_bar: gelenk.Scene) -> None:
    data = page_data(record(four_bar, stop=0.1))
    camera = Camera(data["up"], data["towards"], flat=data["flat"], size=(400, 300))
    assert camera.axes == pytest.approx(np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]), abs=1e-9)


def test_between_frames_bodies_rotate_evenly() -> None:
    """A quarter of a turn of 120 degrees, also if the quaternions have opposite signs, and of none."""
    a = np.array([[1.0, 0, 0, 0, 0, 0, 1]] * 3)
    turn = Rotation.from_rotvec(np.deg2rad(120) * np.array([0.6, 0, 0.8])).as_quat()
    b = np.array([[3.0, 0, 0, *turn], [3.0, 0, 0, *-turn], [3.0, 0, 0, 0, 0, 0, 1]])
    found = interpolated(a, b, 0.25)
    assert found[:, :3] == pytest.approx(np.tile([1.5, 0, 0], (3, 1)))
    angles = np.rad2deg(Rotation.from_quat(found[:, 3:]).magnitude())
    assert angles == pytest.approx([30, 30, 0], abs=1e-9)


@pytest.mark.parametrize("background", ["#f3f4f6", "#15181d"])
def test_colors_can_be_told_from_the_background(background: str) -> None:
    behind = luminance(color_of(background))
    for code in ("#ffffff", "#000000", "#edc948", "#4c78a8", background):
        own = luminance(readable(color_of(code), color_of(background)))
        assert (max(own, behind) + 0.05) / (min(own, behind) + 0.05) >= LEAST_CONTRAST


def test_a_vehicle_is_followed(root: Path) -> None:
    """It stays in the picture on a run of 25 m."""
    data = page_data(record(gelenk.load(root / "scenes" / "bicycle.yaml")))
    painter = Painter(data, PictureOptions(size=SIZE))
    for time in (0.0, 2.5, 5.0):
        painter.frame(time)
        points = painter.model.reached_at(painter.model.poses(time))
        seen = painter.camera.project(points)[:, :2] / OVERSAMPLING
        assert (seen > 0).all()
        assert (seen < SIZE).all()
        assert np.ptp(seen, axis=0).max() > SIZE[1] / 2


def test_trails_and_the_time_are_added(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    page = gelenk.view(four_bar, stop=1.0, inputs={"drive.tau": 3.0})
    plain, more, dark = (tmp_path / f"{k}.png" for k in range(3))
    page.save(plain, size=SIZE)
    page.save(more, size=SIZE, trails=True, time_stamp=True)
    page.save(dark, size=SIZE, dark=True)
    differs = np.abs(pixels(Image.open(more)) - pixels(Image.open(plain))).max(axis=2) > 40
    assert differs[-25:, :60].any()  # the time, in the corner
    assert differs[:-25].any()
    assert pixels(Image.open(dark))[0, 0] == pytest.approx(255 * color_of("#15181d"))


def test_without_pillow_its_extra_is_told(
    four_bar: gelenk.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = gelenk.view(four_bar, stop=0.0)
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(gelenk.UsageError, match=r"drawn with Pillow: pip install 'gelenk\[view\]'"):
        page.save(tmp_path / "x.png")
