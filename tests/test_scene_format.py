# SPDX-License-Identifier: BSD-3-Clause
"""What a scene file says arrives as meant, and what is written reads back to the same bits."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_files
from scipy.spatial.transform import Rotation

import gelenk
from gelenk import _core

EPS = 2.2e-16


def two_bodies(joint: dict[str, Any], **bodies: dict[str, Any]) -> dict[str, Any]:
    """A body `b` on the ground by joint `J`; b's fields may be given."""
    b = {"mass": 1.3, "com": [0.1, -0.2, 0.3], "inertia": [0.3, 0.4, 0.5]} | bodies.get("b", {})
    return {"gelenk": 1, "bodies": {"b": b}, "joints": {"J": {"parent": "ground", "child": "b"} | joint}}


def read(scene: dict[str, Any]) -> dict[str, Any]:
    """What came of joint J."""
    joint = gelenk.load(scene).to_dict()["joints"]["J"]
    assert isinstance(joint, dict)
    return joint


def matrix(frame: dict[str, Any]) -> Any:
    return np.array(frame["rotation"]["matrix"]) if "rotation" in frame else np.eye(3)


@pytest.mark.parametrize("path", scene_files.good(), ids=lambda path: path.stem)
def test_written_scene_reads_back_to_the_same_bits(path: Path) -> None:
    written = gelenk.load(path).to_dict()
    again = gelenk.load(written).to_dict()
    assert json.dumps(again) == json.dumps(written)  # text, as 0.0 == -0.0


def test_rotations_mean_what_their_names_say_and_keep_their_bits() -> None:
    """Truth: scipy. Round-off: three products of rotations, entries below 1: 10 eps."""
    rng = np.random.default_rng(7)
    for _ in range(200):
        rpy = rng.uniform(-4, 4, 3)
        axis, angle = rng.normal(size=3), rng.uniform(-7, 7)
        q = rng.normal(size=4) * 10 ** rng.uniform(-3, 3)
        R = Rotation.random(rng=rng).as_matrix()
        cases: list[tuple[dict[str, Any], Any]] = [
            ({"rpy": rpy}, Rotation.from_euler("xyz", rpy).as_matrix()),
            (
                {"axis": axis, "angle": angle},
                Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix(),
            ),
            ({"quaternion": q}, Rotation.from_quat(q, scalar_first=True).as_matrix()),
            ({"matrix": R}, R),
            ({"matrix": np.round(R, 8)}, R),
        ]
        for rotation, truth in cases:
            joint = read(two_bodies({"type": "weld", "child": {"body": "b", "rotation": rotation}}))
            found = matrix(joint["child"])
            printed = 1e-8 if "matrix" in rotation and rotation["matrix"] is not R else 0
            assert abs(found - truth).max() < 20 * EPS + 2 * printed
            assert abs(found.T @ found - np.eye(3)).max() < 32 * EPS
            again = read(two_bodies({"type": "weld", "child": joint["child"]}))
            assert again["child"] == joint["child"]


def test_joint_placed_in_the_world_is_the_one_placed_in_both_bodies() -> None:
    """X_BF = X_WB^-1 X_WF, with the body's reference pose; the ground's is the identity."""
    rng = np.random.default_rng(11)
    R_WB, R_WF = Rotation.random(2, rng=rng)
    p_WB, p_WF = rng.normal(size=(2, 3))
    joint = read(
        two_bodies(
            {"type": "universal", "at": {"position": p_WF, "rotation": {"matrix": R_WF.as_matrix()}}},
            b={"pose": {"position": p_WB, "rotation": {"quaternion": R_WB.as_quat(scalar_first=True)}}},
        )
    )
    assert joint["parent"]["position"] == list(p_WF)
    assert abs(matrix(joint["parent"]) - R_WF.as_matrix()).max() < 10 * EPS
    # Twelve products and sums of numbers up to about 2.
    assert joint["child"]["position"] == pytest.approx(R_WB.inv().apply(p_WF - p_WB), abs=50 * EPS)
    assert abs(matrix(joint["child"]) - (R_WB.inv() * R_WF).as_matrix()).max() < 20 * EPS


def test_axes_become_unit_vectors_however_long_or_short() -> None:
    for length in (1e-310, 1e-9, 1.0, 7.3, 1e300):
        joint = read(two_bodies({"type": "revolute", "axis": [length * 2, length * -1, length * 2]}))
        assert joint["axis"] == pytest.approx([2 / 3, -1 / 3, 2 / 3], abs=1e-14 if length > 1e-300 else 1e-12)
        assert read(two_bodies({"type": "revolute", "axis": joint["axis"]}))["axis"] == joint["axis"]
    assert read(two_bodies({"type": "revolute"}))["axis"] == [0, 0, 1]
    assert read(two_bodies({"type": "universal"}))["axes"] == [[1, 0, 0], [0, 1, 0]]


def test_start_values_by_name_array_and_rotation() -> None:
    start = {"r": [1, 2, 3], "Q": [0, 0, 3, 4], "w": [5, 6, 7], "fixed": ["r", "w"]}
    joint = read(two_bodies({"type": "free", "start": start}))
    assert joint["start"] == {"r": [1, 2, 3], "Q": [0, 0, 0.6, 0.8], "w": [5, 6, 7], "fixed": ["r", "w"]}
    turned = {"rotation": {"axis": [0, 0, 1], "angle": 2 * np.arctan2(3, 4)}, "fixed": ["rotation"]}
    joint = read(two_bodies({"type": "spherical", "start": turned}))
    assert joint["start"]["Q"] == pytest.approx([0, 0, 0.6, 0.8], abs=4 * EPS)
    assert joint["start"]["fixed"] is True


def test_stop_keeps_the_bounds_it_has() -> None:
    for stop in ({"lower": -0.1, "upper": 0.2}, {"upper": 0.0}, {"lower": 1e-3}):
        full = {**stop, "stiffness": 3e4, "damping": 2.5, "law": "limited"}
        joint = read(two_bodies({"type": "prismatic", "stop": full}))
        assert joint["stop"] == full
        assert read(two_bodies(joint)) == joint
        assert (
            read(two_bodies({"type": "revolute", "stop": {**stop, "stiffness": 2}}))["stop"]["damping"] == 0
        )
    assert "stop" not in read(two_bodies({"type": "revolute"}))


def test_three_moments_of_inertia_are_six_without_products() -> None:
    scene = two_bodies({"type": "free"}, b={"inertia": [0.3, 0.4, 0.5]})
    assert gelenk.load(scene).to_dict()["bodies"]["b"]["inertia"] == [0.3, 0.4, 0.5, 0, 0, 0]


TEXTS = ("author", "version", "description", "copyright", "license")


def test_information_about_the_scene_is_kept_as_it_is_given() -> None:
    texts = {key: f'{key} <&> "Ü"\n\tof two lines\n' for key in TEXTS} | {"author": "é" * 10_000}
    scene = two_bodies({"type": "revolute"})
    written = gelenk.load(scene | texts).to_dict()
    assert {key: written[key] for key in TEXTS} == texts
    assert not set(TEXTS) & set(gelenk.load(scene).to_dict())


@pytest.mark.parametrize("key", TEXTS)
@pytest.mark.parametrize("text", ["", "é" * 10_001, "a\x07b", "a\x7fb", "a\rb", "a\ufffeb", "\uffff"])
def test_information_that_xml_cannot_contain_is_refused(key: str, text: str) -> None:
    scene = two_bodies({"type": "revolute"})
    with pytest.raises(
        gelenk.SceneError, match=f"{key}: found '.*', expected a text of 1 to 10000 printable"
    ):
        gelenk.load(scene | {key: text})


@pytest.mark.parametrize("text", ["a\nb", "\ufffe"])
def test_a_name_has_one_line_of_characters(text: str) -> None:
    with pytest.raises(gelenk.SceneError, match=r"name: found '.*', expected a name of 1 to 200 printable"):
        gelenk.load(two_bodies({"type": "revolute"}) | {"name": text})


def test_sections_keep_the_order_of_the_file() -> None:
    names = ["z", "a", "m", "b"]
    scene = {
        "gelenk": 1,
        "bodies": {name: {"mass": 1} for name in names},
        "joints": {name.upper(): {"type": "weld", "parent": "ground", "child": name} for name in names},
    }
    data = gelenk.load(scene).to_dict()
    assert list(data["bodies"]) == names
    assert list(data["joints"]) == [name.upper() for name in names]


def test_no_mutilated_scene_does_more_than_be_refused() -> None:
    """A mutation breaks JSON, a type, a name or a number. What is read can be written and read."""
    rng = random.Random(5)
    texts = [json.dumps(gelenk.load(path).to_dict()) for path in scene_files.good()]
    pieces = ["", "NaN", "-1", "1e308", "1e-320", "{}", "[]", "null", "true", '"x"', "{", "]", ",", "\\u0000"]
    refusals: list[str] = []
    taken = []
    for _ in range(600):
        text = rng.choice(texts)
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(len(text))
            text = text[:at] + rng.choice(pieces) + text[at + rng.choice([0, 1, 4]) :]
        try:
            taken.append(_core.read_scene_json(text, "scene.json"))
        except gelenk.SceneError as error:
            refusals += error.lines
    assert all(line.startswith("scene.json:") for line in refusals)
    assert 0 < len(taken) < 300  # some mutations touch only digits; most break something
    for scene in taken:
        written = _core.write_scene_json(scene)
        assert _core.write_scene_json(_core.read_scene_json(written, "scene.json")) == written


NULS = {
    "1\0": "1:2: found '\\x00', expected end of input",
    '{"gelenk": 1}\0 {': "1:14: found '\\x00', expected end of input",
    '{"gelenk":\n \0 1}': "2:2: found '\\x00', expected well-formed JSON",
    '{"gelenk": 1, \0"name": ""}': "1:15: found '\\x00', expected a name in double quotes",
    '{"gelenk": 1, "a\0b": 1}': "1:17: found '\\x00', expected a name in double quotes",
}


@pytest.mark.parametrize("text", NULS)
def test_a_nul_does_not_end_a_text(text: str) -> None:
    """Nor hide what stands behind it."""
    with pytest.raises(gelenk.SceneError) as told:
        _core.read_scene_json(text, "s.json")
    assert str(told.value) == f"s.json:{NULS[text]}"
