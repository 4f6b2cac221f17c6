# SPDX-License-Identifier: BSD-3-Clause
"""CPU time of a step with the compiler of the libraries for other platforms (clang in Zig), and with GCC."""

from __future__ import annotations

import resource
from itertools import product
from pathlib import Path

import pytest

import gelenk

from .machines import FMU_TESTS, HERE, HERE_ITSELF, WINDOWS, Machine, extracted

pytestmark = [
    pytest.mark.platforms,
    pytest.mark.clock,
    pytest.mark.skipif(bool(WINDOWS.missing), reason=WINDOWS.missing),
]
SCENES = ("four_bar", "stewart", "slider_crank")
ROUNDS = 20_000
REPETITIONS = 7


def user_time(machine: Machine, host: Path, arguments: list[str], wine: Path) -> float:
    """CPU time of a program in user mode; in Wine, too, the processor runs its instructions."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    machine.output(host, arguments, wine)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


@pytest.mark.parametrize("name", SCENES)
def test_a_step_takes_no_more_than_a_tenth_longer_than_with_gcc(name: str, tmp_path: Path) -> None:
    """The shortest of several runs; start and end of the program are subtracted."""
    scene = gelenk.load(HERE.parents[1] / "scenes" / f"{name}.yaml")
    fmu = gelenk.export_fmu(scene, tmp_path / "x.fmu", ["linux64", "win64"], view=False)
    plant = extracted(fmu, tmp_path / "x")
    source = FMU_TESTS.parent / "costs" / "cost_host.c"
    hosts = {machine: machine.compiled(source, tmp_path) for machine in (HERE_ITSELF, WINDOWS)}
    times: dict[tuple[Machine, int], list[float]] = {}
    for _ in range(REPETITIONS):  # in turns, so that another load of the processor concerns both
        for (machine, host), rounds in product(hosts.items(), (1, ROUNDS)):
            arguments = [*plant.on(machine), str(rounds), "0.001"]
            times.setdefault((machine, rounds), []).append(
                user_time(machine, host, arguments, tmp_path / "wine")
            )
    here, there = ((min(times[m, ROUNDS]) - min(times[m, 1])) / ROUNDS for m in hosts)
    print(f"{name}: linux64 {1e6 * here:.2f} us, win64 {1e6 * there:.2f} us, ratio {there / here:.3f}")
    assert there <= 1.1 * here
