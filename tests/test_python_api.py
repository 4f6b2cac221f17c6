# SPDX-License-Identifier: BSD-3-Clause
"""Loading, changing, saving, stepping: the package as a Python user meets it."""

from __future__ import annotations

import json
import math
import threading
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import four_bar as four_bar_dict

import gelenk

INTEGRATORS = (
    "auto, cvode, cvode-adams, dirk, erk, euler, generalized-alpha, hht, ida, moreau-jean, newmark, rk4"
)


def test_file_text_mapping_and_path_give_the_same_scene(four_bar_file: Path, four_bar: gelenk.Scene) -> None:
    expected = four_bar.to_dict()
    assert gelenk.load(str(four_bar_file)).to_dict() == expected
    assert gelenk.load(four_bar_file.read_text()).to_dict() == expected
    assert gelenk.load(expected).to_dict() == expected
    assert gelenk.load(json.dumps(expected)).to_dict() == expected
    assert gelenk.load(four_bar) is four_bar


def test_numpy_numbers_and_arrays_are_taken() -> None:
    plain = four_bar_dict(1.1)
    arrays = four_bar_dict(1.1)
    arrays["gravity"] = np.array(arrays["gravity"])
    arrays["bodies"]["crank"]["mass"] = np.float64(arrays["bodies"]["crank"]["mass"])
    assert gelenk.load(arrays).to_dict() == gelenk.load(plain).to_dict()


@pytest.mark.parametrize("ending", ["yaml", "yml", "json"])
def test_saved_scene_is_read_back_to_the_same_bits(
    ending: str, four_bar: gelenk.Scene, tmp_path: Path
) -> None:
    changed = four_bar.with_parameters({"crank.m": 1 / 3, "A.phi_start": 0.1 + 0.2})
    for scene in (four_bar, changed):
        scene.save(tmp_path / f"s.{ending}")
        assert gelenk.load(tmp_path / f"s.{ending}").to_dict() == scene.to_dict()


def test_scene_tells_what_it_is(four_bar: gelenk.Scene, four_bar_file: Path) -> None:
    assert repr(four_bar) == "<Scene FourBar: 3 bodies, 4 joints, 1 motor>"
    assert (four_bar.name, four_bar.file) == ("FourBar", str(four_bar_file))
    assert (four_bar.stop, four_bar.step, four_bar.tolerance) == (5, 1e-3, 1e-6)
    assert four_bar.report == ()


def test_parameters_change_a_copy(four_bar: gelenk.Scene) -> None:
    before = four_bar.to_dict()
    changed = four_bar.with_parameters(
        {"gravity[3]": -1.62, "A.fixed": False, "solver.integrator": "rk4", "crank.m": 2}
    )
    assert four_bar.to_dict() == before
    after = changed.to_dict()
    assert after["gravity"] == [0, 0, -1.62]
    assert after["bodies"]["crank"]["mass"] == 2
    assert after["solver"]["integrator"] == "rk4"
    assert changed.parameters["A.fixed"] is False
    assert four_bar.parameters["A.fixed"] is True


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("crank.mas", 1, "crank.mas: no such parameter; did you mean crank.m?"),
        ("crank.m", "x", "crank.m: found 'x', expected a number"),
        ("crank.m", float("nan"), "crank.m: found nan, expected a finite number"),
        ("A.fixed", "maybe", "A.fixed: found 'maybe', expected true or false"),
        (
            "solver.integrator",
            "leapfrog",
            f"solver.integrator: found 'leapfrog', expected one of {INTEGRATORS}",
        ),
        ("solver.integrator", 13, f"solver.integrator: found 13, expected one of {INTEGRATORS}"),
    ],
)
def test_parameter_that_cannot_be_is_refused(
    four_bar: gelenk.Scene, name: str, value: Any, message: str
) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        four_bar.with_parameters({name: value})
    items = sorted(four_bar_items(four_bar))
    told = str(caught.value)
    if "one of" in told:  # the order of the items is the core's
        assert sorted(told.split("one of ")[1].split(", ")) == items
        told = told.split("one of ")[0] + "one of " + ", ".join(items)
    assert told == message


def four_bar_items(scene: gelenk.Scene) -> list[str]:
    names = []
    for i in range(1, 20):
        try:
            names.append(str(scene.with_parameters({"solver.integrator": i}).parameters["solver.integrator"]))
        except gelenk.UsageError:
            return names
    raise AssertionError("more integrators than expected")


def test_impossible_value_of_a_parameter_is_told_with_its_bound(four_bar: gelenk.Scene) -> None:
    with pytest.raises(gelenk.UsageError, match=r"solver\.tolerance: found -1, expected between 1e-15 and 1"):
        four_bar.with_parameters({"solver.tolerance": -1})


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("s.txt", b"a: 1", "s.txt: found the ending .txt, expected .yaml, .yml or .json"),
        ("arm.urdf", b"<robot/>", "arm.urdf:1: found a URDF robot description, expected a scene of Gelenk "
         "(.yaml, .yml or .json); convert it to a scene with `gelenk import`"),
        ("s.yaml", b"a: \xff", "s.yaml:1: byte 4 is not UTF-8 text"),
    ],
)  # fmt: skip
def test_file_that_is_no_scene_is_refused(name: str, content: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(gelenk.SceneError) as caught:
        gelenk.load(tmp_path / name)
    assert str(caught.value) == f"{tmp_path}/{message}"


def test_missing_file_is_the_systems_own_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        gelenk.load(tmp_path / "none.yaml")
    with pytest.raises(IsADirectoryError):
        gelenk.load(tmp_path)


def test_data_that_no_file_could_hold_is_refused() -> None:
    loop: dict[str, Any] = {"gelenk": 1}
    loop["bodies"] = loop
    with pytest.raises(gelenk.SceneError, match="contains itself"):
        gelenk.load(loop)
    with pytest.raises(gelenk.SceneError, match="found a set, expected numbers"):
        gelenk.load({"bodies": {1, 2}})


def test_all_faults_are_told_at_once() -> None:
    with pytest.raises(gelenk.SceneError) as caught:
        gelenk.load("gelenk: 1\nbodies:\n  a: {mass: -1, color: red}\njoints:\n  A: {type: hinge}\n")
    assert len(caught.value.lines) >= 3
    assert str(caught.value) == "\n".join(caught.value.lines)


def test_simulation_by_hand_shows_signals_and_health(four_bar: gelenk.Scene) -> None:
    plant = gelenk.Simulation(four_bar)
    assert [(s.name, s.unit) for s in plant.inputs] == [("drive.tau", "N.m")]
    assert [s.name for s in plant.outputs][:3] == ["A.phi", "A.w", "A.a"]
    plant.initialize()
    assert plant.time == 0
    assert plant.size.degrees_of_freedom == 1
    assert plant.size.planar
    assert len(plant.independent_coordinates) == 1
    assert "loops closed at A.phi = 1.5708 rad" in plant.assembly_report()
    plant.set_input("drive.tau", 3)
    assert plant.input("drive.tau") == 3
    plant.step_to(0.1)
    assert plant.time == 0.1
    both = plant.values(["A.w", "A.phi"])
    assert both.tolist() == [plant.output("A.w"), plant.output("A.phi")]
    assert plant.values().shape == (len(plant.outputs),)
    assert plant.diagnostics["constraints.position"] < 1e-10  # m: the projection's own bound
    assert plant.diagnostics["solver.steps"] >= 1


def test_wrong_calls_are_refused_in_the_users_names(four_bar: gelenk.Scene) -> None:
    plant = gelenk.Simulation(four_bar)
    plant.initialize(1.0)
    with pytest.raises(gelenk.UsageError, match=r"drive\.f: no such input; did you mean drive\.tau\?"):
        plant.set_input("drive.f", 1)
    with pytest.raises(gelenk.UsageError, match=r"A\.ph: no such output; did you mean A\.phi"):
        plant.output("A.ph")
    with pytest.raises(gelenk.UsageError, match=r"drive\.tau.*nan"):
        plant.set_input("drive.tau", float("nan"))
    with pytest.raises(gelenk.UsageError):
        plant.step_to(0.5)
    plant.step_to(1.01)  # none of it did harm
    assert plant.time == 1.01


def test_loop_that_cannot_close_is_an_assembly_error(four_bar: gelenk.Scene) -> None:
    apart = four_bar.to_dict()
    apart["joints"]["D"]["parent"]["position"] = [9, 0, 0]  # m
    gap = math.hypot(9, 0.5) - 1.75 - 1.5  # from the tip of the upright crank, coupler and rocker in line
    with pytest.raises(gelenk.AssemblyError, match=f"cannot be closed: smallest closure error {gap:.3g} m"):
        gelenk.Simulation(apart).initialize()


def test_plants_in_threads_do_not_disturb_each_other(four_bar: gelenk.Scene) -> None:
    torques = [1.0, 2.0, 3.0, 4.0]
    alone = [run(four_bar, tau) for tau in torques]
    together: list[list[float]] = [[] for _ in torques]

    def work(i: int) -> None:
        together[i] = run(four_bar, torques[i])

    threads = [threading.Thread(target=work, args=(i,)) for i in range(len(torques))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert together == alone


def run(scene: gelenk.Scene, tau: float) -> list[float]:
    plant = gelenk.Simulation(scene)
    plant.initialize()
    plant.set_input("drive.tau", tau)
    out = []
    for k in range(200):
        plant.step_to((k + 1) * 1e-3)
        out.append(plant.output("A.phi"))
    return out


def test_one_plant_stepped_from_two_threads_takes_turns(four_bar: gelenk.Scene) -> None:
    """Steps run without Python's lock; the plant has its own."""
    plant = gelenk.Simulation(four_bar)
    plant.initialize()
    stepper = threading.Thread(target=plant.step_to, args=(1.0,))
    stepper.start()
    seen = {plant.time for _ in range(50)}
    stepper.join()
    assert seen <= {0.0, 1.0}


def test_export_holds_scene_library_and_licences(four_bar_fmu: Path) -> None:
    names = zipfile.ZipFile(four_bar_fmu).namelist()
    assert "modelDescription.xml" in names
    assert "resources/scene.json" in names
    assert any(name.startswith("binaries/linux64/") for name in names)
    assert any(name.startswith("documentation/licenses/") for name in names)


def test_export_refuses_what_it_cannot_write(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    with pytest.raises(gelenk.ExportError, match=r"x\.zip: found the ending \.zip, expected \.fmu"):
        gelenk.export_fmu(four_bar, tmp_path / "x.zip")
    with pytest.raises(gelenk.ExportError, match=r"none/x\.fmu"):
        gelenk.export_fmu(four_bar, tmp_path / "none" / "x.fmu")
    assert list(tmp_path.iterdir()) == []


def test_schema_in_the_package_is_the_readers() -> None:
    from gelenk.io import export

    shipped = Path(gelenk.__file__).parent / "schema" / "scene.schema.json"
    assert json.loads(shipped.read_text()) == json.loads(export.schema())


def test_a_simulation_describes_itself_and_is_a_context(four_bar: gelenk.Scene) -> None:
    with gelenk.Simulation(four_bar) as plant:
        plant.initialize()
        plant.step_to(0.5)
        assert repr(plant) == "<Simulation of FourBar at t = 0.5 s: 1 input, 12 outputs>"
