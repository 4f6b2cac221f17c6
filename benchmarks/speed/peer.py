# SPDX-License-Identifier: BSD-3-Clause
"""What the scripts that run another engine share; they run in a virtualenv of their own, without Gelenk.

Arguments: forward NAME ..., step NAME ..., or run NAME METHOD=SETTING ... A line of JSON for each figure,
with the mechanism under "scene"; of what fails one with the reason under "fault".
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

# Of joints at every sample, the start first.
type Samples = list[list[float]]
LONGEST = 20.0  # s, of one run
ROUNDS = 500  # of 1 ms, of a master


def library(name: str) -> ctypes.CDLL:
    """A library that the study has compiled."""
    return ctypes.CDLL(str(os.environ["GELENK_BENCH_LIBRARIES"]) + f"/{name}", mode=ctypes.RTLD_GLOBAL)


def ref_us() -> float:
    """The arithmetic kernel, now."""
    kernel = library("libref_kernel.so").ref_kernel
    kernel.restype = ctypes.c_double
    return 1e6 * float(kernel(100))


def tell(**line: Any) -> None:
    print(json.dumps(line), flush=True)


def tell_time(scene: str, kernel: str, seconds: float, end: Sequence[float] = ()) -> None:
    """A kernel's time; end: the joints' coordinates after the rounds of a master."""
    tell(scene=scene, kernel=kernel, us=1e6 * seconds, ref_us=ref_us(), end=list(end))


def tell_run(scene: str, method: str, setting: float, cpu: float, samples: Samples, finished: bool) -> None:
    tell(
        scene=scene,
        method=method,
        setting=setting,
        cpu_s=cpu,
        finished=finished and bool(np.all(np.isfinite(samples))),
        ref_us=ref_us(),
        samples=np.nan_to_num(samples, nan=1e300, posinf=1e300, neginf=-1e300).tolist(),
    )


type Run = tuple[float, Samples, bool]  # s; whether it came to its end


def sampled(
    tree: Tree, coordinates: Callable[[], list[float]], advance: Callable[[float], tuple[float, bool]]
) -> Run:
    """One run. advance: to a time [s]; returns the seconds it took, and whether the motion is still one."""
    samples, cpu = [coordinates()], 0.0
    for k in range(round(tree.stop / tree.sample)):
        taken, sound = advance((k + 1) * tree.sample)
        cpu += taken
        samples.append(coordinates())
        if not sound or cpu >= LONGEST:
            return cpu, samples, False
    return cpu, samples, True


def tell_least(tree: Tree, method: str, setting: float, once: Callable[[], Run], rounds: int) -> None:
    """The quickest of so many runs, or of those made until one took 0.3 s."""
    best: Run = (np.inf, [], False)
    for _ in range(rounds):
        made = once()
        if made[0] < best[0]:
            best = made
        if made[0] > 0.3:
            break
    tell_run(tree.name, method, setting, *best)


def torques(tree: Tree, steps: int, step: float = 1e-3) -> Array:
    """A master's: another at each step; by joint."""
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
    """Does what the arguments say."""
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
    """A fault of one mechanism is told, and no hindrance to the next."""
    try:
        measure(families.make(scene), *arguments)
    except Exception as fault:
        tell(scene=scene, fault=f"{type(fault).__name__}: {' '.join(str(fault).split())[:200]}")
