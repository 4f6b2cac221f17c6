# SPDX-License-Identifier: BSD-3-Clause
"""The library comes and goes: what is left of it in the host, and what it opens there."""

from __future__ import annotations

import os
import re
import subprocess
import threading
import time
from pathlib import Path

import fmpy
import pytest

import gelenk

from .c_hosts import extracted
from .host import Fmu, Slave
from .plants import crank_rocker

HOST = "loading_host"


@pytest.mark.parametrize("lives", [0, 1], ids=["loaded", "instantiated"])
def test_nothing_is_left_of_a_library_that_was_unloaded(lives: int, host: Path, tmp_path: Path) -> None:
    """Once it was 72,720 bytes each time: what the C++ library inside keeps for exceptions."""
    arguments = extracted(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu"), tmp_path / "x")
    run = subprocess.run(
        [str(host), *arguments, "520", str(lives)],
        env={**os.environ, "GLIBC_TUNABLES": "glibc.malloc.tcache_count=0"},  # no stock that fills up
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert run.returncode == 0, (run.returncode, run.stdout, run.stderr)
    resident_first, resident_last, heap_first, heap_last = map(int, run.stdout.split())
    # Blocks that the loader keeps may be 16 bytes larger or smaller than the time before, as malloc has
    # room. The smallest block of malloc, lost each time, would be 16,000 bytes.
    assert abs(heap_last - heap_first) <= 64
    # Linux maps 64 kB of a file at a time, here of the C library's; a page lost each time would be 2000 kB.
    assert resident_last - resident_first <= 256


def test_programs_that_the_host_starts_do_not_inherit_the_scene(tmp_path: Path) -> None:
    """While scene.json is read, here from a pipe, its descriptor is to be closed on exec."""
    fmu = Fmu(fmpy.extract(str(gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu")), str(tmp_path / "x")))
    scene = tmp_path / "x" / "resources" / "scene.json"
    text = scene.read_bytes()
    scene.unlink()
    os.mkfifo(scene)
    made: list[Slave] = []
    reader = threading.Thread(target=lambda: made.append(Slave(fmu)))
    reader.start()
    with scene.open("wb") as pipe:  # waits until the FMU opens it, and that until it reads something
        while not (found := descriptors(scene, besides=pipe.fileno())):
            time.sleep(0.01)
        flags = [
            int(re.findall(r"flags:\s*(\d+)", Path(f"/proc/self/fdinfo/{fd}").read_text())[0], 8)
            for fd in found
        ]
        pipe.write(text)
    reader.join()
    assert made[0].component is not None
    assert [flag & os.O_CLOEXEC for flag in flags] == [os.O_CLOEXEC]


def descriptors(file: Path, besides: int) -> list[int]:
    """This process's, of a file."""
    open_ones = [fd for fd in Path("/proc/self/fd").iterdir() if os.path.realpath(fd) == str(file)]
    return [int(fd.name) for fd in open_ones if int(fd.name) != besides]
