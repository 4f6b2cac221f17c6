# SPDX-License-Identifier: BSD-3-Clause
"""SSP archives: valid by the schemas of the standard, complete, and run by fmpy as the FMU alone."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssv
from lxml import etree
from typer.testing import CliRunner

import gelenk
from gelenk.cli.commands import app
from gelenk.errors import ExportError

SCENES = sorted((Path(__file__).parents[2] / "scenes").glob("*.yaml"))
SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
FOUR_BAR = SCENES[0].with_name("four_bar.yaml")
VALUES, SYSTEM, VARIANT = "resources/plant.ssv", "SystemStructure.ssd", "Controlled.ssd"


def contents(ssp: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(ssp) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


def plant_of(files: dict[str, bytes], folder: Path) -> Any:
    """The description of the FMU in an archive."""
    fmu = folder / "plant.fmu"
    fmu.write_bytes(files["resources/plant.fmu"])
    return fmpy.read_model_description(str(fmu))


def connectors(element: Any) -> dict[str, tuple[str, str, str | None]]:
    """Kind, type and unit of each connector of an element of a .ssd file."""
    return {
        c.get("name"): (c.get("kind"), etree.QName(c[0]).localname, c[0].get("unit"))
        for c in element.iterfind("./{*}Connectors/{*}Connector")
    }


def links(system: Any) -> list[tuple[Any, Any, str]]:
    """The connections of a system: the elements, and the connectors, which have one name at both ends."""
    found = []
    for c in system.iterfind("./{*}Connections/{*}Connection"):
        assert c.get("startConnector") == c.get("endConnector")
        found.append((c.get("startElement"), c.get("endElement"), c.get("startConnector")))
    return found


@pytest.mark.parametrize("scene", SCENES, ids=lambda path: path.stem)
def test_files_are_valid_and_complete(scene: Path, tmp_path: Path) -> None:
    """Each connector is a variable of the FMU, and has exactly one source."""
    ssp = gelenk.export_ssp(scene, tmp_path / "x.ssp", view=False)
    files = contents(ssp)
    described = plant_of(files, tmp_path)
    ports = {
        v.name: (v.causality, v.type, v.unit)
        for v in described.modelVariables
        if v.causality in ("input", "output")
    }
    inputs = {name for name, port in ports.items() if port[0] == "input"}
    assert (VARIANT in files) == bool(inputs)
    values = etree.XMLSchema(file=str(SCHEMAS / "SystemStructureParameterValues.xsd"))
    values.assertValid(etree.fromstring(files[VALUES]))
    read_ssd(str(ssp), validate=True)
    schema = etree.XMLSchema(file=str(SCHEMAS / "SystemStructureDescription.xsd"))
    for name in files.keys() & {SYSTEM, VARIANT}:
        root = etree.fromstring(files[name])
        schema.assertValid(root)
        (system,) = root.iterfind("./{*}System")
        (plant,) = system.iterfind("./{*}Elements/{*}Component")
        assert connectors(plant) == ports
        outside = connectors(system)
        other = None if name == SYSTEM else "controller"
        if name == SYSTEM:
            assert outside == ports
        else:
            (controller,) = system.iterfind("./{*}Elements/{*}System")
            opposite = {"input": "output", "output": "input"}
            assert connectors(controller) == {k: (opposite[v[0]], *v[1:]) for k, v in ports.items()}
            assert len(controller.findall("./{*}Elements")) == 0
            assert outside == {}
        expected = [(other, "plant", k) for k in inputs] + [
            ("plant", other, k) for k in ports.keys() - inputs
        ]
        assert sorted(links(system), key=str) == sorted(expected, key=str)


def test_values_and_units_are_those_of_the_fmu(tmp_path: Path) -> None:
    ssp = gelenk.export_ssp(FOUR_BAR, tmp_path / "x.ssp", view=False)
    files = contents(ssp)
    described = plant_of(files, tmp_path)
    parameters = {
        v.name: (v.type, float(v.start == "true" if v.type == "Boolean" else v.start), v.unit)
        for v in described.modelVariables
        if v.causality == "parameter"
    }
    root = etree.fromstring(files[VALUES])
    found = {}
    for parameter in root.iterfind("./{*}Parameters/{*}Parameter"):
        kind, value = etree.QName(parameter[0]).localname, parameter[0].get("value")
        number = float(value == "true" if kind == "Boolean" else value)
        found[parameter.get("name")] = (kind, number, parameter[0].get("unit"))
    assert found == parameters
    assert {p.name for p in read_ssv(str(ssp), VALUES).parameters} == parameters.keys()
    units = {u.get("name"): dict(u[0].attrib) for u in root.iterfind("./{*}Units/{*}Unit")}
    assert units.keys() == {unit for *_, unit in parameters.values() if unit}
    assert units["N.m.s/rad"] == {"kg": "1", "m": "2", "s": "-1", "rad": "-1"}


def test_fmpy_runs_the_system_as_the_plant_alone(tmp_path: Path) -> None:
    """Inputs are passed on after each step: the plant reads 0 in the first one."""
    ssp = gelenk.export_ssp(FOUR_BAR, tmp_path / "x.ssp", view=False)
    steps, h = 50, 2.0**-10  # s; fmpy adds steps up
    run = simulate_ssp(str(ssp), stop_time=(steps - 0.5) * h, step_size=h, input={"drive.tau": lambda _: 2.0})
    plant = gelenk.Simulation(FOUR_BAR)
    plant.initialize()
    names = ["A.phi", "B.w", "C.a"]
    for k in range(steps):
        plant.set_input("drive.tau", 2.0 if k > 0 else 0.0)
        plant.step_to((k + 1) * h)
        assert [run[name][k] for name in names] == plant.values(names).tolist()


def driven_pendulum() -> dict[str, Any]:
    return {
        "gelenk": 1,
        "bodies": {"rod": {"mass": 1.0, "com": [0.5, 0, 0], "inertia": [0.01, 0.1, 0.1]}},
        "joints": {"pin": {"type": "revolute", "axis": [0, -1, 0], "parent": "ground", "child": "rod"}},
        "motors": {"brake": {"joint": "pin"}},
        "outputs": ["pin.phi"],
    }


def replaced_controller(folder: Path) -> Path:
    """An archive with a pendulum as controller: torque is what it reads, and what it writes."""
    files = contents(gelenk.export_ssp(FOUR_BAR, folder / "x.ssp", outputs=["A.w"], view=False))
    fmu = gelenk.export_fmu(driven_pendulum(), folder / "controller.fmu", view=False)
    root = etree.fromstring(files[VARIANT])
    (controller,) = root.iterfind("./{*}System/{*}Elements/{*}System")
    controller.tag = controller.tag.replace("}System", "}Component")
    controller.set("source", "resources/controller.fmu")
    names = {"A.w": "brake.tau", "drive.tau": "pin.phi"}
    for connector in controller.iterfind("./{*}Connectors/{*}Connector"):
        connector.set("name", names[connector.get("name")])
    for connection in root.iterfind("./{*}System/{*}Connections/{*}Connection"):
        end = "start" if connection.get("startElement") == "controller" else "end"
        connection.set(f"{end}Connector", names[connection.get(f"{end}Connector")])
    del files[VARIANT]
    files |= {SYSTEM: etree.tostring(root), "resources/controller.fmu": fmu.read_bytes()}
    out = folder / "loop.ssp"
    with zipfile.ZipFile(out, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    read_ssd(str(out), validate=True)
    return out


def test_a_controller_takes_the_place_that_is_left_for_it(tmp_path: Path) -> None:
    """Two FMUs that drive each other: fmpy exchanges their outputs after each step."""
    loop = replaced_controller(tmp_path)
    steps, h = 50, 2.0**-10
    run = simulate_ssp(str(loop), stop_time=(steps - 0.5) * h, step_size=h)
    plant, controller = gelenk.Simulation(FOUR_BAR), gelenk.Simulation(driven_pendulum())
    plant.initialize()
    controller.initialize()
    torque = rate = 0.0
    for k in range(steps):
        plant.set_input("drive.tau", torque)
        controller.set_input("brake.tau", rate)
        plant.step_to((k + 1) * h)
        controller.step_to((k + 1) * h)
        torque, rate = controller.output("pin.phi"), plant.output("A.w")
        assert run["plant.A.w"][k] == rate
        assert run["controller.pin.phi"][k] == torque
    assert torque != 0


def test_any_name_is_written(tmp_path: Path) -> None:
    name = "Ärmchen <1> & \"2\" 'rechts'"
    scene = gelenk.load({**gelenk.load(FOUR_BAR).to_dict(), "name": name})
    ssp = gelenk.export_ssp(scene, tmp_path / "Ä rm.ssp", view=False)
    assert read_ssd(str(ssp)).name == name
    assert len(simulate_ssp(str(ssp), stop_time=0.01, step_size=1e-3)) >= 10


def test_equal_scenes_give_equal_files(tmp_path: Path) -> None:
    first, second = (gelenk.export_ssp(FOUR_BAR, tmp_path / f"{k}.ssp", view=False) for k in "ab")
    assert first.read_bytes() == second.read_bytes()


def test_only_requested_outputs_are_connected(tmp_path: Path) -> None:
    ssp = gelenk.export_ssp(FOUR_BAR, tmp_path / "x.ssp", outputs=["A.phi"], view=False)
    system = etree.fromstring(contents(ssp)[SYSTEM])[0]
    assert connectors(system).keys() == {"drive.tau", "A.phi"}


def test_parameters_of_the_scene_are_the_values(tmp_path: Path) -> None:
    scene = gelenk.load(FOUR_BAR).with_parameters({"gravity[3]": -1.62})
    ssp = gelenk.export_ssp(scene, tmp_path / "x.ssp", view=False)
    values = {p.name: p.value for p in read_ssv(str(ssp), VALUES).parameters}
    assert float(values["gravity[3]"]) == -1.62


def test_command_writes_an_archive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["export", str(FOUR_BAR), "--ssp"])
    assert done.exit_code == 0
    assert done.stdout.startswith("FourBar.ssp: ")
    assert np.any([name.endswith(".fmu") for name in contents(tmp_path / "FourBar.ssp")])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--fmi", "3"], "--fmi: found 3, expected 2"),
        (["-o", "x.fmu"], "x.fmu: found the ending .fmu, expected .ssp"),
    ],
)
def test_what_is_no_archive_is_refused(
    arguments: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["export", str(FOUR_BAR), "--ssp", *arguments])
    assert done.exit_code == 1
    assert words in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=r"none.x\.ssp"):
        gelenk.export_ssp(FOUR_BAR, tmp_path / "none" / "x.ssp", view=False)
