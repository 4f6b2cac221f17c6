# SPDX-License-Identifier: BSD-3-Clause
"""The library for Windows in Wine, where `make win64` has built it."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import fmpy
import pytest

import gelenk
from gelenk.io import export

from .c_hosts import HEADERS, HERE, compiled, extracted
from .plants import crank_rocker

COMPILER = shutil.which("x86_64-w64-mingw32-gcc-posix") or shutil.which("x86_64-w64-mingw32-gcc")
WINE = shutil.which("wine64") or shutil.which("wine")

pytestmark = pytest.mark.skipif(
    bool(export.missing_platforms(["win64"])) or COMPILER is None or WINE is None,
    reason="no runtime for win64 in the package (make win64), no MinGW-w64, or no Wine",
)


def in_wine(folder: Path, arguments: list[str]) -> str:
    assert COMPILER
    assert WINE
    host = folder / "multithreaded_host.exe"
    subprocess.run(
        [
            COMPILER,
            "-O1",
            "-static",
            f"-I{HEADERS}",
            str(HERE / "multithreaded_host.c"),
            "-o",
            str(host),
            "-lpthread",
        ],
        check=True,
    )
    run = subprocess.run(
        [WINE, str(host), *arguments],
        env={**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 0, (run.returncode, run.stdout, run.stderr)
    return run.stdout


def test_the_fmu_runs_on_windows_as_it_does_here(tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(crank_rocker(), tmp_path / "x.fmu", ["linux64", "win64"])
    description = fmpy.read_model_description(str(fmu))
    folder = tmp_path / "a room, Ünïcode"
    linux = extracted(fmu, folder)
    (library,) = (folder / "binaries" / "win64").glob("*.dll")
    windows = [
        f"Z:{library}",
        description.guid,
        "file:///Z:" + (folder / "resources").as_uri()[7:],
        *linux[3:],
    ]
    told = in_wine(
        tmp_path, [*windows, "crowd=20", "threads=4", "states=3", "wrong=3", "run=300"]
    ).splitlines()
    assert told[:4] == ["crowd 20", "threads 4", "states 3", "wrong 3, 51 messages"]

    host = compiled("multithreaded_host", tmp_path)
    assert host
    here = subprocess.run([str(host), *linux, "run=300"], capture_output=True, text=True, check=True)
    there = [float(line) for line in told[4:]]
    # log and pow are other people's there: last bits differ, and the steps of 1e-6 with them.
    assert there == pytest.approx([float(line) for line in here.stdout.split()], rel=1e-6, abs=1e-6)
