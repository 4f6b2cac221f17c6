# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of docs/performance.md."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.speed.errors import Run, Truth
from benchmarks.speed.page import FITS, KERNELS, family_scenes
from benchmarks.speed.timings import ENGINES, Timing, forward_of, slope

from gelenk.chart.style import save
from gelenk.extras import pyplot

COLORS = {"gelenk": "black", "pinocchio": "#0072B2", "mujoco": "#D55E00", "drake": "#009E73",
           "exudyn": "#CC79A7", "simbody": "#E69F00"}  # fmt: skip
MARKERS = {"gelenk": "o", "pinocchio": "s", "mujoco": "^", "drake": "D", "exudyn": "v", "simbody": "P"}
TITLES = {"chain_p": "planar chains", "chain_s": "spatial chains", "nfourbar": "N-four-bars"}


def look(engine: str) -> dict[str, Any]:
    first = engine == "gelenk"
    return {"color": COLORS[engine], "marker": MARKERS[engine], "linewidth": 2.4 if first else 1.3,
            "markersize": 5.5 if first else 4.5, "zorder": 5 if first else 2}  # fmt: skip


def _line(
    axis: Any, sizes: Sequence[int], values: Sequence[float], label: str, least: int, style: Any
) -> None:
    kept = [(n, x) for n, x in zip(sizes, values, strict=True) if math.isfinite(x)]
    if not kept:
        return
    large = [(n, x) for n, x in kept if n >= least]
    fitted = slope([n for n, _ in large], [x for _, x in large])
    power = f": n^{fitted:.2f}" if math.isfinite(fitted) else ""
    axis.plot([n for n, _ in kept], [x for _, x in kept], label=label + power, **style)


def _finish(axis: Any, title: str) -> None:
    axis.set_xscale("log", base=2)
    axis.set_yscale("log")
    axis.set_title(title, fontsize=10)
    axis.set_xlabel("n")
    axis.grid(which="major", alpha=0.35)
    if axis.lines:
        axis.legend(fontsize=8)


def draw_forward(timings: Sequence[Timing], path: Path) -> None:
    """Draw the time of the accelerations over n: planar and spatial chains, N-four-bars."""
    plt = pyplot()
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.6), layout="constrained", sharey=True)
    for axis, (family, least) in zip(axes, FITS.items(), strict=True):
        members = family_scenes(timings, family)
        for engine in ENGINES:
            found = [forward_of(timings, scene, engine) for _, scene in members]
            values = [t.ratio if t else math.nan for t in found]
            _line(axis, [n for n, _ in members], values, engine, least, look(engine))
        _finish(axis, f"{TITLES[family]} (fitted from n = {least})")
    axes[0].set_ylabel("time of the accelerations / ref")
    save(figure, path, 85)
    plt.close(figure)


def draw_kernels(timings: Sequence[Timing], path: Path) -> None:
    """Draw the time of Gelenk's kernels over n."""
    plt = pyplot()
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.6), layout="constrained", sharey=True)
    found = {(t.scene, t.kernel): t.ratio for t in timings if t.engine == "gelenk"}
    for axis, (family, least) in zip(axes, FITS.items(), strict=True):
        members = family_scenes(timings, family)
        for k, kernel in enumerate(KERNELS):
            values = [found.get((scene, kernel), math.nan) for _, scene in members]
            style = {"color": f"C{k}", "marker": "os^Dv<>P"[k], "markersize": 4, "linewidth": 1.3}
            _line(axis, [n for n, _ in members], values, kernel, least, style)
        _finish(axis, TITLES[family])
    axes[0].set_ylabel("time of the kernel / ref")
    save(figure, path, 85)
    plt.close(figure)


def draw_single(timings: Sequence[Timing], scenes: Sequence[str], path: Path) -> None:
    """Draw the time of the accelerations of the mechanisms of one size, relative to Gelenk."""
    plt = pyplot()
    figure, axis = plt.subplots(figsize=(10, 4.2), layout="constrained")
    width = 0.8 / len(ENGINES)
    for k, engine in enumerate(ENGINES):
        heights = []
        for scene in scenes:
            mine, gelenk = forward_of(timings, scene, engine), forward_of(timings, scene, "gelenk")
            heights.append(mine.us / gelenk.us if mine and gelenk else 0.0)
        places = [i + (k - (len(ENGINES) - 1) / 2) * width for i in range(len(scenes))]
        axis.bar(places, heights, width, color=COLORS[engine], label=engine)
    axis.set_yscale("log")
    axis.axhline(1, color="black", linewidth=0.8)
    axis.set_xticks(range(len(scenes)), scenes)
    axis.set_ylabel("time of the accelerations relative to Gelenk")
    axis.grid(which="major", axis="y", alpha=0.35)
    axis.legend(fontsize=8)
    save(figure, path, 85)
    plt.close(figure)


LOST = 10.0  # larger errors are drawn at this value


def draw_errors(runs: Sequence[Run], truth: Truth, path: Path) -> None:
    """Draw processor time per simulated second against error, for all methods of all engines."""
    plt = pyplot()
    figure, axis = plt.subplots(figsize=(8.5, 5.6), layout="constrained")
    lines = list(dict.fromkeys((run.engine, run.method) for run in runs))
    for engine, method in lines:
        mine = [r for r in runs if (r.engine, r.method) == (engine, method) and r.finished]
        mine.sort(key=lambda r: -r.setting)
        first = [m for e, m in lines if e == engine].index(method)
        name = engine.split(" ")[0]
        style = look(name) | {"linestyle": ("-", "--", ":")[first], "label": f"{engine}: {method}"}
        axis.plot([min(LOST, max(r.error, truth.digits)) for r in mine], [r.cost for r in mine], **style)
    axis.set_xscale("log")
    axis.set_yscale("log")
    low = min(0.5 * truth.digits, 1e-11)
    axis.set_xlim(2 * LOST, low)  # accuracy increases to the right
    axis.axvspan(low, 3 * truth.digits, color="#dddddd", zorder=0)
    axis.set_xlabel("largest error of a joint coordinate [rad, m]; gray: below the accuracy of the reference")
    axis.set_ylabel("processor time per simulated second [ms]")
    axis.set_title(runs[0].scene, fontsize=11)
    axis.grid(which="major", alpha=0.35)
    axis.legend(fontsize=8)
    save(figure, path, 85)
    plt.close(figure)
