# SPDX-License-Identifier: BSD-3-Clause
"""The drawing on the page of an FMU: labels are whole, the ground is hatched."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

import gelenk

WIDTH, HEIGHT = 480, 360
LETTER = 0.58 * 13  # pixels; the mean width of lowercase letters in DejaVu Sans, wider than most fonts


def drawing(source: Any, folder: Path) -> ElementTree.Element:
    with zipfile.ZipFile(gelenk.export_fmu(source, folder / "x.fmu")) as archive:
        page = archive.read("documentation/index.html").decode()
    return ElementTree.fromstring(page[page.index("<svg") : page.index("</svg>") + 6])


def renamed(root: Path, long: str) -> dict[str, Any]:
    data = gelenk.load(root / "scenes" / "four_bar.yaml").to_dict()
    data.pop("parameters")
    data["joints"] = {f"{name}{long}": joint for name, joint in data["joints"].items()}
    data["motors"]["drive"]["joint"] = f"A{long}"
    return data


@pytest.mark.parametrize("letters", [1, 20, 90])
def test_no_label_is_cut_off_at_the_edge(letters: int, root: Path, tmp_path: Path) -> None:
    """The joint D is at the right edge; names longer than the picture are squeezed."""
    svg = drawing(renamed(root, letters * "e"), tmp_path)
    labels = [e for e in svg if e.tag.endswith("text")]
    assert {f"{name}{letters * 'e'}" for name in "ABCD"} <= {e.text for e in labels}
    for label in labels:
        x, y = float(label.get("x", "nan")), float(label.get("y", "nan"))
        width = float(label.get("textLength", LETTER * len(label.text or "")))
        assert x >= 0, label.text
        assert x + width <= WIDTH, label.text
        assert 13 <= y <= HEIGHT


def test_the_ground_is_hatched_below_its_bearings(root: Path, tmp_path: Path) -> None:
    svg = drawing(root / "scenes" / "four_bar.yaml", tmp_path)
    circles = [e for e in svg if e.tag.endswith("circle") and e.get("r") == "6"]
    lowest = max(float(e.get("cy", "nan")) for e in circles)
    bearings = [float(e.get("cx", "nan")) for e in circles if float(e.get("cy", "nan")) == lowest]
    assert len(bearings) == 2
    strokes = []
    for line in svg:
        points = [[*map(float, p.split(","))] for p in line.get("points", "").split()]
        if len(points) == 2 and all(lowest + 19 < y < lowest + 30 for _, y in points):
            strokes.append(points)
    for x in bearings:
        own = [points for points in strokes if all(abs(end[0] - x) <= 17 for end in points)]
        assert len(own) == 5
        assert all(bottom[0] < top[0] and bottom[1] > top[1] for top, bottom in own)
