# SPDX-License-Identifier: BSD-3-Clause
"""Recorded runs: the poses of bodies, and which rows of a run become frames."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from models.running import assert_close

import gelenk
from gelenk.model.skeleton import placed
from gelenk.simulation.inputs import Inputs
from gelenk.simulation.recording import MAX_FRAMES, record, scene_of


def test_poses_are_those_of_the_simulation(root: Path) -> None:
    """The same steps with another interface: rotation matrices instead of quaternions."""
    scene = gelenk.load(root / "scenes" / "stewart.yaml")
    recording = record(scene, stop=0.2, step=0.01)
    plant = gelenk.Simulation(scene)
    plant.initialize()
    p = np.array([0.3, -0.2, 0.1])
    for k, t in enumerate(recording.time):
        plant.step_to(float(t))
        for number, body in enumerate(recording.scene["bodies"]):
            R, origin = plant.pose(body)
            found = placed(recording.poses[k : k + 1, number], p)[0]
            assert_close(body, found, R @ p + origin, 1e-12, "rounding of rotations")


def test_a_recorded_run_is_the_same_run(root: Path) -> None:
    """To the bit: where bodies are, and what acts on them, is read, not computed by other steps."""
    scene = gelenk.load(root / "docs" / "gallery" / "gripper" / "scene.yaml")
    inputs: Inputs = {"grip1.tau": lambda t: 0.1 * t, "grip2.tau": 0.2}
    plain = gelenk.simulate(scene, stop=0.1, step=1e-3, inputs=inputs)
    recorded = record(scene, stop=0.1, step=1e-3, inputs=inputs).result
    assert recorded.names == plain.names
    assert all((recorded[name] == plain[name]).all() for name in plain)
    assert recorded.events == plain.events


def test_other_outputs_than_those_of_the_scene(four_bar: gelenk.Scene) -> None:
    narrow = four_bar.with_outputs(["A.phi"])
    assert record(narrow, stop=0.1, outputs=["D.phi"]).result.names == ("D.phi",)


def test_a_long_run_is_thinned_out(four_bar: gelenk.Scene) -> None:
    recording = record(four_bar, stop=3.0, step=0.001)
    assert len(recording.time) == MAX_FRAMES
    assert recording.time[0] == 0
    assert recording.time[-1] == 3.0
    assert np.diff(recording.time).max() <= 0.004 + 1e-12  # the ratio 3.003 rounded up, in steps
    assert len(record(four_bar, stop=1.0, step=0.01).time) == 101


def test_the_start_alone(four_bar: gelenk.Scene) -> None:
    assert record(four_bar, stop=0.0).poses.shape == (1, 3, 7)


def test_requested_outputs_are_those_that_are_plotted(four_bar: gelenk.Scene) -> None:
    recording = record(four_bar.with_outputs(["A.phi"]), stop=0.1)
    assert [*recording.result.names] == ["A.phi"]
    assert recording.poses.shape[1] == 3


def test_parameters_of_the_run_change_what_is_drawn(four_bar: gelenk.Scene) -> None:
    scene = gelenk.load(four_bar.to_dict() | {"parameters": "all"})
    settings = {"B.parent.position[1]": 0.6, "drive.tau": 3.0}  # a longer crank; and an input
    recording = record(scene, stop=0.1, step=0.01, parameters=settings)
    assert recording.scene["joints"]["B"]["parent"]["position"] == [0.6, 0, 0]
    tip, pin = (recording.scene["joints"]["B"][side]["position"] for side in ("parent", "child"))
    crank, coupler = (recording.poses[:, k] for k in (0, 1))
    found = placed(crank, np.array(tip)) - placed(coupler, np.array(pin))
    assert_close("B", found, 0.0, 1e-10, "the closure of the loop")


def test_one_output_by_its_name(four_bar: gelenk.Scene) -> None:
    assert record(four_bar, stop=0.1, outputs="A.phi").result.names == ("A.phi",)


def test_an_fmu_contains_its_scene(four_bar: gelenk.Scene, four_bar_fmu: Path, tmp_path: Path) -> None:
    assert scene_of(four_bar_fmu).to_dict()["bodies"] == four_bar.to_dict()["bodies"]
    other = tmp_path / "other.fmu"
    other.write_bytes(b"no archive")
    with pytest.raises(gelenk.UsageError, match=r"other\.fmu: not an FMU"):
        scene_of(other)
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    with pytest.raises(gelenk.UsageError, match="found no scene in it, expected an FMU made by Gelenk"):
        scene_of(other)


def test_a_result_is_viewed_by_its_run(four_bar: gelenk.Scene) -> None:
    """With its inputs, also if it has few outputs; a file has no mechanism."""
    result = gelenk.simulate(four_bar, stop=0.5, step=0.01, inputs={"drive.tau": 3.0}, outputs=["A.phi"])
    page = result.view()
    assert page.html == gelenk.view(
        four_bar, stop=0.5, step=0.01, inputs={"drive.tau": 3.0}, outputs=["A.phi"]
    ).html  # fmt: skip
    assert page.html != gelenk.view(four_bar, stop=0.5, step=0.01, outputs=["A.phi"]).html
    result.run = None
    with pytest.raises(gelenk.UsageError, match="has no mechanism"):
        result.view()
