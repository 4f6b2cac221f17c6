# SPDX-License-Identifier: BSD-3-Clause
"""Runs a trial in several ways and reports where they disagree by more than the motion is sensitive.

What a motion is sensitive to is seen from a run with slightly other numbers and from one with a tighter
tolerance: an event that rounding decides, or a motion that amplifies errors, makes these deviate, too. From
there on nothing is compared.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import gelenk

from .audit import laws_broken, outputs_of_laws
from .drawn import drawn
from .elements import STEP, Trial
from .ways import (
    FEW_EVALUATIONS,
    Array,
    Run,
    directions,
    motion_names,
    perturbed,
    restoring,
    run,
    run_values_only,
    saving,
    start,
    turned,
    with_floor,
    with_solver,
    without_reductions,
    without_static_excess,
)

PERTURBATION = 1e-10  # relative, of start values and gravity
TIGHTER = 0.03
# Errors of steps add up, and impacts amplify them.
MULTIPLE = 1e3  # of the tolerance
SAFETY = 100.0  # times what other runs are sensitive to
SENSITIVE = 1e-2  # allowed deviations beyond which nothing is compared
STEPPED = (
    1e-2  # allowed where `auto` has gone over to time steps, which it reports with their estimated error
)
FASTEST = 200.0  # m/s, rad/s: beyond, the motion diverges
# Time steps, of first order across impacts and where friction ends: what is allowed at the smaller step, and
# by how much it must have become less on the way from the larger one, unless it is small.
STEPS = (1e-3, 1e-4)  # s
# s: the first of these that comes close decides, where impacts without losses have added up errors of their
# times, or corners land within microseconds of each other.
FINEST = (1e-5, 2e-6)
FOLLOWING = 3  # points after a deviation that count, too: at an impact, speeds are those before or after it
STEPS_CLOSE = 2e-3
STEPS_LATE = 3  # steps by which events may come late
STEPS_GAIN = 0.4
REPETITIONS = 2500
OTHERS = ("erk", "cvode", "ida", "dirk")


@dataclass(frozen=True)
class Finding:
    """What two ways do not agree on.

    Args:
        seed: number of the trial.
        way: the other way, or `laws`, `refused`, `slow`.
        words: values and names, or the message.
        size: of the disagreement, relative to what is allowed.
    """

    seed: int
    way: str
    words: str
    size: float = 0.0


def gap(a: Array, b: Array) -> Array:
    """Deviation by point, relative to values above 1."""
    n = min(len(a), len(b))
    out: Array = np.abs(a[:n] - b[:n]) / (1 + np.abs(a[:n]))
    return out


def lasting(excess: Array) -> Array:
    """What remains at the next point: at an impact, speeds are those before or after it."""
    return np.minimum(excess[:-1], excess[1:])


class Comparison:
    """All ways of one trial."""

    def __init__(self, trial: Trial, seed: int = 0) -> None:
        self.trial, self.seed = trial, seed
        self.base = run(trial, outputs=outputs_of_laws(trial))
        self.names = motion_names(trial.scene)
        self.allowed = np.zeros(0)

    def prepare(self) -> None:
        """Determine what may differ at each point."""
        t = self.trial
        others = [
            gap(self.base.values, run(perturbed(t, PERTURBATION)).values) * t.tolerance / PERTURBATION,
            gap(self.base.values, run(replace(t, tolerance=TIGHTER * t.tolerance)).values),
            gap(self.base.values, run(perturbed(with_solver(t, integrator="erk"), -PERTURBATION)).values),
        ]
        n = min(len(self.base.values), *(len(other) for other in others))
        worst = np.max([other[:n].max(axis=1, initial=0) for other in others[:1]], axis=0)
        own = others[1][:n].max(axis=1, initial=0)
        # What does not shrink with the tolerance is no sensitivity, unless perturbed runs show it, too.
        self.allowed = np.maximum.accumulate(
            MULTIPLE * t.tolerance + SAFETY * np.maximum(worst, np.minimum(own, 1e-4))
        )
        fast = np.abs(self.base.values[:n]).max(axis=1, initial=0) > FASTEST
        self.allowed[np.maximum.accumulate(fast | (self.allowed > SENSITIVE))] = np.inf
        stepped = np.maximum.accumulate(np.array([False, *self.base.stepped])[:n])
        self.allowed[stepped] = np.maximum(self.allowed[stepped], STEPPED)

    def findings(self, ways: list[str] | None = None) -> list[Finding]:
        out: list[Finding] = []
        if self.base.refusal and len(self.base.values) == 0:
            return [Finding(self.seed, "not started", self.base.refusal)]
        if self.base.refusal:
            out.append(
                Finding(self.seed, "refused", f"at point {len(self.base.values)}: {self.base.refusal}")
            )
        if self.base.seconds > 2.0:
            out.append(Finding(self.seed, "slow", f"{self.base.seconds:.1f} s of CPU"))
        out += [Finding(self.seed, "laws", words) for words in laws_broken(self.trial, self.base)[:1]]
        if self.base.said:
            return out
        self.prepare()
        for way in ways if ways is not None else ways_of(self.seed, self.trial):
            out += WAYS[way](self)
        return out

    def at(self, k: int, i: int) -> str:
        return f"{self.names[i]} at {k * STEP:.2f} s"

    def differ(self, way: str, other: Run, *, same_bits: bool = False) -> list[Finding]:
        n = min(len(self.base.values), len(other.values), len(self.allowed))
        if len(other.values) < len(self.base.values):
            if other.said or len(other.values) == 0:
                return []
            words = f"at point {len(other.values)}: {other.refusal}"
            completed = np.vstack([other.values, self.base.values[len(other.values) :]])
            rest = self.differ(way, replace(other, values=completed), same_bits=same_bits)
            return [Finding(self.seed, f"{way} refused", words), *rest]
        if same_bits:
            unequal = np.argwhere(self.base.values[:n] != other.values[:n])
            if not len(unequal):
                return []
            k, i = unequal[0]
            return [Finding(self.seed, way, f"other bits from point {k} on: {self.names[i]}", np.inf)]
        if other.said:
            return []
        found = gap(self.base.values, other.values)[:n]
        excess = lasting(found.max(axis=1, initial=0) / self.allowed[:n])
        if excess.max(initial=0) <= 1:
            return []
        k = int(np.argmax(excess > 1))
        i = int(found[k].argmax())
        words = f"{self.at(k, i)}: {self.base.values[k, i]:.8g} / {other.values[k, i]:.8g}"
        words += f", allowed {self.allowed[k]:.1e}"
        return [Finding(self.seed, way, words, float(excess.max()))]


def by_integrator(name: str) -> Callable[[Comparison], list[Finding]]:
    return lambda c: c.differ(name, run(with_solver(c.trial, integrator=name)))


def by_steps(c: Comparison) -> list[Finding]:
    """Time steps of shrinking size approach the events."""
    gaps, runs = [], []
    for h in STEPS:
        other = run(with_solver(c.trial, integrator="moreau-jean", step=h), outputs=outputs_of_laws(c.trial))
        if not len(other.values):
            return []
        runs.append(other)
        gaps.append(gap(c.base.values, other.values).max(axis=1, initial=0))
    n = min(len(c.allowed), *(len(g) for g in gaps))
    if n < 2:
        return []
    comparable = n if np.isfinite(c.allowed[:n]).all() else int(np.argmax(~np.isfinite(c.allowed[:n])))
    # Sensitive motions amplify the error of the steps as they do others.
    growth = c.allowed[:comparable] / (MULTIPLE * c.trial.tolerance)
    rates = np.max(np.abs(np.gradient(c.base.values, STEP, axis=0)), axis=1)[:comparable]
    excess = gaps[1][:comparable] / ((STEPS_CLOSE + STEPS_LATE * STEPS[1] * rates) * growth)
    out = []
    if len(runs[1].values) < len(c.base.values):
        out.append(Finding(c.seed, "steps refused", f"at point {len(runs[1].values)}: {runs[1].refusal}"))
    # Beyond what is allowed, and not much less than with larger steps.
    least = STEPS_GAIN * np.maximum.accumulate(gaps[0][:comparable])
    excess = lasting(np.where(gaps[1][:comparable] > least, excess, 0.0))
    wrong = excess > 1
    if wrong.any() and not approached(c, int(np.argmax(wrong)), gaps[1]):
        k = int(np.argmax(wrong))
        i = int(gap(c.base.values, runs[1].values)[k].argmax())
        found = [run.values[k, i] for run in (c.base, runs[1], runs[0])]
        words = "{}: {:.8g} / {:.8g}, with larger steps {:.8g}".format(c.at(k, i), *found)
        out.append(Finding(c.seed, "steps", words, float(excess.max())))
    out += [
        Finding(c.seed, "laws in steps", words) for words in laws_broken(c.trial, runs[1], steps=STEPS[1])[:1]
    ]
    return out


def approached(c: Comparison, point: int, before: Array) -> bool:
    """Whether steps of the finest lengths come close at a point or one after it, or much closer at most.

    Before: deviations of steps of the smaller length. Where tens of impacts without losses follow each other,
    as of a stiff spring that presses a joint on its limit, deviations fall in proportion to the step, but are
    not small.
    """
    trial = c.trial.copy()
    trial.points = min(trial.points, point + FOLLOWING)
    for h in FINEST:
        finest = run(with_solver(trial, integrator="moreau-jean", step=h))
        found = gap(c.base.values, finest.values).max(axis=1, initial=0)[point:]
        if len(found) < 2:
            return False
        closer = found < STEPS_GAIN * before[point : point + len(found)]
        if float(found.min()) < STEPS_CLOSE * (1 + point) or float(closer.mean()) > 0.5:
            return True
    return False


def restored(c: Comparison) -> list[Finding]:
    """Saved, driven elsewhere or into a step that is refused, and restored: always the same bits."""
    trial = with_solver(c.trial, max_evaluations=FEW_EVALUATIONS)
    other = run(trial, between=restoring(trial, c.seed))
    if "StepBudgetError" in other.refusal:
        return []  # a step that needs more, and would have been made
    return c.differ("restored", other, same_bits=True)


def repeated(c: Comparison) -> list[Finding]:
    """Restore a state, make a step, again and again: always the same bits."""
    plant = start(c.trial)
    saved = plant.save()
    first: bytes | None = None
    for k in range(REPETITIONS):
        plant.restore(saved)
        try:
            plant.step_to(STEP)
        except Exception as error:
            return [Finding(c.seed, "repeated", f"refused at repetition {k}: {error}", np.inf)] if k else []
        found = plant.values(c.names).tobytes()
        first = first or found
        if found != first:
            return [Finding(c.seed, "repeated", f"other bits at repetition {k}", np.inf)]
    return []


def values_only(c: Comparison) -> list[Finding]:
    """A position given without derivatives, with steps ten times as short: the error is less than before.

    Where its course has derivatives, these jump at its knots by what its series leaves out.
    """
    trial = without_static_excess(c.trial)
    base = c.base if trial.scene == c.trial.scene else run(trial)
    try:
        runs = [run_values_only(trial, parts) for parts in (2, 20)]
    except gelenk.GelenkError as error:
        return [Finding(c.seed, "values only refused", str(error))]
    gaps = [gap(base.values, values).max(axis=1, initial=0) for values in runs]
    n = int(np.sum(np.isfinite(c.allowed)))
    # Means: where impacts come at slightly other times, speeds at a point differ by all of their jump. The
    # velocity of the start is not known.
    means = [float(g[1:n].mean()) if n > 1 else 0.0 for g in gaps]
    if means[1] > 1e-3 and means[1] > 0.5 * means[0]:
        words = f"mean deviations {means[0]:.2e}, with a tenth of the step {means[1]:.2e}"
        return [Finding(c.seed, "values only", words, means[1])]
    return []


WAYS: dict[str, Callable[[Comparison], list[Finding]]] = {
    "reductions": lambda c: c.differ("reductions", run(without_reductions(c.trial))),
    "kernels": lambda c: c.differ("kernels", run(with_solver(c.trial, equations="general"))),
    "floor": lambda c: c.differ("floor", run(with_floor(c.trial))),
    "turned": lambda c: c.differ("turned", run(turned(c.trial, directions(c.seed)))),
    "shifted": lambda c: c.differ("shifted", run(c.trial, begin=3.0)),
    "saved": lambda c: c.differ("saved", run(c.trial, between=saving), same_bits=True),
    "restored": restored,
    "steps": by_steps,
    "repeated": repeated,
    "values only": values_only,
    **{name: by_integrator(name) for name in OTHERS},
}


def ways_of(seed: int, trial: Trial) -> list[str]:
    """The ways in which this trial is run: every one in turn, those that cost much more rarely."""
    out = ["reductions", "floor", "saved", "restored", OTHERS[seed % 4]]
    out.append(("turned", "shifted")[seed % 2])
    out.append("kernels" if seed % 3 else "steps")
    if seed % 10 == 0:
        out.append("repeated")
    if any("s_ref" in name for name in trial.inputs):
        out.append("values only")
    return out


def found_in(seed: int) -> list[Finding]:
    return Comparison(drawn(seed), seed).findings()


def as_line(finding: Finding) -> str:
    out: dict[str, Any] = dict(finding.__dict__)
    out["size"] = min(finding.size, 1e300)
    return json.dumps(out)
