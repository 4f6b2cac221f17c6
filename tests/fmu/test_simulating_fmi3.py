# SPDX-License-Identifier: BSD-3-Clause
"""`gelenk.simulate` and `gelenk.linearize` of FMUs of FMI 3.0 give what they give of FMI 2.0, to the bit."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
import warned

import gelenk

from .plants import crank_rocker, cranked, gyroscope, two_cylinders, with_circuit
from .test_fmi3_exchange import bouncing

pytestmark = warned.GUESSES

SOURCES = {
    "crank_rocker": (crank_rocker, {"drive.tau": 0.4}),
    "gyroscope": (gyroscope, {}),
    "circuit": (with_circuit, {}),
    "bouncing": (bouncing, {}),
}


@pytest.fixture(scope="module", params=SOURCES)
def exports(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Path, dict[str, float]]:
    source, inputs = SOURCES[request.param]
    folder = tmp_path_factory.mktemp(request.param)
    old, new = (gelenk.export_fmu(source(), folder / f"v{v}.fmu", view=False, fmi=v) for v in (2, 3))
    return old, new, inputs


@pytest.mark.parametrize("kind", ["cs", "me"])
def test_runs_are_bitwise_those_of_fmi_2(exports: tuple[Path, Path, dict[str, float]], kind: str) -> None:
    old, new, inputs = exports
    runs = [
        gelenk.simulate(fmu, stop=0.5, step=0.01, kind=kind, inputs=inputs, tolerance=1e-8)
        for fmu in (old, new)
    ]
    assert runs[0].names == runs[1].names
    assert len(runs[0].names) > 2
    for name in runs[0].names:
        assert runs[0][name].tobytes() == runs[1][name].tobytes(), name
        assert runs[0].units[name] == runs[1].units[name]


@pytest.mark.filterwarnings("ignore:.*is not an equilibrium:gelenk.OperatingPointWarning")
def test_linear_models_are_those_of_fmi_2(exports: tuple[Path, Path, dict[str, float]]) -> None:
    models = [gelenk.linearize(fmu) for fmu in exports[:2]]
    for matrix in "ABCD":
        assert np.array_equal(getattr(models[0], matrix), getattr(models[1], matrix))
    assert models[0].state_labels == models[1].state_labels


def test_parameters_of_all_types(tmp_path: Path) -> None:
    """Numbers, choices by name, whole numbers and truth values."""
    settings: dict[str, float | str | bool] = {
        "crank.m": 2.5, "solver.integrator": "rk4", "solver.max_evaluations": 4000, "B.fixed": False,
    }  # fmt: skip
    fmus = [gelenk.export_fmu(crank_rocker(), tmp_path / f"v{v}.fmu", view=False, fmi=v) for v in (2, 3)]
    runs = [gelenk.simulate(fmu, stop=0.2, parameters=settings) for fmu in fmus]
    plain = gelenk.simulate(fmus[1], stop=0.2)
    for name in runs[0].names:
        assert runs[0][name].tobytes() == runs[1][name].tobytes()
    assert (runs[1]["A.phi"] != plain["A.phi"]).any()


def test_inputs_that_prescribe_motions_are_values(tmp_path: Path) -> None:
    """FMI 3.0 has no derivatives of inputs in co-simulation: an accuracy of first order."""
    fmu = gelenk.export_fmu(cranked(), tmp_path / "x.fmu", view=False, fmi=3)
    run = gelenk.simulate(fmu, stop=0.2, step=1e-3, inputs={"crank.w_ref": lambda t: 1.0 + t})
    turned = run["A.phi"][-1] - run["A.phi"][0]
    assert turned == pytest.approx(0.2 + 0.2**2 / 2, abs=1e-3)


@pytest.mark.filterwarnings("ignore:nothing moves:gelenk.StartWarning")
def test_warnings_and_errors_are_sentences(tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(two_cylinders(), tmp_path / "x.fmu", view=False, fmi=3)
    with pytest.warns(gelenk.StartWarning, match="contacts are solved in time steps"):
        gelenk.simulate(fmu, stop=0.01)
    with pytest.raises(
        gelenk.UsageError, match=r"x\.fmu: found an FMU of FMI 3\.0 for co-simulation, expected"
    ):
        gelenk.simulate(fmu, kind="me")
    good = gelenk.export_fmu(crank_rocker(), tmp_path / "y.fmu", view=False, fmi=3)
    with pytest.raises(gelenk.UsageError, match=r"^crank\.m: found -1, expected at least 0 kg"):
        gelenk.simulate(good, parameters={"crank.m": -1.0})


def test_arrays_are_refused_by_name(tmp_path: Path) -> None:
    """Of other tools: ours are scalars."""
    fmu = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu", view=False, fmi=3)
    other = tmp_path / "arrays.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            if name == "modelDescription.xml":
                begin = data.index(b'<Float64 name="A.phi"')
                end = data.index(b"/>", begin)
                data = data[:end] + b'><Dimension start="3"/></Float64>' + data[end + 2 :]
            new.writestr(name, data)
    with pytest.raises(gelenk.UsageError, match=r"found the array A\.phi, expected scalar variables"):
        gelenk.simulate(other)
