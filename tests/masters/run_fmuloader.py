# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs in fmuloader: `python -m masters.run_fmuloader JOBS.json FOUND.json`."""

from __future__ import annotations

import json
import logging
import sys
from pathlib import Path
from typing import Any

import fmpy
from fmuloader.fmi2 import Fmi2Slave, Fmi2Type

logging.basicConfig(format="%(levelname)s %(message)s")


def run(job: dict[str, Any]) -> list[list[float]]:
    description = fmpy.read_model_description(job["fmu"])  # fmuloader reads none
    references = job["references"]
    with Fmi2Slave(job["fmu"], model_identifier=description.coSimulation.modelIdentifier) as slave:
        slave.instantiate("plant", Fmi2Type.CO_SIMULATION, guid=description.guid)
        slave.setup_experiment()
        slave.enter_initialization_mode()
        slave.set_integer([references[name] for name in job["integers"]], list(job["integers"].values()))
        slave.set_real([references[name] for name in job["reals"]], list(job["reals"].values()))
        slave.exit_initialization_mode()
        rows = []
        for k in range(job["steps"]):
            slave.do_step(k * job["step"], job["step"])
            rows.append(slave.get_real([references[name] for name in job["outputs"]]))
        slave.terminate()
        return rows


found = {job["title"]: run(job) for job in json.loads(Path(sys.argv[1]).read_text())}
Path(sys.argv[2]).write_text(json.dumps(found))
