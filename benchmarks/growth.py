# SPDX-License-Identifier: BSD-3-Clause
"""Cost of reading, initializing and exporting a scene as a function of its size, from 256 to 4096 bodies.

`make growth` writes the table of docs/performance.md. Each figure is measured in a separate process:
processor time, and the increase of peak memory.
"""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.page_parts import put

import gelenk
from gelenk.chart.mechanisms import at, four_bar_chain, hinge, rod

PAGE = Path(__file__).resolve().parent.parent / "docs" / "performance.md"
SIZES = (256, 1024, 4096)
Scene = dict[str, Any]


@dataclass(frozen=True)
class Cost:
    """Processor times [s] and memory [MB] of one scene."""

    initialize: float
    initialize_memory: float
    export: float
    export_memory: float


def grown(n: int, carried: int) -> Scene:
    """Return n hinged rods of 0.1 m, each of which carries `carried` others at its end."""
    joints = {
        f"j{i}": hinge(at(f"b{(i - 1) // carried}", 0.1) if i else "ground", f"b{i}", start={"phi": 0.01})
        for i in range(n)
    }
    return scene({f"b{i}": rod(0.1) for i in range(n)}, joints)


def chain(n: int) -> Scene:
    """Return a chain of n rods."""
    return grown(n, 1)


def equipped(n: int) -> Scene:
    """Return a chain with a motor per joint, a frame sensor and a spring per body, and all parameters."""
    springs = {
        f"f{i}": {"type": "spring_damper", "from": {"body": f"b{i}"}, "to": "ground", "stiffness": 1.0}
        for i in range(n)
    }
    return chain(n) | {
        "motors": {f"m{i}": {"joint": f"j{i}"} for i in range(n)},
        "sensors": {f"s{i}": {"type": "frame", "body": f"b{i}"} for i in range(n)},
        "forces": springs,
        "parameters": "all",
    }


def tree(n: int) -> Scene:
    """Return a binary tree of n rods."""
    return grown(n, 2)


def islands(n: int) -> Scene:
    """Return n independent pendulums."""
    joints = {f"j{i}": hinge(at("ground", i), f"b{i}", start={"phi": 0.01}) for i in range(n)}
    return scene({f"b{i}": rod(0.1) for i in range(n)}, joints)


def n_four_bar(n: int) -> Scene:
    """Return the N-four-bar (IFToMM A02) with about n bodies."""
    return four_bar_chain(n // 2, 0.3, 1.0)


def ring(n: int) -> Scene:
    """Return n rods along a circle, all in one loop between two pins on the ground."""
    turn, length = 2 * math.pi / (n + 1), 0.1
    joints = {"j0": hinge("ground", "b0", start={"phi": 0.0})}
    for i in range(1, n):
        joints[f"j{i}"] = hinge(at(f"b{i - 1}", length), f"b{i}", start={"phi": turn})
    end = [sum(length * of(turn * i) for i in range(n)) for of in (math.cos, math.sin)]
    joints["end"] = hinge({"body": "ground", "position": [*end, 0]}, at(f"b{n - 1}", length))
    return scene({f"b{i}": rod(length) for i in range(n)}, joints)


def scissors(n: int) -> Scene:
    """Return a scissor lift of n / 2 crossed pairs."""
    angle = 0.7
    joints: Scene = {"base": hinge("ground", "l0", start={"phi": angle})}
    for i in range(n // 2):
        joints[f"c{i}"] = hinge(at(f"l{i}", 0.5), at(f"r{i}", 0.5), start={"phi": math.pi - 2 * angle})
        if i > 0:
            joints[f"a{i}"] = hinge(at(f"l{i - 1}", 1), f"r{i}")
            joints[f"d{i}"] = hinge(at(f"r{i - 1}", 1), f"l{i}")
    return scene({f"{side}{i}": rod(1) for i in range(n // 2) for side in "lr"}, joints)


def scene(bodies: Scene, joints: Scene) -> Scene:
    return {"gelenk": 1, "name": "Large", "gravity": [0, -9.81, 0], "bodies": bodies, "joints": joints}


FAMILIES: dict[str, Callable[[int], Scene]] = {
    "chain": chain,
    "equipped chain": equipped,
    "tree": tree,
    "islands": islands,
    "N-four-bar": n_four_bar,
    "ring": ring,
    "scissors": scissors,
}


def measured(family: str, n: int) -> Cost:
    """Measure the cost of a scene in a separate process."""
    command = [sys.executable, "-m", "benchmarks.growth", family, str(n)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, cwd=PAGE.parent.parent)
    if ended.returncode != 0:
        raise RuntimeError(ended.stderr)
    return Cost(**json.loads(ended.stdout))


def measure_here(family: str, n: int) -> Cost:
    source = FAMILIES[family](n)

    def initialize() -> None:
        gelenk.Simulation(gelenk.load(source)).initialize()

    def export() -> None:
        with tempfile.TemporaryDirectory() as folder:
            gelenk.export_fmu(source, Path(folder, "large.fmu"))

    figures: list[float] = []
    for action in (initialize, export):
        before = resource.getrusage(resource.RUSAGE_SELF)
        action()
        after = resource.getrusage(resource.RUSAGE_SELF)
        time = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        figures += [time, (after.ru_maxrss - before.ru_maxrss) / 1e3]
    # The export may reuse the memory of the initialization.
    figures[3] += figures[1]
    return Cost(*figures)


def exponent(small: float, large: float, ratio: float) -> float:
    return math.log(large / small) / math.log(ratio)


def table() -> str:
    lines = [
        "| family | bodies | initialization [s] | memory [MB] | FMU export [s] | memory [MB] "
        "| growth exponents: initialization, export |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for family in FAMILIES:
        last: Cost | None = None
        for n in SIZES:
            print(f"{family} of {n}", flush=True)
            cost = measured(family, n)
            if last is not None:
                lines.append(
                    f"| {family} | {n} | {cost.initialize:.3g} | {cost.initialize_memory:.0f} "
                    f"| {cost.export:.3g} | {cost.export_memory:.0f} | {growth(last, cost)} |"
                )
            last = cost
    return "\n".join(lines)


def growth(last: Cost, cost: Cost) -> str:
    """Return the growth exponents of initialization and export from one size to the next."""
    pairs = ((last.initialize, cost.initialize), (last.export, cost.export))
    return ", ".join(f"{exponent(*pair, SIZES[1] / SIZES[0]):.2f}" for pair in pairs)


def main(arguments: list[str]) -> None:
    if arguments:
        print(json.dumps(asdict(measure_here(arguments[0], int(arguments[1])))))
        return
    put(PAGE, "benchmarks/growth", {"large": table()})


if __name__ == "__main__":
    main(sys.argv[1:])
