# SPDX-License-Identifier: BSD-3-Clause
"""Instructions of a step with the compiler of the libraries for other platforms, and with GCC.

Unlike times (test_speed.py), they do not depend on what else the machine does.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from costs.counting import HERE as COSTS
from costs.counting import instructions_of, prepared, valgrind
from fmu.c_hosts import compiled

from .test_speed import CLANG, JOBS

pytestmark = [
    pytest.mark.platforms,
    pytest.mark.skipif(not CLANG.exists(), reason="`make runtimes COMPARE=1` builds linux64 with Zig"),
    pytest.mark.skipif(not valgrind(), reason="Valgrind is not installed: apt-get install valgrind"),
]
ROUNDS = 200


@pytest.mark.parametrize("name", JOBS)
def test_clang_executes_no_more_than_a_tenth_more_instructions_than_gcc(name: str, tmp_path: Path) -> None:
    host = compiled("cost_host", tmp_path, where=COSTS)
    assert host is not None
    gcc = prepared(dataclasses.replace(JOBS[name], rounds=ROUNDS), host, tmp_path / "gcc")
    clang = dataclasses.replace(gcc, command=[gcc.command[0], str(CLANG), *gcc.command[2:]], library=CLANG)
    counts = [instructions_of(job) for job in (gcc, clang)]
    print(f"{name}: GCC {counts[0]}, clang {counts[1]}, ratio {counts[1] / counts[0]:.3f}")
    assert counts[1] <= 1.1 * counts[0]
