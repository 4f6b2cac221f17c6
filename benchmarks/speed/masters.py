# SPDX-License-Identifier: BSD-3-Clause
"""Communication steps of 1 ms with a new torque: Gelenk through the FMU's C interface, others in their own
loops.
"""

from __future__ import annotations

import csv
import json
import math
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from benchmarks.speed import families, timings
from benchmarks.speed.peer import ROUNDS, torques
from benchmarks.speed.tools import HERE, ROOT, Tools
from benchmarks.speed.tree import to_scene

import gelenk

sys.path.insert(0, str(ROOT / "tests"))

from fmu.c_hosts import compiled, extracted

# Name of the method, parameters and tolerance
MODES: dict[str, tuple[dict[str, str | float], float]] = {
    "FMU, auto at 1e-6": ({}, 1e-6),
    "FMU, rk4": ({"solver.integrator": "rk4", "solver.step": 1e-3}, 1e-6),
}
TRUTH = 1e-12  # tolerance of the reference run


@dataclass(frozen=True)
class Step:
    """Time of a round [us] and the largest error of the joint coordinates after all rounds."""

    scene: str
    engine: str
    method: str
    us: float
    ref_us: float
    error: float


@dataclass
class Host:
    """The program that runs FMUs, and their folder."""

    program: Path
    folder: Path

    def run(
        self, name: str, settings: dict[str, str | float], tolerance: float
    ) -> tuple[float, float, list[float]]:
        """Return the time of a round and of `ref` [us], and the joint coordinates at the end."""
        tree = families.make(name)
        data = to_scene(tree)
        data["experiment"]["tolerance"] = tolerance
        scene = gelenk.load(data).with_parameters(settings)
        place = self.folder / f"{name}{len(list(self.folder.iterdir()))}"
        fmu = gelenk.export_fmu(scene, place.with_suffix(".fmu"))
        driven = [i for i, b in enumerate(tree.bodies) if b.driven]
        table = place.with_suffix(".txt")
        np.savetxt(table, torques(tree, ROUNDS)[:, driven], fmt="%.17g")
        arguments = [*extracted(fmu, place), str(table), str(len(driven)), str(ROUNDS)]
        done = subprocess.run([str(self.program), *arguments], capture_output=True, text=True, check=True)
        found = json.loads(done.stdout)
        names = [signal.name for signal in gelenk.Simulation(scene).outputs]
        joints = [names.index(f"j_{b.name}.{'s' if b.slides else 'phi'}") for b in tree.bodies]
        return found["us"], found["ref_us"], [found["end"][i] for i in joints]


def _error(end: Sequence[float], truth: Sequence[float]) -> float:
    return float(np.max(np.abs(np.asarray(end) - truth))) if len(end) == len(truth) else math.nan


def own(host: Host, name: str, truth: Sequence[float]) -> list[Step]:
    """Measure Gelenk's FMU. Raises CalledProcessError."""
    out = []
    for method, (settings, tolerance) in MODES.items():
        us, ref, end = host.run(name, settings, tolerance)
        out.append(Step(name, "gelenk", method, us, ref, _error(end, truth)))
    return out


def peers(tools: Tools, name: str, truth: Sequence[float]) -> list[Step]:
    """Measure all other engines that run the mechanism."""
    out = []
    for engine in timings.ENGINES[1:]:
        if engine in tools.missing:
            continue
        lines, _ = timings.lines(tools, timings.command(tools, engine, "step", name), timings.LONGEST_PROCESS)
        for line in lines:
            if "us" in line:
                fields: dict[str, Any] = dict(line)
                end = fields.get("end", [])
                out.append(
                    Step(
                        name,
                        engine,
                        str(fields["kernel"]),
                        fields["us"],
                        fields["ref_us"],
                        _error(end, truth),
                    )
                )
    return out


def study(tools: Tools, names: Sequence[str], report: Callable[[str], None]) -> list[Step]:
    """Measure all engines on the mechanisms."""
    out: list[Step] = []
    with TemporaryDirectory() as folder:
        program = compiled("fmu_step", Path(folder), "-O2", str(HERE / "ref_kernel.c"), "-lm", where=HERE)
        if program is None:
            sys.exit("no C compiler was found (cc)")
        host = Host(program, Path(folder) / "fmus")
        host.folder.mkdir()
        for name in names:
            timings.write_scene(tools, name)
            try:
                truth = host.run(name, {}, TRUTH)[2]
                out += own(host, name, truth)
            except subprocess.CalledProcessError as fault:
                report(f"{name}: {fault}")
                continue
            out += peers(tools, name, truth)
            summary = [f"{s.engine} {s.method} {s.us:.3g} us" for s in out if s.scene == name]
            report(f"{name}: {', '.join(summary)}")
    return out


def write_csv(steps: Sequence[Step], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "engine", "method", "us", "ref_us", "error"])
        for s in steps:
            writer.writerow([s.scene, s.engine, s.method, f"{s.us:.5g}", f"{s.ref_us:.4g}", f"{s.error:.3g}"])
