# SPDX-License-Identifier: BSD-3-Clause
"""Sweeps that are interrupted: what was computed is kept, nothing is lost or made twice."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import gelenk
from gelenk.sweeps import driver
from gelenk.sweeps.store import OLD
from sweeps.test_runs import same

RUNS = 60


def made(four_bar: gelenk.Scene, store: Path | None, **options: Any) -> xr.Dataset:
    parameters = {
        "crank.m": "normal(1, 0.05)",
        "A.damping": "uniform(-0.01, 0.2)",
        "solver.integrator": "rk4",
    }
    given: dict[str, Any] = {
        "design": "latin", "samples": RUNS, "outputs": {"A.phi": ["rms", "trajectory"]}, "stop": 0.05,
        "store": store,
    }  # fmt: skip
    return gelenk.sweep(four_bar, parameters, **given | options)


def parts(store: Path) -> list[Path]:
    return sorted(store.glob("runs-*.parquet"))


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of two runs: 51 points of a signal are 408 bytes."""
    monkeypatch.setattr(driver, "MAX_CHUNK_BYTES", 1000)


class Interruption(Exception):  # noqa: N818
    """What stops a sweep in these tests."""


def test_a_sweep_interrupted_ten_times_is_the_same_to_the_bit(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    counts = []
    for turn in range(1, 11):

        def interrupt(done: int, _: int, until: int = 5 * turn) -> None:
            if done >= until:
                raise Interruption

        with pytest.raises(Interruption):
            made(four_bar, tmp_path, progress=interrupt, workers=2)
        counts.append(len(parts(tmp_path)))
    assert counts == sorted(set(counts))  # each turn adds to what is there
    before = {path: path.stat().st_mtime_ns for path in parts(tmp_path)}
    resumed = made(four_bar, tmp_path)
    assert same(resumed, made(four_bar, None))
    assert {path: path.stat().st_mtime_ns for path in before} == before  # nothing was made twice
    covered = [run for p in parts(tmp_path) for run in range(int(p.name[5:14]), int(p.name[15:24]) + 1)]
    assert sorted(covered) == list(range(RUNS))
    assert any(resumed["error"].values)
    assert not all(resumed["error"].values)


def test_a_complete_store_is_read_without_a_run(
    four_bar: gelenk.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = made(four_bar, tmp_path)
    monkeypatch.setattr("gelenk.sweeps.plan.Plan.run", None)
    assert same(made(four_bar, tmp_path), first)


@pytest.mark.thorough
def test_a_process_that_is_killed_leaves_whole_parts(four_bar_file: Path, tmp_path: Path) -> None:
    store = tmp_path / "store"
    code = f"""
import os, gelenk
def progress(done, total):
    if done >= 20:
        os.kill(os.getpid(), 9)
gelenk.sweep({str(four_bar_file)!r}, {{"crank.m": [0.9 + 0.001 * k for k in range(200)]}}, stop=0.5,
             outputs={{"A.phi": "max"}}, store={str(store)!r}, progress=progress, workers=2)
"""
    done = subprocess.run([sys.executable, "-c", code], timeout=60, check=False)
    assert done.returncode == -9
    assert parts(store)
    crank = [0.9 + 0.001 * k for k in range(200)]
    options: dict[str, Any] = {"outputs": {"A.phi": "max"}, "stop": 0.5}
    resumed = gelenk.sweep(four_bar_file, {"crank.m": crank}, store=store, **options)
    assert same(resumed, gelenk.sweep(four_bar_file, {"crank.m": crank}, **options))


def test_a_damaged_part_is_made_again(
    four_bar: gelenk.Scene, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    first = made(four_bar, tmp_path)
    part = parts(tmp_path)[3]
    content = bytearray(part.read_bytes())
    content[len(content) // 2] ^= 1
    part.write_bytes(content)
    old, new = (tmp_path / f".sweep-{k:016x}.part.json" for k in range(2))
    for draft in (old, new):
        draft.write_bytes(b"of a process that was killed, or is writing")
    os.utime(old, (0, time.time() - 2 * OLD))
    assert same(made(four_bar, tmp_path), first)
    assert f"{part}: damaged, its checksum is another one; its runs are made again" in caplog.text
    assert not old.exists()
    assert new.exists()


def test_another_sweep_is_refused(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    made(four_bar, tmp_path)
    for options, word in (
        ({"seed": 1}, "seed: found 0, expected 1"),
        ({"samples": 61}, "runs: found 60, expected 61"),
        ({"stop": 0.06}, "stop: found 0.05, expected 0.06"),
        ({"inputs": {"drive.tau": 1.0}}, "inputs_sha256"),
        ({"outputs": {"A.phi": "max"}}, "variables"),
    ):
        with pytest.raises(gelenk.UsageError) as caught:
            made(four_bar, tmp_path, **options)
        assert f"{tmp_path}: found a store of another sweep (" in str(caught.value)
        assert word in str(caught.value)


def test_a_folder_with_other_files_is_refused(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(gelenk.UsageError, match="found other files, expected an empty folder"):
        made(four_bar, tmp_path)


FULL = """
import resource, signal, sys, gelenk
from gelenk.sweeps import store
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
write = store.Store._write
def limited(self, path, content):
    if len(self._parts) == 1:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))  # the next file ends after 100 bytes
    write(self, path, content)
store.Store._write = limited
try:
    gelenk.sweep(sys.argv[1], {"crank.m": [0.9 + 0.01 * k for k in range(20)]}, stop=0.01, workers=1,
                 outputs={"A.phi": "max"}, store=sys.argv[2])
except OSError as e:
    print(e.filename, "|", e.strerror)
"""


def test_a_disk_that_is_full_is_reported_and_the_rest_made_later(four_bar_file: Path, tmp_path: Path) -> None:
    """The limit of the size of files stops the writing in the middle of a file, as a full disk does."""
    store = tmp_path / "store"
    command = [sys.executable, "-c", FULL, str(four_bar_file), str(store)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == (
        f"{store} | File too large; 1 of 20 runs are stored, and the same call makes the others\n"
    )
    assert len(parts(store)) == 1
    assert not list(store.glob(".writing-*"))
    crank = [0.9 + 0.01 * k for k in range(20)]
    found = gelenk.sweep(four_bar_file, {"crank.m": crank}, outputs={"A.phi": "max"}, stop=0.01, store=store)
    assert not np.isnan(found["A.phi.max"].values).any()


def test_a_folder_that_cannot_be_written_is_reported(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="file"):
        made(four_bar, tmp_path / "file" / "store")


def test_large_trajectories_remain_in_the_store(
    four_bar: gelenk.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = made(four_bar, tmp_path)
    monkeypatch.setattr("gelenk.sweeps.runs.MAX_MEMORY", 1000)
    lazy = made(four_bar, tmp_path)
    assert lazy["A.phi"].chunks is not None
    assert same(lazy.compute(), whole)


def test_the_sizes_of_chunks_follow_from_the_cost_of_runs(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    """They are parts of the folder: two runs each, as the limit of memory asks for."""
    made(four_bar, tmp_path, workers=1)
    sizes = [int(p.name[15:24]) - int(p.name[5:14]) + 1 for p in parts(tmp_path)]
    assert max(sizes) == 2
    assert sum(sizes) == RUNS
