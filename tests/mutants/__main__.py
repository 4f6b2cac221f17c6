# SPDX-License-Identifier: BSD-3-Clause
"""`python -m mutants COUNT [SEED] [--list]`: runs the suite on mutants; prints those that survive."""

from __future__ import annotations

import argparse
import gzip
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import gelenk

from .places import ROOT, Mutant, drawn

BUILD = ROOT / "build" / "mutants"
TREE, PACKAGE = BUILD / "tree", BUILD / "package"
PYTEST = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
PYTEST += ["-m", "not (clock or platforms or study)"]


def copied() -> None:
    """The sources to be mutated, and the package as it is installed, on which tests run."""
    shutil.rmtree(PACKAGE, ignore_errors=True)
    shutil.copytree(Path(gelenk.__file__).parent, PACKAGE / "gelenk")
    ignored = shutil.ignore_patterns(".git", ".venv", "build", "out", "__pycache__", ".*_cache")
    shutil.copytree(ROOT, TREE, ignore=ignored, dirs_exist_ok=True)


def run(command: list[str], folder: Path, **env: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=os.environ | env)


def built(jobs: str) -> bool:
    """Compile the tree and put the libraries into the package; whether they could be compiled."""
    folder = BUILD / "native"
    if not (folder / "build.ninja").exists():
        options = ["-DGELENK_PYTHON=ON", "-DGELENK_SCENES=OFF", f"-DPython_EXECUTABLE={sys.executable}"]
        made = run(["cmake", "-S", str(TREE), "-B", str(folder), "-G", "Ninja", *options], ROOT)
        if made.returncode:
            sys.exit(made.stdout + made.stderr)
    if run(["ninja", "-C", str(folder), "-j", jobs, "_core", "gelenk_fmu"], ROOT).returncode:
        return False
    for old in (PACKAGE / "gelenk").glob("_core*.so"):
        old.unlink()
    shutil.copy(next(folder.glob("_core*.so")), PACKAGE / "gelenk")
    for library in folder.glob("runtime/*/gelenk_fmu.so"):
        to = PACKAGE / "gelenk" / "runtime" / library.parent.name / "gelenk_fmu.so.gz"
        to.write_bytes(gzip.compress(library.read_bytes(), 1))
    return True


def near(mutant: Mutant) -> list[str]:
    """Test files that mention the mutated file by a word of its name, the most telling first."""
    words = {word for word in re.split(r"[_./]", str(mutant.path.relative_to(ROOT))) if len(word) > 4}
    found = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        text = path.read_text(encoding="utf-8")
        score = sum((word in text) + 3 * (word in path.stem) for word in words)
        if score > 2:
            found.append((-score, str(path)))
    return [name for _, name in sorted(found)[:12]]


def killer(mutant: Mutant, jobs: str) -> str:
    """The first test that fails; empty: none does."""
    for tests in (near(mutant), ["tests"]):
        if not tests:
            continue
        done = run([*PYTEST, "-n", jobs, *tests], ROOT, PYTHONPATH=str(PACKAGE))
        if done.returncode not in (0, 5):
            failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
            return failed[1] if failed else done.stdout.strip().splitlines()[-1]
    return ""


def tried(mutant: Mutant, jobs: str) -> str:
    """What notices the mutant; empty: nothing does."""
    relative = mutant.path.relative_to(ROOT)
    if mutant.path.suffix == ".py":
        target = PACKAGE / "gelenk" / relative.relative_to("python/gelenk")
        original = target.read_text(encoding="utf-8")
        target.write_text(mutant.text, encoding="utf-8")
        try:
            return killer(mutant, jobs)
        finally:
            target.write_text(original, encoding="utf-8")
    target = TREE / relative
    original = target.read_text(encoding="utf-8")
    target.write_text(mutant.text, encoding="utf-8")
    try:
        return killer(mutant, jobs) if built(jobs) else "the compiler"
    finally:
        target.write_text(original, encoding="utf-8")


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m mutants", description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("--jobs", default=str(os.cpu_count() or 1))
    parser.add_argument("--list", action="store_true", help="print the mutants, run nothing")
    given = parser.parse_args()
    mutants = drawn(given.count, given.seed)
    if given.list:
        print(*mutants, sep="\n")
        return 0
    copied()
    survivors = 0
    for i, mutant in enumerate(mutants):
        begun = time.monotonic()
        by = tried(mutant, given.jobs)
        survivors += not by
        seconds = time.monotonic() - begun
        print(f"{i + 1}/{len(mutants)} {mutant}\n    {by or 'SURVIVED'} ({seconds:.0f} s)", flush=True)
    print(f"{len(mutants) - survivors} of {len(mutants)} killed")
    return survivors > len(mutants) // 20


if __name__ == "__main__":
    sys.exit(main())
