# SPDX-License-Identifier: BSD-3-Clause
"""Model exchange of FMI 3.0 computes what that of FMI 2.0 computes; where it does not exist, FMUs say so."""

from __future__ import annotations

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
from mechanisms import Scene

import gelenk

from .host import OK, Fmu
from .host3 import Fmu3, Slave3, expect
from .importer import Importer
from .importer3 import Importer3
from .plants import crank_rocker, driven, touching, with_circuit
from .test_fmi3 import SHIPPED, source_of
from .test_model_exchange import TORQUES

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


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        (with_circuit, "event indicators, which are variables in FMI 3.0 and not described; with FMI 2.0"),
        (driven, "this FMU is for co-simulation: "),
        (lambda: touching(2), "this FMU is for co-simulation: "),
    ],
)
def test_other_scenes_are_for_co_simulation_only(
    plant: Callable[[], Scene], words: str, tmp_path: Path
) -> None:
    found = gelenk.export_fmu(plant(), tmp_path / "x.fmu", view=False, fmi=3)
    assert fmpy.read_model_description(str(found)).modelExchange is None
    fmu = Fmu3(fmpy.extract(str(found), str(tmp_path / "extracted")))
    s = Slave3(fmu).start()
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
