# SPDX-License-Identifier: BSD-3-Clause
"""Runs jobs and counts what they cost; `python -m costs.counting WHY` writes figures.json anew."""

from __future__ import annotations

import json
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
from fmu.c_hosts import compiled, extracted

import gelenk

from .jobs import JOBS, Job

HERE = Path(__file__).parent
FIGURES = HERE / "figures.json"
TOLD = ("solver.evaluations", "solver.jacobians")
CALLS = ("fmi2SetReal", "fmi2DoStep", "fmi2GetReal")


@dataclass
class Prepared:
    """A job as a command, and the library that it loads."""

    command: list[str]
    library: Path
    folder: Path
    rounds: int


def prepared(job: Job, host: Path, folder: Path) -> Prepared:
    source = job.plant()
    source["solver"] = {**source.get("solver", {}), **job.solver}
    folder.mkdir()
    fmu = gelenk.export_fmu(source, folder / "x.fmu")
    arguments = extracted(fmu, folder / "x")
    variables = {v.name: v.valueReference for v in fmpy.read_model_description(str(fmu)).modelVariables}
    told = [str(variables[name]) for name in TOLD]
    command = [str(host), *arguments, str(job.rounds), repr(job.step), *told]
    return Prepared(command, Path(arguments[0]), folder, job.rounds)


def run(command: list[str]) -> str:
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout


def counts_of(job: Prepared) -> dict[str, int]:
    """Of the whole run: evaluations of the equations of motion, Jacobian matrices."""
    numbers = run(job.command).split()
    return {name.split(".")[1]: int(number) for name, number in zip(TOLD, numbers, strict=True)}


def total(file: Path) -> int:
    """The instructions of a file of callgrind."""
    return int(re.findall(r"^(?:totals|summary): (\d+)", file.read_text(), re.MULTILINE)[-1])


def instructions_of(job: Prepared) -> int:
    """Of a round, inside the FMU's calls, by callgrind."""
    file = job.folder / "callgrind.out"
    toggles = [f"--toggle-collect={call}" for call in CALLS]
    run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={file}", *toggles, *job.command])
    return total(file) // job.rounds


def instructions_of_steps(job: Prepared) -> list[int]:
    """Of each call of fmi2DoStep alone."""
    file = job.folder / "steps.out"
    call = ["--toggle-collect=fmi2DoStep", "--dump-after=fmi2DoStep"]
    run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={file}", *call, *job.command])
    dumps = [job.folder / f"steps.out.{k}" for k in range(1, job.rounds + 1)]
    return [total(dump) for dump in dumps]


def valgrind() -> bool:
    return shutil.which("valgrind") is not None


def machine(library: Path) -> dict[str, str]:
    """What instructions depend on besides the code."""
    compilers = re.findall(rb"(?:GCC: |clang version )[ -~]+", library.read_bytes())
    cpu = Path("/proc/cpuinfo")
    known = set(cpu.read_text().split()) if cpu.exists() else set()
    return {
        "compiler": ", ".join(sorted({text.decode() for text in compilers})),
        "libc": " ".join(platform.libc_ver()),
        "processor": " ".join(name for name in ("sse2", "avx2", "fma") if name in known),
        "valgrind": run(["valgrind", "--version"]).strip() if valgrind() else "",
    }


def written() -> dict[str, Any]:
    figures: dict[str, Any] = json.loads(FIGURES.read_text(encoding="utf-8"))
    return figures


def main() -> None:
    why = " ".join(sys.argv[1:]).strip()
    if not why:
        sys.exit("found no reason, expected why the figures change, as the commit will say it")
    if not valgrind():
        sys.exit("valgrind was not found, which counts the instructions")
    figures: dict[str, Any] = {"why": why, "machine": {}, "jobs": {}}
    with tempfile.TemporaryDirectory() as name:
        host = compiled("cost_host", Path(name), where=HERE)
        if host is None:
            sys.exit("no C compiler was found (cc)")
        for i, (title, job) in enumerate(JOBS.items()):
            ready = prepared(job, host, Path(name) / str(i))
            found = {**counts_of(ready), "instructions": instructions_of(ready)}
            figures["jobs"][title] = {"rounds": job.rounds, **found}
            figures["machine"] = machine(ready.library)
            print(title, found, flush=True)
    FIGURES.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
