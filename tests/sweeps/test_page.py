# SPDX-License-Identifier: BSD-3-Clause
"""The code of docs/sweeps.md runs as printed, and its results are the numbers on the page."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pages import commands, create_files, executed, printed

pytestmark = pytest.mark.thorough

LENGTHS = np.array([0.5, 1.75, 1.5, 2.0])  # m: crank, coupler, rocker, frame
DEVIATION = 0.0002  # m


def swing(lengths: Any) -> float:
    """The angle between the dead centers of the rocker; crank and coupler are then in line: two triangles."""
    crank, coupler, rocker, frame = lengths

    def angle(side: float) -> float:
        return float(np.arccos((rocker**2 + frame**2 - side**2) / (2 * rocker * frame)))

    return angle(coupler + crank) - angle(coupler - crank)


@pytest.fixture
def names(empty_folder: Path, root: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    found = executed(root / "docs" / "sweeps.md")
    assert empty_folder == Path.cwd()
    return found | {"printed": capsys.readouterr().out}


def test_the_tolerance_study_has_the_closed_form_propagation(names: dict[str, Any], root: Path) -> None:
    study = names["study"]
    page = (root / "docs" / "sweeps.md").read_text("utf-8")
    numbers = re.search(r"The swing is ([\d.]+)° with a standard deviation of ([\d.]+)°", page)
    assert numbers is not None
    mean, deviation = np.degrees(study["D.phi.swing"].mean()), np.degrees(study["D.phi.swing"].std())
    assert float(mean) == pytest.approx(float(numbers[1]), abs=0.0005)
    assert float(deviation) == pytest.approx(float(numbers[2]), abs=0.0005)
    assert float(study["A.phi.last"].min()) - np.pi / 2 > 2 * np.pi  # a whole revolution
    # Points are up to 0.004 rad of the crank from a dead center, which is 1e-5 rad of the rocker.
    assert float(mean) == pytest.approx(np.degrees(swing(LENGTHS)), abs=1e-3)
    h = 1e-6
    gradient = [(swing(LENGTHS + h * e) - swing(LENGTHS - h * e)) / (2 * h) for e in np.eye(4)]
    propagated = np.degrees(DEVIATION * np.linalg.norm(gradient))
    # Correlations of 200 samples by chance are 1 / sqrt(200) = 7 %.
    assert float(deviation) == pytest.approx(float(propagated), rel=0.07)
    assert "0 failed" in names["printed"]


def test_the_other_examples_of_the_page(names: dict[str, Any]) -> None:
    grid = names["grid"]
    assert grid["D.phi"].dims == ("crank.mass", "drive.tau", "time")
    assert grid["D.phi"].shape == (3, 3, 1001)
    assert names["stored"]["A.w.max"].shape == (50,)
    assert list(Path("study").glob("runs-*.parquet"))


def test_the_command_of_the_page_writes_a_row_for_each_run(empty_folder: Path, root: Path) -> None:
    page = root / "docs" / "sweeps.md"
    create_files(page, empty_folder)
    ((command, expected),) = commands(page)
    assert printed(command, empty_folder) == (0, expected)
    assert len((empty_folder / "study.csv").read_text().splitlines()) == 7
