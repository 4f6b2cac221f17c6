# SPDX-License-Identifier: BSD-3-Clause
"""A parameter has the name that FMUs give it, and the path in the scene; both work in all calls."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app

CALLS: dict[str, Callable[..., Any]] = {
    "simulate": lambda plant, p: gelenk.simulate(plant, stop=0.2, parameters=p).table.tolist(),
    "linearize": lambda plant, p: gelenk.linearize(plant, at={"hinge.phi": 0}, parameters=p).A.tolist(),
    "equilibrium": lambda plant, p: gelenk.equilibrium(plant, at={"hinge.phi": 3.0}, parameters=p).values,
    "modes": lambda plant, p: gelenk.modes(plant, at={"hinge.phi": 0}, parameters=p).to_dict(),
}


@pytest.fixture(scope="module")
def scene(root: Path) -> gelenk.Scene:
    return gelenk.load(root / "scenes" / "cart_pole.yaml")


@pytest.fixture(scope="module")
def fmu(scene: gelenk.Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(scene, tmp_path_factory.mktemp("fmu") / "CartPole.fmu")


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("what", ["scene", "fmu"])
def test_a_path_of_the_scene_is_the_parameter_of_the_fmu(
    call: str, what: str, request: pytest.FixtureRequest
) -> None:
    plant = request.getfixturevalue(what)
    by_path = CALLS[call](plant, {"pole.mass": 0.5, "pole.com[3]": 0.2})
    assert by_path == CALLS[call](plant, {"pole.m": 0.5, "pole.com[3]": 0.2})
    assert by_path != CALLS[call](plant, {"pole.com[3]": 0.2})


def test_a_path_at_the_operating_point_and_in_a_scene(scene: gelenk.Scene) -> None:
    heavy = scene.with_parameters({"pole.mass": 0.5})
    assert heavy.parameters["pole.m"] == 0.5
    at = gelenk.linearize(scene, at={"hinge.phi": 0, "pole.mass": 0.5})
    assert np.array_equal(at.A, gelenk.linearize(heavy, at={"hinge.phi": 0}).A)


def test_pictures_and_files_of_a_run_have_the_parameters_too(scene: gelenk.Scene, tmp_path: Path) -> None:
    """What is drawn is the scene with the parameters of the run."""
    pytest.importorskip("pyarrow", reason="pyarrow (the extra tables) is not installed")
    gelenk.simulate(scene, stop=0.1, parameters={"pole.mass": 0.5}).save(tmp_path / "run.parquet")
    read = gelenk.Result.read(tmp_path / "run.parquet").scene
    assert read is not None
    assert read["bodies"]["pole"]["mass"] == 0.5


@pytest.mark.parametrize("what", ["scene", "fmu"])
@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"track.damping": 1.0},
         "track.damping: a number of the scene that is no parameter; list it in the scene, "
         "parameters: [cart.mass, pole.mass, pole.com, track.damping]"),
        ({"pole.com": 0.2},
         "pole.com: found an array of 3 numbers, expected one of pole.com[1], pole.com[2], pole.com[3]"),
        ({"pole.mass": 1.0, "pole.m": 2.0}, "pole.mass: given twice, also as pole.m"),
        ({"pole.mas": 1.0}, "pole.mas: no such parameter or input; did you mean pole.m or "),
    ],
)  # fmt: skip
def test_other_numbers_are_refused_with_what_to_do(
    what: str, settings: dict[str, float], message: str, request: pytest.FixtureRequest
) -> None:
    with pytest.raises(gelenk.UsageError) as refused:
        gelenk.simulate(request.getfixturevalue(what), stop=0.1, parameters=settings)
    assert str(refused.value).startswith(message)


def test_parts_that_are_left_out_keep_their_names(four_bar: gelenk.Scene) -> None:
    """The pendulum is not computed if only the four-bar is wanted; its parameter may still be set."""
    scene = four_bar.to_dict()
    scene["bodies"]["bob"] = {"mass": 1.0, "com": [0, 0, -1.0]}
    scene["joints"]["P"] = {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "bob"}
    scene["parameters"] = [*scene["parameters"], "bob.mass"]
    for settings in ({"bob.mass": 2.0}, {"bob.m": 2.0}):
        gelenk.simulate(scene, stop=0.01, outputs=["A.phi"], parameters=settings)


def test_the_option_of_commands(root: Path) -> None:
    call = ["simulate", str(root / "scenes" / "four_bar.yaml"), "--stop", "0.01", "--output", "-", "--set"]
    outputs = {CliRunner().invoke(app, [*call, name]).stdout for name in ("crank.mass=2", "crank.m=2")}
    assert len(outputs) == 1
    assert CliRunner().invoke(app, [*call, "crank.m=1"]).stdout not in outputs
