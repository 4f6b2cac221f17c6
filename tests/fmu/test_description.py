# SPDX-License-Identifier: BSD-3-Clause
"""modelDescription.xml: valid, complete, and true."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu
from mechanisms import body, frame, joint, scene

import gelenk

from .plants import crank_rocker, gyroscope

SCENES = {"crank_rocker": crank_rocker, "gyroscope": gyroscope}


@pytest.fixture(scope="module", params=SCENES)
def fmu(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("description") / f"{request.param}.fmu"
    return gelenk.export_fmu(SCENES[request.param](), out)


@pytest.fixture(scope="module")
def description(fmu: Path) -> Any:
    return fmpy.read_model_description(str(fmu), validate=True)


def test_fmpy_finds_nothing_wrong(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []


def test_variables_are_the_signals_and_parameters_of_the_scene(fmu: Path, description: Any) -> None:
    source = gelenk.load(SCENES[fmu.stem]())
    simulation = gelenk.Simulation(source)
    names = {c: [v.name for v in description.modelVariables if v.causality == c] for c in
             ("input", "output", "parameter", "local")}  # fmt: skip
    assert names["input"] == [s.name for s in simulation.inputs]
    assert names["output"] == [s.name for s in simulation.outputs]
    assert names["parameter"] == list(source.parameters)
    diagnostics = [s.name for s in simulation.diagnostic_signals]
    assert [n for n in names["local"] if not n.startswith("der(")] == diagnostics


def test_every_real_has_a_unit_and_a_sentence(description: Any) -> None:
    units = {u.name: u for u in description.unitDefinitions}
    for v in description.modelVariables:
        assert v.description
        if v.type == "Real":
            assert v.unit in units, v.name
    for unit in units.values():
        assert unit.baseUnit is not None
    base = units["rad/s2"].baseUnit
    assert (base.kg, base.m, base.s, base.rad) == (0, 0, -2, 1)
    shown = {d.name: d.factor for d in units["rad/s"].displayUnits}
    assert shown["deg/s"] == math.degrees(1)
    assert shown["rpm"] == pytest.approx(60 / math.tau, rel=1e-15)


def test_compound_units_are_told_in_base_units(tmp_path: Path) -> None:
    found = fmpy.read_model_description(str(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")))
    units = {u.name: u for u in found.unitDefinitions}
    base = {name: units[name].baseUnit for name in ("N.m.s/rad", "N.m", "J", "rad")}
    exponents = {name: (b.kg, b.m, b.s, b.rad) for name, b in base.items()}
    assert exponents == {
        "N.m.s/rad": (1, 2, -1, -1),
        "N.m": (1, 2, -2, 0),
        "J": (1, 2, -2, 0),
        "rad": (0, 0, 0, 1),
    }
    (degree,) = units["rad"].displayUnits
    assert (degree.name, degree.factor) == ("deg", math.degrees(1))


def test_capabilities_are_those_that_work(description: Any) -> None:
    c = description.coSimulation
    assert c.canHandleVariableCommunicationStepSize
    assert c.canNotUseMemoryManagementFunctions
    assert not c.canBeInstantiatedOnlyOncePerProcess
    assert not c.canRunAsynchronuously


def states(description: Any) -> dict[str, str]:
    """State -> its derivative, as the XML declares them."""
    return {u.variable.derivative.name: u.variable.name for u in description.derivatives}


def test_the_independent_joint_of_a_four_bar_carries_the_states(tmp_path: Path) -> None:
    found = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")
    assert states(fmpy.read_model_description(str(found))) == {"A.phi": "A.w", "A.w": "A.a"}


def test_a_chain_declares_a_state_pair_for_each_freedom(tmp_path: Path) -> None:
    rod = body(1.0, (0.3, 0, 0), (0.01, 0.02, 0.02))
    chain = scene(
        {"upper": rod, "lower": rod},
        {
            "A": joint("universal", frame("ground"), frame("upper"), axes=[[1, 0, 0], [0, 1, 0]]),
            "B": joint("cylindrical", frame("upper", (0.6, 0, 0)), frame("lower")),
        },
    )
    found = gelenk.export_fmu(chain, tmp_path / "x.fmu")
    assert states(fmpy.read_model_description(str(found))) == {
        "A.phi_a": "A.w_a",
        "A.phi_b": "A.w_b",
        "A.w_a": "A.a_a",
        "A.w_b": "A.a_b",
        "B.s": "B.v",
        "B.phi": "B.w",
        "B.v": "B.a",
        "B.w": "B.wd",
    }


def test_rates_of_quaternions_are_their_time_derivatives(tmp_path: Path) -> None:
    """Central difference over 2 h, h = 1e-4 s: error h^2/6 |Q'''| = 2e-9 * 1e3 at 11 rad/s, times two."""
    found = gelenk.export_fmu(gyroscope(), tmp_path / "x.fmu")
    names = [f"{j}.Q[{i}]" for j in "SF" for i in (1, 2, 3, 4)]
    h = 1e-4
    run = gelenk.simulate(
        found, stop=0.2, step=h, tolerance=1e-12, outputs=[*names, *(f"der({n})" for n in names)]
    )
    for name in names:
        quotient = (run[name][2:] - run[name][:-2]) / (2 * h)
        assert abs(run[f"der({name})"][1:-1] - quotient).max() < 4e-6, name


def test_the_same_scene_gives_the_same_bytes(tmp_path: Path) -> None:
    first = gelenk.export_fmu(crank_rocker(), tmp_path / "a.fmu").read_bytes()
    assert gelenk.export_fmu(crank_rocker(), tmp_path / "b.fmu").read_bytes() == first
    other = crank_rocker()
    other["bodies"]["crank"]["mass"] *= 1 + 2e-16
    changed = gelenk.export_fmu(other, tmp_path / "c.fmu")
    guid = fmpy.read_model_description(str(changed)).guid
    assert guid != fmpy.read_model_description(str(tmp_path / "a.fmu")).guid
