# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs in Maestro: `python -m masters.run_maestro JARS JOBS.json FOUND.json`.

The jobs of an FMU are one multi-model; with more in it Maestro's type checker takes for ever. Maestro leaves
out FMUs without a connection and checks the units of connections, so an output of each goes to a sink.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from itertools import groupby
from pathlib import Path
from typing import Any

import gelenk


def sink(n: int) -> dict[str, Any]:
    """Wheels that turn as fast as the inputs say [rad/s]."""
    wheel = {"mass": 1, "inertia": [0.1, 0.1, 0.1]}
    hinge = {"type": "revolute", "axis": [0, 0, 1], "parent": {"body": "ground"}}
    return {
        "gelenk": 1,
        "name": "Sink",
        "bodies": {f"wheel{k}": wheel for k in range(n)},
        "joints": {f"hinge{k}": {**hinge, "child": {"body": f"wheel{k}"}} for k in range(n)},
        "constraints": {
            f"from{k}": {"type": "motion", "joint": f"hinge{k}", "input": "speed"} for k in range(n)
        },
    }


def multi_model(jobs: list[dict[str, Any]], folder: Path) -> dict[str, Any]:
    """In Maestro's first format: `{fmu}.instance.variable`; an instance has its job's number for a name."""
    fmus = {"{sink}": str(gelenk.export_fmu(sink(len(jobs)), folder / "sink.fmu"))}
    connections, parameters, logged = {}, {}, {}
    for k, job in enumerate(jobs):
        key = "{" + Path(job["fmu"]).stem + "}"
        fmus[key] = job["fmu"]
        instance = f"{key}.i{k}"
        connections[f"{instance}.{job['rate']}"] = [f"{{sink}}.wheels.from{k}.w_ref"]
        for name, value in job["integers"].items():  # inputs are set by connections only
            parameters[f"{instance}.{name}"] = value
        logged[instance] = job["outputs"]
    step, steps = jobs[0]["step"], jobs[0]["steps"]
    return {
        "fmus": fmus,
        "connections": connections,
        "parameters": parameters,
        "logVariables": logged,
        "algorithm": {"type": "fixed-step", "size": step},
        "startTime": 0.0,
        "endTime": (steps + 0.5) * step,  # which a sum of steps does not meet by a rounding error
    }


def rows(table: Path, jobs: list[dict[str, Any]]) -> dict[str, list[list[float]]]:
    """Columns of the table: time, then `{fmu}.instance.variable`."""
    with table.open(newline="") as file:
        heading, *lines = csv.reader(file)
    place = {name: i for i, name in enumerate(heading)}
    found = {}
    for k, job in enumerate(jobs):
        columns = [place[f"{{{Path(job['fmu']).stem}}}.i{k}.{name}"] for name in job["outputs"]]
        found[job["title"]] = [[float(line[i]) for i in columns] for line in lines[1 : job["steps"] + 1]]
    return found


def run(jars: str, jobs: list[dict[str, Any]], folder: Path) -> dict[str, list[list[float]]]:
    """Of one FMU. Maestro's own words go to stdout."""
    folder.mkdir(parents=True)
    model = folder / "model.json"
    model.write_text(json.dumps(multi_model(jobs, folder), indent=1))
    done = subprocess.run(
        ["java", "-cp", f"{jars}/*", "org.intocps.maestro.Main", "import", f"-output={folder}", "--interpret",
         "sg1", str(model)],
        cwd=folder, check=False,  # where it leaves a log
    )  # fmt: skip
    table = folder / "outputs.csv"
    if done.returncode != 0 or not table.exists():
        sys.exit(f"{jobs[0]['title']}: Maestro ended with {done.returncode} and no table")
    return rows(table, jobs)


def main(jars: str, job_file: str, found_file: str) -> None:
    """Writes what Maestro found."""
    found: dict[str, list[list[float]]] = {}
    for fmu, jobs in groupby(json.loads(Path(job_file).read_text()), lambda job: str(job["fmu"])):
        found |= run(jars, list(jobs), Path(found_file).parent / "maestro" / Path(fmu).stem)
    Path(found_file).write_text(json.dumps(found))


main(*sys.argv[1:])
