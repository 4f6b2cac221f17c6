# SPDX-License-Identifier: BSD-3-Clause
"""Arrows: forces of springs, loads, motors and joints, against Newton's law and closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene

import gelenk
from gelenk.model.skeleton import loop_joints, placed
from gelenk.simulation.recording import Recording, record
from gelenk.viewer.arrows import Arrow
from gelenk.viewer.data import page_data


def arrows(recording: Recording, name: str, unit: str = "N") -> list[Arrow]:
    return [arrow for arrow in recording.arrows if arrow.name == name and arrow.unit == unit]


def test_forces_on_a_body_are_its_mass_times_its_acceleration(root: Path) -> None:
    """The body K3 of Andrews' squeezer: joint gamma to the ground, joint F3 to K2, and a spring.

    The acceleration is the central difference of positions, of order 2 in steps of 1e-5 s.
    """
    path = root / "scenes" / "andrews.yaml"
    recording = record(gelenk.load(path), stop=0.00999, step=1e-5, reactions=True)
    names = [*recording.scene["bodies"]]
    plain = recording.scene["bodies"]["K3"]
    center = placed(recording.poses[:, names.index("K3")], np.array(plain["com"]))
    step = np.diff(recording.time)[0]
    acceleration = (center[2:] - 2 * center[1:-1] + center[:-2]) / step**2
    total = arrows(recording, "spring")[0].vectors
    for name, row in recording.scene["joints"].items():
        for side, sign in (("child", 1), ("parent", -1)):
            if row[side]["body"] == "K3":
                total = total + sign * arrows(recording, name)[0].vectors
    expected = plain["mass"] * acceleration
    assert np.abs(expected).max() > 10  # N
    # (w h)^2 / 12 with w of about 600/s is 3e-6; rounding of positions to 1e-13 m gives 1e-3 m/s2.
    assert total[1:-1] == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())


def hanging(**more: Any) -> dict[str, Any]:
    """A bob of 2 kg on a slider along z, with what is to be tested."""
    return scene(
        {"bob": body(2.0, inertia=(0.1, 0.1, 0.1))},
        {"J": joint("prismatic", frame("ground"), frame("bob"), axis=[0, 0, 1], start={"s": 0.25, "v": 0.5})},
        gravity=[0, 0, -9.81],
        **more,
    )


def test_springs_loads_and_motors() -> None:
    source = hanging(
        forces={
            "spring": {
                "type": "spring_damper", "stiffness": 100, "damping": 4, "length": 1.5,
                "from": {"body": "ground", "position": [0, 0, 2]}, "to": {"body": "bob"},
            },
            "push": {
                "type": "wrench", "body": "bob", "position": [0.1, 0, 0], "force": [1, 0, 0], "input": True
            },
            "air": {"type": "drag", "body": "bob", "damping": 2, "coefficient": 3},
        },
        motors={"drive": {"joint": "J", "gear_ratio": 5}},
    )  # fmt: skip
    recording = record(
        gelenk.load(source), stop=0.1, step=0.05, inputs={"push.f[2]": lambda t: 2 + t, "drive.f": 0.7}
    )
    s, v = recording.result["J.s"], recording.result["J.v"]
    (spring,) = arrows(recording, "spring")  # the other end is the ground's
    assert spring.vectors[:, 2] == pytest.approx(100 * (2 - s - 1.5) - 4 * v, rel=1e-12)
    (push,) = arrows(recording, "push")
    assert push.points.tolist() == [0.1, 0, 0]
    assert push.vectors == pytest.approx(np.column_stack([1 + 0 * s, 2 + recording.time, 0 * s]))
    (air,) = arrows(recording, "air")
    assert air.vectors[:, 2] == pytest.approx(-(2 + 3 * np.abs(v)) * v, rel=1e-12)
    (drive,) = arrows(recording, "drive")
    assert drive.vectors == pytest.approx(np.tile([0, 0, 3.5], (len(s), 1)))
    assert arrows(recording, "J") == []


def test_a_load_in_the_frame_of_its_body_turns_with_it() -> None:
    turn = {"axis": [1, 0, 0], "angle": np.pi / 2}
    source = scene(
        {"arm": body(1.0, com=(0.5, 0, 0), inertia=(0.1, 0.1, 0.1))},
        {"J": joint("revolute", frame("ground"), frame("arm"), axis=[0, 0, 1], start={"phi": np.pi / 2})},
        forces={
            "jet": {"type": "wrench", "body": "arm", "rotation": turn, "force": [3, 5, 0], "frame": "body"}
        },
    )  # fmt: skip
    (jet,) = arrows(record(gelenk.load(source), stop=0.0), "jet")
    # (3, 5, 0) in the load's frame is (3, 0, 5) in the arm's, and (0, 3, 5) in the world.
    assert jet.vectors[0] == pytest.approx([0, 3, 5], abs=1e-12)


def test_the_page_leaves_out_rounding_errors_and_keeps_components_to_16_bits(root: Path) -> None:
    recording = record(gelenk.load(root / "scenes" / "andrews.yaml"), reactions=True)
    shown = page_data(recording)["arrows"]
    assert {row["name"] for row in shown if row["unit"] == "N m"} == {"drive"}  # joints transmit no torque
    row = next(row for row in shown if row["name"] == "beta")
    (beta,) = arrows(recording, "beta")
    error = np.abs(row["vectors"] * row["scale"] - beta.vectors).max()
    assert error <= 0.5 * np.abs(beta.vectors).max() / 32767 * (1 + 1e-9)


def test_a_joint_with_a_sensor_has_arrows_and_none_twice(root: Path) -> None:
    scene_ = gelenk.load(root / "scenes" / "slider_crank.yaml")
    alone = record(scene_, stop=0.1, inputs={"starter.tau": 1.0})
    assert {arrow.name for arrow in alone.arrows if arrow.kind == "reaction"} == {"main"}
    assert len(arrows(alone, "main")) == 1
    every = record(scene_, stop=0.1, inputs={"starter.tau": 1.0}, reactions=True)
    assert {arrow.name for arrow in every.arrows if arrow.kind == "reaction"} == {*scene_.to_dict()["joints"]}
    assert len(arrows(every, "main")) == 1


def test_joints_that_close_loops(four_bar: gelenk.Scene) -> None:
    assert loop_joints(four_bar.to_dict()) == {"D"}
    assert [row["loop"] for row in page_data(record(four_bar, stop=0.0))["joints"]] == [False] * 3 + [True]


def test_marks_tell_singular_configurations_from_other_events(four_bar: gelenk.Scene) -> None:
    recording = record(four_bar, stop=0.1)
    recording.result.events = (
        (0.02, "passed a singular configuration, where the loops could continue on another branch"),
        (0.03, "A sticks"),
        (0.1, "the run ended: t = 0.1 s: ..."),
    )
    assert [row["kind"] for row in page_data(recording)["events"]] == ["singular", "event", "end"]
