# SPDX-License-Identifier: BSD-3-Clause
"""What people do wrong in a scene file is never accepted in silence: where, what was found, what to do."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import NamedTuple

import programs
import pytest
import scene_files
import yaml

import gelenk

SENTENCE = re.compile(r"[\w.]+:\d+(:\d+)?: .*found .+, expected .+")


class Mistake(NamedTuple):
    what: str
    old: str
    new: str
    messages: list[str]


def read_table(text: str) -> tuple[str, list[Mistake], list[Mistake]]:
    """The scene, and the changes of it that are refused and warned of: `- old`, `+ new`, messages."""

    def mistake(block: str) -> Mistake:
        what, *lines = block.splitlines()
        old, new = (
            "".join(f"{line[2:]}\n" for line in lines if line.startswith(sign)) for sign in ("- ", "+ ")
        )
        return Mistake(what, old, new, [line for line in lines if not line.startswith(("- ", "+ "))])

    _, scene, refused, warned = re.split(r"== .* ==\n\n", text)
    return (
        scene.rstrip() + "\n",
        [mistake(block) for block in refused.strip().split("\n\n")],
        [mistake(block) for block in warned.strip().split("\n\n")],
    )


SCENE, REFUSED, WARNED = read_table(
    (Path(__file__).parent / "typical_mistakes.txt").read_text(encoding="utf-8")
)

# Files of other programs, and of other kinds: name, text, what is said.
A_SCENE = "a scene of Gelenk (.yaml, .yml or .json)"
BY_URDF = "convert it to URDF and use `gelenk import`, or write a scene (docs/scene-format.md)"
BY_HAND = "write a scene with the same bodies and joints (docs/scene-format.md)"
IMPORT = "convert it to a scene with `gelenk import`"
FILES = [
    ("arm.xml", '<?xml version="1.0"?>\n<mujoco model="arm">\n</mujoco>\n',
     f"arm.xml:2: found an MJCF model of MuJoCo, expected {A_SCENE}; {BY_URDF}"),
    ("arm.yaml", '<!-- an arm -->\n<mujoco model="arm">\n</mujoco>\n',
     f"arm.yaml:2: found an MJCF model of MuJoCo, expected {A_SCENE}; {BY_URDF}"),
    ("arm.sdf", '<sdf version="1.9">\n  <model name="arm"/>\n</sdf>\n',
     f"arm.sdf:1: found an SDF model of Gazebo, expected {A_SCENE}; {BY_URDF}"),
    ("arm.urdf", '<?xml version="1.0"?>\n<robot name="arm">\n</robot>\n',
     f"arm.urdf:2: found a URDF robot description, expected {A_SCENE}; {IMPORT}"),
    ("arm.urdf.xacro", '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">\n</robot>\n',
     f"arm.urdf.xacro:1: found a xacro file, expected {A_SCENE}; expand it with xacro, then {IMPORT}"),
    ("Arm.mo", 'within Robots;\nmodel Arm "An arm"\nend Arm;\n',
     f"Arm.mo:1: found a Modelica model, expected {A_SCENE}; {BY_HAND}"),
    ("arm.cmd", "!\ndefaults units length = mm\npart create rigid_body name_and_position &\n",
     f"arm.cmd:3: found a command file of Adams, expected {A_SCENE}; {BY_HAND}"),
    ("arm.adm", "ADAMS/View model name: arm\nPART/1, GROUND\n",
     f"arm.adm:1: found a data set of Adams, expected {A_SCENE}; {BY_HAND}"),
    ("arm.fmu", "PK\x03\x04",
     f"arm.fmu: found an FMU, expected {A_SCENE}; simulate it with `gelenk simulate`"),
    ("arm.csv", "time,A.phi\n0,0\n", "arm.csv: found the ending .csv, expected .yaml, .yml or .json"),
    ("arm.json", '{"gelenk": 1,\n "bodies": {"crank": {"mass": 1,}}}\n',
     "arm.json:2:33: found '}', expected a name in double quotes; leave out the comma before it"),
    ("arm.json", '{"gelenk": 1, // version\n "bodies": {}}\n',
     "arm.json:1:15: found '/', expected a name in double quotes; JSON has no comments"),
]  # fmt: skip


def told(name: str, text: str) -> list[str]:
    """What loading this file says, warnings first."""
    Path(name).write_text(text, encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            gelenk.load(name)
        except gelenk.SceneError as error:
            return [*map(str, (w.message for w in caught)), *error.lines]
    assert {w.category for w in caught} <= {gelenk.SceneWarning}
    return [str(w.message) for w in caught]


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def refused(text: str) -> bool:
    with warnings.catch_warnings(action="ignore", category=gelenk.SceneWarning):
        try:
            gelenk.load(text)
        except gelenk.SceneError:
            return True
    return False


def test_scene_without_mistakes_is_taken_without_a_word() -> None:
    assert told("s.yaml", SCENE) == []


@pytest.mark.parametrize("mistake", [*REFUSED, *WARNED], ids=lambda m: m.what)
def test_mistake_is_told_in_these_words(mistake: Mistake) -> None:
    assert SCENE.count(mistake.old) == 1
    text = SCENE.replace(mistake.old, mistake.new)
    assert told("s.yaml", text) == mistake.messages
    assert refused(text) == (mistake in REFUSED)


@pytest.mark.parametrize(("name", "text", "message"), FILES)
def test_file_of_another_kind_is_named_for_what_it_is(name: str, text: str, message: str) -> None:
    assert told(name, text) == [message]


def test_each_mistake_says_where_and_what() -> None:
    assert len(REFUSED) + len(WARNED) >= 150
    messages = [m for mistake in (*REFUSED, *WARNED) for m in mistake.messages]
    assert [m for m in messages if not SENTENCE.fullmatch(m)] == []


def test_a_joint_may_have_the_name_of_its_body() -> None:
    assert told("s.yaml", SCENE.replace("  B:\n", "  rod:\n")) == []


@pytest.mark.parametrize(("ratio", "warned"), [(29.0, False), (31.0, True)])
def test_sizes_are_warned_of_beyond_thirty_times_that_of_the_mechanism(ratio: float, warned: bool) -> None:
    """The mechanism has 0.5 m. A gear of 100 makes a rotor with a radius of gyration of 2 cm one of 2 m."""
    far = told("s.yaml", SCENE.replace("com: [0.5, 0, 0]", f"com: [{ratio * 0.5}, 0, 0]"))
    assert [line.partition(": found")[0] for line in far] == ["s.yaml:8: bodies.rod.com"] * warned
    moment = (ratio * 0.5) ** 2  # kg m2, for 1 kg
    heavy = told("s.yaml", SCENE.replace("[0.01, 0.02, 0.02]", f"[{moment}, {moment}, {moment}]"))
    assert [line.partition(": found")[0] for line in heavy] == ["s.yaml:5: bodies.crank.inertia"] * warned


def test_nothing_is_warned_of_in_ready_scenes() -> None:
    with warnings.catch_warnings(action="error", category=gelenk.SceneWarning):
        assert [gelenk.load(path).name for path in scene_files.good()]


def test_numbers_that_pyyaml_reads_as_texts_are_explained_as_such() -> None:
    """YAML 1.1 has no 1e-4; nobody has written quotes that could be left out."""
    data = yaml.safe_load(SCENE.replace("mass: 0.5", "mass: 1e-4").replace("mass: 1.0", "mass: '1'"))
    with pytest.raises(gelenk.SceneError) as refused:
        gelenk.load(data)
    assert refused.value.lines == (
        "scene: bodies.crank.mass: found '1', expected a number in kg, not a text",
        "scene: bodies.rod.mass: found '1e-4', expected a number in kg, not a text; "
        "PyYAML reads 1e-4 as a text and 1.0e-4 as a number: read the file with gelenk.load",
    )


def test_lines_are_those_of_json_files_too() -> None:
    text = '{"gelenk": 1,\n "bodies": {"a": {"mass": 1}, "b":\n  {"mass": -1, "com": [0,\n   "x", 0]}},\n'
    text += ' "joints": {"A": {"type": "weld", "parent": "ground", "child": "a"},\n'
    text += '  "A": 1}}\n'
    assert told("s.json", text) == [
        "s.json:6: joints.A: found twice, expected every name once",
        "s.json:3: bodies.b.mass: found -1 kg, expected 0 kg or more",
        "s.json:4: bodies.b.com[2]: found 'x', expected a number in m",
        "s.json:2: bodies: found no chain of joints from ground to b, expected every body connected "
        "to ground (a floating body has a joint of type free)",
    ]


def test_faults_found_after_reading_have_a_line_too() -> None:
    scene = gelenk.load(scene_files.FOLDER / "loop_too_short.yaml")
    with pytest.raises(
        gelenk.AssemblyError, match=r"loop_too_short\.yaml:\d+: loop through C cannot be closed"
    ):
        gelenk.Simulation(scene).initialize()


def test_names_with_signs_in_them_are_found() -> None:
    text = "gelenk: 1\nbodies:\n  a: {mass: 1}\n  'a.b: [1]': {mass: x}\njoints:\n  A: {type: weld}\n"
    assert "s.yaml:4: bodies.a.b: [1].mass: found 'x', expected a number in kg" in told("s.yaml", text)


def test_a_name_that_is_too_long_is_found_among_others_that_begin_so() -> None:
    bodies = "".join(f"  {name}: {{mass: 1}}\n" for name in ("x" * 20, "x" * 50, "x" * 201, "x" * 51))
    text = f"gelenk: 1\nbodies:\n{bodies}joints:\n  A: {{type: weld, parent: ground, child: {'x' * 20}}}\n"
    name = "x" * 20 + "..."
    assert f"s.yaml:5: bodies.{name}: found a name of 201 characters, expected at most 200" in told(
        "s.yaml", text
    )


@pytest.mark.parametrize("angle", ["6.283185307179586", "12.566", "31.41592653589793", "9", "1234.567891234"])
def test_turns_are_not_taken_for_degrees(angle: str) -> None:
    assert told("s.yaml", SCENE.replace("phi: 0.5", f"phi: {angle}")) == []


def test_parameter_in_degrees_is_warned_of() -> None:
    scene = gelenk.load(SCENE)
    with pytest.warns(gelenk.SceneWarning, match=r"joints\.A\.start\.phi: found 90 rad"):
        scene.with_parameters({"A.phi_start": 90})


def test_leaving_out_reductions_does_not_warn_again() -> None:
    with pytest.warns(gelenk.SceneWarning) as caught:
        gelenk.load(SCENE.replace("phi: 0.5", "phi: 90")).without(["planar"])
    assert len(caught) == 1


def test_command_tells_a_warning_as_a_line() -> None:
    Path("s.yaml").write_text(SCENE.replace("phi: 0.5", "phi: 90"))
    done = programs.gelenk("check", "s.yaml")
    assert done.returncode == 0
    assert done.stderr.splitlines() == [
        "s.yaml:11: joints.A.start.phi: found 90 rad, which is 14.3 turns, expected an angle in rad; "
        "90 degrees are 1.5708 rad"
    ]


@pytest.mark.parametrize(("name", "found"), [("r.xlsx", "the ending .xlsx"), ("r", "no ending")])
def test_table_of_another_kind_is_refused_before_the_run(name: str, found: str) -> None:
    Path("s.yaml").write_text(SCENE)
    done = programs.gelenk("simulate", "s.yaml", "--output", name)
    assert done.returncode == 1
    expected = "FILE.csv, FILE.parquet, FILE.nc, FILE.mat, or - for stdout"
    assert done.stderr == f"--output {name}: found {found}, expected {expected}\n"
    assert not Path(name).exists()
