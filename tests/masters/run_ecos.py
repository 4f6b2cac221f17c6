# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs in Ecos: `python -m masters.run_ecos JOBS.json FOUND.json`."""

from __future__ import annotations

import ctypes
import json
import sys
from pathlib import Path
from typing import Any

# Ecos' library asks for it by name; the wheel `tbb` puts it where the system's linker does not look.
ctypes.CDLL(str(Path(sys.prefix, "lib", "libtbb.so.12")), mode=ctypes.RTLD_GLOBAL)
from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: E402


def run(job: dict[str, Any]) -> list[list[float]]:
    with EcosSimulationStructure() as structure:
        structure.add_model("plant", job["fmu"])
        settings = {f"plant::{name}": value for name, value in (job["integers"] | job["reals"]).items()}
        structure.add_parameter_set("asked", settings)
        with EcosSimulation(structure=structure, step_size=job["step"]) as simulation:
            simulation.init(parameter_set="asked")
            for name, number in job["integers"].items():
                assert simulation.get_integer(f"plant::{name}") == number, name
            rows = []
            for _ in range(job["steps"]):
                simulation.step()
                rows.append([simulation.get_real(f"plant::{name}") for name in job["outputs"]])
            simulation.terminate()
            return rows


found = {job["title"]: run(job) for job in json.loads(Path(sys.argv[1]).read_text())}
Path(sys.argv[2]).write_text(json.dumps(found))
