# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs in fmi-sim: `python -m masters.run_fmi_sim PROGRAM JOBS.json FOUND.json`."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

PROGRAM = sys.argv[1]


def run(job: dict[str, Any], table: Path) -> list[list[float]]:
    settings = [f"--init-values={name}={value!r}" for name, value in (job["integers"] | job["reals"]).items()]
    command = [
        PROGRAM, "--model", job["fmu"], "-o", str(table), "co-simulation", "--output-interval",
        str(job["step"]), "-f", str(job["steps"] * job["step"]), *settings,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (job["title"], done.stdout[-2000:], done.stderr[-2000:])
    progress = "Recorded outputs at time"  # a line for each step
    print(
        *(line for line in done.stdout.splitlines() if not line.startswith(progress)), done.stderr, sep="\n"
    )
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return [[float(row[name]) for name in job["outputs"]] for row in rows[1:]]


with tempfile.TemporaryDirectory() as folder:
    found = {
        job["title"]: run(job, Path(folder, "table.csv")) for job in json.loads(Path(sys.argv[2]).read_text())
    }
Path(sys.argv[3]).write_text(json.dumps(found))
