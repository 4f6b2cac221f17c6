# SPDX-License-Identifier: BSD-3-Clause
"""FMUs of FMI 3.0: their description, and that they compute what those of FMI 2.0 compute."""

from __future__ import annotations

import shutil
import zipfile
import zlib
from collections.abc import Callable
from ctypes import byref, c_size_t, c_ubyte, c_void_p
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree
from mechanisms import Scene

import gelenk
from gelenk import _core
from gelenk.errors import ExportError
from gelenk.io import export

from .host import OK, Fmu, Slave
from .host3 import Fmu3, Slave3
from .plants import crank_rocker, cranked, driven, gyroscope, touching, with_circuit
from .states import get_state, serialized

PLANTS: dict[str, Callable[[], Scene]] = {
    "crank_rocker": crank_rocker,
    "gyroscope": gyroscope,
    "driven": driven,
    "cranked": cranked,
    "with_circuit": with_circuit,
    "touching": lambda: touching(2),
}
SHIPPED = sorted(path.stem for path in (Path(__file__).parent.parent.parent / "scenes").glob("*.yaml"))


def source_of(name: str, root: Path) -> Any:
    return PLANTS[name]() if name in PLANTS else root / "scenes" / f"{name}.yaml"


@pytest.fixture(scope="module", params=[*PLANTS, *SHIPPED])
def both(
    request: pytest.FixtureRequest, root: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Path]:
    """The FMUs of a scene for both versions."""
    folder = tmp_path_factory.mktemp(request.param)
    source = source_of(request.param, root)
    return (
        gelenk.export_fmu(source, folder / "fmi2.fmu", view=False),
        gelenk.export_fmu(source, folder / "fmi3.fmu", view=False, fmi=3),
    )


def test_fmpy_finds_nothing_wrong(both: tuple[Path, Path]) -> None:
    """Neither the XML schema of FMI 3.0, nor names, units, start values, model structure."""
    assert validate_fmu(str(both[1])) == []


def test_variables_are_those_of_fmi_2(both: tuple[Path, Path]) -> None:
    old, new = (fmpy.read_model_description(str(path)) for path in both)
    assert new.fmiVersion == "3.0"
    assert new.instantiationToken == old.guid
    types = {"Real": "Float64", "Boolean": "Boolean", "Integer": "Int32"}
    found = {v.name: v for v in new.modelVariables}
    indicators = {f"event_indicators[{k + 1}]" for k in range(old.numberOfEventIndicators or 0)}
    assert found.keys() - {v.name for v in old.modelVariables} == {"time"} | indicators
    for v in old.modelVariables:
        other = found[v.name]
        same = ("valueReference", "description", "causality", "variability", "unit", "displayUnit", "start")
        assert [getattr(v, a) for a in same] == [getattr(other, a) for a in same], v.name
        assert other.type == types[v.type] or v.name in (
            "solver.formulation",
            "solver.integrator",
            "solver.start",
            "solver.equations",
        )
        assert (v.derivative and v.derivative.name) == (other.derivative and other.derivative.name)
    for of in ("outputs", "derivatives", "initialUnknowns"):
        lists = [
            [(u.variable.name, u.dependencies and [d.name for d in u.dependencies]) for u in getattr(d, of)]
            for d in (old, new)
        ]
        assert lists[0] == lists[1], of


def test_trajectories_are_bitwise_those_of_fmi_2(both: tuple[Path, Path]) -> None:
    """In fmpy's loop, with torques that vary from step to step: 60 steps."""
    description = fmpy.read_model_description(str(both[0]))
    experiment = description.defaultExperiment
    step = float(experiment.stepSize)
    inputs = [v for v in description.modelVariables if v.causality == "input"]
    signals = None
    if inputs:
        t = np.arange(61) * step
        columns = [float(v.start) + 0.1 * np.sin(3 * t + i) - 0.1 * np.sin(i) for i, v in enumerate(inputs)]
        signals = np.array(
            list(zip(t, *columns, strict=True)), dtype=[("time", float), *((v.name, float) for v in inputs)]
        )
    runs = [
        fmpy.simulate_fmu(
            str(path),
            stop_time=60 * step,
            step_size=step,
            output_interval=step,
            relative_tolerance=float(experiment.tolerance),
            input=signals,
            fmi_type="CoSimulation",
            output=[v.name for v in description.modelVariables if v.causality == "output"],
            # fmpy keeps the last one of all runs in a static variable, without a reference: a warning would
            # call that of a former test.
            logger=lambda *_: None,
        )
        for path in both
    ]
    assert len(runs[0]) == 61
    assert runs[0].dtype == runs[1].dtype
    assert runs[0].tobytes() == runs[1].tobytes()


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return gelenk.export_fmu(crank_rocker(), tmp_path_factory.mktemp("fmi3") / "x.fmu", fmi=3)


def test_choices_are_enumerations(fmu: Path) -> None:
    description = fmpy.read_model_description(str(fmu))
    variables = {v.name: v for v in description.modelVariables}
    integrator = variables["solver.integrator"]
    assert integrator.type == "Enumeration"
    words = [item.name for item in integrator.declaredType.items]
    assert words[:2] == ["auto", "erk"]
    assert all(len(item.description) > 10 for item in integrator.declaredType.items)
    slave = Slave3(Fmu3(fmpy.extract(str(fmu))))
    assert slave.set({"solver.integrator": words.index("rk4") + 1}, "Int64") == 0
    assert slave.get(["solver.integrator"], "Int64") == [words.index("rk4") + 1]
    slave.free()


def test_capabilities_are_those_that_work(fmu: Path) -> None:
    """Read from the file: fmpy 0.3.32 has names of FMI 2.0 for some."""
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    found = root.find("CoSimulation")
    assert found is not None
    assert found.attrib == {
        "modelIdentifier": "FourBar",
        "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "providesAdjointDerivatives": "true",
        "mightReturnEarlyFromDoStep": "true",
        "maxOutputDerivativeOrder": "2",
    }


def test_files_are_where_fmi_3_has_them(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        page = archive.read("documentation/index.html").decode()
    assert {name.split("/")[1] for name in names if name.startswith("binaries/")} == {"x86_64-linux"}
    assert {"resources/scene.json", "documentation/view.html", "terminalsAndIcons/icon.png"} <= set(names)
    assert "model.png" not in names
    order = root.find("Annotations/Annotation[@type='Gelenk']/Order")
    assert order is not None
    assert order.get("states") == "2"
    assert "FMI 3.0 FMU for co-simulation" in page
    assert "fmi2" not in page
    assert "fmi3Discard" in page


def terminals_in(fmu: Path) -> Any:
    """The root of terminalsAndIcons.xml, which the schema of FMI 3.0 accepts."""
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    with zipfile.ZipFile(fmu) as archive:
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    etree.XMLSchema(file=str(schema)).assertValid(root)
    return root


def test_each_joint_is_a_terminal(both: tuple[Path, Path]) -> None:
    root = terminals_in(both[1])
    variables = {v.name: v for v in fmpy.read_model_description(str(both[1])).modelVariables}
    names = [terminal.get("name") for terminal in root.iter("Terminal")]
    assert len(names) == len(set(names)) > 0
    for terminal in root.iter("Terminal"):
        members = {m.get("memberName"): m.get("variableName") for m in terminal}
        assert len(members) == len(terminal) > 1
        for variable in members.values():
            v = variables[variable]
            is_of_joint = variable.startswith(terminal.get("name") + ".")
            assert v.causality == ("output" if is_of_joint else "input"), variable


def test_a_terminal_has_motion_and_motors(fmu: Path) -> None:
    terminals = {t.get("name"): t for t in terminals_in(fmu).iter("Terminal")}
    members = {
        name: [(m.get("memberName"), m.get("variableName")) for m in t] for name, t in terminals.items()
    }
    motion = {name: [(q, f"{name}.{q}") for q in ("phi", "w", "a")] for name in "ABCD"}
    assert members == motion | {"A": [*motion["A"], ("drive.tau", "drive.tau")]}


def test_joints_without_wanted_outputs_are_no_terminals(tmp_path: Path) -> None:
    some = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu", outputs=["C.*"], view=False, fmi=3)
    assert [t.get("name") for t in terminals_in(some).iter("Terminal")] == ["C"]
    none = gelenk.export_fmu(crank_rocker(), tmp_path / "y.fmu", outputs=["hinge.*"], view=False, fmi=3)
    assert list(terminals_in(none).iter("Terminal")) == []
    assert validate_fmu(str(some)) == validate_fmu(str(none)) == []


def test_platforms_have_the_folders_of_fmi_3(tmp_path: Path) -> None:
    """The library for macOS, for two processors, is in the folder of each. Contents do not matter here."""
    runtimes = []
    for platform, library in export.LIBRARIES.items():
        file = tmp_path / platform / library
        file.parent.mkdir()
        shutil.copy(export.runtime_library(), file)
        runtimes.append((platform, file))
    out = tmp_path / "x.fmu"
    scene = gelenk.load(crank_rocker())._core
    _core.export_fmu(scene, runtimes, out, export.licenses(), zlib.compress, version=3)
    with zipfile.ZipFile(out) as archive:
        names = {name for name in archive.namelist() if name.startswith("binaries/")}
        assert archive.testzip() is None
    assert names == {
        "binaries/x86_64-linux/FourBar.so",
        "binaries/aarch64-linux/FourBar.so",
        "binaries/x86_64-windows/FourBar.dll",
        "binaries/x86_64-darwin/FourBar.dylib",
        "binaries/aarch64-darwin/FourBar.dylib",
    }
    assert validate_fmu(str(out)) == []


def test_time_is_the_independent_variable(fmu: Path) -> None:
    slave = Slave3(Fmu3(fmpy.extract(str(fmu)))).start()
    slave.run(3)
    assert slave.get(["time"]) == [pytest.approx(0.03, rel=1e-15)]
    slave.free()


def test_a_state_of_one_version_is_restored_by_the_other(fmu: Path, tmp_path: Path) -> None:
    fmpy.extract(
        str(gelenk.export_fmu(crank_rocker(), tmp_path / "y.fmu", view=False)), str(tmp_path / "fmi2")
    )
    old, new = Slave(Fmu(tmp_path / "fmi2")).start(), Slave3(Fmu3(fmpy.extract(str(fmu)))).start()
    for slave in (old, new):
        assert slave.set({"drive.tau": 1.4}) == OK
    assert old.run(5) == new.run(5)
    content = serialized(old, get_state(old))
    expected = old.run(6, first=5)
    state = c_void_p()
    data = (c_ubyte * len(content)).from_buffer_copy(content)
    assert new.call("fmi3DeserializeFMUState", data, c_size_t(len(content)), byref(state)) == OK, new.said
    new.run(3, first=5)
    assert new.call("fmi3SetFMUState", state) == OK
    assert new.run(6, first=5) == expected
    old.free()
    new.free()


def test_other_versions_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="fmi: found 1, expected 2 or 3"):
        gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu", fmi=1)
    assert not list(tmp_path.iterdir())
