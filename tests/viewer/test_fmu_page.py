# SPDX-License-Identifier: BSD-3-Clause
"""The documentation of an FMU in Chromium: opened from a file, it shows every body, and asks for nothing."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gelenk

from .browser import Browser

SCENES = sorted(path.stem for path in (Path(__file__).parent.parent.parent / "scenes").glob("*.yaml"))
NEAR = 4  # pixels; links are 6 wide
NOTICEABLE = 12  # of 255, between a body and the background


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    out = Browser(900, 1000)
    yield out
    out.close()


def pixels(png: bytes) -> NDArray[np.int64]:
    image = pytest.importorskip("PIL.Image", reason="pillow is not installed").open(io.BytesIO(png))
    return np.asarray(image.convert("RGB")).astype(np.int64)


def unpacked(fmu: Path, folder: Path) -> Path:
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(folder)
    return folder / "documentation"


@pytest.mark.parametrize("name", SCENES)
def test_every_body_is_seen(name: str, root: Path, tmp_path: Path, browser: Browser) -> None:
    scene = gelenk.load(root / "scenes" / f"{name}.yaml")
    pages = unpacked(gelenk.export_fmu(scene, tmp_path / "x.fmu"), tmp_path)
    browser.open(pages / "view.html")
    assert browser.run("return gelenk.frames") == 1
    image = pixels(browser.picture())
    background = image[-5, 5]  # below the mechanism, left of it
    for body in scene.to_dict()["bodies"]:
        x, y = (round(v) for v in browser.run(f"return gelenk.project({body!r})"))
        around = image[y - NEAR : y + NEAR + 1, x - NEAR : x + NEAR + 1]
        assert abs(around - background).max() > NOTICEABLE, body
    assert browser.errors() == []
    assert browser.requests() == []


def test_the_documentation_contains_the_view(four_bar_fmu: Path, tmp_path: Path, browser: Browser) -> None:
    browser.show(unpacked(four_bar_fmu, tmp_path) / "index.html")
    box: dict[str, Any] = browser.run(
        "const r = document.querySelector('iframe').getBoundingClientRect();"
        "return {x: r.x, y: r.y, width: r.width, height: r.height}"
    )
    with browser.frame("iframe"):
        browser.wait("return Boolean(window.gelenk && window.gelenk.ready)")
        assert browser.run("return gelenk.pose('crank').p") == pytest.approx([0, 0, 0], abs=1e-6)
        x, y = browser.run("return gelenk.project('coupler')")
    image = pixels(browser.picture())
    left, top = round(box["x"] + x), round(box["y"] + y)
    around = image[top - NEAR : top + NEAR + 1, left - NEAR : left + NEAR + 1]
    corner = image[round(box["y"] + box["height"]) - 8, round(box["x"] + box["width"]) - 8]
    assert abs(around - corner).max() > NOTICEABLE
    assert browser.errors() == []
    assert browser.requests() == []
