# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs in fmpy: `python -m masters.run_fmpy JOBS.json FOUND.json`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import fmpy

found = {}
for job in json.loads(Path(sys.argv[1]).read_text()):
    run = fmpy.simulate_fmu(
        job["fmu"],
        stop_time=job["steps"] * job["step"],
        output_interval=job["step"],
        start_values=job["integers"] | job["reals"],
        output=job["outputs"],
    )
    found[job["title"]] = [[float(row[name]) for name in job["outputs"]] for row in run[1:]]
Path(sys.argv[2]).write_text(json.dumps(found))
