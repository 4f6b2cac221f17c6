# SPDX-License-Identifier: BSD-3-Clause
"""Angles in degrees in plots and pages, by one option; everything else is unchanged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app

UNITS = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2"}


def test_plots_in_degrees(four_bar: gelenk.Scene) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib (the extra charts) is not installed")
    run = gelenk.simulate(four_bar, stop=0.1)
    names = ["A.phi", "A.w", "A.a"]
    for axes, name in zip(run.plot(names, degrees=True).axes, names, strict=True):
        assert axes.get_ylabel() == UNITS[run.units[name]]
        np.testing.assert_allclose(
            np.asarray(axes.lines[-1].get_ydata(), float), np.degrees(run[name]), rtol=4e-16
        )
    for axes, name in zip(run.plot(names).axes, names, strict=True):
        assert axes.get_ylabel() == run.units[name]
        assert np.array_equal(axes.lines[-1].get_ydata(), run[name])


def test_lengths_remain_lengths(root: Path) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib (the extra charts) is not installed")
    run = gelenk.simulate(root / "scenes" / "cart_pole.yaml", stop=0.1)
    track, hinge = run.plot(["track.s", "hinge.phi"], degrees=True).axes
    assert (track.get_ylabel(), hinge.get_ylabel()) == ("m", "deg")
    assert np.array_equal(track.lines[-1].get_ydata(), run["track.s"])


def test_a_result_without_units_is_not_guessed_at(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib (the extra charts) is not installed")
    gelenk.simulate(four_bar, stop=0.01).save(tmp_path / "run.csv")
    with pytest.raises(gelenk.UsageError, match="degrees: found a result without units"):
        gelenk.Result.read(tmp_path / "run.csv").plot(degrees=True)


def test_pages_in_degrees(four_bar: gelenk.Scene) -> None:
    """The bodies are the same; single precision rounds to 6e-8."""
    page = gelenk.view(four_bar, stop=0.1)
    turned = gelenk.view(four_bar, stop=0.1, degrees=True)
    assert page._data.keys() == turned._data.keys()
    assert np.array_equal(page._data["poses"], turned._data["poses"])
    for before, after in zip(page._data["signals"], turned._data["signals"], strict=True):
        assert after["unit"] == UNITS.get(before["unit"], before["unit"])
        expected = np.degrees(before["values"]) if before["unit"] in UNITS else before["values"]
        np.testing.assert_allclose(after["values"], expected, rtol=2e-7)
        assert after["values"].dtype == before["values"].dtype
    assert '"deg"' in turned.html


def test_both_runs_of_an_overlay(four_bar: gelenk.Scene) -> None:
    both = gelenk.view([four_bar, four_bar.with_parameters({"crank.m": 2.0})], stop=0.1, degrees=True)
    row = next(row for row in both._data["signals"] if row["name"] == "A.phi")
    assert row["unit"] == "deg"
    assert row["values"][0] == row["second"][0] == pytest.approx(90.0, rel=1e-6)


def test_the_option_of_commands(root: Path, empty_folder: Path) -> None:
    pytest.importorskip("matplotlib", reason="matplotlib (the extra charts) is not installed")
    scene = str(root / "scenes" / "four_bar.yaml")
    assert CliRunner().invoke(app, ["plot", scene, "--degrees", "-o", "a.svg"]).exit_code == 0
    assert (
        CliRunner().invoke(app, ["view", scene, "--stop", "0.1", "--degrees", "-o", "a.html"]).exit_code == 0
    )
    assert '"deg"' in (empty_folder / "a.html").read_text(encoding="utf-8")
