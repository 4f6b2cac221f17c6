# SPDX-License-Identifier: BSD-3-Clause
"""The scenes of docs/modelica against published curves, closed forms and independent integrations."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import modelica_page
import numpy as np
import pytest

import gelenk

FOLDER = Path(__file__).parents[3] / "docs" / "modelica"
SCENES = sorted(file.relative_to(FOLDER).with_suffix("").as_posix() for file in FOLDER.glob("*/*.yaml"))


def values_of(name: str) -> dict[str, Any]:
    folder, _, scene = name.partition("/")
    found: dict[str, Any] = json.loads((FOLDER / folder / "values.json").read_text())[scene]
    return found


def test_the_page_lists_all_scenes() -> None:
    assert (FOLDER / "README.md").read_text(encoding="utf-8") == modelica_page.page(), (
        "run tests/modelica_page.py"
    )


def test_each_scene_has_values() -> None:
    named = {
        f"{file.parent.name}/{scene}"
        for file in FOLDER.glob("*/values.json")
        for scene in json.loads(file.read_text())
    }
    assert named == set(SCENES)


@pytest.mark.parametrize("name", SCENES)
def test_scene_has_the_values(name: str) -> None:
    """At a tolerance of 1e-9, without a warning of the scene, relative to the range over the run."""
    expected = values_of(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gelenk.StartWarning)
        warnings.simplefilter("error", gelenk.SceneWarning)
        scene = gelenk.load(FOLDER / f"{name}.yaml")
        simulation = gelenk.Simulation(scene)
        simulation.initialize(0.0, 1e-9)
    signals = expected["signals"]
    stop = scene.to_dict()["experiment"]["stop"]
    asked = {t for rows in signals.values() for t, _ in rows}
    times = sorted(asked | set(np.linspace(0, stop, 101).tolist()))
    courses = {signal: {0.0: simulation.output(signal)} for signal in signals}
    for t in times:
        simulation.step_to(t)
        for signal, course in courses.items():
            course[t] = simulation.output(signal)
    for signal, rows in signals.items():
        course = courses[signal]
        size = max(course.values()) - min(course.values())
        for t, value in rows:
            assert abs(course[t] - value) <= expected["bound"] * size, (signal, t)
