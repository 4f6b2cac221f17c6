# SPDX-License-Identifier: BSD-3-Clause
"""modelDescription.xml: valid, complete, and true."""

from __future__ import annotations

import math
import re
import uuid
import zipfile
from collections.abc import Callable, Sequence
from ctypes import c_int
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import pytest
from fmpy.validation import validate_fmu
from mechanisms import Scene, body, frame, joint, scene

import gelenk

from .host import OK, Fmu, Slave
from .plants import crank_rocker, cranked, driven, gyroscope

SCENES = {"crank_rocker": crank_rocker, "gyroscope": gyroscope, "driven": driven, "cranked": cranked}


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


def test_choices_are_integers_whose_words_are_told(fmu: Path, description: Any) -> None:
    """An Enumeration is refused by Maestro 3 and passed over by libcosim 0.10."""
    assert not [v.name for v in description.modelVariables if v.type == "Enumeration"]
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    variables = {v.name: v for v in description.modelVariables}
    choices = root.findall("VendorAnnotations/Tool[@name='Gelenk']/Model/Choice")
    chosen = [f"solver.{name}" for name in ("formulation", "integrator", "start", "equations")]
    assert [c.get("variable") for c in choices] == chosen
    for choice in choices:
        v = variables[str(choice.get("variable"))]
        words = [item.get("name") for item in choice]
        assert all(len(item.get("description", "")) > 10 for item in choice)
        assert [item.get("value") for item in choice] == [str(k + 1) for k in range(len(words))]
        assert (v.type, v.min, v.max) == ("Integer", "1", str(len(words)))
        assert v.description.endswith(": " + ", ".join(f"{k + 1} {word}" for k, word in enumerate(words)))


def test_information_about_the_scene_is_in_the_attributes_of_the_same_names(tmp_path: Path) -> None:
    texts = {
        "author": "A. <Example> & 'Söhne'",
        "version": "1.10",
        "description": 'Two\nlines of "text"\n',
        "copyright": "2026 Example Ltd.",
        "license": "BSD-3-Clause",
    }
    fmu = gelenk.export_fmu(crank_rocker() | texts, tmp_path / "x.fmu")
    assert validate_fmu(str(fmu)) == []
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        page = archive.read("documentation/index.html").decode()
    wanted = texts | {"description": 'Two lines of "text"'}  # an attribute has no line breaks
    assert {key: root.get(key) for key in texts} == wanted
    assert "<p>Two lines of &quot;text&quot;</p>" in page
    assert "Author: A. &lt;Example&gt; &amp; 'Söhne'" in page
    other = gelenk.export_fmu(crank_rocker(), tmp_path / "y.fmu")
    with zipfile.ZipFile(other) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert {key: root.get(key) for key in texts if key in root.attrib} == {
        "description": "Multibody plant FourBar"
    }


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
    assert c.canInterpolateInputs
    assert not c.canBeInstantiatedOnlyOncePerProcess
    assert not c.canRunAsynchronuously
    assert c.providesDirectionalDerivative
    assert c.maxOutputDerivativeOrder == 2


def test_capabilities_of_model_exchange_are_those_that_work(description: Any) -> None:
    m = description.modelExchange
    if m is None:
        assert any(v.name.endswith("_ref") for v in description.modelVariables if v.causality == "input")
        return
    assert m.needsCompletedIntegratorStep
    assert m.canNotUseMemoryManagementFunctions
    assert m.canGetAndSetFMUstate
    assert m.canSerializeFMUstate
    assert m.providesDirectionalDerivative
    assert not m.canBeInstantiatedOnlyOncePerProcess


def test_no_output_is_the_derivative_of_a_state(description: Any) -> None:
    """CasADi refuses variables that are both."""
    derivatives = [unknown.variable for unknown in description.derivatives]
    assert derivatives
    assert {v.causality for v in derivatives} == {"local"}


def states(description: Any) -> dict[str, str]:
    """State -> its derivative, as the XML declares them."""
    return {u.variable.derivative.name: u.variable.name for u in description.derivatives}


def test_the_independent_joint_of_a_four_bar_carries_the_states(tmp_path: Path) -> None:
    found = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")
    assert states(fmpy.read_model_description(str(found))) == {"A.phi": "der(A.phi)", "A.w": "der(A.w)"}


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
    names = ["A.phi_a", "A.phi_b", "A.w_a", "A.w_b", "B.s", "B.phi", "B.v", "B.w"]
    assert states(fmpy.read_model_description(str(found))) == {name: f"der({name})" for name in names}


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


def fnv_1a(content: bytes) -> int:
    """Of 128 bits, as Fowler, Noll and Vo give it."""
    found = 0x6C62272E07BB014262B821756295C58D
    for byte in content:
        found = (found ^ byte) * (2**88 + 0x13B) % 2**128
    return found


def test_the_guid_is_a_sum_of_version_and_scene(tmp_path: Path) -> None:
    assert fnv_1a(b"a") == 0xD228CB696F1A8CAF78912B704E4A8964  # a test vector of theirs
    fmu = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")
    with zipfile.ZipFile(fmu) as archive:
        scene = archive.read("resources/scene.json")
    guid = fmpy.read_model_description(str(fmu)).guid
    assert guid == str(uuid.UUID(int=fnv_1a(gelenk.__version__.encode() + b"\n" + scene)))


def test_reals_have_types_with_quantities(description: Any) -> None:
    types = {t.name: t for t in description.typeDefinitions}
    for v in description.modelVariables:
        if v.type == "Real" and v.unit not in ("1", "1/s"):
            assert v.declaredType is types[v.declaredType.name]
            assert v.declaredType.quantity
            assert v.declaredType.unit == v.unit
            assert v.declaredType.displayUnit == v.displayUnit
    assert types["Gelenk.AngularVelocity"].displayUnit == "rpm"


def test_sizes_and_bounds_are_told_where_they_are_known(tmp_path: Path) -> None:
    """7.5 kg under 9.81 m/s2: a weight of 74 N, at arms of 1.75 m."""
    found = fmpy.read_model_description(str(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")))
    variables = {v.name: v for v in found.modelVariables}
    for name in ("drive.tau", "hinge.f[1]", "energy.total"):
        assert float(variables[name].nominal) == 100, name
    assert float(variables["constraints.position"].nominal) == 1e-6
    for name in ("energy.kinetic", "energy_meter.kinetic", "solver.steps", "crank.m", "A.damping"):
        assert float(variables[name].min) == 0, name
    assert variables["energy.potential"].min is None


def test_what_may_change_while_running_is_tunable(tmp_path: Path) -> None:
    found = fmpy.read_model_description(str(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")))
    kinds = {v.name: v.variability for v in found.modelVariables if v.causality == "parameter"}
    assert {name for name, kind in kinds.items() if kind == "tunable"} == {
        "A.damping",
        *(f"gravity[{i}]" for i in (1, 2, 3)),
    }
    assert set(kinds.values()) == {"tunable", "fixed"}


def two_machines() -> Scene:
    """A crank-rocker beside a gyroscope: nothing couples them."""
    out, other = crank_rocker(), gyroscope()
    for section in ("bodies", "joints"):
        out[section] |= other[section]
    out["forces"] = other["forces"]
    out["sensors"]["pose"] = {"type": "frame", "body": "rocker"}
    out["sensors"]["mount"] = {"type": "frame", "body": "ground"}
    return out


def dependencies(description: Any) -> dict[str, set[str]]:
    """Of each output: the names that modelDescription.xml lists."""
    return {u.variable.name: {v.name for v in u.dependencies} for u in description.outputs}


def test_an_input_acts_at_once_on_the_outputs_that_depend_on_it_and_on_no_other(tmp_path: Path) -> None:
    fmu = extracted(two_machines(), tmp_path)
    declared = dependencies(fmu.description)
    inputs = [v.name for v in fmu.description.modelVariables if v.causality == "input"]
    assert set(inputs) >= {"drive.tau", "push.f[1]", "push.t[3]"}
    slave = Slave(fmu).start()
    slave.run(5)
    before = dict(zip(declared, slave.outputs(), strict=True))
    for name in inputs:
        assert slave.set({name: 1.7}) == OK
        after = dict(zip(declared, slave.outputs(), strict=True))
        assert slave.set({name: 0.0}) == OK
        changed = {output for output in declared if after[output] != before[output]}
        wanted = {output for output in declared if name in declared[output]}
        assert changed <= wanted, name
        # A four-bar in a plane loads its hinge in that plane, and no hinge about its own axis.
        assert wanted - changed <= {"hinge.f[3]", "hinge.t[1]", "hinge.t[2]", "hinge.t[3]"}, name


def test_a_state_acts_on_no_output_but_those_that_depend_on_it(tmp_path: Path) -> None:
    """States are changed by their start values."""
    fmu = extracted(two_machines(), tmp_path)
    declared = dependencies(fmu.description)
    assert declared["A.phi"] == {"A.phi"}
    assert declared["C.phi"] == {"A.phi"}
    assert declared["C.w"] == {"A.phi", "A.w"}
    assert declared["C.a"] == {"A.phi", "A.w", "drive.tau"}
    assert declared["pose.r[1]"] == {"A.phi"}
    assert declared["mount.r[1]"] == set()
    before = dict(zip(declared, Slave(fmu).start().outputs(), strict=True))
    for name, value in {"A.phi": 1.3, "A.w": 0.7, "S.w[2]": 0.4, "F.r[3]": 0.9, "F.v[1]": 0.3}.items():
        slave = Slave(fmu)
        joint, quantity = name.split(".")
        start = re.sub(r"(\[\d\])?$", r"_start\1", quantity, count=1)
        assert slave.set({f"{joint}.{start}": value}) == OK, slave.said
        after = dict(zip(declared, slave.start().outputs(), strict=True))
        changed = {output for output in declared if after[output] != before[output]}
        assert name in changed
        assert changed <= {output for output in declared if name in declared[output]}, name


# Start values kept exactly that are not those of the motion, of gear and rack.
CONTRADICTIONS: dict[Callable[[], Scene], Sequence[str]] = {
    driven: [
        "solver.start",
        *(f"{joint}.fixed" for joint in ("A", "B", "C", "D", "shakes", "turns", "runs")),
    ],
    cranked: ["A.w_start"],
}


@pytest.mark.parametrize("plant", [crank_rocker, gyroscope, driven, cranked])
def test_values_at_the_start_depend_on_what_is_listed(plant: Callable[[], Scene], tmp_path: Path) -> None:
    fmu = extracted(plant(), tmp_path)
    listed = {u.variable.name: {v.name for v in u.dependencies} for u in fmu.description.initialUnknowns}
    before = starting(fmu, {})
    for v in fmu.description.modelVariables:
        if v.causality not in ("parameter", "input"):
            continue
        if v.name.startswith(
            ("solver.baumgarte_", "solver.rho_inf", "solver.cone_")
        ):  # refused without their methods
            continue
        if v.name in CONTRADICTIONS.get(plant, ()):  # against the motion
            continue
        after = starting(fmu, {v.name: another(v)})
        changed = {name for name in before if after[name] != before[name]}
        assert changed <= {name for name in before if v.name in listed[name]}, v.name


def another(variable: Any) -> float:
    """A value that differs from the start value."""
    if variable.type == "Boolean":
        return float(variable.start != "true")
    if variable.type == "Integer":
        return float(int(variable.start) + 1)
    if variable.name == "assembly.tolerance":
        return 1e-3
    if variable.type == "Real":
        return 1.013 * float(variable.start) + 0.011
    return 1 + int(variable.start) % len(variable.declaredType.items)


def starting(fmu: Fmu, values: dict[str, float]) -> dict[str, float]:
    """Outputs at the end of initialization."""
    slave = Slave(fmu)
    for name, value in values.items():
        kind = next(v.type for v in fmu.description.modelVariables if v.name == name)
        if kind == "Real":
            assert slave.set({name: value}) == OK, slave.said
        else:
            setter = "fmi2SetBoolean" if kind == "Boolean" else "fmi2SetInteger"
            assert slave.set({name: int(value)}, setter, c_int) == OK, slave.said
    outputs = slave.start().outputs()
    slave.free()
    names = [v.name for v in fmu.description.modelVariables if v.causality == "output"]
    return dict(zip(names, outputs, strict=True))


def test_large_models_do_not_repeat_that_all_depends_on_all(tmp_path: Path) -> None:
    """A chain of n links: accelerations depend on everything, which is what no list means."""
    n = 40
    rod = body(1.0, (0.3, 0, 0), (0.01, 0.02, 0.02))
    hinges = {
        f"J{i}": joint("revolute", frame(f"B{i - 1}" if i else "ground", (0.6, 0, 0)), frame(f"B{i}"))
        for i in range(n)
    }
    found = gelenk.export_fmu(scene({f"B{i}": rod for i in range(n)}, hinges), tmp_path / "x.fmu")
    assert validate_fmu(str(found)) == []
    description = fmpy.read_model_description(str(found))
    assert len(description.derivatives) == 2 * n
    for u in description.outputs:
        assert u.dependencies == (None if u.variable.name.endswith(".a") else [u.variable])


def extracted(source: Scene, folder: Path) -> Fmu:
    fmpy.extract(str(gelenk.export_fmu(source, folder / "x.fmu")), str(folder / "extracted"))
    return Fmu(folder / "extracted")
