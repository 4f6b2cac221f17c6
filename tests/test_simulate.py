# SPDX-License-Identifier: BSD-3-Clause
"""gelenk.simulate: inputs, times, tables, the same for a scene and for its FMU."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.simulation import inputs, run

SINE = "drive.tau"


def sine(t: float) -> float:
    return 3 + math.sin(7 * t)


@pytest.mark.parametrize(
    ("stop", "step", "count"),
    [
        (0.3, 0.1, 4),
        (1.1, 0.1, 12),
        (5, 0.001, 5001),
        (1, 0.3, 5),
        (0, 0.1, 1),
        (0.05, 0.1, 2),
        (4.35, 0.01, 436),
    ],
)
def test_times_are_multiples_of_the_step_and_end_at_stop(stop: float, step: float, count: int) -> None:
    times = run.grid(stop, step)
    assert len(times) == count
    assert times[-1] == stop
    assert times[:-1].tolist() == [k * step for k in range(count - 1)]


@pytest.mark.parametrize(
    ("stop", "step"), [(-1, 0.1), (math.nan, 0.1), (1, 0), (1, -1), (1, math.inf), (1, 1e-12)]
)
def test_span_that_cannot_be_is_refused(four_bar: gelenk.Scene, stop: float, step: float) -> None:
    with pytest.raises(gelenk.UsageError, match=r"^(stop|step): "):
        gelenk.simulate(four_bar, stop=stop, step=step)


def test_fmu_gives_the_bits_of_the_scene(four_bar: gelenk.Scene, four_bar_fmu: Path) -> None:
    """One core behind both; the FMU passes every number through XML and C."""
    args: dict[str, Any] = {
        "stop": 0.5,
        "step": 1e-3,
        "inputs": {SINE: sine},
        "parameters": {"A.phi_start": 1.2, "gravity[3]": -1.62, "A.damping": 0.3},
    }
    for more in ({}, {"integrator": "ida", "tolerance": 1e-8}, {"integrator": "rk4"}):
        scene = gelenk.simulate(four_bar, **args, **more)
        fmu = gelenk.simulate(four_bar_fmu, **args, **more)
        assert scene.names == fmu.names
        assert scene.units == fmu.units
        assert scene.table.tolist() == fmu.table.tolist()


def test_result_is_a_table_by_name(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    result = gelenk.simulate(four_bar, stop=0.02, outputs=["A.phi", "constraints.position", "D.w"])
    assert result.names == ("A.phi", "constraints.position", "D.w")
    assert result.table.dtype.names == ("time", *result.names)
    assert (result.table["D.w"] == result["D.w"]).all()
    assert result.units["D.w"] == "rad/s"
    assert len(result) == 21
    assert "loops closed" in result.assembly_report
    with pytest.raises(gelenk.UsageError, match=r"D\.phi: no such output"):
        result["D.phi"]
    result.to_csv(tmp_path / "r.csv")
    with (tmp_path / "r.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["time", *result.names]
    assert [tuple(map(float, row)) for row in rows[1:]] == result.table.tolist()  # to the last bit


def test_diagnostics_are_read_in_the_order_asked_for(four_bar: gelenk.Scene, four_bar_fmu: Path) -> None:
    names = ["energy.total", "A.phi", "constraints.velocity", "energy.kinetic", "A.w"]
    table = gelenk.simulate(four_bar, stop=0.01, outputs=names)
    for name in names:
        assert (table[name] == gelenk.simulate(four_bar_fmu, stop=0.01, outputs=[name])[name]).all()


def test_every_kind_of_input_means_the_same(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    """A ramp of 2 N m/s from 1 N m on is the same ramp however it is told: the sampling is the run's."""
    times = np.array([0.0, 0.5])
    table = np.array([(0.0, 1.0), (0.5, 2.0)], dtype=[("time", float), (SINE, float)])
    file = tmp_path / "in.csv"
    file.write_text("time, drive.tau\n0, 1\n0.5, 2\n")
    kinds: list[Any] = [
        {SINE: lambda t: 1 + (t - 0.0) * (1.0 / 0.5)},
        {SINE: (times, [1, 2])},
        table,
        file,
        str(file),
    ]
    first, *others = [gelenk.simulate(four_bar, stop=0.5, step=0.01, inputs=kind) for kind in kinds]
    for other in others:
        # round-off of the interpolation grows with the motion: some 100 eps over half a second
        assert np.abs(other["A.phi"] - first["A.phi"]).max() < 1e-13


def test_constant_input_is_a_parameter_too(four_bar: gelenk.Scene) -> None:
    a = gelenk.simulate(four_bar, stop=0.1, inputs={SINE: 3})
    b = gelenk.simulate(four_bar, stop=0.1, parameters={SINE: "3"})
    assert a.table.tolist() == b.table.tolist()
    with pytest.raises(gelenk.UsageError, match="given twice, as input and as parameter"):
        gelenk.simulate(four_bar, stop=0.1, inputs={SINE: 3}, parameters={SINE: 3})


def test_table_is_held_outside_and_jumps_where_a_time_repeats() -> None:
    f = inputs.functions({"u": ([1, 2, 2, 3], [10, 20, 50, 40])}, ["u"])["u"]
    assert [f(t) for t in (0, 1, 1.5, 1.999, 2, 2.5, 3, 9)] == pytest.approx(
        [10, 10, 15, 19.99, 50, 45, 40, 40], abs=1e-12
    )


def test_held_input_is_sampled_at_the_start_of_a_step(four_bar: gelenk.Scene) -> None:
    asked: list[float] = []

    def torque(t: float) -> float:
        asked.append(t)
        return 3.0

    gelenk.simulate(four_bar, stop=0.05, step=0.02, inputs={SINE: torque}, hold=[SINE])
    assert asked == [0.0, 0.0, 0.02, 0.04]  # to start consistently, then once a step


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,drive.ta\n0,1\n", "in.csv: drive.ta: no such input; did you mean drive.tau?"),
        ("t,drive.tau\n0,1\n", "in.csv: found the columns t, drive.tau, expected a column time"),
        ("time,drive.tau\n0,x\n1,\n", "in.csv:2: drive.tau: found 'x', expected a number\n"
         "in.csv:3: drive.tau: found '', expected a number"),
        ("time,drive.tau\n0,nan\n", "in.csv:2: drive.tau: found 'nan', expected a number"),
        ("time,drive.tau\n0\n", "in.csv:2: found 1 cells, expected 2"),
        ("time,drive.tau\n1,0\n0.5,0\n", "in.csv: drive.tau: times decrease from 1 s to 0.5 s (row 2)"),
        ("time,drive.tau,drive.tau\n1,0,0\n", "in.csv:1: found column 'drive.tau' twice, expected it once"),
        ("time,drive.tau\n",
         "in.csv: found 1 lines, expected a header line and at least one line of numbers"),
    ],
)  # fmt: skip
def test_table_that_is_no_input_is_refused(
    four_bar: gelenk.Scene, text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("in.csv").write_text(text)
    with pytest.raises(gelenk.UsageError) as caught:
        gelenk.simulate(four_bar, stop=0.01, inputs="in.csv")
    assert str(caught.value) == message


@pytest.mark.parametrize("plant", ["scene", "fmu"])
@pytest.mark.parametrize(
    ("args", "message"),
    [
        (
            {"parameters": {"A.fi_start": 1}},
            "A.fi_start: no such parameter or input; did you mean A.phi_start",
        ),
        ({"inputs": {"drive.f": 1}}, "drive.f: no such input; did you mean drive.tau?"),
        ({"inputs": {SINE: "x"}}, "drive.tau: found 'x', expected a number, a function of time"),
        ({"inputs": {SINE: math.nan}}, "drive.tau: found nan, expected a finite number"),
        ({"inputs": {SINE: ([0, 1], [1])}}, "drive.tau: found times of shape (2,) and values of shape (1,)"),
        ({"outputs": ["A.psi"]}, "A.psi: no such output; did you mean A.phi"),
        ({"outputs": ["A.phi", "A.phi"]}, "A.phi: found twice, expected once"),
        ({"tolerance": 2}, "tolerance: found 2, expected a number between 0 and 1"),
        ({"integrator": "leapfrog"}, "solver.integrator: found 'leapfrog', expected one of "),
        (
            {"parameters": {"solver.tolerance": -1}},
            "solver.tolerance: found -1, expected between 1e-15 and 1",
        ),
        ({"parameters": {"A.fixed": "perhaps"}}, "A.fixed: found 'perhaps', expected true or false"),
    ],
)
def test_wrong_arguments_are_refused(
    four_bar: gelenk.Scene, four_bar_fmu: Path, plant: str, args: dict[str, Any], message: str
) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        gelenk.simulate(four_bar if plant == "scene" else four_bar_fmu, stop=0.01, **args)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("plant", ["scene", "fmu"])
def test_failed_step_leaves_the_rows_until_then(
    four_bar: gelenk.Scene, four_bar_fmu: Path, plant: str
) -> None:
    """No integrator follows a torque of 1e100 N m, set at t = 0.005 s."""
    torque = {SINE: lambda t: 1e100 if t > 0.0045 else 3.0}
    with pytest.raises(gelenk.StepError, match=r"state is unchanged at t = 0\.005 s") as caught:
        gelenk.simulate(four_bar if plant == "scene" else four_bar_fmu, stop=0.1, inputs=torque)
    result = caught.value.result
    assert result is not None
    assert result.time.tolist() == [k * 1e-3 for k in range(6)]
    assert np.isfinite(result["A.phi"]).all()


def test_start_values_that_cannot_be_assembled_are_told_in_the_files_name(four_bar_fmu: Path) -> None:
    with pytest.raises(gelenk.AssemblyError) as caught:
        gelenk.simulate(four_bar_fmu, parameters={"D.phi_start": -1.5, "D.fixed": True})
    assert str(caught.value).startswith(
        f"{four_bar_fmu}: loop through C cannot be closed: smallest closure error "
    )


def test_progress_hears_of_every_step(four_bar: gelenk.Scene) -> None:
    heard: list[tuple[float, float]] = []
    gelenk.simulate(four_bar, stop=0.05, step=0.02, progress=lambda t, stop: heard.append((t, stop)))
    assert heard == [(0.02, 0.05), (0.04, 0.05), (0.05, 0.05)]


def test_file_that_is_no_fmu_is_refused(tmp_path: Path) -> None:
    for content in (b"", b"PK\x03\x04 but no more"):
        (tmp_path / "x.fmu").write_bytes(content)
        with pytest.raises(gelenk.UsageError, match=r"x\.fmu: not an FMU \(a zip file"):
            gelenk.simulate(tmp_path / "x.fmu")
    with pytest.raises(FileNotFoundError):
        gelenk.simulate(tmp_path / "none.fmu")
    (tmp_path / "d.fmu").mkdir()
    with pytest.raises(IsADirectoryError):
        gelenk.simulate(tmp_path / "d.fmu")


@pytest.mark.parametrize(
    ("kind", "name", "signal", "bound"),
    [
        # Through five values, H = 0.01 s: the angle is up to 0.0035 H^5 max|f^(5)| / 120 = 1e-11 rad off in a
        # step, its speed at the end 0.09 H^4 max|f^(5)| / 120 = 4e-8 rad/s, an impact that B feels.
        ("position", "follow.phi_ref", lambda t: 0.5 * math.sin(2 * math.pi * t), 2e-7),
        ("speed", "follow.w_ref", lambda t: math.pi * math.cos(2 * math.pi * t), 1e-9),
    ],
)
def test_inputs_that_are_motions_follow_their_functions(
    kind: str, name: str, signal: Callable[[float], float], bound: float, tmp_path: Path
) -> None:
    def hinges(**motion: Any) -> dict[str, Any]:
        link = {"mass": 1.0, "com": [0, 0, -0.5], "inertia": [0.1, 0.1, 0.1]}
        return {
            "gelenk": 1,
            "gravity": [0, 0, -9.81],
            "bodies": {"a": link, "b": link},
            "joints": {
                "A": {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "a"},
                "B": {"type": "revolute", "axis": [0, 1, 0], "child": "b",
                      "parent": {"body": "a", "position": [0, 0, -1]}},
            },
            "constraints": {"follow": {"type": "motion", "joint": "A", **motion}},
            "experiment": {"stop": 1.0, "step": 0.01, "tolerance": 1e-10},
        }  # fmt: skip

    expected = gelenk.simulate(hinges(sine={"amplitude": 0.5, "frequency": 1}))
    source = hinges(input=kind)
    for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu")):
        found = gelenk.simulate(plant, inputs={name: signal})
        for output in ("A.phi", "A.w", "B.phi"):
            assert found[output] == pytest.approx(expected[output], abs=bound)
