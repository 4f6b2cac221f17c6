# SPDX-License-Identifier: BSD-3-Clause
"""Writers of all kinds of files, killed, stopped by a full disk, or two at once.

As a program: what remained how often.

python file_writers.py (kills | moments | full | two) KIND COUNT FOLDER
"""

from __future__ import annotations

import functools
import json
import os
import random
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import gelenk
from gelenk.cli.sweep import write

FOUR_BAR = Path(__file__).parent.parent / "scenes" / "four_bar.yaml"
REPEATS = 3  # writings in a process that is killed at a random time


def _plot(result: gelenk.Result, path: Path) -> None:
    from gelenk.cli.pictures import save_figure

    save_figure(result.plot(["A"]), path)


KINDS: dict[str, Callable[[Any, Path], object]] = {
    "csv": gelenk.Result.save, "parquet": gelenk.Result.save, "nc": gelenk.Result.save,
    "mat": gelenk.Result.save, "yaml": gelenk.Scene.save, "json": gelenk.Scene.save,
    "html": gelenk.View.save, "gif": gelenk.View.save, "png": gelenk.View.save, "svg": _plot,
    "fmu": functools.partial(gelenk.export_fmu, view=False),
    "ssp": functools.partial(gelenk.export_ssp, view=False),
    "sweep.csv": write, "sweep.parquet": write, "sweep.nc": write,
}  # fmt: skip


def new_and_old(kind: str, folder: Path) -> tuple[Path, Any, Any]:
    """A file that has been written, and what to write to it: the same, and something else."""
    random_numbers = np.random.default_rng(0)
    scene = gelenk.load(FOUR_BAR)
    found: list[Any]
    if KINDS[kind] in (gelenk.Result.save, _plot):
        rows = random_numbers.normal(size=(2, 2000, 3))
        found = [gelenk.Result(["A", "B"], values, {"A": "m", "B": "m"}) for values in rows]
    elif KINDS[kind] is write:
        import xarray

        values = random_numbers.normal(size=(2, 20, 100))
        found = [xarray.Dataset({"x": (("run", "time"), x), "error": ("run", ["none"] * 20)}) for x in values]
    elif KINDS[kind] is gelenk.View.save:
        other = scene.with_parameters({"A.phi_start": 1.2})  # a picture shows the start
        found = [gelenk.view(scene, stop=0.05), gelenk.view(other, stop=0.1)]
    else:
        found = [scene, gelenk.load({**scene.to_dict(), "name": "Another"})]
    path = folder / f"file.{kind}"
    KINDS[kind](found[0], path)
    return path, found[0], found[1]


def contents(kind: str, path: Path, what: Any) -> bytes:
    """What a file contains to which something is written."""
    other = path.with_name(f"other.{kind}")
    KINDS[kind](what, other)
    content = other.read_bytes()
    other.unlink()
    return content


def _in_a_child(function: Callable[[], None]) -> int:
    """Call a function in a forked process; return its number."""
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        function()
        code = 0
    except OSError:
        code = 2
    finally:
        os._exit(code)


class _Case:
    def __init__(self, kind: str, folder: Path) -> None:
        self.kind = kind
        self.folder = folder
        self.path, self.old, self.new = new_and_old(kind, folder)
        self.before = self.path.read_bytes()

        def writing() -> None:
            KINDS[kind](self.new, self.path)

        start = time.perf_counter()  # of a process as those that are killed
        os.waitpid(_in_a_child(writing), 0)
        self.seconds = time.perf_counter() - start
        self.size = self.path.stat().st_size

    def found(self) -> str:
        content = self.path.read_bytes()
        if content == self.before:
            return "old"
        # Pictures and HDF5 contain times and identifiers: what can be read and has the size is the new file.
        return "new" if self.is_new(content) else f"{len(content)} of {self.size} bytes"

    def is_new(self, content: bytes) -> bool:
        return len(content) == self.size

    def restore(self) -> None:
        for file in self.folder.iterdir():
            file.unlink()
        self.path.write_bytes(self.before)


def kills(kind: str, count: int, folder: Path) -> Counter[str]:
    """Kill processes that write a file, at random times."""
    case = _Case(kind, folder)
    outcomes: Counter[str] = Counter()
    for _ in range(count):
        case.restore()

        def writing() -> None:
            for _ in range(REPEATS):
                KINDS[kind](case.new, case.path)

        child = _in_a_child(writing)
        time.sleep(random.uniform(0.0, 1.5 * case.seconds))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        outcomes[case.found()] += 1
    return outcomes


def moments(kind: str, _: int, folder: Path) -> Counter[str]:
    """What a process would leave that is killed before a call of the operating system, or in one that writes.

    A killed process leaves what others see at that moment: the file is read before each call.
    """
    case = _Case(kind, folder)
    case.restore()
    outcomes: Counter[str] = Counter()
    reader, writer = os.pipe()
    is_looking = False

    def look(event: str, _: object) -> None:
        nonlocal is_looking
        if not is_looking and event.startswith(("open", "os.", "shutil.", "tempfile.")):
            is_looking = True
            os.write(writer, f"{case.found()}\n".encode())
            is_looking = False

    def looking() -> None:
        sys.addaudithook(look)
        KINDS[kind](case.new, case.path)
        look("open", None)

    child = _in_a_child(looking)
    os.close(writer)
    with os.fdopen(reader, encoding="utf-8") as file:
        outcomes.update(file.read().splitlines())
    _, status = os.waitpid(child, 0)
    outcomes[f"ended with {status}"] += 1
    case.restore()

    def cut() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (case.size // 2, case.size // 2))
        KINDS[kind](case.new, case.path)

    _, status = os.waitpid(_in_a_child(cut), 0)
    outcomes[f"killed by {os.WTERMSIG(status)}, {case.found()}"] += 1
    return outcomes


def full(kind: str, count: int, folder: Path) -> Counter[str]:
    """Let writing fail at the first byte, the last one, and then after a random number of bytes.

    The process must end by itself, with an OSError.
    """
    case = _Case(kind, folder)
    outcomes: Counter[str] = Counter()
    for k in range(count):
        case.restore()
        limit = (0, case.size - 1)[k] if k < 2 else random.randrange(case.size)

        def writing(limit: int = limit) -> None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            try:
                KINDS[kind](case.new, case.path)
            except gelenk.ExportError as e:
                raise OSError from e

        _, status = os.waitpid(_in_a_child(writing), 0)
        left = [file.name for file in folder.iterdir()]
        if status != 2 << 8 or left != [case.path.name]:
            outcomes[f"status {status}, files {left}"] += 1
        outcomes[case.found()] += 1
    return outcomes


def two(kind: str, count: int, folder: Path) -> Counter[str]:
    """Let two processes write one file, each so often; count what is found in it meanwhile."""
    case = _Case(kind, folder)
    after = case.path.read_bytes()
    expected, sizes = {case.before, after}, {len(case.before), len(after)}
    time.sleep(1.1)  # files of MATLAB, of HDF5 and SVG contain the time in seconds
    is_reproducible = contents(kind, case.path, case.new) == after

    def found() -> str:
        content = case.path.read_bytes()
        if content in expected or (not is_reproducible and len(content) in sizes):
            return "whole"
        return f"{len(content)} of {sizes} bytes"

    def writing(what: Any) -> None:
        for _ in range(count):
            KINDS[kind](what, case.path)

    outcomes: Counter[str] = Counter()
    children = [_in_a_child(functools.partial(writing, what)) for what in (case.old, case.new)]
    while children:
        outcomes[found()] += 1
        for child in list(children):
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                children.remove(child)
                outcomes[f"ended with {status}"] += 1
    left = [file.name for file in folder.iterdir()]
    outcomes[f"files {left}"] += 1
    outcomes[found()] += 1
    return outcomes


if __name__ == "__main__":
    job, kind, count, folder = sys.argv[1:]
    random.seed(0)
    jobs = {"kills": kills, "moments": moments, "full": full, "two": two}
    print(json.dumps(jobs[job](kind, int(count), Path(folder))))
