# SPDX-License-Identifier: BSD-3-Clause
"""Targets for Gelenk's speed relative to other engines, and the values measured."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from benchmarks.speed import families, page
from benchmarks.speed.errors import Run, cheapest, engines
from benchmarks.speed.masters import Step
from benchmarks.speed.timings import Timing, forward_of, slope


@dataclass(frozen=True)
class Aim:
    """A ratio or an exponent with its upper limit `most`; `found` is NaN if it was not measured."""

    words: str
    most: float
    found: float


def _largest(values: Iterable[float]) -> float:
    """Return the largest finite value; NaN if there is none."""
    return max((x for x in values if math.isfinite(x)), default=math.nan)


def _to(timings: Sequence[Timing], scene: str, engine: str) -> float:
    mine, other = forward_of(timings, scene, "gelenk"), forward_of(timings, scene, engine)
    return mine.us / other.us if mine and other else math.nan


def _exponent(timings: Sequence[Timing], family: str) -> float:
    members = page.family_scenes(timings, family, page.FITS[family])
    found = [forward_of(timings, scene, "gelenk") for _, scene in members]
    if not all(found) or len(members) < len([n for n in families.FAMILIES[family] if n >= page.FITS[family]]):
        return math.nan  # the largest mechanism is missing
    return slope([n for n, _ in members], [t.us if t else math.nan for t in found])


def of_kernels(timings: Sequence[Timing]) -> list[Aim]:
    """Return the targets for accelerations and derivatives."""

    def worst(scenes: Iterable[str], engine: str = "pinocchio") -> float:
        return _largest(_to(timings, scene, engine) for scene in scenes)

    def chains(family: str) -> list[str]:
        return [f"{family}_{n}" for n in families.CHAINS]

    arm = {t.kernel: t.us for t in timings if (t.scene, t.engine) == ("arm7", "gelenk")}
    jacobian = arm.get("derivatives", math.nan) / arm.get("forward dynamics", math.nan)
    of = "accelerations, Gelenk / Pinocchio:"
    return [
        Aim(f"{of} four-bar, slider-crank", 1 / 3, worst(["fourbar", "slidercrank"])),
        Aim(f"{of} planar chains", 1 / 2, worst(chains("chain_p"))),
        Aim(f"{of} spatial chains, arm", 0.9, worst([*chains("chain_s"), "arm7"])),
        Aim(f"{of} Stewart platform, Bricard", 0.7, worst(["stewart", "bricard"])),
        Aim("accelerations, Gelenk / MuJoCo: N-four-bar, N = 40", 1 / 2, worst(["nfourbar_40"], "mujoco")),
        Aim("growth exponent: N-four-bar, N = 10 to 1000", 1.15, _exponent(timings, "nfourbar")),
        Aim("growth exponent: planar chains, n = 16 to 1024", 1.05, _exponent(timings, "chain_p")),
        Aim("growth exponent: spatial chains, n = 16 to 1024", 1.05, _exponent(timings, "chain_s")),
        Aim("Jacobian df/dy / one evaluation: arm", 6, jacobian),
    ]


def of_steps(steps: Sequence[Step]) -> list[Aim]:
    """Return the targets for a step through the FMU's C interface: the cheapest method with an error up to
    1e-6.
    """

    def share(scene: str) -> float:
        there = [s for s in steps if s.scene == scene and s.error <= 1e-6]
        mine = [s.us for s in there if s.engine == "gelenk"]
        other = [s.us for s in there if s.engine == "pinocchio"]
        return min(mine) / min(other) if mine and other else math.nan

    return [
        Aim("FMU step, Gelenk / Pinocchio: four-bar", 1 / 3, share("fourbar")),
        Aim("FMU step, Gelenk / Pinocchio: arm", 1.0, share("arm7")),
    ]


def of_runs(runs: Sequence[Run]) -> list[Aim]:
    """Return the targets for the cheapest runs within an error bound."""

    def share(scene: str, engine: str, error: float) -> float:
        mine, other = cheapest(runs, scene, "gelenk", error), cheapest(runs, scene, engine, error)
        return mine.cost / other.cost if mine and other else math.nan

    def worst(scene: str, error: float) -> float:
        return _largest(share(scene, engine, error) for engine in engines(runs) if engine != "gelenk")

    limits = {"Pinocchio": 1 / 2, "Simbody": 1 / 20, "MuJoCo": 1 / 50}
    out = [
        Aim(f"run to 1e-6, Gelenk / {e}: four-bar", most, share("fourbar", e.lower(), 1e-6))
        for e, most in limits.items()
    ]
    for scene, words in (("arm7", "arm"), ("chain_s_32", "chain of 32"), ("stewart", "Stewart platform"),
                         ("bricard", "Bricard")):  # fmt: skip
        out.append(Aim(f"run to 1e-6, Gelenk / cheapest other: {words}", 1.0, worst(scene, 1e-6)))
    out.append(Aim("run to 1e-4, Gelenk / cheapest other: governor", 1.0, worst("governor", 1e-4)))
    return out


def table(aims: Sequence[Aim]) -> str:
    """Return the table of targets; missed ones are bold."""
    lines = []
    for aim in aims:
        found = page.figure(aim.found)
        cell = "none" if not found else found if aim.found <= aim.most else f"**{found}**"
        lines.append([aim.words, page.figure(aim.most), cell])
    return page.rows(["ratio or exponent", "target", "measured"], lines)
