# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs with FMUs of FMI 3.0 in fmuloader: `python -m masters.run_fmuloader3 JOBS.json FOUND.json`."""

from __future__ import annotations

import json
import logging
import sys
from pathlib import Path
from typing import Any

import fmpy
from fmuloader.fmi3 import Fmi3Slave

logging.basicConfig(format="%(levelname)s %(message)s")


def run(job: dict[str, Any]) -> list[list[float]]:
    description = fmpy.read_model_description(job["fmu"])  # fmuloader reads none
    references = job["references"]
    with Fmi3Slave(job["fmu"], model_identifier=description.coSimulation.modelIdentifier) as slave:
        slave.instantiate_co_simulation("plant", instantiation_token=description.instantiationToken)
        slave.enter_initialization_mode()
        slave.set_int64([references[name] for name in job["integers"]], list(job["integers"].values()))
        slave.set_float64([references[name] for name in job["reals"]], list(job["reals"].values()))
        slave.exit_initialization_mode()
        rows = []
        for k in range(job["steps"]):
            slave.do_step(k * job["step"], job["step"])
            rows.append(slave.get_float64([references[name] for name in job["outputs"]]))
        slave.terminate()
        return rows


found = {job["title"]: run(job) for job in json.loads(Path(sys.argv[1]).read_text())}
Path(sys.argv[2]).write_text(json.dumps(found))
