# SPDX-License-Identifier: BSD-3-Clause
"""What linear models read of the scene that an FMU carries."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest
from mechanisms import body, frame, joint, scene

import gelenk
from gelenk.simulation.fmu_plant import FmuPlant


def test_warnings_of_a_scene_are_not_repeated_by_its_fmu(tmp_path: Path) -> None:
    """They name a file that its user has never seen."""
    stop = {"upper": 0.1, "stiffness": 100.0}
    box = joint("prismatic", frame("ground"), frame("box"), stop=stop, start={"s": 0.2})
    with pytest.warns(gelenk.SceneWarning, match=r"beyond it, the stop pushes"):
        fmu = gelenk.export_fmu(scene({"box": body(1.0)}, {"J": box}), tmp_path / "box.fmu")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gelenk.linearize(fmu)
    assert [of.category for of in caught] == [gelenk.OperatingPointWarning]


def test_a_scene_in_an_fmu_of_another_tool_is_not_read(root: Path, tmp_path: Path) -> None:
    """It is a file of the same name; rates of states are known from the model description."""
    plant = FmuPlant(gelenk.export_fmu(root / "scenes" / "cart_pole.yaml", tmp_path / "x.fmu"))
    try:
        Path(plant._folder, "resources", "scene.json").write_text("[]")
        plant._description.generationTool = "Other 1.0"
        assert plant.scene is None
        assert plant.quaternions == ()
        plant.start(None, {})
        found = plant.derivatives(())
        assert {name: found.rates[name] for name in ("track.s", "hinge.phi")} == {
            "track.s": "der(track.s)",
            "hinge.phi": "der(hinge.phi)",
        }
    finally:
        plant.close()
