# SPDX-License-Identifier: BSD-3-Clause
"""Functions for blocks of memory that replace those of Zig: fmu/zig.cpp."""

from __future__ import annotations

import importlib.util
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from .machines import ARM, HERE, HERE_ITSELF, WINDOWS, Machine, zig

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("ziglang") is None,
    reason="ziglang is not installed: pip install --group runtimes",
)
SOURCE = HERE.parents[1] / "fmu" / "zig.cpp"


@pytest.mark.parametrize(
    "machine", [replace(HERE_ITSELF, target="x86_64-linux-gnu.2.17"), WINDOWS, ARM], ids=lambda m: m.platform
)
def test_blocks_are_copied_filled_and_compared_as_by_loops_over_bytes(
    machine: Machine, tmp_path: Path
) -> None:
    if machine.programs and not any(map(shutil.which, machine.programs)):
        pytest.skip(f"none of {', '.join(machine.programs)} is installed: {machine.how}")
    program = tmp_path / "blocks.exe"
    object_file = tmp_path / "zig.o"
    flags = ["-O2", "-fno-builtin", "-fno-sanitize=undefined"]
    zig("c++", machine.target, [*flags, "-c", str(SOURCE), "-o", str(object_file)])
    zig("cc", machine.target, [*flags, str(HERE / "blocks_host.c"), str(object_file), "-o", str(program)])
    done = machine.output(program, [], tmp_path / "wine")
    # 151 sizes with 303 distances, two functions each; 43 values; six changes of each byte of each size.
    assert int(done) == 151 * (2 * 303 + 43) + 6 * 151 * 150 // 2
