# SPDX-License-Identifier: BSD-3-Clause
"""Results from files in motion."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app
from gelenk.simulation import replay
from gelenk.simulation.recording import record

SCENES = ("four_bar", "stewart", "bicycle", "free_body", "heavy_top", "slider_crank")


def positions(view: gelenk.View) -> Any:
    return view._data["poses"][..., :3]


@pytest.mark.parametrize("name", SCENES)
def test_the_motion_of_a_result_is_that_of_its_run(name: str, root: Path) -> None:
    """By the sensors of the recorded run, and by the joint coordinates of the result of the same run."""
    scene = gelenk.load(root / "scenes" / f"{name}.yaml")
    recording = record(scene, stop=0.3, step=0.05)
    found = replay.replayed(scene, recording.result)
    assert found.time == pytest.approx(recording.time)
    assert found.poses[..., :3] == pytest.approx(recording.poses[..., :3], abs=1e-8)
    cosine = np.abs(np.einsum("ijk,ijk->ij", found.poses[..., 3:], recording.poses[..., 3:]))
    assert cosine == pytest.approx(np.ones_like(cosine), abs=1e-12)


def test_long_results_are_thinned_out(four_bar: gelenk.Scene) -> None:
    result = gelenk.simulate(four_bar, stop=1.0, step=0.001)
    assert len(replay.replayed(four_bar, result).time) == replay.MAX_FRAMES


@pytest.mark.parametrize("ending", ["parquet", "nc", "mat"])
def test_files_contain_their_scene_with_its_parameters(
    ending: str, four_bar: gelenk.Scene, tmp_path: Path
) -> None:
    changed = gelenk.load(four_bar.to_dict() | {"parameters": "all"})
    settings = {"crank.m": 0.7, "drive.tau": 2.0}
    result = gelenk.simulate(changed, stop=0.2, step=0.01, parameters=settings)
    file = tmp_path / f"run.{ending}"
    result.save(file)
    read = gelenk.Result.read(file)
    assert read.scene is not None
    assert read.scene["bodies"]["crank"]["mass"] == 0.7
    assert positions(read.view()) == pytest.approx(positions(result.view()), abs=1e-6)
    again = tmp_path / f"again.{ending}"
    read.save(again)
    assert gelenk.Result.read(again).scene == read.scene


def test_a_table_needs_its_scene(four_bar: gelenk.Scene, four_bar_file: Path, tmp_path: Path) -> None:
    result = gelenk.simulate(four_bar, stop=0.2, step=0.01)
    file = tmp_path / "run.csv"
    result.save(file)
    read = gelenk.Result.read(file)
    with pytest.raises(
        gelenk.UsageError, match="the result has no mechanism: it was read from a file without one"
    ):
        read.view()
    assert positions(read.view(scene=four_bar_file)) == pytest.approx(positions(result.view()), abs=1e-6)
    out = tmp_path / "x.html"
    assert (
        run(file, "-o", out).output
        == f"{file}: found no mechanism in it, expected its scene, too: --scene FILE\n"
    )
    done = run(file, "--scene", four_bar_file, "-o", out)
    assert done.exit_code == 0, done.output
    assert out.exists()


def test_a_result_of_another_scene(four_bar: gelenk.Scene, root: Path) -> None:
    partial = gelenk.simulate(four_bar, stop=0.1, outputs=["A.w"])
    with pytest.raises(gelenk.UsageError, match="found no coordinates of A, B, C in the result"):
        replay.replayed(four_bar, partial)
    result = gelenk.simulate(four_bar, stop=0.1)
    with pytest.raises(gelenk.UsageError, match=r"found no coordinates of base1, leg1, .* and \d+ more"):
        replay.replayed(gelenk.load(root / "scenes" / "stewart.yaml"), result)
    source: dict[str, Any] = json.loads(json.dumps(four_bar.to_dict()))
    source["joints"]["D"]["parent"]["position"] = [20, 0, 0]
    with pytest.raises(gelenk.UsageError, match=r"not one of this scene: at t = 0 s, .*cannot be closed"):
        replay.replayed(gelenk.load(source), result)


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["view", *map(str, arguments)])


def test_options_of_simulations_are_refused(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    file = tmp_path / "run.mat"
    gelenk.simulate(four_bar, stop=0.1).save(file)
    done = run(file, "--stop", "1", "--reactions", "-o", tmp_path / "x.html")
    assert done.exit_code == 1
    assert "--stop, --reactions: only for simulations, found results in" in done.output
    wrong = run(file, "--set", "A.phii_start=1", "-o", tmp_path / "x.html")
    assert wrong.exit_code == 1
    assert "A.phii_start" in wrong.output
    assert run(file, "--gif", tmp_path / "x.gif", "--size", "80x60").exit_code == 0


def test_an_fmu_of_others_has_no_scene(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    result = gelenk.simulate(four_bar, stop=0.1)
    result.run = (tmp_path / "gone.yaml", {})
    result.save(tmp_path / "run.mat")
    assert gelenk.Result.read(tmp_path / "run.mat").scene is None
