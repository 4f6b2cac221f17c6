# SPDX-License-Identifier: BSD-3-Clause
"""Measure steps of batches and write the table of docs/batches.md: `make batches`.

The smallest of several CPU times of each run counts: what else the machine does makes them only longer. With
two threads it is that of both, so that their gain is the one of two idle processors. Alone is one simulation
of the same scene with the same method, all steps in one call.
"""

from __future__ import annotations

import platform
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gelenk
from gelenk import _core

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.page_parts import put  # noqa: E402 (found by the line above)
from benchmarks.speed.families import PANDA  # noqa: E402

LANES = 1024
STEP = 1e-3  # s
INPUT = 0.5  # N m, N: at rest, a simulation alone would repeat a solution
LENGTH = 0.1  # s: of one measurement
REPEATED = 15


def panda() -> dict[str, Any]:
    """Franka Emika's Panda, with a damper in each joint."""
    bodies: dict[str, Any] = {}
    joints: dict[str, Any] = {}
    starts = (0, -0.785, 0, -2.356, 0, 1.571, 0.785)  # rad
    for k, (place, turn, mass, com, (xx, yy, zz, xy, xz, yz)) in enumerate(PANDA):
        moments = [xx, yy, zz, xy, xz, yz]
        bodies[f"link{k + 1}"] = {"mass": mass, "com": list(com), "inertia": moments}
        parent = {
            "body": f"link{k}" if k else "ground",
            "position": list(place),
            "rotation": {"axis": [1, 0, 0], "angle": turn * 1.5707963267948966},
        }
        joints[f"joint{k + 1}"] = {
            "type": "revolute", "axis": [0, 0, 1], "parent": parent, "child": f"link{k + 1}",
            "damping": 0.5, "start": {"phi": starts[k]},
        }  # fmt: skip
    motors = {f"motor{k + 1}": {"type": "drive", "joint": f"joint{k + 1}"} for k in range(7)}
    scene = {"gelenk": 1, "name": "Panda", "gravity": [0, 0, -9.81]}
    return {**scene, "bodies": bodies, "joints": joints, "motors": motors}


SCENES: dict[str, gelenk.Scene | Path | dict[str, Any]] = {
    **{name: ROOT / "scenes" / f"{name}.yaml" for name in ("cart_pole", "double_pendulum", "four_bar")},
    **{
        name: ROOT / "scenes" / f"{name}.yaml"
        for name in ("slider_crank", "five_bar", "free_body", "andrews")
    },
    "panda": panda(),
    **{name: ROOT / "scenes" / f"{name}.yaml" for name in ("bicycle", "stewart")},
}


def shortest(run: Callable[[], object]) -> float:
    """Return the shortest time of a call [s of CPU, of all threads]."""
    times = []
    for _ in range(REPEATED):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return min(times)


def alone(scene: gelenk.Scene) -> float:
    """Return the time of a step of one simulation [s]."""
    settings: dict[str, str | float] = {"solver.integrator": "rk4", "solver.step": STEP}
    plant = gelenk.Simulation(scene.with_parameters(settings))
    plant.initialize()
    for signal in plant.inputs:
        plant.set_input(signal.name, INPUT)
    count = 500
    return shortest(lambda: plant.step_to(plant.time + count * STEP)) / count


def together(scene: gelenk.Scene, threads: int = 1, lanes: int = LANES) -> float:
    """Return the time of a step of one lane [s]."""
    batch = gelenk.batch(scene, lanes, step=STEP, threads=threads)
    for name in batch.inputs:
        batch.inputs[name] = INPUT
    batch.step(2)
    begin = time.process_time()
    batch.step(10)
    count = max(1, round(LENGTH / ((time.process_time() - begin) / 10)))
    return shortest(lambda: batch.step(count)) / (count * lanes)


def rows() -> Iterator[str]:
    """Return the rows of the table."""
    for name, source in SCENES.items():
        scene = gelenk.load(source)
        operations = gelenk.batch(scene, 1, step=STEP)._core.operations
        one = alone(scene)
        fast = together(scene)
        two = together(scene, threads=2)
        _core.use_all_lane_instructions(False)
        baseline = together(scene)
        _core.use_all_lane_instructions(True)
        cells = [name, operations, f"{1e-6 / baseline:.3g}", f"{1e-6 / fast:.3g}"]
        row = f"| {' | '.join(map(str, [*cells, f'{2 * fast / two:.2f}', f'{one / fast:.0f}']))} |"
        print(row, flush=True)
        yield row


def main() -> None:
    """Write the table."""
    lines = [
        "| scene | operations | SSE2 | AVX2 | two threads | faster than alone |",
        "|---|--:|--:|--:|--:|--:|",
        *rows(),
        "",
        f"Million steps per second and core; {LANES} lanes, steps of 1 ms, {platform.machine()}.",
    ]
    put(ROOT / "docs" / "batches.md", "batches.py", {"steps": "\n".join(lines)})


if __name__ == "__main__":
    main()
