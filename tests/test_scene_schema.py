# SPDX-License-Identifier: BSD-3-Clause
"""The JSON Schema takes what the reader takes, and refuses what a schema can refuse."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import scene_files

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
