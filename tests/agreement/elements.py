# SPDX-License-Identifier: BSD-3-Clause
"""What acts on joints of random scenes, and the courses of inputs."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from math import factorial, pi
from typing import Any

import numpy as np

SceneData = dict[str, Any]

COORDINATES = {"revolute": ("phi", "w"), "prismatic": ("s", "v")}
STEP = 0.02  # s between communication points


@dataclass(frozen=True)
class Course:
    """The course of one input: constant until the next knot, or a polynomial from each knot on.

    Args:
        knots: times at which it jumps [s], the first one 0.
        values: value and derivatives at each knot.
    """

    knots: tuple[float, ...]
    values: tuple[tuple[float, ...], ...]

    def at(self, t: float) -> list[float]:
        """Value and derivatives at t [s]; at a knot those after it."""
        k = max(i for i, knot in enumerate(self.knots) if knot <= t + 1e-9)
        x, c = t - self.knots[k], self.values[k]
        return [
            sum(c[j] * x ** (j - order) / factorial(j - order) for j in range(order, len(c)))
            for order in range(len(c))
        ]


@dataclass
class Trial:
    """A scene, the courses of its inputs and how long it runs.

    Args:
        scene: as `gelenk.load` accepts it.
        inputs: courses by name of the input.
        points: number of communication steps.
        tolerance: of integrators with error control.
    """

    scene: SceneData
    inputs: dict[str, Course] = field(default_factory=dict)
    points: int = 25
    tolerance: float = 1e-8

    def copy(self) -> Trial:
        return copy.deepcopy(self)


class Elements:
    """Draws what a scene consists of: bodies, what acts on joints, motors and inputs."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.bodies: SceneData = {}
        self.joints: SceneData = {}
        self.motors: SceneData = {}
        self.constraints: SceneData = {}
        self.forces: SceneData = {}
        self.contacts: SceneData = {}
        self.inputs: dict[str, Course] = {}
        self.carriers: list[SceneData] = []  # frames on which a chain can stand
        self.points = int(self.one_of((15, 25, 25, 40)))
        self.gravity = self.one_of(([0, 0, -9.81], [0, 0, -9.81], [0, 0, -10.0], [1.0, 0, -9.0]))

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def one_of(self, values: Any) -> Any:
        return values[int(self.rng.integers(len(values)))]

    def number(self, low: float, high: float) -> float:
        """A number with two digits, between these of equal sign, by orders of magnitude."""
        return float(f"{np.exp(self.rng.uniform(np.log(low), np.log(high))):.2g}")

    def between(self, low: float, high: float) -> float:
        return round(float(self.rng.uniform(low, high)), 3)

    # --- inputs ---

    def course(self, sizes: tuple[float, ...], *, jumps: bool = True) -> Course:
        """Jumps between values of these sizes, a ramp between them, or a sine with its derivatives."""
        kind = self.one_of(("held", "held", "ramp", "sine")) if jumps else "sine"
        knots, levels = self.knots_and_levels(sizes)
        if kind == "held":
            return Course(knots, tuple((level,) for level in levels[:-1]))
        ends = [*knots[1:], self.points * STEP]
        if kind == "ramp":
            slopes = [
                (b - a) / (end - start)
                for a, b, start, end in zip(levels, levels[1:], knots, ends, strict=False)
            ]
            return Course(knots, tuple(zip(levels[:-1], slopes, strict=True)))
        rate, size, phase = self.between(2, 15), levels[0], self.between(0, 2 * pi)
        times = tuple(round(STEP * k, 3) for k in range(self.points))
        return Course(
            times,
            tuple(
                tuple(size * rate**n * float(np.sin(rate * t + phase + n * pi / 2)) for n in range(6))
                for t in times
            ),
        )

    def held(self, sizes: tuple[float, ...]) -> Course:
        """Jumps between values of these sizes."""
        knots, levels = self.knots_and_levels(sizes)
        return Course(knots, tuple((level,) for level in levels[:-1]))

    def knots_and_levels(self, sizes: tuple[float, ...]) -> tuple[tuple[float, ...], list[float]]:
        """Up to four knots, and a level of these sizes at each of them and at the end."""
        count = int(self.rng.integers(1, 5))
        later = {round(STEP * int(k), 3) for k in self.rng.integers(1, self.points, count - 1)} - {0.0}
        knots = (0.0, *sorted(later))
        return knots, [float(self.one_of(sizes)) for _ in range(len(knots) + 1)]

    def motor(self, joint: str, force: float) -> None:
        self.motors[f"M{joint}"] = {"joint": joint}
        effort = "tau" if self.joints[joint]["type"] == "revolute" else "f"
        sizes = (0.0, force, -force, 0.999 * force, 1.001 * force, 3 * force, -2.7 * force)
        self.inputs[f"M{joint}.{effort}"] = self.course(sizes)

    # --- what acts on a joint coordinate ---

    def law(self, joint: str, force: float, *, bounds: float = 1.0) -> None:
        """Friction, limits, a one-way clutch, stops, springs; force: about what acts on it [N m, N]."""
        out = self.joints[joint]
        if self.chance(0.5):
            out["friction"] = self.friction(joint, force)
        kind = self.one_of(("limit", "limit", "one_way", "stop", "none", "none"))
        if kind == "limit":
            out["limit"] = self.bounds(bounds) | {"restitution": self.one_of((0.0, 0.0, 0.5, 0.8, 1.0))}
        elif kind == "one_way" and out["start"].get("fixed", False):
            out["one_way"] = {
                "free": "positive" if out["start"][COORDINATES[out["type"]][1]] >= 0 else "negative"
            }
        elif kind == "stop":
            stiffness = force * self.number(10, 1000)
            out["stop"] = self.bounds(bounds) | {
                "stiffness": stiffness,
                "damping": self.one_of((0.0, 0.003)) * stiffness,
            }
        if self.chance(0.25):
            out |= {"stiffness": force * self.number(1, 1000), "spring_reference": self.one_of((0.0, 0.2))}
        if self.chance(0.25):
            out["damping"] = force * self.number(0.01, 1)

    def locks(self, trial: Trial) -> None:
        """Locks of some joints, engaged and released at knots.

        Not of those that a motion moves, nor of vertical guides of wheels: nothing determines which part of
        a load these and the ground bear.
        """
        driven = {c["joint"] for c in self.constraints.values() if c["type"] == "motion"}
        free = [name for name in trial.scene["joints"] if name not in driven]
        chosen = [name for name in free if self.chance(0.4)] or [self.one_of(free)] if free else []
        for name in chosen:
            course = self.held((0.0, 1.0, 1.0, 0.3, 20.0, -1.0))
            if name.endswith("z"):
                continue
            trial.scene["joints"][name]["lock"] = {"input": "engagement"}
            if course.values[0][0] > 0.5 and self.chance(0.7):
                trial.scene["joints"][name]["lock"]["engaged"] = True
            trial.inputs[f"{name}.lock.engagement"] = course

    def friction(self, joint: str, force: float) -> SceneData:
        coulomb = self.number(0.05, 3) * force
        out: SceneData = {"coulomb": coulomb}
        if self.chance(0.4):
            out["static"] = coulomb * self.one_of((1.0, 1.2, 2.0))
            if self.chance(0.6):
                out["stribeck"] = self.one_of((0.02, 0.2, 1.0))
                if self.chance(0.3):
                    out["exponent"] = 1
        if self.chance(0.35):
            out["input"] = "engagement"
            self.inputs[f"{joint}.friction.engagement"] = self.course((0.0, 1.0, 1.0, 0.05, 0.5, 2.0))
        return out

    def bounds(self, size: float) -> SceneData:
        """Bounds of a coordinate that starts at 0: there, near, or far."""
        both = {
            "lower": -size * self.one_of((0.0, 0.02, 0.1, 0.5)),
            "upper": size * self.one_of((0.02, 0.1, 0.5)),
        }
        if self.chance(0.3):
            both = {"lower": -both["upper"], "upper": -both["lower"]}
        wanted = self.one_of((("lower",), ("upper",), ("lower", "upper"), ("lower", "upper")))
        return {name: both[name] + 0.0 for name in wanted}

    def speed(self, size: float = 1.0) -> float:
        return float(self.one_of((0.0, 0.0, 1.0, -1.0, self.between(-3, 3)))) * size

    def body(self, name: str, size: float, mass: float) -> float:
        """A body of about this size [m], with its center of mass off its frame; returns its moment."""
        c = [self.between(0.2, 0.8) * size, 0.0, self.one_of((0.0, 0.0, self.between(-0.2, 0.2) * size))]
        moment = mass * size**2 * self.between(0.1, 0.5)
        self.bodies[name] = {"mass": mass, "com": c, "inertia": [0.6 * moment, moment, 0.9 * moment]}
        return moment

    def contact(self, part: str) -> SceneData:
        return {
            "between": [part, "road"],
            "friction": self.one_of((0.0, 0.3, 0.5, 0.8)),
            "restitution": self.one_of((0.0, 0.0, 0.3, 0.8)),
        }
