# SPDX-License-Identifier: BSD-3-Clause
"""Pages in Chromium: they draw without errors and requests, and bodies are where the run has them."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import scene_files
import warned
from samples import sampled

import gelenk
from gelenk.simulation.recording import record
from gelenk.viewer.data import page_data
from gelenk.viewer.page import page_of

from .browser import Browser

NEAR = 4  # pixels around the middle of a body
COLORED = 0.25  # saturation; bodies have 0.31 and more in any light, the grid 0.16
DARK = 112  # of 255; symbols of joints are darker, the grid is not


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    out = Browser()
    yield out
    out.close()


def undrawn(browser: Browser, bodies: list[str]) -> list[str]:
    """Return the bodies at whose middle only background and grid are seen, which are light and gray."""
    Image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    browser.run("document.getElementById('labels').hidden = true")
    picture = np.asarray(Image.open(io.BytesIO(browser.picture())).convert("RGB"), float)
    missing = []
    for body in bodies:
        x, y = (round(c) for c in browser.run(f"return gelenk.project({body!r})"))
        found = picture[max(y - NEAR, 0) : y + NEAR + 1, max(x - NEAR, 0) : x + NEAR + 1]
        brightest = found.max(axis=2)
        if not ((np.ptp(found, axis=2) > COLORED * brightest) | (brightest < DARK)).any():
            missing.append(body)
    return missing


@warned.STILL  # five_bar, without torques
@pytest.mark.parametrize(
    "name", sampled(scene_files.gallery(), ["car", "five_bar", "gripper", "rolling_disc"])
)
def test_pages_of_the_gallery(name: str, tmp_path: Path, browser: Browser) -> None:
    """No errors, no requests; at each of some frames, every body is drawn and has the pose of the run."""
    recording = record(gelenk.load(scene_files.gallery()[name]))
    page = tmp_path / f"{name}.html"
    page.write_text(page_of(page_data(recording)), encoding="utf-8")
    browser.open(page)
    frames = len(recording.time)
    assert browser.run("return gelenk.frames") == frames
    for frame in (0, frames // 3, frames - 1):
        browser.run(f"gelenk.show({frame})")
        assert browser.run("return gelenk.time") == pytest.approx(recording.time[frame], abs=1e-12)
        for number, body in enumerate(recording.scene["bodies"]):
            pose = browser.run(f"return gelenk.pose({body!r})")
            expected = recording.poses[frame, number]
            # Single precision, 6e-8 of the value; the car moves by 45 m.
            assert pose["p"] == pytest.approx(expected[:3], rel=6e-8, abs=1e-6)
            sign = np.sign(np.dot(pose["q"], expected[3:]))  # q and -q are one rotation
            assert sign * np.array(pose["q"]) == pytest.approx(expected[3:], abs=1e-6)
        assert undrawn(browser, recording.scene["bodies"]) == []
    assert browser.errors() == []
    assert browser.requests() == []


def test_bodies_that_are_not_drawn_are_found(
    four_bar: gelenk.Scene, tmp_path: Path, browser: Browser
) -> None:
    browser.open(gelenk.view(four_bar, stop=0.0).save(tmp_path / "four_bar.html"))
    bodies = ["crank", "coupler", "rocker"]
    assert undrawn(browser, bodies) == []
    browser.run("document.getElementById('canvas').style.visibility = 'hidden'")
    assert undrawn(browser, bodies) == bodies


def test_playing_advances_at_the_speed_of_the_run(
    four_bar: gelenk.Scene, tmp_path: Path, browser: Browser
) -> None:
    browser.open(gelenk.view(four_bar, stop=30.0, step=0.05).save(tmp_path / "four_bar.html"))
    mark = "return [performance.now() / 1000, gelenk.time]"
    browser.run("gelenk.show(0); gelenk.play()")
    browser.wait("return gelenk.time > 0.5")  # the first frames prepare the renderer
    began, first = browser.run(mark)
    browser.wait("return gelenk.time > 3.5")
    ended, last = browser.run(mark)
    browser.run("gelenk.pause()")
    assert last - first == pytest.approx(ended - began, abs=0.6)  # a slow frame at either end
    assert browser.errors() == []


def test_keys(four_bar: gelenk.Scene, tmp_path: Path, browser: Browser) -> None:
    browser.open(gelenk.view(four_bar, stop=1.0, step=0.1).save(tmp_path / "four_bar.html"))
    browser.run("gelenk.pause(); gelenk.show(0)")
    right, end, home = "\ue014", "\ue010", "\ue011"
    for key, frame in ((right, 1), (right, 2), (end, 10), (home, 0)):
        browser.press(key)
        assert browser.run("return gelenk.frame") == frame
    browser.press(" ")
    assert browser.run("return gelenk.playing")
    browser.press(" ")
    assert not browser.run("return gelenk.playing")
    assert browser.errors() == []


def screenshot(browser: Browser) -> np.ndarray:
    Image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    return np.asarray(Image.open(io.BytesIO(browser.picture())).convert("RGB"), float)


def test_arrows_are_seen_through_bodies(tmp_path: Path, browser: Browser) -> None:
    """A load and a reaction that act inside of a block of 1 m: without, nothing of them was seen."""
    block = {"mass": 2.0, "shapes": {"hull": {"box": [1.0, 1.0, 1.0]}}}
    source = {
        "gelenk": 1, "name": "block", "gravity": [0, 0, 0], "bodies": {"block": block},
        "joints": {"J": {"type": "prismatic", "parent": "ground", "child": "block", "axis": [0, 0, 1]}},
        "forces": {
            "push": {"type": "wrench", "body": "block", "position": [0, 0, -0.4], "force": [0.2, 0, 0.3]}
        },
    }  # fmt: skip
    browser.open(gelenk.view(source, stop=0.0, reactions=True).save(tmp_path / "block.html"))
    for element in ("labels", "legend"):
        browser.run(f"document.getElementById({element!r}).style.visibility = 'hidden'")
    plain = screenshot(browser)
    browser.press("v")
    browser.wait("return !document.getElementById('legend').hidden")
    x, y = (round(c) for c in browser.run("return gelenk.project('block')"))
    changed = np.abs(screenshot(browser) - plain).max(axis=2)[y - 60 : y + 60, x - 60 : x + 60] > 40
    assert changed.sum() > 200  # pixels
    assert browser.errors() == []


def test_labels_are_within_the_picture(root: Path, tmp_path: Path, browser: Browser) -> None:
    """The labels of joints begin at the joint, those of bodies are centered on it: at the edge, both were
    cut off.
    """
    data = gelenk.load(root / "scenes" / "four_bar.yaml").to_dict()
    data.pop("parameters")
    joints = {"D": "bearing_of_the_rocker", "A": "bearing_of_the_crank"}
    data["joints"] = {joints.get(name, name): joint for name, joint in data["joints"].items()}
    for motor in data["motors"].values():
        motor["joint"] = joints.get(motor["joint"], motor["joint"])
    browser.open(gelenk.view(data, stop=0.0).save(tmp_path / "four_bar.html"))
    visible = browser.run("""
        const stage = document.getElementById("labels").getBoundingClientRect();
        return [...document.querySelectorAll(".label")]
          .filter((label) => label.style.visibility === "visible")
          .map((label) => [label.textContent, label.getBoundingClientRect()])
          .map(([text, box]) => [text, box.left - stage.left, stage.right - box.right,
                                 box.top - stage.top, stage.bottom - box.bottom]);
    """)
    assert {"bearing_of_the_rocker", "bearing_of_the_crank"} <= {row[0] for row in visible}
    assert all(room >= 0 for _, *rooms in visible for room in rooms), visible
