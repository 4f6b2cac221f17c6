# SPDX-License-Identifier: BSD-3-Clause
"""The masters that nobody here wrote: how each is called, and what came of it."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from .jobs import Job, expected, rows, write

HERE = Path(__file__).resolve().parent
JARS = os.environ.get("GELENK_MASTERS", "")  # the folder that `make masters` gets the jars of pom.xml into
BAD_WORDS = re.compile(r"\[(?i:warning|discard|error|fatal)\]|\b(?:WARN|WARNING|ERROR|FATAL)\b")


@dataclass(frozen=True)
class Master:
    """One of them. package: on PyPI or crates.io, or the artifact in pom.xml."""

    name: str
    command: Sequence[str]
    package: str
    modules: Sequence[str] = ()  # of Python
    program: str = ""  # neither modules nor a program: it is in Java
    inputs_from: int | None = 0  # see `jobs.expected`

    @property
    def missing(self) -> str:
        """Why it cannot be run here; empty if it can."""
        for module in self.modules:
            if importlib.util.find_spec(module) is None:
                return f"{module} is not installed"
        if self.program:
            return (
                "" if Path(self.program).exists() else f"{self.program} is missing: `make masters` builds it"
            )
        return "" if self.modules or JARS else "GELENK_MASTERS names no folder of jars: `make masters` does"

    @property
    def version(self) -> str:
        """Its package's."""
        if self.modules:
            return importlib.metadata.version(self.package)
        if self.program:
            # fmi-sim reports its version like an error, with status 1.
            done = subprocess.run([self.program, "--version"], capture_output=True, text=True, check=False)
            (found,) = re.findall(rf"{self.package} (\d[\w.]*)", done.stdout + done.stderr)
            return str(found)
        pom = ElementTree.parse(HERE / "pom.xml").getroot()
        space = {"m": "http://maven.apache.org/POM/4.0.0"}
        for dependency in pom.findall(".//m:dependency", space):
            if dependency.findtext("m:artifactId", namespaces=space) == self.package:
                return str(dependency.findtext("m:version", namespaces=space))
        raise LookupError(self.package)


PYTHON = [sys.executable, "-m"]
FMI_SIM = str(Path(JARS or HERE.parents[1] / "build" / "masters") / "bin" / "fmi-sim")
MASTERS = [
    Master("fmpy", [*PYTHON, "masters.run_fmpy"], "fmpy", ["fmpy"]),
    Master("libcosim", [*PYTHON, "masters.run_libcosim"], "libcosimpy", ["libcosimpy"], inputs_from=1),
    Master("Ecos", [*PYTHON, "masters.run_ecos"], "ecospy", ["ecospy"]),
    Master("fmuloader", [*PYTHON, "masters.run_fmuloader"], "fmuloader", ["fmuloader"]),
    Master("fmi-sim", [*PYTHON, "masters.run_fmi_sim", FMI_SIM], "fmi-sim", program=FMI_SIM),
    Master("FMI4j", ["java", "-cp", f"{JARS}/*", str(HERE / "RunFmi4j.java")], "fmi-import"),
    Master("Maestro", [*PYTHON, "masters.run_maestro", JARS], "maestro", inputs_from=None),
]

# With FMUs of FMI 3.0. Ecos does not know enumerations, so that it cannot choose methods; each is a warning.
MASTERS_OF_FMI_3 = [
    Master("Ecos", [*PYTHON, "masters.run_ecos"], "ecospy", ["ecospy"]),
    Master("fmuloader", [*PYTHON, "masters.run_fmuloader3"], "fmuloader", ["fmuloader"]),
]


@dataclass(frozen=True)
class Outcome:
    """What a master made of jobs: titles of runs with other bits than Gelenk's own, its warnings."""

    different: list[str]
    warnings: list[str]


def outcome(master: Master, jobs: list[Job], folder: Path) -> Outcome:
    """Runs all jobs in a process of its own. Raises AssertionError where that fails."""
    asked, found = folder / "jobs.json", folder / "found.json"
    write(asked, jobs)
    # Masters leave logs where they are called.
    path = os.pathsep.join(filter(None, [str(HERE.parent), os.environ.get("PYTHONPATH", "")]))
    done = subprocess.run(
        [*master.command, str(asked), str(found)], cwd=folder, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, timeout=1800, check=False, env={**os.environ, "PYTHONPATH": path},
    )  # fmt: skip
    said = done.stdout.decode("utf-8", "replace")
    assert done.returncode == 0, said[-3000:]
    runs = rows(found)
    different = [
        job["title"]
        for job in jobs
        if not np.array_equal(runs[job["title"]], expected(job, master.inputs_from))
    ]
    return Outcome(different, [line for line in said.splitlines() if BAD_WORDS.search(line)])
