# SPDX-License-Identifier: BSD-3-Clause
"""gelenk.sweep: its runs are those of gelenk.simulate, whoever makes them."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import gelenk

RK4 = {"solver.integrator": "rk4"}


def same(a: xr.Dataset, b: xr.Dataset) -> bool:
    """Whether two results are equal to the bit, attributes included."""
    floats = [name for name in a.data_vars if a[name].dtype == float]
    return a.identical(b) and all(a[n].values.tobytes() == b[n].values.tobytes() for n in floats)


@pytest.mark.parametrize(
    ("varied", "parameter"),
    [
        ("crank.m", "crank.m"),
        ("gravity[3]", "gravity[3]"),
        ("A.phi_start", "A.phi_start"),
        ("solver.tolerance", "solver.tolerance"),
        ("B.parent.position[1]", "B.parent.position[1]"),  # not listed by the scene: its path in the file
        ("coupler.com[1]", "coupler.com[1]"),
        ("drive.tau", "drive.tau"),
    ],
)
def test_runs_are_those_of_simulate(four_bar: gelenk.Scene, varied: str, parameter: str) -> None:
    values = {
        "gravity[3]": [-9.0, -3.0], "A.phi_start": [1.5, 1.6], "solver.tolerance": [1e-5, 1e-7],
        "B.parent.position[1]": [0.49, 0.51], "coupler.com[1]": [0.87, 0.88], "drive.tau": [1.0, 4.0],
    }.get(varied, [0.9, 1.1])  # fmt: skip
    found = gelenk.sweep(four_bar, {varied: values}, outputs=["A.*"], stop=0.2, step=0.01)
    listed = [name for name in (parameter,) if name not in four_bar.parameters and name != "drive.tau"]
    data = four_bar.to_dict()
    scene = gelenk.load({**data, "parameters": [*data["parameters"], *listed]})
    for i, value in enumerate(values):
        run = gelenk.simulate(scene, parameters={parameter: value}, outputs=["A.*"], stop=0.2, step=0.01)
        for name in run.names:
            assert found[name].values[i].tobytes() == run[name].tobytes()
    assert found["A.phi"].dims == (varied, "time")
    assert found["A.phi"].attrs["units"] == "rad"
    assert found["error"].values.tolist() == ["", ""]


def test_a_path_is_another_name_of_a_listed_parameter(four_bar: gelenk.Scene) -> None:
    """The scene lists crank.mass; its parameter is called crank.m."""
    by_path = gelenk.sweep(four_bar, {"crank.mass": [0.9, 1.1]}, outputs={"A.w": "last"}, stop=0.1)
    by_name = gelenk.sweep(four_bar, {"crank.m": [0.9, 1.1]}, outputs={"A.w": "last"}, stop=0.1)
    assert by_path["A.w.last"].values.tolist() == by_name["A.w.last"].values.tolist()
    assert by_path["crank.mass"].attrs["units"] == "kg"


def test_motions_are_followed_as_in_simulate() -> None:
    """A prescribed motion that differs between runs is at rest; a common one is a polynomial in each step."""
    scene = {
        "gelenk": 1, "name": "Driven", "gravity": [0, 0, -9.81],
        "bodies": {"arm": {"mass": 1, "com": [0.5, 0, 0]}, "tip": {"mass": 0.3, "com": [0.2, 0, 0]}},
        "joints": {
            "A": {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "arm"},
            "B": {"type": "revolute", "axis": [0, 1, 0], "child": "tip",
                  "parent": {"body": "arm", "position": [1, 0, 0]}},
        },
        "constraints": {"a": {"type": "motion", "joint": "A", "input": "position"}},
    }  # fmt: skip
    name = gelenk.Simulation(scene).inputs[0].name
    still = gelenk.sweep(scene, {name: [0.1, 0.2]}, outputs=["B.phi"], stop=0.1, step=0.01)
    moved = gelenk.sweep(scene, {"gravity[3]": [-1.0, -2.0]}, inputs={name: math.sin}, outputs=["B.phi"],
                         stop=0.1, step=0.01)  # fmt: skip
    for i in range(2):
        run = gelenk.simulate(scene, inputs={name: 0.1 * (i + 1)}, outputs=["B.phi"], stop=0.1, step=0.01)
        # simulate interpolates the constant by a polynomial whose coefficients are zero but for rounding,
        # 1e-16 / h^4 in the fourth derivative, of which h^4 / 24 acts.
        assert np.allclose(still["B.phi"].values[i], run["B.phi"], rtol=0, atol=1e-12)
        run = gelenk.simulate(scene, inputs={name: math.sin}, parameters={"gravity[3]": -1.0 - i},
                              outputs=["B.phi"], stop=0.1, step=0.01)  # fmt: skip
        assert moved["B.phi"].values[i].tobytes() == run["B.phi"].tobytes()


def test_an_fmu_gives_the_numbers_of_its_scene(four_bar: gelenk.Scene, four_bar_fmu: Path) -> None:
    parameters = {"crank.m": [0.9, 1.0, 1.1], "drive.tau": [1.0, 2.0], **RK4}
    options: dict[str, Any] = {"outputs": {"A.phi": ["last", "trajectory"]}, "stop": 0.1}
    scene = gelenk.sweep(four_bar, parameters, **options)
    fmu = gelenk.sweep(four_bar_fmu, parameters, workers=2, **options)
    assert fmu["A.phi"].values.tobytes() == scene["A.phi"].values.tobytes()
    assert fmu["A.phi.last"].values.tolist() == scene["A.phi.last"].values.tolist()
    assert fmu.attrs["plant_sha256"] != scene.attrs["plant_sha256"]


def test_the_number_of_workers_changes_nothing(four_bar: gelenk.Scene) -> None:
    def made(workers: int) -> xr.Dataset:
        return gelenk.sweep(
            four_bar, {"crank.m": "normal(1, 0.05)", "A.damping": "uniform(0, 0.2)", **RK4}, design="latin",
            samples=40, seed=4, outputs={"A.phi": ["rms", "trajectory"]}, stop=0.1, workers=workers,
        )  # fmt: skip

    assert same(made(1), made(3))


def test_one_run_without_anything_that_differs(four_bar: gelenk.Scene) -> None:
    found = gelenk.sweep(four_bar, RK4, outputs={"A.phi": "last"}, stop=0.0)
    assert found["A.phi.last"].shape == ()
    assert float(found["A.phi.last"]) == pytest.approx(math.pi / 2)


def test_failures_are_rows(four_bar: gelenk.Scene) -> None:
    """A wrong value, a loop that cannot be closed, a failed step, a function that raises."""

    def picky(_: Any, x: Any) -> float:
        if x[0] > 1.59:
            raise ValueError("too far")
        return float(x[0])

    found = gelenk.sweep(
        four_bar,
        {"crank.m": [1.0, -1.0, 1.0, 1.0, 1.0], "B.parent.position[1]": [0.5, 0.5, 50.0, 0.5, 0.5],
         "A.phi_start": [1.5, 1.5, 1.5, 1.6, 1.5], "solver.max_evaluations": [9999, 9999, 9999, 9999, 2]},
        design="list", outputs={"A.phi": [picky, "trajectory", "max"]}, stop=0.01,
    )  # fmt: skip
    errors = found["error"].values.tolist()
    assert errors[0] == ""
    assert "crank.m: found -1, expected " in errors[1]
    assert "loop" in errors[2]
    assert errors[3] == "A.phi.picky: ValueError: too far"
    assert "evaluations" in errors[4]
    assert np.isnan(found["A.phi.max"].values).tolist() == [False, True, True, False, True]
    assert not np.isnan(found["A.phi"].values[0]).any()
    assert np.isnan(found["A.phi"].values[4]).tolist() == [False] + 10 * [True]  # up to where it came


def test_a_parameter_without_effect_on_the_outputs_is_checked(four_bar: gelenk.Scene) -> None:
    data = four_bar.to_dict()
    data["bodies"]["alone"] = {"mass": 1, "com": [1, 0, 0]}
    data["joints"]["Z"] = {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "alone"}
    data["parameters"].append("alone.mass")
    found = gelenk.sweep(data, {"alone.m": [1.0, -1.0]}, outputs={"A.phi": "last"}, stop=0.01)
    assert [bool(error) for error in found["error"].values.tolist()] == [False, True]


def test_a_run_that_takes_too_long_ends(four_bar: gelenk.Scene) -> None:
    found = gelenk.sweep(
        four_bar, {"crank.m": [1.0], **RK4}, outputs={"A.phi": "last"}, stop=300.0, max_run_time=0.05
    )
    assert "the run has taken longer than 0.05 s; it had reached t = " in str(found["error"].values[0])


def test_a_sweep_that_takes_too_long_ends(four_bar: gelenk.Scene) -> None:
    found = gelenk.sweep(
        four_bar, {"crank.m": np.linspace(0.9, 1.1, 1000), **RK4}, outputs={"A.phi": "last"}, stop=100.0,
        max_time=0.5,
    )  # fmt: skip
    errors = set(found["error"].values.tolist()) - {""}
    assert errors == {"the run was not made within the time of the sweep, 0.5 s"}


def test_progress_reaches_the_number_of_runs(four_bar: gelenk.Scene) -> None:
    seen: list[tuple[int, int]] = []
    gelenk.sweep(
        four_bar, {"crank.m": [0.9, 1.0, 1.1]}, outputs={"A.phi": "last"}, stop=0.01,
        progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    assert seen[-1] == (3, 3)
    assert seen == sorted(seen)


def test_provenance(four_bar: gelenk.Scene) -> None:
    found = gelenk.sweep(
        four_bar, {"crank.m": "normal(1, 0.1)", "A.damping": 0.2, **RK4}, design="sobol", samples=4, seed=9,
        outputs={"A.phi": "last"}, stop=0.01, inputs={"drive.tau": 1.0},
    )  # fmt: skip
    attributes = found.attrs
    assert attributes["gelenk_version"] == gelenk.__version__
    assert (attributes["design"], attributes["samples"], attributes["seed"]) == ("sobol", 4, 9)
    assert (attributes["constant:A.damping"], attributes["constant:solver.integrator"]) == (0.2, "rk4")
    assert len(attributes["plant_sha256"]) == 2 * hashlib.sha256().digest_size
    assert found["crank.m"].dims == ("run",)


def test_results_are_written_and_read(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    found = gelenk.sweep(
        four_bar, {"crank.m": [0.9, -1.0]}, outputs={"A.phi": ["max", "trajectory"]}, stop=0.01
    )
    found.to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "x.nc", engine="h5netcdf") as read:
        assert read["A.phi"].values.tobytes() == found["A.phi"].values.tobytes()
        assert read["error"].values.tolist() == found["error"].values.tolist()


@pytest.mark.parametrize(
    ("parameters", "options", "sentence"),
    [
        ({"crank.mas": [1, 2]}, {}, "crank.mas: no such parameter or input; did you mean"),
        ({"crank.com": [1, 2]}, {}, "crank.com: found an array of 3 numbers, expected one of crank.com[1], "),
        ({"crank.m": ["a", "b"]}, {}, "crank.m: found 'a', expected a number"),
        ({"solver.integrator": ["rk4", "rk5"]}, {}, "solver.integrator: found 'rk5', expected one of "),
        ({"drive.tau": [1, 2]}, {"inputs": {"drive.tau": 1}}, "drive.tau: given twice"),
        ({"solver.integrator": ["rk4"]}, {"integrator": "ida"}, "solver.integrator: given twice"),
        ({"crank.m": [1]}, {"max_time": 0}, "max_time: found 0, expected more than 0 s"),
        ({"crank.m": [1]}, {"workers": 0}, "workers: found 0, expected at least 1"),
        ({"crank.m": [1]}, {"outputs": ["A.x"]}, "A.x: no such output"),
        (
            {"crank.m": [1]},
            {"outputs": {"A.phi": "mode"}},
            "A.phi: found the reduction 'mode', expected traj",
        ),
        ({"crank.m": [1]}, {"cluster": "tcp://127.0.0.1:9"}, "where no scheduler answers"),
    ],
)
def test_wrong_calls_say_what_is_expected(
    four_bar: gelenk.Scene, parameters: Any, options: Any, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gelenk.sweeps.workers.CONNECT", 0.5)
    with pytest.raises(gelenk.UsageError) as caught:
        gelenk.sweep(four_bar, parameters, **{"outputs": {"A.phi": "last"}, "stop": 0.01} | options)
    assert sentence in str(caught.value)
