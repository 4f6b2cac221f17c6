# SPDX-License-Identifier: BSD-3-Clause
"""The JSON Schema takes what the reader takes, and refuses what a schema can refuse."""

from __future__ import annotations

import copy
import json
import random
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import scene_files
from pages import ROOT, blocks

import gelenk
from gelenk import _core
from gelenk.model import yaml12

# Beyond a schema: names that must exist, arithmetic, numbers that are none, repeated keys, two ways at once.
BEYOND = {
    "at_and_position", "axes_parallel", "axis_not_finite", "axis_zero", "bearing_fields", "body_unknown",
    "body_unknown_many", "constraint_name_taken", "disconnected", "duplicate_field",
    "experiment_step_longer_than_run", "gear_joints", "gear_name_taken", "gear_on_slide",
    "gear_with_itself", "inertia_impossible", "inertia_negative", "inertia_principal",
    "inertia_one_axis", "inertia_products", "joint_to_itself", "knife_edge_itself", "locking_combinations",
    "mass_infinite", "mass_nan", "motion_coordinate_missing", "motion_coordinate_unknown",
    "motion_independent",
    "motion_joint_unknown", "motion_of_ball", "motion_of_speed_name", "motion_parameter",
    "motion_table_lengths", "motion_table_period", "motion_table_times", "motion_twice",
    "motor_joint_unknown", "motor_on_spherical", "name_of_health_variable", "names_collide",
    "parameter_of_missing_bound", "parameter_unknown", "rack_swapped", "rolling_independent",
    "rolling_parameter", "rotation_matrix_mirror", "rotation_matrix_stretched",
    "rotation_quaternion_zero", "sensor_joint_unknown", "solver_gain_without_baumgarte",
    "solver_partners", "solver_rho_inf", "solver_rho_inf_unused", "spring_on_one_body", "start_nan",
    "start_quaternion_zero", "start_weight_nan", "stop_bounds_crossed",
}  # fmt: skip


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft202012Validator:
    schema = json.loads(_core.scene_schema())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def tree(path: Path) -> Any:
    return json.loads(yaml12.to_json(path.read_text(encoding="utf-8"), path.name))


@pytest.mark.parametrize("path", scene_files.good(), ids=lambda path: path.stem)
def test_schema_takes_ready_scenes_as_written_and_as_read(
    path: Path, validator: jsonschema.Draft202012Validator
) -> None:
    validator.validate(tree(path))
    validator.validate(gelenk.load(path).to_dict())


def test_schema_refuses_malformed_scenes(validator: jsonschema.Draft202012Validator) -> None:
    files = [path for path in scene_files.malformed() if path.suffix == ".yaml"]
    accepted = {path.stem for path in files if validator.is_valid(tree(path))}
    assert accepted == BEYOND


def test_schema_knows_every_kind_of_joint(validator: jsonschema.Draft202012Validator) -> None:
    for entry in _core.joints.kinds():
        kind = entry["name"]
        numbers = {number["name"]: 0.5 for number in entry["fields"] if number["required"]}
        scene = {
            "gelenk": 1,
            "bodies": {"b": {"mass": 2.5, "inertia": [0.3, 0.4, 0.5]}},
            "joints": {"J": {"type": kind, "parent": "ground", "child": "b"} | numbers},
        }
        validator.validate(scene)
        gelenk.load(scene)


def merged(a: Any, b: Any) -> Any:
    """Two parts of a scene in one."""
    if not (isinstance(a, dict) and isinstance(b, dict)):
        return b
    return a | {key: merged(a[key], value) if key in a else value for key, value in b.items()}


def completed(part: dict[str, Any]) -> dict[str, Any]:
    """A part of a scene with the bodies and joints that it refers to."""
    empty: dict[str, Any] = {"gelenk": 1, "bodies": {}, "joints": {}}
    scene = copy.deepcopy(empty | part)
    bodies, joints = scene["bodies"], scene["joints"]
    for element in scene.get("constraints", {}).values():
        for name in (element.get("joint"), element.get("with")):
            if name is not None and name not in joints:
                joints[name] = {"type": "revolute", "parent": "ground", "child": f"body_of_{name}"}
    for joint in list(joints.values()):
        for side in ("parent", "child"):
            frame = joint[side]
            name = frame if isinstance(frame, str) else frame["body"]
            if name != "ground" and name not in bodies:
                bodies[name] = {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]}
    carried = {j["child"] if isinstance(j["child"], str) else j["child"]["body"] for j in joints.values()}
    for name in bodies if bodies else ["b"]:
        if name not in carried:
            bodies.setdefault(name, {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]})
            joints[f"place_of_{name}"] = {"type": "free", "parent": "ground", "child": name}
    return scene


PAGES = ("README.md", *(f"docs/{page.name}" for page in sorted((ROOT / "docs").glob("*.md"))))
OTHER_FILES = {"services"}  # sections of files that are no scenes: compose.yaml
PIECES = {  # pages of which all blocks together are one scene
    "docs/scene-format.md", "docs/tutorial-gripper.md", "docs/tutorial-lqr.md", "docs/tutorial-stiction.md",
    "docs/tutorial-wheels.md",
}  # fmt: skip


def scenes_of_pages() -> Iterator[Any]:
    for page in PAGES:
        parts: list[Any] = []
        for text in blocks(ROOT / page, "yaml"):
            part = json.loads(yaml12.to_json(text, page))
            if text.startswith(" "):  # an entry of the section `joints`
                part = {"joints": part}
            if not OTHER_FILES & part.keys():
                parts.append(part)
        if page in PIECES:
            whole: Any = {}
            for part in parts:
                whole = merged(whole, part)
            parts = [whole]
        for number, part in enumerate(parts, 1):
            yield pytest.param(completed(part), id=f"{page}-{number}")


@pytest.mark.parametrize("scene", [*scenes_of_pages()])
def test_schema_and_reader_take_every_scene_of_every_page(
    scene: dict[str, Any], validator: jsonschema.Draft202012Validator
) -> None:
    validator.validate(scene)
    gelenk.Simulation(scene).initialize()


WITH_SHAPES = {
    "gelenk": 1,
    "bodies": {
        "crate": {
            "mass": {"density": 600},
            "shapes": {"hull": {"box": [0.2, 0.3, 0.6], "surface": "wood"}},
        }
    },
    "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "concrete"}}},
    "joints": {"place": {"type": "free", "parent": "ground", "child": "crate"}},
    "contacts": {"slide": {"between": ["wood", "concrete"], "friction": 0.5}},
}
SAMPLES: tuple[Any, ...] = (
    None, True, 0, 1, -1, 2.5, 1e9, "x", "", "all", "ground", [], {}, [0, 0, 0], [1, 2, 3], [1, 2, 3, 4],
    [1] * 6, [[1, 0, 0]], ["x"], {"a": 1}, {"density": 600}, {"density": -1}, {"body": "ground"},
)  # fmt: skip
# What a schema cannot know: names that must exist and fit each other, and arithmetic.
BEYOND_A_SCHEMA = re.compile(
    r"(?!.*(unknown field|found nothing))"
    r".*(found '\w*', expected (one of )?[\w, ]+(; did you mean .*)?$|no chain of joints|"
    r"no rigid body has such moments|expected two different bodies|: parameters\[|: outputs\[|"
    r"expected a direction|expected at most experiment\.stop)"
)


def mutated(scene: Any, rng: random.Random) -> Any:
    """A scene with one change: a value replaced, removed, renamed, negated, or put into a list."""
    scene = copy.deepcopy(scene)
    places: list[tuple[Any, Any]] = []

    def collect(value: Any) -> None:
        for key, inner in list(value.items() if isinstance(value, dict) else enumerate(value)):
            places.append((value, key))
            if isinstance(inner, dict | list):
                collect(inner)

    collect(scene)
    inside, key = rng.choice(places)
    value = inside[key]
    change = rng.randrange(5)
    if change == 0:
        inside[key] = copy.deepcopy(rng.choice(SAMPLES))
    elif change == 1:
        del inside[key]
    elif change == 2 and isinstance(inside, dict):
        inside[rng.choice(["x", "mass", "type", "fixed", "axis", f"{key}_"])] = inside.pop(key)
    elif change == 3 and isinstance(value, int | float) and not isinstance(value, bool):
        inside[key] = -value
    else:
        inside[key] = [value]
    return scene


def test_schema_and_reader_judge_500_changed_scenes_alike(validator: jsonschema.Draft202012Validator) -> None:
    """What the schema refuses, the reader refuses, and conversely, but for what a schema cannot know."""
    rng = random.Random(5)
    sources = [tree(path) for path in scene_files.good() if path.suffix == ".yaml"] + 4 * [WITH_SHAPES]
    refused = 0
    disagreements = []
    for _ in range(500):
        scene = mutated(rng.choice(sources), rng)
        fault = next(validator.iter_errors(scene), None)
        with warnings.catch_warnings(action="ignore", category=gelenk.SceneWarning):
            try:
                gelenk.load(copy.deepcopy(scene))
                lines: tuple[str, ...] = ()
            except gelenk.SceneError as e:
                lines = e.lines
        refused += bool(lines)
        if fault is not None and not lines:
            disagreements.append(f"only the schema refuses {fault.json_path}: {fault.message[:200]}")
        if fault is None and not all(map(BEYOND_A_SCHEMA.match, lines)):
            disagreements.append(f"only the reader refuses {lines}")
    assert disagreements == []
    assert 200 < refused < 450
