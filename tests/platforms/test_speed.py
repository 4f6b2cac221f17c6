# SPDX-License-Identifier: BSD-3-Clause
"""CPU time of a step with the compiler of the libraries for other platforms (clang in Zig), and with GCC.

`make runtimes COMPARE=1` builds linux64 with Zig, too: the compilers compared without Wine, in which
calls into the library and mathematical functions differ as well.
"""

from __future__ import annotations

import resource
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import pytest
from costs.jobs import RK4, Job, arm, chain, shipped, windows

import gelenk

from .machines import FMU_TESTS, HERE, HERE_ITSELF, WINDOWS, Machine, Plant, extracted

pytestmark = [pytest.mark.platforms, pytest.mark.clock]
BUILDS = HERE.parents[1] / "build" / "runtimes"
CLANG = BUILDS / "x86_64-linux-gnu.2.17" / "gelenk" / "runtime" / "linux64" / "gelenk_fmu.so"
JOBS = {
    "four_bar": Job(shipped("four_bar"), 20_000),
    "stewart": Job(shipped("stewart"), 5_000),
    "slider_crank": Job(shipped("slider_crank"), 20_000),
    "arm": Job(arm, 20_000, solver=RK4),
    "chain": Job(lambda: chain(32), 5_000, solver=RK4),
    "ten_four_bars": Job(lambda: windows(10), 5_000, solver=RK4),
}
REPETITIONS = 15
HOST = FMU_TESTS.parent / "costs" / "cost_host.c"


def user_time(machine: Machine, host: Path, arguments: list[str], wine: Path) -> float:
    """CPU time of a program in user mode; in Wine, too, the processor runs its instructions."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    machine.output(host, arguments, wine)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def times_of_a_step(job: Job, runs: Sequence[tuple[Machine, list[str]]], folder: Path) -> list[float]:
    """The shortest of several runs; start and end of the program are subtracted."""
    hosts = [machine.compiled(HOST, folder) for machine, _ in runs]
    times: dict[tuple[int, int], list[float]] = {}
    for _ in range(REPETITIONS):  # in turns, so that another load of the processor concerns both
        for i, rounds in product(range(len(runs)), (1, job.rounds)):
            machine, arguments = runs[i]
            complete = [*arguments, str(rounds), repr(job.step)]
            times.setdefault((i, rounds), []).append(user_time(machine, hosts[i], complete, folder / "wine"))
    return [(min(times[i, job.rounds]) - min(times[i, 1])) / job.rounds for i in range(len(runs))]


def exported(job: Job, folder: Path, platforms: list[str]) -> Plant:
    source = job.plant()
    source["solver"] = {**source.get("solver", {}), **job.solver}
    return extracted(gelenk.export_fmu(source, folder / "x.fmu", platforms, view=False), folder / "x")


@pytest.mark.skipif(not CLANG.exists(), reason="`make runtimes COMPARE=1` builds linux64 with Zig")
@pytest.mark.parametrize("name", JOBS)
def test_clang_takes_no_more_than_a_tenth_longer_than_gcc(name: str, tmp_path: Path) -> None:
    plant = exported(JOBS[name], tmp_path, ["linux64"]).on(HERE_ITSELF)
    runs = [(HERE_ITSELF, plant), (HERE_ITSELF, [str(CLANG), *plant[1:]])]
    gcc, clang = times_of_a_step(JOBS[name], runs, tmp_path)
    print(f"{name}: GCC {1e6 * gcc:.2f} us, clang {1e6 * clang:.2f} us, ratio {clang / gcc:.3f}")
    assert clang <= 1.1 * gcc


@pytest.mark.skipif(bool(WINDOWS.missing), reason=WINDOWS.missing)
@pytest.mark.parametrize("name", JOBS)
def test_windows_takes_no_more_than_a_tenth_longer_than_linux(name: str, tmp_path: Path) -> None:
    plant = exported(JOBS[name], tmp_path, ["linux64", "win64"])
    runs = [(machine, plant.on(machine)) for machine in (HERE_ITSELF, WINDOWS)]
    here, there = times_of_a_step(JOBS[name], runs, tmp_path)
    print(f"{name}: linux64 {1e6 * here:.2f} us, win64 {1e6 * there:.2f} us, ratio {there / here:.3f}")
    assert there <= 1.1 * here
