# SPDX-License-Identifier: BSD-3-Clause
"""Holds the forces that a run reports against the laws of friction, limits, one-way clutches and contacts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from .elements import COORDINATES, STEP, Trial
from .ways import Run, motion_names

# Relative to the forces in the scene, and absolute: of events, which are located; of means over time steps.
ROUNDING, STEPS_ROUNDING = 1e-6, 1e-2
MOVES, STEPS_MOVES = 1e-4, 0.05  # rad/s, m/s
PENETRATION = 1e-7  # rad, m
AT_LIMIT = 1e-6  # rad, m; rad/s, m/s
ENGAGES = 0.5
VELOCITIES_OF_FREE = [f"{x}[{i}]" for x in "vw" for i in (1, 2, 3)]
LONGEST_STEP = 5e-4  # s: half of solver.step, of `auto`


def _effort(joint: dict[str, Any]) -> str:
    return "tau" if joint["type"] == "revolute" else "f"


def outputs_of_laws(trial: Trial) -> list[str]:
    out = []
    for name, joint in trial.scene["joints"].items():
        if "lock" in joint:
            out.append(f"{name}.lock.mode")
        for law in ("friction", "limit", "one_way"):
            if law in joint:
                out += [f"{name}.{law}.{_effort(joint)}", f"{name}.{law}.mode"]
    for name in trial.scene.get("contacts", {}):
        out += [f"{name}.f[3]", f"{name}.gap"]
    return out


def capacity(trial: Trial, name: str, v: float, t: float) -> tuple[float, float]:
    """Friction at rest and in motion at speed v, with the input just before t [s]."""
    law = trial.scene["joints"][name]["friction"]
    coulomb = law["coulomb"]
    static = law.get("static", coulomb)
    sliding = coulomb
    if "stribeck" in law:
        x = abs(v) / law["stribeck"]
        sliding += (static - coulomb) * float(np.exp(-x if law.get("exponent") == 1 else -x * x))
    pressed = 1.0
    if "input" in law:
        course = trial.inputs[f"{name}.friction.engagement"]
        pressed = max(0.0, value_before(course, t))
    return pressed * static, pressed * sliding


def value_before(course: Any, t: float) -> float:
    k = max((i for i, knot in enumerate(course.knots) if knot < t - 1e-9), default=0)
    x = t - course.knots[k]
    c = course.values[k]
    out = 0.0
    for j in range(len(c) - 1, -1, -1):
        out = out * x / (j + 1) + c[j]
    return float(out)


def laws_broken(trial: Trial, run: Run, steps: float = 0.0) -> list[str]:
    """What reported forces and positions contradict, in words; steps: length of time steps [s], 0: `auto`.

    Forces of time steps, which `auto` makes where contacts pile up, too, are means over the last one. An
    impact in that one is a coincidence: only what is broken at two points in succession counts.
    """
    out: list[str] = []
    before: set[str] = set()
    names = motion_names(trial.scene)
    for k, forces in enumerate(run.outputs[: len(run.values) - 1], 1):
        if not np.isfinite(run.values[k]).all():
            out.append(f"not finite at {k * STEP:.2f} s")
            continue
        length = LONGEST_STEP if run.stepped[k - 1] and not steps else steps
        at = Moment(trial, k * STEP, forces, dict(zip(names, run.values[k], strict=True)), length)
        found = list(at.broken())
        out += [f"{words} at {k * STEP:.2f} s" for words in found if not length or words.split()[0] in before]
        before = {words.split()[0] for words in found}
    return out


@dataclass
class Moment:
    """Forces and motion at a communication point; steps: length of steps [s], of which forces are means."""

    trial: Trial
    t: float
    forces: dict[str, float]
    motion: dict[str, float]
    steps: float

    def __post_init__(self) -> None:
        self.in_steps = self.steps > 0
        found = [abs(x) for name, x in self.forces.items() if not name.endswith(("mode", "gap"))]
        self.slack = (STEPS_ROUNDING if self.in_steps else ROUNDING) * (1 + max(found, default=0.0))
        self.moves = STEPS_MOVES if self.in_steps else MOVES

    def broken(self) -> Iterator[str]:
        for name, joint in self.trial.scene["joints"].items():
            if "lock" in joint:
                yield from self.lock(name)
            if joint["type"] not in COORDINATES:
                continue
            q, v = (self.motion[f"{name}.{x}"] for x in COORDINATES[joint["type"]])
            if "friction" in joint and name not in self.lossy():
                yield from self.friction(name, joint, q, v)
            if "limit" in joint:
                yield from self.limit(name, joint, q, v)
            if "one_way" in joint:
                yield from self.one_way(name, joint, v)
        for name in self.trial.scene.get("contacts", {}):
            if self.forces[f"{name}.f[3]"] < -self.slack:
                yield f"{name} pulls with {self.forces[f'{name}.f[3]']:.6g}"
            gap = self.forces[f"{name}.gap"]
            if gap < -PENETRATION or not np.isfinite(gap):
                yield f"{name}.gap is {gap:.6g}"

    def lock(self, name: str) -> Iterator[str]:
        """It is engaged where its input says so, and then the joint is at rest."""
        course = self.trial.inputs.get(f"{name}.lock.engagement")
        engaged = course is None or value_before(course, self.t) > ENGAGES
        if (self.forces[f"{name}.lock.mode"] == 1) != engaged:
            yield f"{name}.lock is {'released' if engaged else 'engaged'}, against its input,"
        speeds = [self.motion.get(f"{name}.{x}", 0.0) for x in ("v", "w", *VELOCITIES_OF_FREE)]
        if engaged and max(map(abs, speeds)) > self.moves:
            yield f"{name}.lock is engaged, but moves with {max(map(abs, speeds)):.6g}"

    def lossy(self) -> set[str]:
        """Joints with friction of gears, which depends on their torques."""
        constraints = self.trial.scene.get("constraints", {})
        return {c["joint"] for c in constraints.values() if "efficiency" in c}

    def friction(self, name: str, joint: dict[str, Any], q: float, v: float) -> Iterator[str]:
        f = self.forces[f"{name}.friction.{_effort(joint)}"]
        static, sliding = capacity(self.trial, name, v, self.t)
        # Friction of a speed that changes within a time step.
        slack = self.slack + (0.1 * sliding if self.in_steps else 1e-5 * static)
        if abs(f) > max(static, sliding) + self.slack:
            yield f"{name}.friction is {f:.6g}, but at most {static:.6g},"
        elif self.in_steps and any(self.reaches(joint, q, v)):
            return  # of the speeds before and after impacts, which can follow each other in every step
        elif abs(v) > self.moves and abs(f + np.sign(v) * sliding) > slack:
            yield f"{name}.friction is {f:.6g} with {v:.6g}, but slides with {sliding:.6g},"

    def reaches(self, joint: dict[str, Any], q: float, v: float) -> tuple[bool, bool]:
        """Whether the lower and the upper limit may have acted; one that is met within a step acts in it."""
        limits = joint.get("limit", {})
        near = AT_LIMIT + 2 * self.steps * abs(v)
        return abs(q - limits.get("lower", np.nan)) < near, abs(q - limits.get("upper", np.nan)) < near

    def limit(self, name: str, joint: dict[str, Any], q: float, v: float) -> Iterator[str]:
        f = self.forces[f"{name}.limit.{_effort(joint)}"]
        lower, upper = (joint["limit"].get(x, np.nan) for x in ("lower", "upper"))
        if q < lower - PENETRATION or q > upper + PENETRATION:
            yield f"{name} is {q:.9g}, beyond its limit,"
        at_lower, at_upper = self.reaches(joint, q, v)
        if (f > self.slack and not at_lower) or (f < -self.slack and not at_upper):
            yield f"{name}.limit exerts {f:.6g} with {q:.9g}"

    def one_way(self, name: str, joint: dict[str, Any], v: float) -> Iterator[str]:
        f = self.forces[f"{name}.one_way.{_effort(joint)}"]
        sign = 1 if joint["one_way"]["free"] == "positive" else -1
        if sign * f < -self.slack or (abs(f) > self.slack and abs(v) > self.moves):
            yield f"{name}.one_way exerts {f:.6g} with {v:.6g}"
        if sign * v < -AT_LIMIT:
            yield f"{name}.one_way lets it turn back with {v:.6g}"
