# SPDX-License-Identifier: BSD-3-Clause
"""Scenes and running simulations are pickled, for other processes."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import pytest

import gelenk


def test_a_pickled_scene_is_the_scene(four_bar_file: Path, tmp_path: Path) -> None:
    """All numbers and comments: it is saved as it was read."""
    scene = pickle.loads(pickle.dumps(gelenk.load(four_bar_file).with_parameters({"crank.m": 1 / 3})))
    assert scene.parameters["crank.m"] == 1 / 3
    scene.with_parameters({"crank.m": 1.0}).save(tmp_path / "copy.yaml")
    assert (tmp_path / "copy.yaml").read_text("utf-8") == four_bar_file.read_text("utf-8")


def test_faults_of_a_pickled_scene_name_their_lines(four_bar_file: Path, tmp_path: Path) -> None:
    far = tmp_path / "far.yaml"
    far.write_text(four_bar_file.read_text("utf-8").replace("position: [2, 0, 0]", "position: [20, 0, 0]"))
    scene = pickle.loads(pickle.dumps(gelenk.load(far)))
    with pytest.raises(gelenk.AssemblyError, match=rf"^{far}:\d+: loop through "):
        gelenk.Simulation(scene).initialize()


def test_requested_outputs_and_omitted_parts_survive(root: Path) -> None:
    scene = gelenk.load(root / "scenes" / "stewart.yaml")
    first = next(iter(gelenk.Simulation(scene).outputs)).name
    part = pickle.loads(pickle.dumps(scene.with_outputs([first]).pruned()))
    assert part.outputs == (first,)
    assert part.pruned() is part  # it knows that nothing is left to be removed


@pytest.mark.parametrize("integrator", ["rk4", "erk", "ida"])
def test_a_pickled_simulation_continues_with_the_same_bits(four_bar: gelenk.Scene, integrator: str) -> None:
    plant = gelenk.Simulation(four_bar.with_parameters({"solver.integrator": integrator}))
    plant.set_input("drive.tau", 2.0)
    plant.initialize(0.5, 1e-7)
    plant.step_to(0.6)
    plant.set_input("drive.tau", 3.0)
    plant.set_input_derivative("drive.tau", 1, 4.0)
    copy = pickle.loads(pickle.dumps(plant))
    for each in (plant, copy):
        each.step_to(0.7)
        each.step_to(0.75)
    assert copy.time == plant.time
    assert copy.values().tobytes() == plant.values().tobytes()


def test_a_simulation_is_pickled_before_it_starts(four_bar: gelenk.Scene) -> None:
    plant = gelenk.Simulation(four_bar)
    plant.set_input("drive.tau", 2.5)
    copy: Any = pickle.loads(pickle.dumps(plant))
    assert copy.input("drive.tau") == 2.5
    copy.initialize()
    assert copy.time == 0
