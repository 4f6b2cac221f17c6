# SPDX-License-Identifier: BSD-3-Clause
"""Files from others, malformed by accident or on purpose: each is read or refused in a sentence, soon."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hostile_files import KINDS
from samples import thorough_beyond

import gelenk

SECONDS, MEGABYTES = 2.0, 300.0  # of processor time and of additional memory, for each file
NEEDED = {"netcdf": "h5netcdf", "parquet": "pyarrow", "store": "pyarrow", "urdf": "yourdfpy"}
NEEDED |= dict.fromkeys(("stl", "obj", "ply", "off"), "trimesh")


def outcomes(kind: str, folder: Path) -> list[dict[str, Any]]:
    program = [sys.executable, "-W", "ignore", str(Path(__file__).with_name("hostile_files.py"))]
    done = subprocess.run([*program, kind, str(folder)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is measured on Linux")
@pytest.mark.parametrize("kind", thorough_beyond(KINDS, ["csv", "inputs", "json"]))
def test_a_hostile_file_is_refused_in_a_sentence(kind: str, tmp_path: Path) -> None:
    """Some 460 files; only exceptions of Gelenk, and OSError for what cannot be opened."""
    if kind in NEEDED:
        pytest.importorskip(NEEDED[kind])
    found = outcomes(kind, tmp_path)
    assert len(found) > 10
    for each in found:
        assert not each["said"].startswith("RAW"), each
        assert each["seconds"] <= SECONDS, each
        assert each["megabytes"] <= MEGABYTES, each
    assert not Path("/tmp/was_run").exists()
    assert not Path("/tmp/absolute").exists()


@pytest.mark.parametrize("make", [lambda path: path.write_bytes(bytes(9)), os.mkfifo], ids=["file", "pipe"])
@pytest.mark.parametrize(
    "read",
    [gelenk.load, gelenk.simulate, gelenk.import_urdf, gelenk.Result.read, gelenk.linearize, gelenk.modes],
)
def test_names_with_a_zero_byte_are_refused(make: Any, read: Any, tmp_path: Path) -> None:
    make(tmp_path / "a")
    endings = {gelenk.load: ".yaml", gelenk.import_urdf: ".urdf", gelenk.Result.read: ".csv"}
    with pytest.raises(gelenk.UsageError, match="found a zero byte in the name of a file, expected none"):
        read(f"{tmp_path}/a\0{endings.get(read, '.fmu')}")


def test_scenes_and_inputs_may_come_from_pipes(four_bar_file: Path, tmp_path: Path) -> None:
    scene, table = tmp_path / "scene.yaml", tmp_path / "inputs.csv"
    for pipe in (scene, table):
        os.mkfifo(pipe)
    with (
        subprocess.Popen(["cp", str(four_bar_file), str(scene)]),
        subprocess.Popen(["sh", "-c", f"printf 'time,drive.tau\\n0,3\\n' > {table}"]),
    ):
        run = gelenk.simulate(scene, stop=0.1, inputs=table)
    assert run.table.tobytes() == gelenk.simulate(
        four_bar_file, stop=0.1, inputs={"drive.tau": 3.0}
    ).table.tobytes()  # fmt: skip


def test_a_pipe_that_does_not_end_is_refused(four_bar_file: Path, tmp_path: Path) -> None:
    scene, table = tmp_path / "scene.yaml", tmp_path / "inputs.csv"
    for pipe in (scene, table):
        os.mkfifo(pipe)
    with (
        subprocess.Popen(["sh", "-c", f"yes '# x' > {scene}"], stderr=subprocess.DEVNULL),
        pytest.raises(
            gelenk.SceneError, match=r"scene\.yaml: found 50 MB, expected a scene of at most 32 MB"
        ),
    ):
        gelenk.load(scene)
    with (
        subprocess.Popen(["sh", "-c", f"yes 1,2 > {table}"], stderr=subprocess.DEVNULL),
        pytest.raises(gelenk.UsageError, match=r"inputs\.csv: found more than 4 MB in a pipe"),
    ):
        gelenk.simulate(four_bar_file, inputs=table)
