# SPDX-License-Identifier: BSD-3-Clause
"""Common parts of the scripts that run other engines, in a virtual environment without Gelenk.

Arguments: forward NAME ..., step NAME ..., or run NAME METHOD=SETTING ... Each figure is printed as a line of
JSON with the mechanism under "scene"; a failure is printed with its reason under "fault".
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from benchmarks.speed import families
from benchmarks.speed.tree import Array, Tree

# Joint coordinates at every sample, the start first
type Samples = list[list[float]]
LONGEST = 20.0  # s, limit of one run
ROUNDS = 500  # communication steps of 1 ms


def library(name: str) -> ctypes.CDLL:
    """Load a library that the study has compiled."""
    return ctypes.CDLL(str(os.environ["GELENK_BENCH_LIBRARIES"]) + f"/{name}", mode=ctypes.RTLD_GLOBAL)


def ref_us() -> float:
    """Time the arithmetic kernel `ref` now [us]."""
    kernel = library("libref_kernel.so").ref_kernel
    kernel.restype = ctypes.c_double
    return 1e6 * float(kernel(100))


def print_line(**line: Any) -> None:
    print(json.dumps(line), flush=True)


def print_time(scene: str, kernel: str, seconds: float, end: Sequence[float] = ()) -> None:
    """Print a kernel's time; `end` are the joint coordinates after the communication steps."""
    print_line(scene=scene, kernel=kernel, us=1e6 * seconds, ref_us=ref_us(), end=list(end))


def print_run(scene: str, method: str, setting: float, cpu: float, samples: Samples, finished: bool) -> None:
    print_line(
        scene=scene,
        method=method,
        setting=setting,
        cpu_s=cpu,
        finished=finished and bool(np.all(np.isfinite(samples))),
        ref_us=ref_us(),
        samples=np.nan_to_num(samples, nan=1e300, posinf=1e300, neginf=-1e300).tolist(),
    )


type Run = tuple[float, Samples, bool]  # processor time [s], samples, whether it finished


def sampled(
    tree: Tree, coordinates: Callable[[], list[float]], advance: Callable[[float], tuple[float, bool]]
) -> Run:
    """Run once. `advance` steps to a time [s] and returns (processor time [s], whether the run is valid)."""
    samples, cpu = [coordinates()], 0.0
    for k in range(round(tree.stop / tree.sample)):
        taken, sound = advance((k + 1) * tree.sample)
        cpu += taken
        samples.append(coordinates())
        if not sound or cpu >= LONGEST:
            return cpu, samples, False
    return cpu, samples, True


def print_fastest(tree: Tree, method: str, setting: float, once: Callable[[], Run], rounds: int) -> None:
    """Print the fastest of `rounds` runs, or of fewer if one takes more than 0.3 s."""
    best: Run = (np.inf, [], False)
    for _ in range(rounds):
        made = once()
        if made[0] < best[0]:
            best = made
        if made[0] > 0.3:
            break
    print_run(tree.name, method, setting, *best)


def torques(tree: Tree, steps: int, step: float = 1e-3) -> Array:
    """Return the torques of the communication steps, shape (steps, joints): a new value at each step."""
    moved = [i for i, b in enumerate(tree.bodies) if b.driven]
    out = np.zeros((steps, len(tree.bodies)))
    for k in range(steps):
        out[k, moved] = [tree.torque(i, k * step) for i in moved]
        out[k, moved[0]] += 1e-3 * (k % 7)
    return out


def least(call: Callable[[], float], rounds: int = 5) -> float:
    return min(call() for _ in range(rounds))


def timed(call: Callable[[], Any]) -> float:
    begin = time.thread_time()
    call()
    return time.thread_time() - begin


type Measure = Callable[[Tree], None]


def main(forward: Measure, step: Measure, run: Callable[[Tree, str, float], None]) -> None:
    """Run the measurement that the command line selects."""
    what, *rest = sys.argv[1:]
    if what == "run":
        name, *settings = rest
        for setting in settings:
            method, value = setting.split("=")
            attempt(name, run, method, float(value))
        return
    for name in rest:
        attempt(name, forward if what == "forward" else step)


def attempt(scene: str, measure: Callable[..., None], *arguments: Any) -> None:
    """Measure a mechanism; print a failure, so that the next one can still be measured."""
    try:
        measure(families.make(scene), *arguments)
    except Exception as fault:
        print_line(scene=scene, fault=f"{type(fault).__name__}: {' '.join(str(fault).split())[:200]}")
