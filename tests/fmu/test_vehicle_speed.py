# SPDX-License-Identifier: BSD-3-Clause
"""The FMU of a vehicle is ten times faster than real time; `make clocks` measures it."""

from __future__ import annotations

import resource
import subprocess
from pathlib import Path

import pytest
from models.car import FILE

import gelenk

from .c_hosts import compiled, extracted

SECONDS = 3  # of driving: the front wheels meet the bump at 0.45 s


@pytest.mark.clock
def test_a_car_drives_ten_times_faster_than_real_time(root: Path, tmp_path: Path) -> None:
    """In steps of 1 ms with a torque of the engine that changes in each, over a bump.

    The first eight outputs are read, coordinates and speeds; all 233 cost another evaluation.
    """
    host = compiled("real_time_host", tmp_path, where=root / "benchmarks")
    if host is None:
        pytest.skip("no C compiler")
    car = gelenk.load(FILE).with_parameters({"solver.integrator": "rk4", "solver.step": 1e-3})
    fmu = gelenk.export_fmu(car, tmp_path / "Car.fmu")
    *arguments, _ = extracted(fmu, tmp_path / "car")
    arguments.append("8")
    taken = []
    for _ in range(5):  # the least of several: the speed of machines changes
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run([str(host), *arguments, str(1000 * SECONDS)], check=True, capture_output=True)
        taken.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
    assert min(taken) <= SECONDS / 10
