# SPDX-License-Identifier: BSD-3-Clause
"""CONTRIBUTING.md's recipes, followed: one header and one name make a joint, a force, a sensor, a shape.

The headers of tests/recipes are put into a copy of the sources. All that reads, writes and describes scenes
is built and run with them; of the equations of motion, the files that see every kind are compiled without
making code; and the tests of the layout pass. It takes some 100 s of a processor.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

pytestmark = pytest.mark.study

RECIPES = Path(__file__).parent / "recipes"
# What the headers of tests/recipes are, and the list that each is to stand in.
ADDED = {
    "dial": ("Dial", "AnyJoint"),
    "servo": ("Servo", "AnyMotor"),
    "magnet": ("Magnet", "AnyForce"),
    "belt": ("Belt", "AnyConstraint"),
    "sleeve": ("Sleeve", "AnyConstraint"),
    "height": ("Height", "AnySensor"),
    "preload": ("std::optional<Preload>", "JointForces"),
    "detent": ("std::optional<Detent>", "JointForces"),
    "ellipsoid": ("Ellipsoid", "AnyShape"),
}
ROOMS = {
    "AnyJoint": "joint",
    "AnyMotor": "element/motors",
    "AnyForce": "element/forces",
    "AnyConstraint": "element/constraints",
    "AnySensor": "element/sensors",
    "JointForces": "element/joint_forces",
    "AnyShape": "shape",
}
BUILT = (
    "util", "expression", "field", "math", "decomposition", "shape", "joint", "element", "scene", "check",
    "scene_file", "scene_schema", "mechanism",
)  # fmt: skip
NOT_BUILT = ("yaml.cpp",)  # of no use to JSON
# Of the rooms above, what says which forces act on bodies.
SAYING_FORCES = (
    "kinematics/forces_by_kind.cpp",
    "kinematics/loads.cpp",
    "preparation/loads.cpp",
    "preparation/signal_binder.cpp",
    "outputs/port_readings.cpp",
    "outputs/sensor_reading.cpp",
    "outputs/wrenches.cpp",
)
LAYOUT = ("test_sizes.py", "test_layout.py", "test_folders.py")
# These see every joint, force, constraint, sensor and motor there is; the dynamics ask laws of friction.
KERNELS = (
    "dynamics/dynamics.cpp",
    "kinematics/forces_by_kind.cpp",
    "kinematics/load_kernels.cpp",
    "derivatives/forces_by_kind.cpp",
    "derivatives/forces_dual_by_kind.cpp",
    "derivatives/residual_kernels_dual.cpp",
    "derivatives/recursive.cpp",
    "outputs/outputs.cpp",
)
SCENE: dict[str, Any] = {
    "gelenk": 1,
    "bodies": {
        **{name: {"mass": 1, "inertia": [1, 1, 1]} for name in ("hand", "wheel")},
        "bead": {"mass": {"density": 1}, "shapes": {"egg": {"ellipsoid": [1, 2, 3]}}},
    },
    "joints": {
        "A": {"type": "dial", "parent": "ground", "child": "hand", "ratio": 2, "preload": {"size": 3},
              "stop": {"upper": 1, "stiffness": 100}},
        "B": {"type": "revolute", "parent": "ground", "child": "wheel", "friction": {"coulomb": 1},
              "detent": {"holding": 2, "position": 0.5, "width": 0.1}},
        "C": {"type": "free", "parent": "ground", "child": "bead"},
    },
    "motors": {"turn": {"type": "servo", "joint": "A", "gain": 5}},
    "forces": {
        "rope": {
            "type": "magnet", "from": {"body": "ground", "position": [0, 0, 2]}, "to": "bead", "strength": 28,
        }
    },
    "constraints": {
        "band": {"type": "belt", "joint": "A", "with": "B", "radius": 0.1, "other_radius": 0.2},
        "bore": {"type": "sleeve", "body": "bead", "on": "ground"},
    },
    "sensors": {"level": {"type": "height", "body": "bead", "position": [0, 0, 0.5]}},
}  # fmt: skip


def extended(registry: str, kind: str, lists: str, header: str) -> str:
    """The text of a registry with an include and a name more."""
    include = f'#include "{header}"\n'
    assert include not in registry
    at = registry.index('#include "')
    text = registry[:at] + include + registry[at:]
    text, changed = re.subn(
        rf"(struct {lists}\s*:\s*std::(?:variant|tuple)<[^{{]*)>\s*\{{", rf"\1, {kind}> {{", text
    )
    assert changed == 1
    return text


@dataclass
class Tree:
    """A copy of the sources, and how its files are compiled."""

    folder: Path
    command: list[str]

    def add(self, header: Path, kind: str, lists: str) -> None:
        room = ROOMS[lists]
        shutil.copy(header, self.folder / "src" / room)
        registry = self.folder / "src" / room / "registry.h"
        text = extended(registry.read_text("utf-8"), kind, lists, f"{room}/{header.name}")
        registry.write_text(text, "utf-8")

    def compile(self, *arguments: str) -> str:
        """What the compiler says; empty: all is well."""
        done = subprocess.run([*self.command, *arguments], cwd=self.folder, capture_output=True, text=True)
        return done.stderr + ("" if done.returncode == 0 else f"\nexit code {done.returncode}")

    def build(self) -> None:
        """All that knows scenes, as the program `told`; the files of a folder together, as everywhere."""
        sources = [RECIPES / "told.cpp"]
        for room in BUILT:
            files = [
                p for p in sorted((self.folder / "src" / room).rglob("*.cpp")) if p.name not in NOT_BUILT
            ]
            sources.append(self.folder / f"{room}.cpp")
            sources[-1].write_text("".join(f'#include "{path}"\n' for path in files))
        for name in SAYING_FORCES:
            sources.append(self.folder / name.replace("/", "_"))
            sources[-1].write_text(f'#include "{name}"\n')
        objects = [f"{p.stem}.o" for p in sources]
        calls = [("-c", str(p), "-o", o) for p, o in zip(sources, objects, strict=True)]
        with ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
            assert "".join(pool.map(lambda call: self.compile(*call), calls)) == ""
        assert self.compile(*objects, "-o", "told") == ""

    def told(self, scene: dict[str, Any]) -> str:
        (self.folder / "scene.json").write_text(json.dumps(scene))
        done = subprocess.run(["./told", "scene.json"], cwd=self.folder, capture_output=True, text=True)
        return done.stdout


def copied(root: Path, folder: Path) -> Tree:
    compiler = shlex.split(os.environ.get("CXX", "c++"))
    if shutil.which(compiler[0]) is None:
        pytest.skip(f"there is no C++ compiler ({compiler[0]})")
    listed = subprocess.run(
        [sys.executable, str(root / "cmake" / "find_wheels.py")], capture_output=True, text=True, check=True
    ).stdout
    wheels = {name: Path(place) for name, place in (line.split("=", 1) for line in listed.splitlines())}
    include = ["-Isrc", "-I."]
    if "eigen" in wheels:  # .../share/eigen3/cmake; else the compiler's own folders have it, as json below
        include += ["-isystem", str(wheels["eigen"].parents[2] / "include" / "eigen3")]
    else:
        include += ["-isystem", "/usr/include/eigen3"]
    include += [word for name in ("json",) if name in wheels for word in ("-isystem", str(wheels[name]))]
    ignored = shutil.ignore_patterns(".git", ".venv", "build", "out", "__pycache__", ".*_cache")
    shutil.copytree(root, folder, ignore=ignored, dirs_exist_ok=True)
    flags = ["-std=c++20", "-O0", "-Wall", "-Wextra", "-Werror", "-Wno-restrict", "-DEIGEN_MPL2_ONLY"]
    return Tree(folder, [*compiler, *flags, '-DGELENK_VERSION="0"', *include])


@pytest.fixture(scope="module")
def tree(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Tree:
    """With every header of tests/recipes."""
    made = copied(root, tmp_path_factory.mktemp("recipes"))
    headers = {path.stem: path for path in RECIPES.rglob("*.h")}
    assert set(headers) == set(ADDED)
    for name, path in headers.items():
        made.add(path, *ADDED[name])
    return made


@pytest.fixture(scope="module")
def built(tree: Tree) -> Iterator[Tree]:
    tree.build()
    yield tree
    for path in tree.folder.glob("*.o"):  # 100 MB
        path.unlink()


@pytest.fixture(scope="module")
def told(built: Tree) -> dict[str, Any]:
    """What follows from the scene with all the new kinds."""
    return dict(json.loads(built.told(SCENE)))


def test_new_kinds_are_read_and_written_back(told: dict[str, Any]) -> None:
    back = told["scene"]
    for section in ("joints", "motors", "forces", "constraints", "sensors"):
        for name, given in SCENE[section].items():
            for key, value in given.items():
                found = back[section][name][key]
                if key in ("parent", "child", "from", "to", "on"):  # bodies become frames
                    assert found["body"] == (value["body"] if isinstance(value, dict) else value)
                elif isinstance(value, dict):
                    assert value.items() <= found.items()  # beside what was not given
                else:
                    assert found == value, (name, key)


def test_new_kinds_have_signals_with_units(told: dict[str, Any]) -> None:
    units = {name: unit for name, (unit, _) in told["outputs"].items()}
    expected = {
        "A.phi": "rad", "A.w": "rad/s", "B.detent.tau": "N.m", "B.detent.mode": "1", "band.tau": "N.m",
        "bore.f[1]": "N", "bore.f[2]": "N",
        "level.h": "m", "level.rise": "m/s",
    }  # fmt: skip
    assert {name: units.get(name) for name in expected} == expected
    assert told["inputs"] == {"turn.phi_wanted": ["rad", "turn: target position of joint A"]}
    assert told["outputs"]["band.tau"][1] == "band: torque of the belt on joint A"
    assert told["outputs"]["level.h"][1] == "level: height of a point of bead"


def test_numbers_of_new_kinds_are_parameters_with_units(told: dict[str, Any]) -> None:
    units = {name: unit for name, (unit, _) in told["settable"].items()}
    expected = {
        "A.ratio": "1", "A.preload.size": "N.m", "B.detent.holding": "N.m", "B.detent.width": "rad",
        "turn.gain": "N.m/rad", "rope.strength": "N.m2",
        "band.radius": "m", "band.other_radius": "m",
    }  # fmt: skip
    assert {name: units.get(name) for name in expected} == expected


def test_schema_knows_new_kinds(told: dict[str, Any]) -> None:
    validator = jsonschema.Draft202012Validator(told["schema"])
    assert list(validator.iter_errors(SCENE)) == []
    assert list(validator.iter_errors(told["scene"])) == []
    for section, name, key in (
        ("joints", "A", "ratio"), ("motors", "turn", "gain"), ("constraints", "band", "radius"),
    ):  # fmt: skip
        wrong = json.loads(json.dumps(SCENE))
        del wrong[section][name][key]
        assert list(validator.iter_errors(wrong)), key


@pytest.mark.parametrize(
    ("section", "name", "fields", "says"),
    [
        ("joints", "A", {"ratio": 0}, "joints.A.ratio: found 0"),
        ("joints", "C", {"preload": {"size": 1}}, "has more than one degree of freedom"),
        ("joints", "B", {"detent": {"holding": 1, "width": 0}}, "joints.B.detent.width: found 0 rad"),
        ("joints", "C", {"detent": {"holding": 1, "width": 1}}, "has more than one degree of freedom"),
        ("motors", "turn", {"gain": -5}, "motors.turn.gain: found -5 N m/rad"),
        ("forces", "rope", {"strength": "2"}, "forces.rope.strength: found '2', expected a number in N m2"),
        ("constraints", "band", {"with": "C"}, "constraints.band.with"),
        ("sensors", "level", {"pose": 1}, "sensors.level.pose"),
    ],
)
def test_faults_of_new_kinds_are_told(
    built: Tree, section: str, name: str, fields: dict[str, Any], says: str
) -> None:
    wrong = json.loads(json.dumps(SCENE))
    wrong[section][name].update(fields)
    assert says in built.told(wrong).replace('"', "'")


def test_new_forces_have_arrows(told: dict[str, Any]) -> None:
    """28 / 2^2 N towards the pole above; on a dial of the ratio 2 half of the effort."""
    found = {name: rest for name, *rest in told["wrenches"]}
    assert found["rope"] == ["bead", [0, 0, 7], [0, 0, 0]]
    assert found["A.preload"] == ["hand", [0, 0, 0], [0, 0, 1.5]]
    assert found["turn"] == ["hand", [0, 0, 0], [0, 0, 0]]  # at the angle that is wanted


def test_new_shapes_are_drawn_and_have_mass(told: dict[str, Any]) -> None:
    """By points on the surface, the outermost among them, whose hull has nearly the volume 4/3 pi 1 2 3."""
    egg = told["drawings"]["egg"]
    points, triangles = np.array(egg["points"]), np.array(egg["triangles"])
    assert np.sum((points / [1, 2, 3]) ** 2, axis=1) == pytest.approx(1, rel=1e-12)
    assert np.abs(points).max(axis=0) == pytest.approx([1, 2, 3])
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert 0.9 * 8 * np.pi < volume < 8 * np.pi
    assert told["scene"]["bodies"]["bead"]["mass"] == pytest.approx(8 * np.pi)


@pytest.mark.parametrize("source", KERNELS)
def test_equations_of_motion_take_new_kinds(tree: Tree, source: str) -> None:
    assert tree.compile("-fsyntax-only", f"src/{source}") == ""


def test_the_layout_permits_new_kinds(tree: Tree) -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist"]
    done = subprocess.run(
        [*command, *(f"tests/{name}" for name in LAYOUT)], cwd=tree.folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout


def test_the_check_sees_a_kind_that_the_equations_cannot_take(root: Path, tmp_path: Path) -> None:
    """A force that acts by a number it has not: a template, which only its use looks at."""
    lacking = copied(root, tmp_path)
    header = tmp_path / "magnet.h"
    text = (RECIPES / "element" / "forces" / "magnet.h").read_text("utf-8")
    header.write_text(text.replace("at[0].push(f)", "at[0].pushed(f)"), "utf-8")
    lacking.add(header, *ADDED["magnet"])
    assert "pushed" in lacking.compile("-fsyntax-only", "src/kinematics/forces_by_kind.cpp")
