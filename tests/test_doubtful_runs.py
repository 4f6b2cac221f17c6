# SPDX-License-Identifier: BSD-3-Clause
"""Runs that are valid but probably not intended are warned of; calls that make no sense are refused."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import programs
import pytest

import gelenk

ROD: dict[str, Any] = {
    "gelenk": 1,
    "name": "rod",
    "gravity": [0, 0, -9.81],
    "bodies": {"rod": {"mass": 1.2, "com": [0.4, 0, 0], "inertia": [0, 0.064, 0.064]}},
    "joints": {"pin": {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "rod"}},
    "motors": {"drive": {"joint": "pin"}},
    "experiment": {"stop": 0.1, "step": 0.01},
}


def said(**call: Any) -> list[str]:
    """What a run of the rod, or of another scene, warns of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gelenk.simulate(call.pop("scene", ROD), **call)
    assert {w.category for w in caught} <= {gelenk.StartWarning}
    assert all(w.filename == __file__ for w in caught)  # the caller's line
    return [str(w.message) for w in caught]


@pytest.mark.parametrize(
    ("gravity", "cause"),
    [
        ([0, 0, 0], "there is no gravity (such as gravity: [0, 0, -9.81])"),
        ([0, -9.81, 0], "gravity [0, -9.81, 0] m/s2 accelerates no joint at the start"),
    ],
)
def test_nothing_that_moves_is_warned_of_with_its_cause(gravity: list[float], cause: str) -> None:
    (sentence,) = said(scene=ROD | {"gravity": gravity})
    assert sentence.startswith(f"nothing moves: {cause}")
    assert sentence.endswith(", and all inputs are 0 (drive.tau)")


def test_no_warning_where_something_moves_or_is_meant_not_to() -> None:
    floating = ROD | {"gravity": [0, 0, 0]}
    assert said() == []
    assert said(scene=floating, inputs={"drive.tau": 1e-9}) == []
    assert said(scene=floating, inputs={"drive.tau": lambda _: 0.0}) == []
    assert said(scene=floating, stop=0.0) == []
    assert said(scene=floating, outputs=["pin.phi"]) == []  # others might move
    pin = ROD["joints"]["pin"]
    held = ROD | {"joints": {"pin": pin | {"friction": {"coulomb": 8.0}}}}
    assert said(scene=held) == []
    turning = ROD | {"joints": {"pin": pin | {"start": {"w": 1.0}}}, "gravity": [0, 0, 0]}
    assert said(scene=turning) == []


@pytest.mark.parametrize(
    ("times", "values", "sentence"),
    [
        ([0, 0.05], [1, 2], "the table ends at 0.05 s, before the end of the run at 0.1 s; "
                            "its last values are held from there on"),
        ([0, 0.1], [1, 2], ""),
        ([0, 0.1 * (1 - 1e-12)], [1, 2], ""),
        ([0.05], [1], ""),  # a constant
        ([0, *np.linspace(0.01, 0.1, 20), 0.1], [*np.arange(21.0), 50], ""),  # a jump
        ([0, *np.linspace(0, 0.1, 20)], [0, *np.zeros(20)],
         "found the time 0 s twice with equal values, expected it once"),
        ([0, 0.04, 0.04, 0.04, 0.1], [1, 2, 3, 4, 5],
         "found the time 0.04 s three times, expected it once, or twice for a jump"),
        ([0, 0.02, 0.02, 0.04, 0.04, 0.1], [1, 2, 3, 4, 5, 6],
         "found 2 of 6 times twice, 0.02 s first; values jump where a time is repeated: have the times been "
         "rounded?"),
    ],
)  # fmt: skip
def test_doubtful_tables_of_inputs(times: list[float], values: list[float], sentence: str) -> None:
    found = said(inputs={"drive.tau": (times, values)})
    assert found == ([f"drive.tau: {sentence}"] if sentence else [])


def test_inputs_of_one_table_are_warned_of_once(tmp_path: Path) -> None:
    table = tmp_path / "in.csv"
    table.write_text("time,drive.tau,push.tau\n0,3,1\n0.05,4,2\n")
    scene = ROD | {"motors": {"drive": {"joint": "pin"}, "push": {"joint": "pin"}}}
    with warnings.catch_warnings(action="ignore", category=gelenk.SceneWarning):
        loaded = gelenk.load(scene)  # two motors at one joint
    (sentence,) = said(scene=loaded, inputs=table)
    assert sentence.startswith("drive.tau, push.tau: the table ends at 0.05 s")


def test_an_fmu_is_warned_of_alike(tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(ROD | {"gravity": [0, 0, 0]}, tmp_path / "rod.fmu")
    (sentence,) = said(scene=fmu)
    assert sentence.startswith("nothing moves: there is no gravity")


def test_the_command_prints_the_warning_as_a_line(tmp_path: Path) -> None:
    gelenk.load(ROD | {"gravity": [0, 0, 0]}).save(tmp_path / "rod.yaml")
    done = programs.gelenk("simulate", "rod.yaml", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr.startswith("nothing moves: there is no gravity")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"stop": "1"}, "stop: found '1', expected a number of s; leave out the quotes"),
        ({"stop": "one"}, "stop: found 'one', expected a number of s"),
        ({"step": [0.1]}, "step: found [0.1], expected a number of s"),
        ({"stop": True}, "stop: found True, expected a number of s"),
        ({"tolerance": "1e-6"}, "tolerance: found '1e-6', expected a number; leave out the quotes"),
    ],
)
def test_what_is_no_number_is_refused_in_a_sentence(arguments: dict[str, Any], sentence: str) -> None:
    with pytest.raises(gelenk.UsageError) as refused:
        gelenk.simulate(ROD, **arguments)
    assert str(refused.value) == sentence
    numbers: dict[str, Any] = {"stop": np.float32(0.25), "step": np.int64(1)}
    assert len(gelenk.simulate(ROD, **numbers)) == 2


@pytest.mark.parametrize(
    "read",
    [
        lambda name: gelenk.load(f"{name}.yaml"),
        lambda name: gelenk.simulate(f"{name}.fmu"),
        lambda name: gelenk.simulate(ROD, inputs=f"{name}.csv"),
    ],
)
def test_a_missing_file_is_one_of_our_errors_and_names_similar_ones(
    read: Callable[[str], Any], empty_folder: Path
) -> None:
    for place in (".", "scenes"):
        for ending in ("yaml", "fmu", "csv"):
            (empty_folder / place).mkdir(exist_ok=True)
            (empty_folder / place / f"four_bar.{ending}").touch()
    with pytest.raises(gelenk.MissingFileError) as missing:
        read("fourbar")
    ending = Path(missing.value.filename).suffix
    names = f"four_bar{ending} or scenes/four_bar{ending}"
    assert str(missing.value) == f"fourbar{ending}: no such file or directory; did you mean {names}?"
    assert isinstance(missing.value, FileNotFoundError)
    assert isinstance(missing.value, gelenk.GelenkError)
    assert str(pickle.loads(pickle.dumps(missing.value))) == str(missing.value)
    with pytest.raises(gelenk.MissingFileError, match=r"^none\.\w+: no such file or directory$"):
        read("none")


def test_pictures_do_not_pretend_to_show_reactions(empty_folder: Path) -> None:
    gelenk.load(ROD).save("rod.yaml")
    done = programs.gelenk("view", "rod.yaml", "--reactions", "-o", "rod.png")
    assert done.returncode == 1
    assert done.stderr == "--reactions: pictures have no arrows, expected a page: -o FILE.html\n"
    assert not (empty_folder / "rod.png").exists()
