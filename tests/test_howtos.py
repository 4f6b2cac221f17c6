# SPDX-License-Identifier: BSD-3-Clause
"""The code of the how-to pages runs as printed, and its results are the numbers on the page."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import warned
import yaml
from mechanisms import GRAVITY, Scene
from pages import blocks, executed

import gelenk


@pytest.mark.usefixtures("empty_folder")
def test_friction_of_bearings(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = root / "docs" / "howto-bearings.md"
    executed(page)
    told = capsys.readouterr().out.splitlines()
    assert float(told[0]) == pytest.approx(float(told[1]), rel=1e-7)  # the tolerance, over the speed's range
    assert f"{float(told[0]):.1f}" == "364.9"
    assert f'print(rest.held["axle.phi"])  # {told[2]}' in blocks(page, "python")[0]


@warned.GYRATION
@pytest.mark.parametrize(("share", "rests"), [(0.999, True), (1.001, False)])
def test_a_pin_holds_within_its_friction_circle(root: Path, share: float, rests: bool) -> None:
    """1.5 mm, as the page states."""
    pin = yaml.safe_load(blocks(root / "docs" / "howto-bearings.md", "yaml")[1])["pin"]
    lever = {"mass": 3.0, "com": [share * 0.0015, 0, 0], "inertia": [0.01, 0.01, 0.01]}
    source: Scene = {
        "gelenk": 1,
        "name": "lever",
        "gravity": [0, -GRAVITY, 0],
        "bodies": {"lever": lever},
        "joints": {"pin": pin},
    }
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize(0.0, 1e-8)
    plant.step_to(0.5)
    assert (plant.output("pin.w") == 0) == rests
    assert math.isfinite(plant.output("pin.phi"))
