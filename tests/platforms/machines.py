# SPDX-License-Identifier: BSD-3-Clause
"""Other machines, as far as programs for them run here: Windows in Wine, 64-bit ARM in QEMU."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from numpy.typing import NDArray

from gelenk.io import export

HERE = Path(__file__).resolve().parent
FMU_TESTS = HERE.parent / "fmu"
HEADERS = Path(fmpy.__file__).parent / "c-code"
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
NO_RUNTIMES = "gelenk-runtimes is not installed: `make runtimes` builds and installs it"


def zig(compiler: str, target: str, arguments: Sequence[str]) -> None:
    """Run Zig's `cc` or `c++` for one of its targets."""
    import ziglang

    environment = dict(os.environ)
    # Zig keeps the C library that `make runtimes` has compiled, which takes minutes.
    for kind in ("GLOBAL", "LOCAL"):
        environment.setdefault(f"ZIG_{kind}_CACHE_DIR", str(HERE.parents[1] / "build/runtimes/zig-cache"))
    program = str(Path(ziglang.__file__).parent / "zig")
    subprocess.run([program, compiler, "-target", target, *arguments], check=True, env=environment)


@dataclass(frozen=True)
class Machine:
    """One of them.

    Attributes:
        target: of Zig, which compiles the hosts; empty: the C compiler of this machine.
        programs: that run the host, in the order of preference.
        how: what installs them.
    """

    platform: str
    target: str = ""
    programs: Sequence[str] = ()
    how: str = ""

    @property
    def missing(self) -> str:
        """Why it cannot be had here; empty if it can."""
        if export.missing_platforms(self.platform):
            return NO_RUNTIMES
        if self.target and importlib.util.find_spec("ziglang") is None:
            return "ziglang is not installed: pip install --group runtimes"
        if self.programs and not any(map(shutil.which, self.programs)):
            return f"none of {', '.join(self.programs)} is installed: {self.how}"
        if self.platform == "aarch64-linux" and not ARM_LIBRARIES.exists():
            return f"{ARM_LIBRARIES} is missing: {self.how}"
        return ""

    def compiled(self, source: Path, folder: Path) -> Path:
        """A host as a program of this machine."""
        out = folder / f"{source.stem}-{self.platform}{'.exe' if self.platform == 'win64' else ''}"
        libraries = ["-lpthread"] if self.platform == "win64" else ["-lpthread", "-ldl", "-lm"]
        includes = [f"-I{HEADERS}", f"-I{FMU_TESTS}"]
        command = [*includes, "-O1", str(source), "-o", str(out), *libraries]
        if self.target:
            zig("cc", self.target, command)
        else:
            subprocess.run(["cc", *command], check=True)
        return out

    def path(self, file: Path) -> str:
        """A file as programs of this machine call it."""
        return f"Z:{file}" if self.platform == "win64" else str(file)

    def uri(self, folder: Path) -> str:
        """The same as a URI."""
        return f"file:///Z:{folder.as_uri()[7:]}" if self.platform == "win64" else folder.as_uri()

    def output(self, host: Path, arguments: Sequence[str], wine: Path) -> str:
        """What a host prints. wine: the folder in which Wine keeps its files."""
        program = [found for name in self.programs if (found := shutil.which(name))][:1]
        if self.platform == "aarch64-linux":
            program += ["-L", str(ARM_LIBRARIES)]
        done = subprocess.run(
            [*program, str(host), *arguments], capture_output=True, text=True, timeout=600, check=False,
            env={**os.environ, "WINEPREFIX": str(wine), "WINEDEBUG": "-all"},
        )  # fmt: skip
        assert done.returncode == 0, (done.returncode, done.stdout[-2000:], done.stderr[-2000:])
        return done.stdout


HERE_ITSELF = Machine("linux64")
WINDOWS = Machine("win64", "x86_64-windows-gnu", ("wine64", "wine"), "apt-get install wine wine64")
ARM = Machine(
    "aarch64-linux", "aarch64-linux-gnu.2.34", ("qemu-aarch64", "qemu-aarch64-static"),
    "apt-get install qemu-user libc6-arm64-cross",
)  # fmt: skip
# As parameters of a test.
OTHERS = [
    pytest.param(machine, marks=pytest.mark.skipif(bool(machine.missing), reason=machine.missing), id=name)
    for name, machine in (("Windows", WINDOWS), ("ARM", ARM))
]


@cache
def host(name: str, machine: Machine, folder: Path) -> Path:
    """A host of these tests or those of FMUs as a program of a machine, compiled once."""
    where = HERE if (HERE / f"{name}.c").exists() else FMU_TESTS
    return machine.compiled(where / f"{name}.c", folder)


@dataclass(frozen=True)
class Plant:
    """An extracted FMU with the libraries of all machines."""

    folder: Path
    guid: str
    arguments: Sequence[str]  # of its variables: INPUT FIRST_OUTPUT OUTPUTS

    def on(self, machine: Machine) -> list[str]:
        """The common arguments of a host."""
        (library,) = (self.folder / "binaries" / machine.platform).iterdir()
        return [machine.path(library), self.guid, machine.uri(self.folder / "resources"), *self.arguments]


def extracted(fmu: Path, folder: Path, pushed: str = "") -> Plant:
    """Unpack an FMU. pushed: the input that the hosts change, otherwise the first one."""
    description = fmpy.read_model_description(str(fmu))
    fmpy.extract(str(fmu), str(folder))
    references = {
        kind: [v.valueReference for v in description.modelVariables if v.causality == kind]
        for kind in ("input", "output")
    }
    if pushed:
        references["input"] = [
            v.valueReference for v in description.modelVariables if (v.causality, v.name) == ("input", pushed)
        ]
    outputs = references["output"]
    assert outputs == list(range(outputs[0], outputs[0] + len(outputs)))
    numbers = [*references["input"][:1], -1][0], outputs[0], len(outputs)
    return Plant(folder, description.guid, [str(n) for n in numbers])


def table(text: str) -> NDArray[np.float64]:
    """The rows of numbers that a host has printed."""
    return np.array([[float(word) for word in line.split()] for line in text.splitlines()])


@dataclass(frozen=True)
class Life:
    """A run of `life_host`: tolerance, end [s], number of steps; a state is saved in the middle."""

    tolerance: float
    stop: float
    steps: int

    def differences(
        self,
        plant: Plant,
        machine: Machine,
        hosts: Path,
        wine: Path,
        folder: Path,
        compared: Sequence[bool] | None = None,
    ) -> float:
        """Of a run there from one here, and of states that change machines from the run that they left.

        The largest one, relative to the largest value of the output, or 1. hosts, wine: folders for these.
        compared: whether, by output; None: all of them.
        """
        settings = [str(self.tolerance), repr(self.stop / self.steps), str(self.steps), str(self.steps // 2)]
        files = {HERE_ITSELF: folder / "here", machine: folder / "there"}
        runs, found = {}, []

        def printed(where: Machine, *task: str) -> NDArray[np.float64]:
            program = host("life_host", where, hosts)
            return table(where.output(program, [*plant.on(where), *settings, *task], wine))

        for where, file in files.items():
            runs[where] = printed(where, "save", where.path(file))
        scale = 1 + np.abs(runs[HERE_ITSELF]).max(axis=0)
        found.append(runs[machine] - runs[HERE_ITSELF])
        for where, other in ((HERE_ITSELF, machine), (machine, HERE_ITSELF)):
            rest = printed(where, "restore", where.path(files[other]))
            found.append(rest - runs[other][self.steps // 2 :])
        chosen = slice(None) if compared is None else np.array(compared)
        return max(float((np.abs(rows) / scale)[:, chosen].max()) for rows in found)
