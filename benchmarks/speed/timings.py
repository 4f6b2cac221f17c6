# SPDX-License-Identifier: BSD-3-Clause
"""Processor time of kernels: the smallest of all rounds, with alternating engines."""

from __future__ import annotations

import csv
import json
import math
import resource
import subprocess
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.speed import families, tree
from benchmarks.speed.tools import Tools

ENGINES = ("gelenk", "pinocchio", "mujoco", "drake", "exudyn")
# s of processor time: limits of one call of a kernel and of a process
LONGEST_CALL, LONGEST_PROCESS = 0.3, 60.0
# Numbers of bodies above which an engine takes minutes, and engines that are measured only once
LARGEST = {"exudyn": 130, "drake": 300}
ONCE = ("drake", "exudyn")
MOST_MEMORY = 6 << 30  # bytes; Pinocchio allocates 4 nv^3 numbers, which exceeds this at n = 1024


def _limit_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))


@dataclass(frozen=True)
class Timing:
    """Time of an engine's kernel on a mechanism and of `ref` next to it [us], or why there is none."""

    scene: str
    engine: str
    kernel: str
    us: float = math.nan
    ref_us: float = math.nan
    fault: str = ""

    @property
    def ratio(self) -> float:
        """The time over `ref`."""
        return self.us / self.ref_us


def write_scene(tools: Tools, name: str) -> tuple[Path, Path]:
    """Write the mechanism as a scene and as plain numbers; return both paths."""
    made = families.make(name)
    scene, text = tools.scenes / f"{name}.json", tools.scenes / f"{name}.txt"
    scene.write_text(json.dumps(tree.to_scene(made)), encoding="utf-8")
    text.write_text(tree.to_text(made), encoding="utf-8")
    return scene, text


def command(tools: Tools, engine: str, what: str, name: str) -> list[str]:
    """Return the command of the process that measures `forward` or `step`."""
    scene, text = tools.scenes / f"{name}.json", tools.scenes / f"{name}.txt"
    if engine == "gelenk":
        return [str(tools.gelenk_kernels), str(scene), str(LONGEST_CALL)]
    if engine == "pinocchio":
        return [str(tools.pinocchio), what, str(text)]
    return tools.peer(engine, what, name)


def lines(tools: Tools, command: Sequence[str], timeout: float) -> tuple[list[dict[str, object]], str]:
    """Run a process; return the JSON lines that it prints and an error text, empty if it succeeded."""
    fault = ""
    try:
        done = subprocess.run(
            list(command),
            capture_output=True,
            text=True,
            timeout=timeout,
            env=tools.environment,
            cwd=tools.folder,
            preexec_fn=_limit_memory,
        )
        out, err = done.stdout, done.stderr
        if done.returncode != 0:
            fault = " ".join(err.split())[-160:] or f"exit {done.returncode}"
    except subprocess.TimeoutExpired as late:
        raw = late.stdout or b""
        out = raw.decode() if isinstance(raw, bytes) else raw
        fault = f"timed out after {timeout:.0f} s"
    found = [json.loads(line) for line in out.splitlines() if line.startswith("{") and line.endswith("}")]
    return found, fault


def measure(tools: Tools, engine: str, what: str, name: str) -> list[Timing]:
    """Measure an engine on a mechanism in one process."""
    if engine in tools.missing:
        return [Timing(name, engine, what, fault=tools.missing[engine])]
    if len(families.make(name).bodies) > LARGEST.get(engine, 1 << 30):
        return [Timing(name, engine, what, fault="not measured: takes minutes")]
    found, fault = lines(tools, command(tools, engine, what, name), LONGEST_PROCESS)
    out = []
    for line in found:
        if "us" in line:
            us, ref = float(str(line["us"])), float(str(line["ref_us"]))
            out.append(Timing(name, engine, str(line["kernel"]), us, ref))
        elif "fault" in line:
            fault_here = " ".join(str(line["fault"]).split())[:160]
            out.append(Timing(name, engine, str(line.get("kernel", what)), fault=fault_here))
    if fault:
        out.append(Timing(name, engine, what, fault=fault))
    return out


def least(timings: Iterable[Timing]) -> list[Timing]:
    """Return the smallest time of each kernel on each mechanism; `ref` is the smallest over all engines."""
    best: dict[tuple[str, str, str], Timing] = {}
    refs: dict[str, float] = {}
    for t in timings:
        key = (t.scene, t.engine, t.kernel)
        if key not in best or not t.us >= best[key].us:
            best[key] = t if math.isfinite(t.us) or key not in best else best[key]
        if math.isfinite(t.ref_us):
            refs[t.scene] = min(refs.get(t.scene, math.inf), t.ref_us)
    return [replace(t, ref_us=refs.get(t.scene, math.nan)) for t in best.values()]


def study(
    tools: Tools,
    names: Sequence[str],
    what: str = "forward",
    rounds: int = 3,
    engines: Sequence[str] = ENGINES,
    report: Callable[[str], None] = print,
) -> list[Timing]:
    """Measure all engines on all mechanisms, alternating."""
    out: list[Timing] = []
    for name in names:
        write_scene(tools, name)
        found: list[Timing] = []
        hopeless: set[str] = set()
        for turn in range(rounds):
            for engine in engines:
                if engine in hopeless or (turn > 0 and engine in ONCE):
                    continue
                mine = measure(tools, engine, what, name)
                found += mine
                if any(t.fault.startswith("timed out") for t in mine):
                    hopeless.add(engine)
        out += least(found)
        report(f"{name}: {summary(out, name)}")
    return out


def forward_of(timings: Iterable[Timing], scene: str, engine: str) -> Timing | None:
    """Return the fastest measurement of an engine's accelerations on a mechanism."""
    kernels = {"gelenk": {"forward dynamics"}}.get(engine)
    mine = [
        t
        for t in timings
        if t.scene == scene
        and t.engine == engine
        and math.isfinite(t.us)
        and (kernels is None or t.kernel in kernels)
    ]
    return min(mine, key=lambda t: t.us, default=None)


def summary(timings: Sequence[Timing], scene: str) -> str:
    """Return the times [us] of the accelerations by engine, as text."""
    found = {engine: forward_of(timings, scene, engine) for engine in ENGINES}
    return ", ".join(f"{engine} {t.us:.3g} us" for engine, t in found.items() if t is not None)


def slope(sizes: Sequence[int], values: Sequence[float]) -> float:
    """Return the exponent of the power law of n fitted to the finite values (least squares in logarithms)."""
    pairs = [(math.log(n), math.log(x)) for n, x in zip(sizes, values, strict=True) if math.isfinite(x)]
    if len(pairs) < 2:
        return math.nan
    mean_x, mean_y = (sum(p[i] for p in pairs) / len(pairs) for i in (0, 1))
    across = sum((x - mean_x) ** 2 for x, _ in pairs)
    return sum((x - mean_x) * (y - mean_y) for x, y in pairs) / across


def write_csv(timings: Sequence[Timing], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "engine", "kernel", "us", "ref_us", "ratio", "fault"])
        for t in timings:
            numbers = [f"{x:.5g}" if math.isfinite(x) else "" for x in (t.us, t.ref_us, t.ratio)]
            writer.writerow([t.scene, t.engine, t.kernel, *numbers, t.fault])
