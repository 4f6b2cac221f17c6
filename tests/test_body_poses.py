# SPDX-License-Identifier: BSD-3-Clause
"""Poses of bodies against frame sensors: of links, welded and standing bodies, rods that became rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scene_files
from models.rods import spatial_four_bar
from scipy.spatial.transform import Rotation

import gelenk

ROUNDING = 1e-14  # a rotation matrix from a quaternion and back, products of three poses


def watched(source: dict[str, Any]) -> dict[str, Any]:
    sensors = {f"on_{name}": {"type": "frame", "body": name} for name in source["bodies"]}
    return source | {"sensors": sensors}


def assert_poses_are_those_of_sensors(source: dict[str, Any]) -> None:
    plant = gelenk.Simulation(watched(source))
    plant.initialize()
    for t in (0.0, 0.013):
        plant.step_to(t)
        for body in source["bodies"]:
            R, r = plant.pose(body)
            Q = [plant.output(f"on_{body}.Q[{i}]") for i in (1, 2, 3, 4)]
            assert np.abs(R - Rotation.from_quat(Q).as_matrix()).max() < ROUNDING, body
            expected = [plant.output(f"on_{body}.r[{i}]") for i in (1, 2, 3)]
            assert np.abs(r - expected).max() < ROUNDING * (1 + np.abs(expected).max()), body


@pytest.mark.parametrize("name", scene_files.gallery())
def test_of_the_gallery(name: str) -> None:
    assert_poses_are_those_of_sensors(gelenk.load(scene_files.gallery()[name]).to_dict())


def test_of_rods_and_of_what_is_welded_or_stands_still() -> None:
    source = spatial_four_bar()
    body = {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]}
    source["bodies"] |= {"fixed": body, "carried": body}
    first = next(name for name, entry in source["bodies"].items() if entry["mass"] > 0)
    turn = {"axis": [1, 2, 3], "angle": 0.7}
    source["joints"] |= {
        "W": {"type": "weld", "parent": {"body": "ground", "position": [1, 2, 3], "rotation": turn},
              "child": "fixed"},
        "V": {"type": "weld", "parent": {"body": first, "position": [0.1, 0, 0.2], "rotation": turn},
              "child": "carried"},
    }  # fmt: skip
    assert_poses_are_those_of_sensors(source)


def test_of_a_mechanism_that_is_solved_in_units_of_its_own_size() -> None:
    """In micrometres."""
    rod = {"mass": 1e-12, "com": [5e-7, 0, 0], "inertia": [0, 1e-25, 1e-25]}
    hinge = {"type": "revolute", "axis": [0, 1, 0], "start": {"phi": 0.3, "fixed": True}}
    joints = {"A": hinge | {"parent": {"body": "ground", "position": [3e-6, 0, 0]}, "child": "rod"}}
    plant = gelenk.Simulation({"gelenk": 1, "name": "Small", "bodies": {"rod": rod}, "joints": joints})
    plant.initialize()
    R, r = plant.pose("rod")
    assert np.abs(r - [3e-6, 0, 0]).max() < 1e-20
    assert np.abs(R - Rotation.from_rotvec([0, 0.3, 0]).as_matrix()).max() < ROUNDING


def test_wrong_calls() -> None:
    plant = gelenk.Simulation(scene_files.good()[0])
    body = next(iter(gelenk.load(scene_files.good()[0]).to_dict()["bodies"]))
    with pytest.raises(gelenk.UsageError, match="before initialize"):
        plant.pose(body)
    plant.initialize()
    with pytest.raises(gelenk.UsageError, match=f"no such body; did you mean {body}"):
        plant.pose(f"{body}x")
