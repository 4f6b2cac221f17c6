# SPDX-License-Identifier: BSD-3-Clause
"""What `make` decides before it builds: how many jobs run at once, and whether a target has what it needs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gelenk import demo

GIGABYTE = 1_048_576  # in kB, as in /proc/meminfo
PROCESSORS = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


def jobs(root: Path, folder: Path, available: int, threads: str = "") -> int:
    """How many jobs run at once with this memory [kB] available, and these threads allowed to OpenMP."""
    (folder / "meminfo").write_text(f"MemTotal: 99 kB\nMemAvailable:   {available} kB\n")
    command = ["sh", str(root / "cmake" / "jobs.sh"), str(folder / "meminfo")]
    env = {**os.environ, "OMP_NUM_THREADS": threads, "OMP_THREAD_LIMIT": threads} if threads else None
    return int(subprocess.run(command, capture_output=True, text=True, check=True, env=env).stdout)


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="reads /proc/meminfo, of Linux")
def test_all_processors_work_as_far_as_memory_allows(root: Path, tmp_path: Path) -> None:
    script = (root / "cmake" / "jobs.sh").read_text(encoding="utf-8")
    per_job = int(re.findall(r"^MEGABYTES=(\d+)", script, re.MULTILINE)[0])
    # A container may have less memory.
    assert jobs(root, tmp_path, 1000 * GIGABYTE) in range(1, PROCESSORS + 1)
    assert jobs(root, tmp_path, per_job * 1024 - 1) == 1
    assert jobs(root, tmp_path, 0) >= 1
    assert jobs(root, tmp_path, 2 * per_job * 1024 - 1) == 1
    assert jobs(root, tmp_path, 2 * per_job * 1024) == min(2, PROCESSORS)
    # Dask sets it for its own workers, users for OpenMP: nproc then counts these threads.
    assert jobs(root, tmp_path, 2 * per_job * 1024, threads="1") == min(2, PROCESSORS)


@pytest.fixture
def bare(tmp_path: Path) -> dict[str, str]:
    """An environment whose PATH has nothing but a shell."""
    for program in ("sh", "bash", "printf"):
        found = shutil.which(program)
        assert found is not None
        (tmp_path / program).symlink_to(found)
    return {"PATH": str(tmp_path)}


PACKAGES = {
    "costs": {"valgrind"},
    "fuzz": {"clang"},
    "masters": {"maven", "default-jdk", "cargo"},
    "page-core": {"cargo"},
    "runtimes": {"cargo"},
    "sanitize": {"valgrind", "libgcc-VERSION-dev"},
}


@pytest.mark.parametrize("target", PACKAGES)
def test_what_a_target_lacks_is_named_before_anything_is_built(
    target: str, root: Path, bare: dict[str, str]
) -> None:
    make = shutil.which("make")
    assert make is not None
    done = subprocess.run(
        [make, "-C", str(root), target], env=bare, capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode != 0
    faults = [line for line in done.stderr.splitlines() if line.startswith(f"make {target}: ")]
    packages = {re.findall(r"\(Debian, Ubuntu: apt install (\S+?)\)", line)[0] for line in faults}
    assert packages - {"libclang-dev"} == PACKAGES[target]  # of libclang, folders of the system are searched
    assert "Creating" not in done.stdout + done.stderr
    assert "Fetching" not in done.stdout + done.stderr


def test_every_target_that_needs_more_than_a_compiler_checks_it(root: Path) -> None:
    """Programs that recipes call, other than those of .venv, of the shell and of the build."""
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    checked = set(re.findall(r"^needs-([\w-]+):", makefile, re.MULTILINE))
    assert checked == set(PACKAGES)
    for target in checked:
        assert re.search(rf"^{target}: needs-{target} ", makefile, re.MULTILINE)
    for program, target in (("mvn", "masters"), ("cargo", "masters")):
        assert re.search(rf"^\t{program} ", makefile, re.MULTILINE)
        assert target in checked


def test_a_compiler_that_is_too_old_is_named_before_the_first_download(
    root: Path, bare: dict[str, str], tmp_path: Path
) -> None:
    old = tmp_path / "old++"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    done = subprocess.run(
        ["sh", str(root / "cmake" / "needs.sh"), "demo", "c++"], env=bare | {"CXX": str(old)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.startswith(f"make demo: found no C++20 compiler ({old}, which CXX=... selects)")


@pytest.mark.skipif(sys.prefix == sys.base_prefix, reason="the environment is not a virtual one")
def test_the_demo_ends_with_how_the_command_is_called(
    root: Path, bare: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(root)
    monkeypatch.setenv("PATH", bare["PATH"])
    first, last = demo.how_to_call("gelenk check", "four_bar.yaml")
    activate = re.findall(r"source (\S+)", first)[0]
    shell = shutil.which("bash")
    assert shell is not None
    found = subprocess.run(
        [shell, "-c", f"source {activate} && type -p gelenk"], capture_output=True, text=True, check=True
    ).stdout.strip()
    assert Path(found).is_file()
    assert found == str(Path(re.findall(r"or call (\S+)\)", first)[0]).absolute())
    assert last == f"Try: gelenk check {Path('scenes', 'four_bar.yaml')}"
    monkeypatch.setenv("PATH", str(Path(found).parent))
    assert demo.how_to_call("gelenk check", "four_bar.yaml") == [last]
