# SPDX-License-Identifier: BSD-3-Clause
"""Thousands of instances, side by side and one after the other, in a host written in C."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

import gelenk

from .c_hosts import extracted
from .plants import crank_rocker, gyroscope

HOST = "multithreaded_host"


def play(host: Path, arguments: list[str], *tasks: str, **variables: str) -> str:
    run = subprocess.run(
        [str(host), *arguments, *tasks],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, (run.returncode, run.stdout, run.stderr)
    return run.stdout


@pytest.mark.parametrize(("integrator", "n"), [("auto", 200), ("rk4", 200), ("ida", 40), ("cvode", 100)])
def test_instances_in_turns_and_in_threads_give_the_bits_of_one_alone(
    integrator: str, n: int, host: Path, tmp_path: Path
) -> None:
    source = crank_rocker()
    source["solver"] = {"integrator": integrator}
    arguments = extracted(gelenk.export_fmu(source, tmp_path / "x.fmu"), tmp_path / "x")
    assert play(host, arguments, f"crowd={n}", "threads=4") == f"crowd {n}\nthreads 4\n"


def test_instances_of_quaternions_give_the_bits_of_one_alone(host: Path, tmp_path: Path) -> None:
    arguments = extracted(gelenk.export_fmu(gyroscope(), tmp_path / "x.fmu"), tmp_path / "x")
    assert play(host, arguments, "crowd=50", "threads=4") == "crowd 50\nthreads 4\n"


@pytest.mark.thorough
@pytest.mark.parametrize("integrator", ["auto", "ida"])
def test_ten_thousand_lives_leave_no_memory_behind(
    integrator: str, host: Path, four_bar: gelenk.Scene, tmp_path: Path
) -> None:
    source = four_bar.to_dict()
    source["solver"] = {**source.get("solver", {}), "integrator": integrator}
    arguments = extracted(gelenk.export_fmu(source, tmp_path / "x.fmu"), tmp_path / "x")
    # glibc counts as taken what a thread keeps in stock, a stock that fills up over thousands of lives.
    told = play(host, arguments, "cycles=10000", GLIBC_TUNABLES="glibc.malloc.tcache_count=0")
    found = re.fullmatch(
        r"cycles 10000, kB resident (\d+) (\d+), bytes of heap (\d+) (\d+)\n",
        told,
    )
    assert found, told
    resident_first, resident_last, heap_first, heap_last = map(int, found.groups())
    # All lives are alike, so that what is taken after a thousand is taken after ten thousand. The smallest
    # block of malloc (32 bytes), lost in each of the 9000 lives between, would be 288 kB; some pages are the
    # host's.
    assert heap_last == heap_first
    assert resident_last - resident_first <= 64


def test_an_instance_is_ready_within_two_milliseconds(host: Path, four_bar_fmu: Path, tmp_path: Path) -> None:
    told = play(host, extracted(four_bar_fmu, tmp_path / "x"), "timing=300")
    found = re.search(r"median ([\d.]+) ", told)
    assert found, told
    # Of the processor's time, which other programs do not take from us; some 0.2 ms were seen.
    assert float(found[1]) < 2


def test_wrong_calls_are_refused_again_and_again(host: Path, four_bar_fmu: Path, tmp_path: Path) -> None:
    told = play(host, extracted(four_bar_fmu, tmp_path / "x"), "wrong=20")
    assert told == f"wrong 20, {20 * 17} messages\n"
