# SPDX-License-Identifier: BSD-3-Clause
"""Instructions of one evaluation and of its functions, counted by callgrind, which is reproducible."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.speed import timings
from benchmarks.speed.tools import Tools

SCENES = ("fourbar", "slidercrank", "bricard", "arm7", "stewart", "governor", "andrews", "chain_p_32",
          "chain_s_32", "nfourbar_10")  # fmt: skip
CALLS = 500


@dataclass(frozen=True)
class Cost:
    """Instructions of one evaluation, in total and in each function itself."""

    scene: str
    instructions: float
    functions: dict[str, float]


def short(name: str) -> str:
    """Return a function's name without namespace, template arguments and parameters."""
    before, name = "", re.sub(r" \[clone [^\]]*\]", "", name)
    while before != name:
        before, name = name, re.sub(r"<[^<>]*>|\([^()]*\)", "", name)
    word = name.replace(" const", "").split(" ")[-1]
    return "::".join(word.replace("'2", "").split("::")[-2:]).replace("kernels::", "").replace("gelenk::", "")


def read(path: Path) -> Counter[str]:
    """Return the exclusive instructions by function ("Callgrind Format Specification" in its manual)."""
    names: dict[str, str] = {}
    found: Counter[str] = Counter()
    function, is_call = "", False
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("fn="):
            number, _, name = line[3:].partition(" ")
            if name:
                names[number] = name
            function = names[number]
        elif line.startswith(("cfn=", "cfi=", "cob=")):
            number, _, name = line[4:].partition(" ")
            if name and line.startswith("cfn="):
                names[number] = name
        elif line.startswith("calls="):
            is_call = True  # the next line is the cost of the called function
        elif re.match(r"[+\-*0-9]", line):
            if not is_call:
                found[short(function)] += int(line.split()[1])
            is_call = False
    return found


def _count(tools: Tools, scene: Path, calls: int) -> Counter[str]:
    with TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind"
        subprocess.run(
            ["valgrind", "--tool=callgrind", "--toggle-collect=gelenk::Formulation::rhs*", "--dump-line=no",
             f"--callgrind-out-file={out}", str(tools.gelenk_kernels), str(scene), "evaluate",
             str(calls)],
            check=True, capture_output=True, env=tools.environment,
        )  # fmt: skip
        return read(out)


def measure(tools: Tools, scene: str) -> Cost:
    """Count the instructions of one evaluation. Raises CalledProcessError, OSError."""
    path, _ = timings.write_scene(tools, scene)
    # The evaluations that prepare a run are the same in both counts.
    found = _count(tools, path, CALLS + 1)
    found.subtract(_count(tools, path, 1))
    functions = {name: n / CALLS for name, n in found.items()}
    return Cost(scene, sum(functions.values()), functions)


def study(tools: Tools, scenes: Sequence[str], report: Callable[[str], None]) -> list[Cost]:
    """Return the instructions of all scenes; nothing if Valgrind is not installed."""
    if shutil.which("valgrind") is None:
        report("Valgrind is not installed: instructions are not counted")
        return []
    out = []
    for scene in scenes:
        try:
            out.append(measure(tools, scene))
        except subprocess.CalledProcessError as fault:
            report(f"{scene}: {fault}")
            continue
        report(f"{scene}: {out[-1].instructions:.0f} instructions")
    return out
