# SPDX-License-Identifier: BSD-3-Clause
"""Reading hostile and malformed files of 14 kinds; as a program: what each of them causes.

python hostile_files.py KIND FOLDER
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import resource
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from hostile_contents import (
    FOUR_BAR,
    Files,
    anything,
    crafted_part,
    csv_tables,
    fmus,
    json_scenes,
    mat_tables,
    netcdf_tables,
    obj,
    off,
    parquet_tables,
    pipe,
    ply,
    stl,
    stores,
    urdf,
    yaml_scenes,
)

import gelenk
from gelenk.io.urdf import import_urdf

LONGEST = 20  # s, after which a file counts as endless


def read_store(path: Path) -> None:
    """Make a sweep, replace files of its store by those at a path, and continue."""
    replacements: dict[str, Any] = MADE.get(path.name, {})

    def swept() -> None:
        runs = {"crank.m": [1.0, 1.1, 1.2, 1.3]}
        gelenk.sweep(FOUR_BAR, runs, outputs={"A.phi": "max"}, stop=0.01, store=path, workers=1)

    swept()
    for name, content in replacements.items():
        for file in [path / name] if name != "runs" else sorted(path.glob("runs-*")):
            rows = file.name
            made = crafted_part(file, content) if isinstance(content, str) else content
            if isinstance(content, str):
                rows = f"{file.name[:25]}{hashlib.sha256(made).hexdigest()[:16]}.parquet"
            file.unlink()
            put(path / rows, made)
    swept()


MADE: dict[str, Any] = {}


def put(path: Path, content: Any) -> None:
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif isinstance(content, int):
        with path.open("wb") as file:
            file.truncate(content)
    elif isinstance(content, dict):
        MADE[path.name] = content
    else:
        content(path)


def with_mesh(path: Path) -> None:
    scene = gelenk.load(FOUR_BAR).to_dict()
    scene["bodies"]["crank"]["shapes"] = {"s": {"mesh": path.name}}
    from gelenk.model.scene import from_dict

    from_dict(scene, str(path.with_name("scene.json")))


def run_fmu(path: Path) -> None:
    from gelenk.simulation.recording import scene_of

    failed: gelenk.GelenkError | None = None
    for use in (scene_of, lambda file: gelenk.simulate(file, stop=0.01), gelenk.modes):
        try:
            use(path)
        except gelenk.GelenkError as e:
            failed = e
    if failed is not None:
        raise failed


def run_with_inputs(path: Path) -> None:
    gelenk.simulate(FOUR_BAR, stop=0.01, inputs=path)


KINDS: dict[str, tuple[str, Callable[[Path], Files], Callable[[Path], object]]] = {
    "yaml": (".yaml", lambda _: yaml_scenes(), gelenk.load),
    "json": (".json", lambda _: json_scenes(), gelenk.load),
    "stl": (".stl", lambda _: stl(), with_mesh),
    "obj": (".obj", lambda _: obj(), with_mesh),
    "ply": (".ply", lambda _: ply(), with_mesh),
    "off": (".off", lambda _: off(), with_mesh),
    "urdf": (".urdf", lambda _: urdf(), import_urdf),
    "fmu": (".fmu", fmus, run_fmu),
    "csv": (".csv", lambda _: csv_tables(header="time,A"), gelenk.Result.read),
    "inputs": (".csv", lambda _: csv_tables(header="time,drive.tau"), run_with_inputs),
    "parquet": (".parquet", parquet_tables, gelenk.Result.read),
    "netcdf": (".nc", netcdf_tables, gelenk.Result.read),
    "mat": (".mat", mat_tables, gelenk.Result.read),
    "store": ("", stores, read_store),
}


def files_of(kind: str, folder: Path) -> Iterator[Path]:
    """Make the files of a kind, one after the other."""
    ending, make, _ = KINDS[kind]
    (folder / "made").mkdir()
    of_kind = list(make(folder / "made"))
    general = [] if kind == "store" else list(anything(ending))
    if kind not in ("yaml", "json", "inputs", "store"):  # which may come from pipes
        general.append(("pipe", pipe))
    for name, content in general + of_kind:
        path = folder / f"{''.join(c if c.isalnum() else '_' for c in name)}{ending}"
        put(path, content)
        yield path
        if path.is_file() or path.is_symlink():
            path.unlink()


def outcome_of(read: Callable[[Path], object], path: Path) -> dict[str, Any]:
    """Read a file in a forked process: how it ended, processor time [s], and additional memory [MB]."""
    r, w = os.pipe()
    before = resident()
    child = os.fork()
    if not child:
        os.close(r)
        signal.alarm(LONGEST)
        said = "read"
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                read(path)
        except (gelenk.GelenkError, OSError) as e:
            said = f"{type(e).__name__}: {e}"
        except BaseException as e:
            said = f"RAW {type(e).__name__}: {e}"
        os.write(w, said.encode("utf-8", "replace")[:4000])
        os._exit(0)
    os.close(w)
    with os.fdopen(r, "rb") as file:
        text = file.read().decode("utf-8", "replace")
    _, status, used = os.wait4(child, 0)
    return {
        "file": path.name, "said": text or f"RAW status {status}",
        "seconds": used.ru_utime + used.ru_stime, "megabytes": max(0.0, used.ru_maxrss / 1e3 - before),
    }  # fmt: skip


def resident() -> float:
    """The memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


if __name__ == "__main__":
    kind, place = sys.argv[1], Path(sys.argv[2])
    ending, _, use = KINDS[kind]
    with contextlib.suppress(Exception):  # imports what is needed
        if ending:
            (place / f"first{ending}").write_bytes(b"<robot name='r'><link name='a'/></robot>")
        use(place / f"first{ending}")
    print(json.dumps([outcome_of(use, path) for path in files_of(kind, place)]))
