# SPDX-License-Identifier: BSD-3-Clause
"""Two runs on one page."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation, Slerp
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app
from gelenk.viewer.interpolation import resampled

from .browser import Browser


def test_poses_at_other_times() -> None:
    """Against SciPy; before the first frame and after the last, bodies rest."""
    rng = np.random.default_rng(3)
    time = np.array([0.0, 0.3, 1.0, 1.1])
    turns = [Rotation.random(4, rng=rng) for _ in range(2)]
    poses = np.stack([np.column_stack([rng.normal(size=(4, 3)), turn.as_quat()]) for turn in turns], axis=1)
    at = np.array([-1.0, 0.0, 0.1, 0.3, 0.99, 1.1, 5.0])
    found = resampled(time, poses, at)
    inside = at.clip(0, 1.1)
    for body, turn in enumerate(turns):
        expected = Slerp(time, turn)(inside)
        error = (expected.inv() * Rotation.from_quat(found[:, body, 3:])).magnitude()
        assert error == pytest.approx(np.zeros(7), abs=1e-7)  # arccos near 1
        for k in range(3):
            assert found[:, body, k] == pytest.approx(np.interp(inside, time, poses[:, body, k]), abs=1e-12)


def runs(four_bar: gelenk.Scene) -> tuple[gelenk.View, gelenk.View]:
    first = gelenk.view(four_bar, stop=1.0, step=0.01, inputs={"drive.tau": 3.0})
    return first, gelenk.view(four_bar, stop=1.5, step=0.02, inputs={"drive.tau": 2.0})


def test_the_longer_run_determines_the_times(four_bar: gelenk.Scene) -> None:
    first, second = runs(four_bar)
    data = first.overlay(second, ["3 N m", "2 N m"])._data
    assert data["time"] == pytest.approx([*np.arange(101) / 100, *np.arange(51, 76) / 50])
    assert data["poses"].shape == data["second"]["poses"].shape == (126, 3, 7)
    assert (data["poses"][100:] == first._data["poses"][-1]).all()
    assert data["second"]["poses"][100:] == pytest.approx(second._data["poses"][50:], abs=1e-6)
    phi = next(row for row in data["signals"] if row["name"] == "A.phi")
    assert np.isnan(phi["values"][101:]).all()
    assert np.isfinite(phi["values"][:101]).all()
    assert np.isfinite(phi["second"]).all()
    assert data["name"] == "3 N m"
    shorter = second.overlay(first)._data
    assert (shorter["name"], shorter["second"]["name"]) == ("FourBar 1", "FourBar 2")
    assert len(shorter["time"]) == 76


def test_three_runs_are_refused(four_bar: gelenk.Scene) -> None:
    first, second = runs(four_bar)
    both = first.overlay(second)
    for one, other in ((both, first), (first, both)):
        with pytest.raises(gelenk.UsageError, match="found a page of two runs, expected one run each"):
            one.overlay(other)
    with pytest.raises(gelenk.UsageError, match="names: found 1, expected 2"):
        first.overlay(second, ["a"])
    with pytest.raises(gelenk.UsageError, match="view: found 3 runs, expected one or two"):
        gelenk.view([four_bar] * 3)


def test_results_are_laid_over_each_other(four_bar: gelenk.Scene) -> None:
    results = [gelenk.simulate(four_bar, stop=0.2, inputs={"drive.tau": tau}) for tau in (1.0, 3.0)]
    page = gelenk.view(results)
    assert page.html == results[0].view().overlay(results[1].view()).html


def test_the_second_run_is_translucent_in_pictures(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    """At its end, another color where it is, paler than the first run's."""
    first, second = runs(four_bar)
    both = first.overlay(second)
    pictures = []
    for k, page in enumerate((both, both.__class__({k: v for k, v in both._data.items() if k != "second"}))):
        file = page.save(tmp_path / f"{k}.png", size=(160, 120), camera=(-90, 0), span=(1.0, 1.0))
        pictures.append(np.asarray(Image.open(file).convert("RGB"), float))
    # The cameras fit different points, so that the pictures are compared as a whole.
    dark = [(picture.min(axis=2) < 225).sum() for picture in pictures]
    assert dark[0] > 1.3 * dark[1]


def test_command(four_bar_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.html"
    arguments = [
        "view",
        str(four_bar_file),
        "--stop",
        "0.1",
        "--set",
        "drive.tau=3",
        "--with-set",
        "drive.tau=1",
    ]
    done = CliRunner().invoke(app, [*arguments, "-o", str(out)])
    assert done.exit_code == 0, done.output
    assert '"name":"FourBar 2"' in out.read_text(encoding="utf-8")
    other = CliRunner().invoke(app, [*arguments[:4], "--with", str(four_bar_file), "-o", str(out)])
    assert other.exit_code == 0, other.output
    assert '"second":{"name":"FourBar 2"' in out.read_text(encoding="utf-8")


def test_both_runs_move_on_the_page(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    first, second = runs(four_bar)
    browser = Browser()
    try:
        browser.open(first.overlay(second).save(tmp_path / "x.html"))
        browser.run("gelenk.pause(); gelenk.show(50)")
        for run, view, frame in ((1, first, 50), (2, second, 25)):
            pose = browser.run(f"return gelenk.pose('coupler', {run})")
            assert pose["p"] == pytest.approx(view._data["poses"][frame, 1, :3], abs=1e-6)
        assert browser.errors() == []
    finally:
        browser.close()
