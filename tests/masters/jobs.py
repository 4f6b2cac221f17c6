# SPDX-License-Identifier: BSD-3-Clause
"""What each master has to run: the shipped scenes, as they are and with other methods, inputs constant."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from numpy.typing import NDArray

import gelenk

SCENES = sorted((Path(__file__).resolve().parents[2] / "scenes").glob("*.yaml"))
STEP, STEPS = 1e-3, 30  # s; a multiple of nanoseconds, in which libcosim counts
METHODS: list[dict[str, str]] = [
    {},
    {"formulation": "baumgarte", "integrator": "rk4"},
    {"formulation": "udwadia-kalaba", "integrator": "cvode-adams"},
]
RATE = "rad/s"  # every scene has an output of that unit

Job = dict[str, Any]


def jobs(folder: Path, fmi: int = 2) -> list[Job]:
    """Of each scene and pair of methods: the FMU, what is to be set, what is to be read after each step."""
    found = []
    for scene in SCENES:
        fmu = gelenk.export_fmu(gelenk.load(scene), folder / f"{scene.stem}.fmu", fmi=fmi)
        variables = fmpy.read_model_description(str(fmu)).modelVariables
        found += [_job(scene, fmu, variables, methods) for methods in METHODS]
    return found


def _job(scene: Path, fmu: Path, variables: list[Any], methods: dict[str, str]) -> Job:
    outputs = [v for v in variables if v.causality == "output"]
    inputs = [v.name for v in variables if v.causality == "input"]
    return {
        "title": "-".join([scene.stem, *methods.values()]),
        "scene": str(scene),
        "fmu": str(fmu),
        "methods": methods,
        "integers": {f"solver.{kind}": _number(variables, kind, word) for kind, word in methods.items()},
        "reals": {name: 0.1 * (k + 1) for k, name in enumerate(inputs)},
        "outputs": [v.name for v in outputs],
        "rate": next(v.name for v in outputs if v.unit == RATE),
        "references": {v.name: v.valueReference for v in variables},
        "step": STEP,
        "steps": STEPS,
    }


def _number(variables: list[Any], kind: str, word: str) -> int:
    """What a user of the master reads in the variable's description."""
    (description,) = (v.description for v in variables if v.name == f"solver.{kind}")
    choices = dict(item.split(" ")[::-1] for item in description.split(": ")[-1].split(", "))
    return int(choices[word])


def expected(job: Job, inputs_from: int | None = 0) -> NDArray[np.float64]:
    """The same run by Gelenk without an FMU: a row after each step, a column for each output.

    inputs_from: 0: inputs are set in initialization mode; 1: with the first step; None: never.
    """
    choices = {f"solver.{kind}": word for kind, word in job["methods"].items()}
    plant = gelenk.Simulation(gelenk.load(Path(job["scene"])).with_parameters(choices))
    rows = []
    for k in range(job["steps"] + 1):
        if k == inputs_from:
            for name, value in job["reals"].items():
                plant.set_input(name, value)
        if k == 0:
            plant.initialize()
            continue
        plant.step_to(k * job["step"])
        rows.append(plant.values(job["outputs"]))
    return np.array(rows)


def write(file: Path, all_jobs: list[Job]) -> None:
    """For programs."""
    file.write_text(json.dumps(all_jobs), encoding="utf-8")


def rows(file: Path) -> dict[str, NDArray[np.float64]]:
    """What a program found, by the job's title."""
    found = json.loads(file.read_text(encoding="utf-8"))
    return {title: np.array(table, np.float64) for title, table in found.items()}
