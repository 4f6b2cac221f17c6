# SPDX-License-Identifier: BSD-3-Clause
"""The conformance suite under instruments; `make sanitize` runs them all.

python -m fmu.sanitizers INSTRUMENT [LIBRARY]: address, thread (LIBRARY is then a runtime built with
GELENK_SANITIZE), memcheck or helgrind (valgrind, on the runtime of the installed package, or LIBRARY). A host
written in C runs several scenes with all kinds of methods; with address, the scenarios of test_calls.py
follow. Ends with 0 where nothing was found.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from mechanisms import Scene

import gelenk
from fmu.c_hosts import compiled, extracted
from fmu.plants import crank_rocker, driven, gyroscope
from fmu.scenarios import SCENARIOS

TESTS = Path(__file__).resolve().parent.parent
VALGRIND = ("valgrind", "--quiet", "--error-exitcode=9", "--fair-sched=yes")
# What runs the host, how it is compiled, and its tasks, small: an instrument slows down 10 to 50 times.
INSTRUMENTS = {
    "address": (
        (),
        ("-fsanitize=address,undefined",),
        ("cycles=20", "crowd=8", "threads=4", "states=3", "wrong=5"),
    ),
    "thread": ((), ("-fsanitize=thread",), ("cycles=5", "crowd=12", "threads=4", "states=2", "wrong=2")),
    "memcheck": (
        (*VALGRIND, "--leak-check=full", "--errors-for-leak-kinds=definite,indirect,possible"),
        (),
        ("cycles=5", "crowd=4", "threads=4", "states=2", "wrong=2"),
    ),
    "helgrind": ((*VALGRIND, "--tool=helgrind"), (), ("crowd=8", "threads=4")),
}
# Undefined behavior ends the process of itself. LeakSanitizer of GCC 12 dies of the thread-local storage of
# a library that was loaded late; memcheck looks there.
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=1",
    "LSAN_OPTIONS": "use_tls=0:print_suppressions=0",
    "UBSAN_OPTIONS": "print_stacktrace=1",
    "TSAN_OPTIONS": "exitcode=9",
}
METHODS = ("auto", "rk4", "erk", "ida", "cvode", "dirk", "generalized-alpha")


def plants() -> dict[str, Scene]:
    """Scenes by name: a loop with each method, quaternions, motions and gears, and what the package ships."""
    found = {}
    for integrator in METHODS:
        found[f"crank_rocker-{integrator}"] = {**crank_rocker(), "solver": {"integrator": integrator}}
    found["gyroscope"] = gyroscope()
    found["driven"] = driven()
    gripper = gelenk.load(TESTS.parent / "docs" / "gallery" / "gripper" / "scene.yaml")
    found["gripper"] = gripper.to_dict()
    for name in ("stewart", "slider_crank", "bicycle"):
        found[name] = gelenk.load(TESTS.parent / "scenes" / f"{name}.yaml").to_dict()
    return found


def runtime(file_name: str) -> str:
    """The file of a sanitizer's runtime, for a host that is not linked with it."""
    return subprocess.run(
        ["cc", f"-print-file-name={file_name}"], capture_output=True, text=True, check=True
    ).stdout.strip()


def clean(what: str, command: list[str], environment: dict[str, str] | None = None) -> bool:
    """Runs it; tells what was found."""
    run = subprocess.run(
        command,
        env={**os.environ, **OPTIONS, **(environment or {})},
        capture_output=True,
        text=True,
        timeout=1800,
        check=False,
    )
    fine = run.returncode == 0 and run.stderr == ""
    print(f"{'clean' if fine else 'FOUND'}  {what}", flush=True)
    if not fine:
        print(f"exit code {run.returncode}\n{run.stdout}\n{run.stderr}", flush=True)
    return fine


def main(instrument: str, library: Path | None = None) -> int:
    """Number of hosts in which something was found."""
    runner, flags, tasks = INSTRUMENTS[instrument]
    found = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        host = compiled("multithreaded_host", folder, *flags)
        if host is None:
            raise SystemExit("sanitizers.py: no C compiler")
        for plant, source in plants().items():
            fmu = gelenk.export_fmu(source, folder / f"{plant}.fmu")
            arguments = extracted(fmu, folder / plant, library)
            found += not clean(plant, [*runner, str(host), *arguments, *tasks])
        if instrument == "address":
            # Python itself leaks, and the host's traps meet those of the runtime.
            preload = {
                "LD_PRELOAD": f"{runtime('libasan.so')} {runtime('libubsan.so')}",
                "ASAN_OPTIONS": "detect_leaks=0",
                "PYTHONMALLOC": "malloc",
                "PYTHONPATH": os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")]),
            }
            fmu = gelenk.export_fmu(crank_rocker(), folder / "x.fmu")
            for scenario in SCENARIOS:
                own = folder / scenario
                extracted(fmu, own / "extracted", library)
                command = [sys.executable, "-m", "fmu.scenarios", scenario, str(own / "extracted")]
                found += not clean(scenario, command, preload)
    return found


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1] not in INSTRUMENTS:
        raise SystemExit(__doc__)
    sys.exit(min(1, main(sys.argv[1], *map(Path, sys.argv[2:]))))
