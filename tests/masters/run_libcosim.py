# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs in libcosim: `python -m masters.run_libcosim JOBS.json FOUND.json`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def run(job: dict[str, Any]) -> list[list[float]]:
    references = job["references"]
    execution = CosimExecution.from_step_size(step_size=job["step"] * 1e9)
    slave = CosimLocalSlave(fmu_path=job["fmu"], instance_name="plant")
    index = execution.add_local_slave(local_slave=slave)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    manipulator = CosimManipulator.create_override()
    execution.add_manipulator(manipulator=manipulator)
    for name, number in job["integers"].items():
        assert execution.integer_initial_value(index, references[name], number), name
    for name, value in job["reals"].items():
        assert execution.real_initial_value(index, references[name], value), name
        assert manipulator.slave_real_values(index, [references[name]], [value]), name
    outputs = [references[name] for name in job["outputs"]]
    rows = []
    for _ in range(job["steps"]):
        assert execution.step(), job["title"]
        rows.append(list(observer.last_real_values(index, outputs)))
    return rows


found = {job["title"]: run(job) for job in json.loads(Path(sys.argv[1]).read_text())}
Path(sys.argv[2]).write_text(json.dumps(found))
