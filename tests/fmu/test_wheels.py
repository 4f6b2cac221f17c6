# SPDX-License-Identifier: BSD-3-Clause
"""FMUs of what rolls and slides: described truly, the same numbers as in Python, saved and restored."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_void_p
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
import warned
from fmpy.validation import validate_fmu
from mechanisms import Scene, rotation
from models.disc import disc, disc_on_a_table, flying_disc
from models.sleighs import chaplygin_sleigh, on_a_turntable
from models.vehicles import four_wheeled_cart, trailer, two_wheeled_cart
from models.whipple import bicycle

import gelenk
from gelenk.chart import mechanisms

from .derivatives import directional
from .host import OK, Fmu, Slave
from .states import deserialize, get_state, serialized, set_state

pytestmark = [warned.MOVING, warned.STILL]

KNOCKED = {"lean": {"phi": 0.05, "w": 0.3, "fixed": True}}
ON_TABLE = {"r": [0.5, 0.1, 0.3], "Q": [0, 0, 0, 1], "w": [0.2, 9.0, 0.4]}

# Plants, and how many of their states are coordinates and how many speeds.
PLANTS: dict[str, tuple[Callable[[], Scene], int, int]] = {
    "disc": (disc, 5, 3),
    "bicycle": (lambda: bicycle(5.0, KNOCKED), 7, 3),
    "robot": (lambda: mechanisms.shipped("balancing_robot"), 6, 3),
    "cart": (lambda: two_wheeled_cart(0.5, 2.0), 5, 2),
    "four wheels": (lambda: four_wheeled_cart(rotation([0, 1, 0], 0.2)), 0, 1),
    "sleigh": (lambda: chaplygin_sleigh(-1.0, 0.4), 3, 2),
    "skate on a table": (lambda: on_a_turntable(0.7, driven=False), 4, 3),
    "trailer": (lambda: trailer(0.5, wheels=True), 3, 0),
    "flying disc": (flying_disc, 0, 3),
    "disc on a table": (lambda: disc_on_a_table(0.7, None, ON_TABLE), 0, 3),
}
SPEEDS = ("v_x", "v_y", "w", "v")
SMOOTH = [name for name, (_, coordinates, _) in PLANTS.items() if coordinates]  # no quaternions


@pytest.fixture(scope="module", params=PLANTS)
def exported(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    folder = tmp_path_factory.mktemp("wheels")
    return request.param, gelenk.export_fmu(PLANTS[request.param][0](), folder / "x.fmu")


def opened(file: Path, folder: Path) -> Fmu:
    return Fmu(fmpy.extract(str(file), str(folder / "extracted")))


def states_of(description: Any) -> list[str]:
    return [u.variable.derivative.name for u in description.derivatives]


def test_fmpy_finds_nothing_wrong(exported: tuple[str, Path]) -> None:
    assert validate_fmu(str(exported[1])) == []


def test_states_are_as_many_as_there_are(exported: tuple[str, Path]) -> None:
    name, file = exported
    _, coordinates, speeds = PLANTS[name]
    states = states_of(fmpy.read_model_description(str(file)))
    if coordinates:
        assert len(states) == coordinates + speeds
    assert len(set(states)) == len(states)
    found = [s for s in states if s.split(".")[1].split("[")[0] in SPEEDS]
    assert len(found) == speeds


def test_runs_are_those_in_python(exported: tuple[str, Path]) -> None:
    """The same program at the same tolerance and the same times: times are added up otherwise."""
    name, file = exported
    source = PLANTS[name][0]()
    expected = gelenk.simulate(source, stop=1.0, step=0.01)
    names = [n for n in expected.names if n not in ("time",) and not n.startswith("solver.")]
    found = fmpy.simulate_fmu(str(file), stop_time=1.0, output_interval=0.01, output=names)
    for n in names:
        assert np.abs(found[n] - expected[n]).max() < 1e-9 * (1 + np.abs(expected[n]).max()), n


def test_run_goes_on_from_a_saved_state_to_the_bit(exported: tuple[str, Path], tmp_path: Path) -> None:
    fmu = opened(exported[1], tmp_path)
    slave = Slave(fmu).start()
    slave.run(10)
    saved = get_state(slave)
    first = slave.run(20, first=10)
    set_state(slave, saved)
    assert slave.run(20, first=10) == first
    other, copy = Slave(fmu), c_void_p()
    assert deserialize(other, serialized(slave, saved), copy) == OK, other.said
    set_state(other, copy)
    assert other.run(20, first=10) == first
    slave.free()
    other.free()


def test_what_acts_is_declared(exported: tuple[str, Path], tmp_path: Path) -> None:
    """Derivatives of outputs and rates by states and inputs vanish where no dependency is declared."""
    fmu = opened(exported[1], tmp_path)
    unknowns = [*fmu.description.outputs, *fmu.description.derivatives]
    names = [u.variable.name for u in unknowns]
    known = {v.name for v in fmu.description.modelVariables if v.causality == "input"}
    known |= set(states_of(fmu.description))
    slave = Slave(fmu).start()
    slave.run(10)
    acting = 0
    for name in known:
        for unknown, slope in zip(unknowns, directional(slave, names, {name: 1.0}), strict=True):
            if slope != 0:
                acting += 1
                listed = unknown.dependencies
                assert listed is None or name in {v.name for v in listed}, (unknown.variable.name, name)
    assert acting >= len(known)
    slave.free()


@pytest.mark.parametrize("name", [name for name in PLANTS if name != "four wheels"])  # see the next
def test_linear_models_of_fmu_and_scene_are_the_same(name: str, tmp_path: Path) -> None:
    source = PLANTS[name][0]()
    models = [
        gelenk.linear.linear_model(plant, at=0.3)
        for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu"))
    ]
    for first, second in zip(*((m.A, m.B, m.C, m.D) for m in models), strict=True):
        assert np.abs(first - second).max(initial=0) < 1e-9 * (1 + np.abs(first).max(initial=0))
    assert models[0].states == models[1].states


def test_heading_that_no_state_tells_is_left_out_by_name() -> None:
    """Four wheels of a rigid cart hold two turns of its quaternion; nothing depends on its heading."""
    with pytest.warns(gelenk.OperatingPointWarning, match=r"left out: flight\.theta\[3\]"):
        model = gelenk.linearize(PLANTS["four wheels"][0]())
    assert "flight.theta[3]" not in model.names.states


@pytest.mark.parametrize("name", SMOOTH)
def test_directional_derivatives_are_those_of_the_plant_set_beside(name: str, tmp_path: Path) -> None:
    """By start values of the states: central differences of fourth order, h = 1e-3, to 1e-7."""
    source = PLANTS[name][0]()
    file = gelenk.export_fmu(source, tmp_path / "x.fmu")
    states = states_of(fmpy.read_model_description(str(file)))
    keep_exactly(source, states)
    fmu = opened(gelenk.export_fmu(source, file), tmp_path)
    assert states_of(fmu.description) == states
    slave = Slave(fmu).start()
    slave.run(20)
    names = [v.name for v in fmu.description.modelVariables if v.causality == "output"]
    joints = {state.split(".")[0] for state in states}  # what is set at these is kept exactly
    given = [
        n for n in names if f"{n}_start" in fmu.reference and (n in states or n.split(".")[0] not in joints)
    ]
    here = {n: float(slave.get(n)) for n in given}
    h = 1e-3
    for state in states:
        column = np.zeros(len(names))
        for k, weight in {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}.items():
            column += weight / h * np.array(beside(fmu, here | {state: here[state] + k * h}, states, names))
        found = np.array(directional(slave, names, {state: 1.0}))
        assert np.abs(found - column).max() < 1e-7 * (1 + np.abs(column).max()), state
    slave.free()


def keep_exactly(source: Scene, states: list[str]) -> None:
    """All states are `fixed` at the start, and nothing else is."""
    for name, joint in source["joints"].items():
        mine = [state.split(".")[1] for state in states if state.split(".")[0] == name]
        start = joint.get("start", {})
        joint["start"] = {n: start.get(n, 0.0) for n in mine} | start | {"fixed": mine}


def beside(fmu: Fmu, values: dict[str, float], states: list[str], names: list[str]) -> list[float]:
    """Outputs of an instance that starts here, its states exactly."""
    slave = Slave(fmu)
    assert slave.set({f"{n}_start": v for n, v in values.items()}) == OK, slave.said
    slave.start()
    for n in states:
        assert abs(slave.get(n) - values[n]) < 1e-12, n
    out = [float(slave.get(n)) for n in names]
    slave.free()
    return out
