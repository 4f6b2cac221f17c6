# SPDX-License-Identifier: BSD-3-Clause
"""Model exchange of FMI 3.0 computes what that of FMI 2.0 computes; where it does not exist, FMUs say so."""

from __future__ import annotations

import ctypes
import random
import zipfile
from collections.abc import Callable
from ctypes import c_bool
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from mechanisms import GRAVITY, Scene

import gelenk

from .host import ERROR, OK, Fmu
from .host3 import Fmu3, Slave3, expect
from .importer import Importer
from .importer3 import Importer3
from .plants import crank_rocker, driven, two_cylinders, with_circuit
from .test_fmi3 import SHIPPED, source_of
from .test_model_exchange import TORQUES
from .test_model_exchange_events import slide

SMOOTH = ["crank_rocker", "gyroscope", *SHIPPED]


@pytest.fixture(scope="module", params=SMOOTH)
def both(
    request: pytest.FixtureRequest, root: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Path]:
    """The FMUs of a scene for both versions."""
    folder = tmp_path_factory.mktemp(request.param)
    source = source_of(request.param, root)
    return (
        gelenk.export_fmu(source, folder / f"{request.param}.fmu", view=False),
        gelenk.export_fmu(source, folder / "fmi3.fmu", view=False, fmi=3),
    )


def test_evaluations_and_events_are_bitwise_those_of_fmi_2(both: tuple[Path, Path]) -> None:
    """Steps of Euler's method, completed or not, with inputs that jump at events."""
    old = Importer(Fmu(fmpy.extract(str(both[0])))).start()
    new = Importer3(Fmu3(fmpy.extract(str(both[1])))).start()
    assert new.count("ContinuousStates") == old.size
    assert new.count("EventIndicators") == 0
    assert new.nominals() == old.nominals()
    inputs = [name for name, v in new.fmu.variables.items() if v.causality == "input"]
    draw, t = random.Random(7), 0.0
    for k in range(30):
        x, rates = old.states(), old.rates()
        assert (new.states(), new.rates(), new.outputs()) == (x, rates, old.outputs())
        h = draw.uniform(1e-4, 2e-3)
        t += h
        ahead = [a + h * b for a, b in zip(x, rates, strict=True)]
        old.go_to(t, ahead)
        new.go_to(t, ahead)
        if k % 2 == 0:
            assert new.completed() == old.completed()
        if k % 5 == 0:
            values = {name: draw.uniform(-0.1, 0.1) for name in inputs}
            assert old.set(values) == new.set(values) == OK
            old.enter_event_mode()
            new.enter_event_mode()
            expected, found = old.event(), new.event()
            assert found.states_changed == bool(expected.states_changed)
            assert found.next_time == (expected.next_event_time if expected.next_event_time_defined else None)
            old.go_on()
            new.go_on()
    old.free()
    new.free()


def test_fmpy_integrates_both_alike(both: tuple[Path, Path]) -> None:
    """CVODE in fmpy's own loop for model exchange, 50 output points."""
    description = fmpy.read_model_description(str(both[0]))
    step = float(description.defaultExperiment.stepSize)
    runs = [
        fmpy.simulate_fmu(
            str(path),
            fmi_type="ModelExchange",
            start_values=TORQUES.get(both[0].stem, {}),
            stop_time=50 * step,
            output_interval=step,
            relative_tolerance=1e-10,
            output=[v.name for v in description.modelVariables if v.causality == "output"],
        )
        for path in both
    ]
    assert len(runs[0]) == 51
    assert runs[0].tobytes() == runs[1].tobytes()


def test_the_description_is_of_both_kinds(both: tuple[Path, Path]) -> None:
    assert validate_fmu(str(both[1])) == []
    with zipfile.ZipFile(both[1]) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    found = root.find("ModelExchange")
    assert found is not None
    assert {name: value for name, value in found.attrib.items() if name != "modelIdentifier"} == {
        "needsCompletedIntegratorStep": "true",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "providesAdjointDerivatives": "true",
    }
    states = {v.get("derivative") for v in root.iter("Float64")} - {None}
    assert {v.get("valueReference") for v in root.iter("Float64") if v.get("reinit") == "true"} == states
    assert states


def bouncing() -> Scene:
    """Impacts on a limit, then rest."""
    return slide(0.7, GRAVITY, {"s": 1.1}, limit={"lower": 0.1, "restitution": 0.5})


@pytest.mark.parametrize(
    ("plant", "least"),
    [
        (bouncing, 2),
        (lambda: slide(friction={"coulomb": 2.0}, start={"v": 1.0}), 2),
        ("docs/gallery/cam/scene.yaml", 5),
        (with_circuit, 1),
    ],
    ids=["limit", "friction", "contact", "kink"],
)
def test_event_indicators_are_variables(
    plant: Callable[[], Scene] | str, least: int, root: Path, tmp_path: Path
) -> None:
    """Values by reference are those of fmi3GetEventIndicators; fmpy's runs are those of FMI 2.0."""
    source = root / plant if isinstance(plant, str) else plant()
    paths = [gelenk.export_fmu(source, tmp_path / f"v{v}.fmu", view=False, fmi=v) for v in (2, 3)]
    assert validate_fmu(str(paths[1])) == []
    fmu = Fmu3(fmpy.extract(str(paths[1]), str(tmp_path / "extracted")))
    names = [v.variable.name for v in fmu.description.eventIndicators]
    assert names == [f"event_indicators[{k + 1}]" for k in range(len(names))]
    new, old = Importer3(fmu).start(), Importer(Fmu(fmpy.extract(str(paths[0])))).start()
    assert new.count("EventIndicators") == len(names) == len(old.indicators()) >= least
    t = 0.0
    for _ in range(20):
        t += 1e-3
        x = [a + 1e-3 * b for a, b in zip(old.states(), old.rates(), strict=True)]
        old.go_to(t, x)
        new.go_to(t, x)
        status, values = new.read("fmi3GetEventIndicators", len(names))
        assert status == OK
        assert values == old.indicators() == new.get(names[::-1])[::-1]
    new.free()
    old.free()
    runs = [
        fmpy.simulate_fmu(
            str(path),
            fmi_type="ModelExchange",
            stop_time=2.0,
            output_interval=0.01,
            relative_tolerance=1e-10,
            output=[v.name for v in fmu.description.modelVariables if v.causality == "output"],
        )
        for path in paths
    ]
    assert runs[0].tobytes() == runs[1].tobytes()


def test_event_indicators_in_co_simulation_and_wrong_calls(tmp_path: Path) -> None:
    """They are 0 where events are passed within steps, and cannot be set; FMI 2.0 has no such variables."""
    folder = fmpy.extract(str(gelenk.export_fmu(bouncing(), tmp_path / "x.fmu", view=False, fmi=3)))
    s = Slave3(Fmu3(folder))
    first = ["event_indicators[1]"]
    assert s.enter() == OK
    assert s.get(first) == [0]
    assert s.leave() == OK
    s.step(0.0, 0.1)
    assert s.get(["event_indicators[2]", "J.s", *first])[::2] == [0, 0]
    assert s.set({first[0]: 1.0}) == ERROR
    expect(s, ERROR, ERROR, "event_indicators[1] is computed by the plant and cannot be set")
    place, number = (ctypes.c_int32 * 1)(), ctypes.c_size_t(1)
    assert s.call("fmi3GetInt32", s.references(first), number, place, number) == ERROR
    expect(s, ERROR, ERROR, "event_indicators[1] is of type Float64")
    beyond = (ctypes.c_uint32 * 1)(s.references(first)[0] + len(s.fmu.description.eventIndicators))
    assert s.call("fmi3GetFloat64", beyond, number, (ctypes.c_double * 1)(), number) == ERROR
    expect(s, ERROR, ERROR, f"value reference: found {beyond[0]}, expected less than")
    s.free()


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        (driven, "this FMU is for co-simulation: "),
        (two_cylinders, "this FMU is for co-simulation: contacts are solved in time steps"),
    ],
)
def test_other_scenes_are_for_co_simulation_only(
    plant: Callable[[], Scene], words: str, tmp_path: Path
) -> None:
    found = gelenk.export_fmu(plant(), tmp_path / "x.fmu", view=False, fmi=3)
    assert fmpy.read_model_description(str(found)).modelExchange is None
    fmu = Fmu3(fmpy.extract(str(found), str(tmp_path / "extracted")))
    s = Slave3(fmu).start()
    s.log.clear()  # with co-simulation, time steps are warned of
    token, resources = fmu.description.instantiationToken, str(fmu.folder / "resources")
    arguments = [b"plant", token.encode(), resources.encode(), c_bool(False), c_bool(False), None, s._logger]
    assert fmu.library.fmi3InstantiateModelExchange(*arguments) is None
    expect(s, 3, 3, "fmi3InstantiateModelExchange: this FMU is for co-simulation: ", words)
    s.free()


def test_derivatives_from_both_sides_are_of_one_matrix(tmp_path: Path) -> None:
    """At states that the importer sets. 1e-12 of the sum of the magnitudes."""
    fmu = Fmu3(fmpy.extract(str(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu", view=False, fmi=3))))
    s = Importer3(fmu).start()
    s.go_to(0.1, [a + 0.2 for a in s.states()])
    unknowns, knowns = [*fmu.outputs, "der(A.w)"], ["drive.tau", "A.phi", "A.w"]
    rng = np.random.default_rng(5)
    v, w = rng.normal(size=len(unknowns)), rng.normal(size=len(knowns))
    forward = s.sensitivity("fmi3GetDirectionalDerivative", unknowns, knowns, w.tolist(), len(unknowns))
    adjoint = s.sensitivity("fmi3GetAdjointDerivative", unknowns, knowns, v.tolist(), len(knowns))
    magnitude = np.abs(v) @ np.abs(forward)
    assert (
        abs(v @ np.asarray(forward, dtype=float) - np.asarray(adjoint, dtype=float) @ w) < 1e-12 * magnitude
    )
    s.free()
