# SPDX-License-Identifier: BSD-3-Clause
"""Programs of the measurements: Gelenk's, and other engines from PyPI in a separate virtual environment."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PEERS = {"pinocchio": "pin>=4", "mujoco": "mujoco>=3.3", "drake": "drake>=1.40", "exudyn": "exudyn>=1.9"}
COMPILING = 1500.0  # s, limit; Pinocchio's headers take minutes


@dataclass
class Tools:
    """Paths of programs and folders. `missing` has the reason for each engine that is not available."""

    folder: Path
    gelenk_kernels: Path
    gelenk_runs: Path
    python: Path
    missing: dict[str, str] = field(default_factory=dict)

    @property
    def pinocchio(self) -> Path:
        """The program around Pinocchio's library."""
        return self.folder / "pinocchio-runs"

    @property
    def scenes(self) -> Path:
        """The folder of the mechanisms' files."""
        return self.folder / "scenes"

    def peer(self, name: str, *arguments: str) -> list[str]:
        """Return the command that runs the script peer_NAME.py."""
        return [str(self.python), "-m", f"benchmarks.speed.peer_{name}", *arguments]

    @property
    def environment(self) -> dict[str, str]:
        """Environment variables of all programs; one thread each."""
        single = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
        return os.environ | single | {"GELENK_BENCH_LIBRARIES": str(self.folder), "PYTHONPATH": str(ROOT)}


def _quiet(command: Sequence[str], timeout: float = COMPILING) -> str:
    """Run a command; return an empty string, or the end of its error output."""
    try:
        done = subprocess.run(list(command), capture_output=True, text=True, timeout=timeout, cwd=ROOT)
    except (OSError, subprocess.TimeoutExpired) as fault:
        return str(fault)[:200]
    words = (done.stderr or done.stdout).strip()
    return "" if done.returncode == 0 else " ".join(words.split())[-200:] or f"exit {done.returncode}"


def _compiler(kind: str) -> str:
    found = shutil.which(os.environ.get(*(("CC", "cc") if kind == "c" else ("CXX", "c++"))))
    if found is None:
        sys.exit(
            "make bench compiles small programs around the peers: no C and C++ compiler was found (cc, c++)"
        )
    return found


def _place(python: Path, package: str) -> Path:
    """Return the folder of an installed package."""
    code = f"import importlib.util as u; print(u.find_spec({package!r}).submodule_search_locations[0])"
    out = subprocess.run([str(python), "-c", code], capture_output=True, text=True, check=True)
    return Path(out.stdout.strip())


def versions(tools: Tools) -> str:
    """Return the names and versions of the available engines."""
    packages = [PEERS[name].split(">")[0] for name in PEERS if name not in tools.missing]
    code = f"import importlib.metadata as m; print(', '.join(p + ' ' + m.version(p) for p in {packages!r}))"
    out = subprocess.run([str(tools.python), "-c", code], capture_output=True, text=True, check=False)
    return out.stdout.strip()


def _newer(target: Path, *sources: Path) -> bool:
    return target.exists() and all(target.stat().st_mtime > source.stat().st_mtime for source in sources)


def _reference(tools: Tools) -> str:
    source, out = HERE / "ref_kernel.c", tools.folder / "libref_kernel.so"
    if _newer(out, source):
        return ""
    return _quiet([_compiler("c"), "-O2", "-shared", "-fPIC", str(source), "-o", str(out), "-lm"])


def _mujoco(tools: Tools) -> str:
    out, sources = tools.folder / "libmujoco_loop.so", [HERE / "mujoco_loop.c", HERE / "ref_kernel.c"]
    if _newer(out, *sources):
        return ""
    include = _place(tools.python, "mujoco") / "include"
    files = [str(source) for source in sources]
    return _quiet([_compiler("c"), "-O2", "-shared", "-fPIC", f"-I{include}", *files, "-o", str(out), "-lm"])


def _table() -> str:
    """Return DOP853's coefficients, from SciPy, as a C++ header."""
    from scipy.integrate import DOP853

    def numbers(array: np.ndarray) -> str:
        if array.ndim > 1:
            return "{" + ", ".join(numbers(row) for row in array) + "}"
        return "{" + ", ".join(repr(float(x)) for x in array) + "}"

    lines = [f"inline constexpr int stages = {DOP853.n_stages};"]
    for name in ("A", "B", "C", "E3", "E5"):
        array = np.asarray(getattr(DOP853, name))
        shape = "".join(f"[{n}]" for n in array.shape)
        lines.append(f"inline constexpr double {name}{shape} = {numbers(array)};")
    return "#pragma once\nnamespace dop853 {\n" + "\n".join(lines) + "\n}  // namespace dop853\n"


def _pinocchio(tools: Tools) -> str:
    """Compile the program around the wheel's library, for the vector width of the wheel."""
    sources = [HERE / name for name in ("pinocchio_runs.cpp", "pinocchio_model.h", "dop853.h", "runs.h",
                                        "timing.h", "tree_file.h")]  # fmt: skip
    if _newer(tools.pinocchio, *sources):
        return ""
    (tools.folder / "dop853_table.h").write_text(_table(), encoding="utf-8")
    place = _place(tools.python, "pinocchio")
    prefix = next(p for p in place.parents if p.name == "cmeel.prefix")
    # Definitions for Boost from Pinocchio's build and its CMake files
    boost = ["BOOST_MPL_LIMIT_LIST_SIZE=30", "BOOST_MPL_LIMIT_VECTOR_SIZE=30",
             "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "BOOST_FUSION_INVOKE_MAX_ARITY=12"]  # fmt: skip
    defines = [f"-D{d}" for d in (*boost, "NDEBUG", "PINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION")]
    objects = tools.folder / "ref_kernel.o"
    fault = _quiet([_compiler("c"), "-O2", "-c", str(HERE / "ref_kernel.c"), "-o", str(objects)])
    return fault or _quiet([
        _compiler("c++"), "-O3", "-std=c++20", "-w", *defines, f"-I{tools.folder}", f"-I{HERE}",
        f"-I{prefix / 'include'}", f"-I{prefix / 'include' / 'eigen3'}", str(sources[0]), str(objects),
        "-o", str(tools.pinocchio), f"-L{prefix / 'lib'}", "-lpinocchio_default", "-lboost_serialization",
        f"-Wl,-rpath,{prefix / 'lib'}",
    ])  # fmt: skip


def _install(tools: Tools, report: Callable[[str], None]) -> None:
    venv = tools.python.parent.parent
    if not tools.python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(venv)], check=True)
    pip = [str(tools.python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    for name, package in PEERS.items():
        module = {"drake": "pydrake"}.get(name, name)
        if _quiet([str(tools.python), "-c", f"import {module}"]) == "":
            continue
        report(f"installing {package}")
        more = ["cmeel-eigen>=3.4,<4"] if name == "pinocchio" else []
        fault = _quiet([*pip, package, *more])
        if fault:
            tools.missing[name] = f"not installed: {fault}"


def prepare(folder: Path, programs: Path, python: Path | None, report: Callable[[str], None]) -> Tools:
    """Install and compile what is missing.

    Args:
        folder: Folder for programs, libraries and scenes.
        programs: Folder of gelenk-kernels and gelenk-runs.
        python: Interpreter of the other engines; None: they are installed into the folder.
        report: Called with a message before each long operation.
    """
    folder.mkdir(parents=True, exist_ok=True)
    own = folder / "peers" / "bin" / "python"
    tools = Tools(folder, programs / "gelenk-kernels", programs / "gelenk-runs", python or own)
    for program in (tools.gelenk_kernels, tools.gelenk_runs):
        if not program.exists():
            sys.exit(f"{program} does not exist; `make bench` builds it")
    _install(tools, report)
    fault = _reference(tools)
    if fault:
        sys.exit(f"the reference kernel was not compiled: {fault}")
    tools.scenes.mkdir(exist_ok=True)
    for name, build in (("mujoco", _mujoco), ("pinocchio", _pinocchio)):
        if name in tools.missing:
            continue
        report(f"compiling the program for {name}")
        fault = build(tools)
        if fault:
            tools.missing[name] = f"not compiled: {fault}"
    return tools
