# SPDX-License-Identifier: BSD-3-Clause
"""A scene is saved as it was given: what has not changed keeps its comments, its layout and its spelling."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from difflib import unified_diff
from pathlib import Path

import pytest
import scene_files
from samples import thorough_beyond

import gelenk
from gelenk import _core
from gelenk.model import yaml_edits

SMALL = [file for file in scene_files.good() if file.stem not in ("andrews", "bicycle", "stewart")]
TEXT = """\
# A pendulum
gelenk: 1
gravity: [0, 0, -981e-2]   # m/s2
bodies:
  bob: {mass: 0x10, com: [+.5, 0., 0],   # kg, m
        inertia: [0, 1e-1, 1e-1]}   # kg m2
# The only joint
joints:
  'pin':
    type: revolute
    axis: [0, 1, 0]   # across
    parent: ground   # at the origin
    child: bob
    start: {phi: 0.3}   # a guess

sensors: {swing: {type: energy},   # of all
          tip: {type: frame, body: bob}}
outputs:
  - pin.phi   # rad
  # its speed, too
  - pin.w   # rad/s
  - swing.*
parameters: [bob.mass]
# The end
"""


def saved(scene: gelenk.Scene, folder: Path) -> str:
    """The text, after it was read again."""
    path = folder / "saved.yaml"
    scene.save(path)
    assert gelenk.load(path).to_dict() == scene.to_dict()
    return path.read_bytes().decode()


def differences(before: str, after: str) -> list[str]:
    """The lines that went, with `-`, and those that came, with `+`."""
    found = [*unified_diff(before.splitlines(), after.splitlines(), n=0, lineterm="")][2:]
    return [line for line in found if not line.startswith("@@")]


@pytest.mark.parametrize("path", scene_files.good(), ids=lambda path: path.stem)
def test_a_scene_that_was_not_changed_is_saved_byte_by_byte(path: Path, tmp_path: Path) -> None:
    assert saved(gelenk.load(path), tmp_path) == path.read_text("utf-8")


@pytest.mark.parametrize("path", thorough_beyond(scene_files.good(), SMALL), ids=lambda path: path.stem)
def test_a_parameter_changes_its_own_line(path: Path, tmp_path: Path) -> None:
    """Every number that the scene has: its line is another, or one has come, and all others stay."""
    scene = gelenk.load(path)
    text = path.read_text("utf-8")
    for parameter in _core.list_parameters(scene._core):
        if parameter.type != "real" or re.match(r"solver\.(baum|rho)|.*Q_start", parameter.name):
            continue  # not with this formulation and integrator; made a unit quaternion again
        value = parameter.value(scene._core)
        other = 0.9 * value if value else min(1e-3, parameter.max)
        found = differences(text, saved(scene.with_parameters({parameter.name: other}), tmp_path))
        assert [line[0] for line in found] in (["-", "+"], ["+"]), (parameter.name, found)


CHANGES: list[tuple[str, Callable[[gelenk.Scene], gelenk.Scene], list[str]]] = [
    (
        "a mass",
        lambda scene: scene.with_parameters({"bob.m": 3}),
        [
            "-  bob: {mass: 0x10, com: [+.5, 0., 0],   # kg, m",
            "+  bob: {mass: 3.0, com: [+.5, 0., 0],   # kg, m",
        ],
    ),
    (
        "gravity",
        lambda scene: scene.with_parameters({"gravity[3]": -1.62}),
        ["-gravity: [0, 0, -981e-2]   # m/s2", "+gravity: [0, 0, -1.62]   # m/s2"],
    ),
    (
        "a start value that was not given",
        lambda scene: scene.with_parameters({"pin.w_start": 2}),
        ["-    start: {phi: 0.3}   # a guess", "+    start: {phi: 0.3, w: 2.0}   # a guess"],
    ),
    (
        "a section that was not given",
        lambda scene: scene.with_parameters({"solver.integrator": "rk4"}),
        ["+solver: {integrator: rk4}"],
    ),
    ("a reduction", lambda scene: scene.without(["planar"]), ["+solver: {reductions: {planar: false}}"]),
    ("no outputs", lambda scene: scene.with_outputs(None), [
        "-outputs:", "-  - pin.phi   # rad", "-  # its speed, too", "-  - pin.w   # rad/s", "-  - swing.*",
    ]),
    ("fewer outputs", lambda scene: scene.with_outputs(["pin.w", "swing.*"]), ["-  - pin.phi   # rad"]),
    (
        "another output",
        lambda scene: scene.with_outputs(["pin.phi", "swing.*", "tip.v[2]"]),
        ["-  - pin.w   # rad/s", "+  - 'tip.v[2]'"],
    ),
    ("more outputs", lambda scene: scene.with_outputs([*scene.outputs, "tip.r[1]"]), ["+  - 'tip.r[1]'"]),
    (
        "outputs in another order",
        lambda scene: scene.with_outputs(["swing.*", "pin.phi"]),
        [
            "-  - pin.phi   # rad",
            "-  # its speed, too",
            "-  - pin.w   # rad/s",
            "-  - swing.*",
            "+  [swing.*, pin.phi]",
        ],
    ),
    (
        "one thing after the other",
        lambda scene: scene.with_parameters({"bob.m": 3}).without(["planar"]).with_parameters({"bob.m": 4}),
        [
            "-  bob: {mass: 0x10, com: [+.5, 0., 0],   # kg, m",
            "+  bob: {mass: 4.0, com: [+.5, 0., 0],   # kg, m",
            "+solver: {reductions: {planar: false}}",
        ],
    ),
    ("and back", lambda scene: scene.with_parameters({"bob.m": 3}).with_parameters({"bob.m": 16}), []),
]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "lines"), [case[1:] for case in CHANGES], ids=[case[0] for case in CHANGES]
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_change_leaves_all_else_as_it_stands(
    change: Callable[[gelenk.Scene], gelenk.Scene], lines: list[str], newline: str, tmp_path: Path
) -> None:
    text = TEXT.replace("\n", newline)
    found = saved(change(gelenk.load(text)), tmp_path)
    assert differences(text, found) == lines
    assert found.count("\n") == found.count(newline)


def test_a_branch_is_put_into_the_text_of_its_scene(tmp_path: Path) -> None:
    path = scene_files.SCENES / "four_bar.yaml"
    found = saved(gelenk.assemblies(path)[1].apply_to(path), tmp_path)
    assert {line[1:].strip().split(":")[0] for line in differences(path.read_text(), found)} == {"start"}


def test_a_text_of_one_language_is_not_put_into_another(tmp_path: Path) -> None:
    scene = gelenk.load(TEXT).with_parameters({"bob.m": 3})
    scene.save(tmp_path / "s.json")
    data = json.loads((tmp_path / "s.json").read_text())
    assert data["bodies"]["bob"] == {"mass": 3.0, "com": [0.5, 0.0, 0], "inertia": [0, 0.1, 0.1]}
    again = gelenk.load(tmp_path / "s.json")
    assert saved(again, tmp_path).startswith("gelenk: 1\ngravity: [0, 0, -9.81]\n")
    assert "solver" not in saved(again.with_parameters({"bob.m": 5}), tmp_path)  # nor defaults


def test_where_single_fields_do_not_do_it_all_is_written_anew(tmp_path: Path) -> None:
    """The crank is placed by `at`, and moved with the rest by the tolerance of assembly."""
    text = TEXT.replace(
        "    parent: ground   # at the origin\n", "    parent: ground\n    at: {position: [0, 0, 1]}\n"
    )
    scene = gelenk.load(text)
    data = scene.to_dict()
    data["joints"]["pin"]["parent"]["position"] = [0, 0, 2]
    moved = scene._with_core(gelenk.load(data)._core)
    assert saved(moved, tmp_path).count("#") == 0
    assert gelenk.load(tmp_path / "saved.yaml").to_dict() == data


@pytest.mark.parametrize(
    ("text", "after", "expected"),
    [
        ("a: &x 1\nb: *x\n", {"a": 2, "b": 2}, "a: &x 2\nb: *x\n"),
        ("a: &x 1\nb: *x # c\n", {"a": 1, "b": 2}, "a: &x 1\nb: 2 # c\n"),
        ("a: &x 1\nb: *x\n", {"a": 2, "b": 1}, "a: &x 2\nb: 1\n"),
        ("a: &x {k: 1} # c\nb: *x\n", {"a": {"k": 2}, "b": {"k": 2}}, "a: &x {k: 2} # c\nb: *x\n"),
        ("a: &x 1\nb: *x\n", {"b": 1}, "b: 1\n"),
        ("a: !!float 1\n", {"a": 2.5}, "a: 2.5\n"),
        ("{a: 1, # one\n b: 2}", {"a": 1}, "{a: 1, # one\n }"),
        ("{a: 1, # one\n b: 2,}", {"b": 2, "c": "x: y"}, "{b: 2, c: 'x: y',}"),
        ("[{a: 1, b: 2, c: 3}]", [{"a": 1}], "[{a: 1}]"),
        ("a: 1 # one\n# two\nb: 2", {"b": 2, "c": [1]}, "# two\nb: 2\nc: [1]"),
        ("- a: 1 # one\n  b: 2\n", [{"b": 2}], "- b: 2\n"),
        ("a: |\n  b\n# c\n", {"a": "x", "d": 1}, "a: x\nd: 1\n# c\n"),
        ("a: # c\n  - 1\n", {"a": [1, 2]}, "a: # c\n  [1, 2]\n"),
        ("a:\nb: 1\n", {"a": {"k": 1}, "b": 1}, "a: {k: 1}\nb: 1\n"),
        ("a: {}\n", {"a": {"k": 1}}, "a: {k: 1}\n"),
        ("? a\n: 1\n", {"a": 2}, "? a\n: 2\n"),
        ("a: 1\n...\n", {"a": 1, "b": 2}, "a: 1\nb: 2\n...\n"),
        ("? a\n: 1\nb: 2\n", {"b": 2}, None),  # the sign before a name is none of its own
        ("a: 0.0\n", {"a": -0.0}, "a: -0.0\n"),
        ("a: 1\n", {"a": True}, "a: true\n"),
    ],
)  # fmt: skip
def test_yaml_of_all_sorts_is_changed_where_it_must_be(
    text: str, after: object, expected: str | None
) -> None:
    before = json.loads(gelenk.model.yaml12.to_json(text, ""))
    assert yaml_edits.changed(text, before, before) == text
    assert yaml_edits.changed(text, before, after) == expected
