# SPDX-License-Identifier: BSD-3-Clause
"""The ground in drawings of planar mechanisms: hatched below bearings and along rails, behind springs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene

import gelenk
from gelenk.simulation.recording import record
from gelenk.viewer.data import page_data


def wires(source: Any) -> tuple[np.ndarray, float]:
    """Return both ends of the thin tubes of the ground, shape (tubes, 2, 3), and the radius of links."""
    data = page_data(record(gelenk.load(source), stop=0.0))
    tubes = [tube for tube in data["ground"]["tubes"] if not tube["role"]]
    thin = min((tube["r"] for tube in tubes), default=0.0)
    ends = [(tube["a"], tube["b"]) for tube in tubes if tube["r"] == thin]
    links = [tube["r"] for row in data["bodies"] for tube in row["tubes"] if not tube["role"]]
    return np.array(ends).reshape(-1, 2, 3), min(links, default=5 * thin)


def test_bearings_stand_on_the_ground(root: Path) -> None:
    """Gravity is along -z, and y is away from the viewer: all is below the bearings, and behind the links."""
    ends, radius = wires(root / "scenes" / "four_bar.yaml")
    for x in (0.0, 2.0):
        own = ends[np.abs(ends[:, :, 0] - x).max(axis=1) < 10 * radius]
        legs = own[np.isclose(own[:, 0], [x, own[0, 0, 1], 0.0]).all(axis=1)]
        assert len(legs) == 2
        (level,) = [pair for pair in own if np.ptp(pair[:, 2]) < 1e-12]
        assert level[:, 0].mean() == pytest.approx(x)
        assert np.ptp(level[:, 0]) > 2 * np.ptp(legs[:, 1, 0]) / 2
        strokes = own[(own[:, 1, 2] < level[0, 2] - 1e-9) & (own[:, 0, 2] < -1e-9)]
        assert len(strokes) >= 4
        assert (own[:, :, 1] > radius).all()
    assert ends[:, :, 2].max() <= 1e-12


def test_rails_are_hatched_as_far_as_they_reach(root: Path) -> None:
    path = root / "scenes" / "slider_crank.yaml"
    data = page_data(record(gelenk.load(path), stop=1.0))
    (rail,) = [
        np.array([tube["a"], tube["b"]])
        for tube in data["ground"]["tubes"]
        if not tube["role"] and abs(tube["b"][0] - tube["a"][0]) > 0.3 and tube["a"][1] == 0
    ]
    starts = np.array([tube["a"] for tube in data["ground"]["tubes"] if tube["b"][2] < tube["a"][2] - 1e-9])
    along = starts[np.abs(starts[:, 2] - rail[0, 2]) < 1e-9]
    assert along[:, 0].max() == pytest.approx(rail[:, 0].max())
    assert along[:, 0].min() < rail[:, 0].min() + 0.1 * np.ptp(rail[:, 0])


def test_a_spring_hangs_on_a_wall_across_it() -> None:
    """A planar pendulum with a spring to the right: the wall is vertical, and hatched on its right."""
    source = scene(
        {"bob": body(1.0, inertia=(0.1, 0.1, 0.1), com=(0, 0, -1))},
        {"J": joint("revolute", frame("ground"), frame("bob"), axis=[0, 1, 0])},
        gravity=[0, 0, -9.81],
        forces={
            "s": {"type": "spring_damper", "stiffness": 10, "length": 0.5,
                  "from": {"body": "ground", "position": [1, 0, -1]},
                  "to": {"body": "bob", "position": [0, 0, -1]}},
        },
    )  # fmt: skip
    ends, _ = wires(source)
    near = ends[(np.abs(ends[:, 0, 0] - 1) < 1e-9) & (np.abs(ends[:, 0, 2] + 1) < 0.3)]
    walls = near[np.ptp(near[:, :, 0], axis=1) < 1e-12]
    assert len(walls) == 1
    assert walls[0, :, 2].mean() == pytest.approx(-1)
    strokes = near[np.ptp(near[:, :, 0], axis=1) > 1e-12]
    assert len(strokes) >= 4
    assert (strokes[:, 1, 0] > 1).all()


@pytest.mark.parametrize("name", ["cart_pole", "stewart"])
def test_mechanisms_in_space_stand_on_the_grid_only(name: str, root: Path) -> None:
    data = page_data(record(gelenk.load(root / "scenes" / f"{name}.yaml"), stop=0.0))
    assert not data["flat"]
    assert len(data["ground"]["tubes"]) <= 8  # pins and rails


def test_the_time_fits_into_small_pictures(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    """At 60 pixels, the last digits were cut off."""
    Image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    page = gelenk.view(four_bar, stop=0.0)
    pictures = [
        np.asarray(Image.open(page.save(tmp_path / "x.png", size=(60, 40), time_stamp=stamp)), float)
        for stamp in (True, False)
    ]
    written = np.abs(pictures[0] - pictures[1]).max(axis=2) > 30
    assert written.any()
    assert not written[:, -2:].any()
