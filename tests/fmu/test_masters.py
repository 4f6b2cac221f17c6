# SPDX-License-Identifier: BSD-3-Clause
"""The FMU in masters of other people gives what Gelenk's own simulation of the scene gives."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk

from .plants import crank_rocker, gyroscope

STEP, STOP = 0.01, 0.5  # s


def torque(t: float) -> float:
    return 3.0 + 2.0 * math.sin(7.0 * t)  # N m


@pytest.mark.parametrize("integrator", ["auto", "erk", "ida", "rk4"])
def test_fmpy_through_gelenk_gives_the_same_bits(integrator: str, tmp_path: Path) -> None:
    source = crank_rocker()
    source["solver"] = {"integrator": integrator}
    found = gelenk.export_fmu(source, tmp_path / "x.fmu")
    inputs = {"drive.tau": torque}
    expected = gelenk.simulate(source, stop=STOP, step=STEP, inputs=inputs)
    run = gelenk.simulate(found, stop=STOP, step=STEP, inputs=inputs)
    assert run.names == expected.names
    for name in expected.names:
        assert np.array_equal(run[name], expected[name]), name


@pytest.mark.parametrize("plant", [crank_rocker, gyroscope])
def test_fmpy_gives_the_same_run(plant: Callable[[], Scene], tmp_path: Path) -> None:
    """Its steps are differences of times: rounding of 1e-16 s in a step, so 1e-12."""
    source = plant()
    value = {"drive.tau": 3.0} if "motors" in source else {"push.f[1]": 0.7, "push.t[3]": -0.02}
    found = gelenk.export_fmu(source, tmp_path / "x.fmu")
    expected = gelenk.simulate(source, stop=STOP, step=STEP, inputs=value)
    run = fmpy.simulate_fmu(
        str(found), stop_time=STOP, output_interval=STEP, start_values=value, output=list(expected.names)
    )
    assert run["time"] == pytest.approx(expected.time, abs=1e-12)
    for name in expected.names:
        scale = 1 + np.abs(expected[name]).max()
        assert np.abs(run[name] - expected[name]).max() < 1e-12 * scale, name


def nine_sleds() -> Scene:
    """Masses of 1 to 9 kg on slides, each pushed by an input: fmpy writes derivatives of nine inputs only."""
    numbers = range(1, 10)
    return scene(
        {f"m{k}": body(float(k)) for k in numbers},
        {f"S{k}": joint("prismatic", frame("ground"), frame(f"m{k}"), axis=[1, 0, 0]) for k in numbers},
        motors={f"push{k}": {"joint": f"S{k}"} for k in numbers},
    )


def test_fmpy_interpolates_the_inputs(tmp_path: Path) -> None:
    """With `set_input_derivatives` fmpy gives the slope to the next point of its table."""
    found = gelenk.export_fmu(nine_sleds(), tmp_path / "x.fmu")
    times = STEP * np.arange(round(STOP / STEP) + 1)
    names = [f"push{k}.f" for k in range(1, 10)]
    columns = [("time", float), *((name, float) for name in names)]
    table = np.array([(t, *(torque(t) * k for k in range(1, 10))) for t in times], dtype=columns)
    expected = 1.5 * STOP**2 + 2 / 7 * STOP - 2 / 49 * math.sin(7 * STOP)  # the force, twice integrated
    for interpolate in (True, False):
        run = fmpy.simulate_fmu(
            str(found), stop_time=STOP, output_interval=STEP, input=table, set_input_derivatives=interpolate
        )
        for k in range(1, 10):
            # Straight lines leave H^2/12 of the second derivative, some 1e-3 N, twice integrated: 1e-4 m;
            # held values H/2 of the first, 14 N/s: some 1e-3 m.
            error = abs(run[f"S{k}.s"][-1] - expected)
            assert error < 1e-4 if interpolate else error > 1e-3


def test_libcosim_gives_the_same_run(tmp_path: Path) -> None:
    """One slave under a fixed step of 10 ms: libcosim's clock counts nanoseconds, exact here."""
    execution_module = pytest.importorskip("libcosimpy.CosimExecution")
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    found = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")
    expected = gelenk.simulate(crank_rocker(), stop=STOP, step=STEP, inputs={"drive.tau": 3.0})
    description = fmpy.read_model_description(str(found))
    reference = {v.name: v.valueReference for v in description.modelVariables}

    execution = execution_module.CosimExecution.from_step_size(step_size=STEP * 1e9)
    slave = CosimLocalSlave(fmu_path=str(found), instance_name="plant")
    index = execution.add_local_slave(local_slave=slave)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    manipulator = CosimManipulator.create_override()
    execution.add_manipulator(manipulator=manipulator)
    # The value an override sets is there from the first step on.
    assert execution.real_initial_value(index, reference["drive.tau"], 3.0)
    assert manipulator.slave_real_values(index, [reference["drive.tau"]], [3.0])
    assert CosimVariableType.REAL.value == 0

    references = [reference[name] for name in expected.names]
    for k in range(1, len(expected)):
        assert execution.step(), f"libcosim stopped at step {k}"
        values = np.array(observer.last_real_values(index, references))
        for name, value in zip(expected.names, values, strict=True):
            scale = 1 + np.abs(expected[name]).max()
            assert abs(value - expected[name][k]) < 1e-12 * scale, (name, k)
