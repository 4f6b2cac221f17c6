# SPDX-License-Identifier: BSD-3-Clause
"""CPU time of a step with the compiler of the libraries for other platforms (clang in Zig), and with GCC."""

from __future__ import annotations

import resource
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
REPETITIONS = 5


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
    shortest = {}
    for machine in (HERE_ITSELF, WINDOWS):
        host = machine.compiled(source, tmp_path)
        times = {
            rounds: min(
                user_time(machine, host, [*plant.on(machine), str(rounds), "0.001"], tmp_path / "wine")
                for _ in range(REPETITIONS)
            )
            for rounds in (1, ROUNDS)
        }
        shortest[machine.platform] = (times[ROUNDS] - times[1]) / ROUNDS
    print({platform: f"{1e6 * seconds:.2f} us" for platform, seconds in shortest.items()})
    assert shortest["win64"] <= 1.1 * shortest["linux64"]
