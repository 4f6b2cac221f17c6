# SPDX-License-Identifier: BSD-3-Clause
"""Random mechanisms with dry friction, limits and stops in their joints, and schedules of motor torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from mechanisms import GRAVITY, Scene

# Names of the coordinate and the velocity of joints with one degree of freedom.
COORDINATES = {"revolute": ("phi", "w"), "prismatic": ("s", "v"), "screw": ("phi", "w")}
INTEGRATORS = ("auto", "auto", "erk", "ida", "dirk", "cvode", "cvode-adams", "rk4")
SEGMENTS, STEPS, STEP = 4, 8, 0.025  # constant torques, steps with each, size of a step [s]
# Unit vectors, several of which are parallel or at right angles.
DIRECTIONS = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1), (0.6, 0, 0.8), (0.48, 0.6, 0.64))


@dataclass
class Trial:
    """A mechanism and how it is run."""

    scene: Scene
    integrator: str
    tolerance: float
    schedule: list[dict[str, float]]  # by segment: inputs

    @property
    def source(self) -> Scene:
        """The scene with its integrator; bounds on the cost of a step, so that each run ends."""
        solver = {"integrator": self.integrator, "max_evaluations": 300_000, "max_events": 2000}
        return {**self.scene, "experiment": {"step": 1e-3}, "solver": solver}


def drawn(seed: int) -> Trial:
    """The mechanism with this number; always the same."""
    return Draw(np.random.default_rng([2605, seed])).trial()


class Draw:
    """Draws one mechanism. All joints start at their reference position, so that loops are closed."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.planar = self.chance(0.55)
        self.regular = self.chance(0.5)  # points on a grid, axes at right angles
        self.at_rest = self.chance(0.4)
        self.closed = self.chance(0.45)
        self.count = int(rng.integers(3, 7)) if self.closed else int(rng.integers(1, 7))

    def chance(self, probability: float) -> bool:
        return bool(self.rng.random() < probability)

    def one_of(self, values: Any) -> Any:
        return values[int(self.rng.integers(len(values)))]

    def magnitude(self, low: float, high: float) -> float:
        """A number with two digits, between these orders of magnitude."""
        return float(f"{np.exp(self.rng.uniform(np.log(low), np.log(high))):.2g}")

    def point(self, size: float) -> list[float]:
        """A point in space, or in the plane y = 0."""
        r = (
            self.rng.integers(-2, 3, 3) * size / 2
            if self.regular
            else self.rng.uniform(-size, size, 3).round(3)
        )
        return [float(r[0]), 0.0 if self.planar else float(r[1]), float(r[2])]

    def axis(self, kind: str) -> list[float]:
        if self.planar and kind == "prismatic":
            a = self.rng.uniform(0, 6.3)
            return self.one_of(([1.0, 0, 0], [0, 0, 1.0], [float(np.cos(a)), 0, float(np.sin(a))]))  # type: ignore[no-any-return]
        if self.planar:
            return [0, self.one_of((1.0, -1.0)), 0]
        return [
            float(x) for x in (self.one_of(DIRECTIONS) if self.regular else self.rng.normal(size=3).round(3))
        ]

    def body(self) -> dict[str, Any]:
        """Principal moments of inertia that are sums of two second moments."""
        a, b, c = (self.magnitude(0.002, 0.2) for _ in range(3))
        pose = {"position": self.point(1.0)}
        return {
            "mass": self.magnitude(0.2, 4),
            "com": self.point(0.4),
            "inertia": [a + b, b + c, c + a],
            "pose": pose,
        }

    def joint(self, parent: str, child: str) -> dict[str, Any]:
        """A joint with one degree of freedom, with what acts on its coordinate."""
        kinds = ("revolute", "revolute", "revolute", "prismatic") + (() if self.planar else ("screw",))
        kind = self.one_of(kinds)
        q, v = COORDINATES[kind]
        out: dict[str, Any] = {
            "type": kind,
            "parent": parent,
            "child": child,
            "at": {"position": self.point(1.0)},
            "axis": self.axis(kind),
        }
        if kind == "screw":
            out["pitch"] = self.one_of((0.05, -0.2))
        speed = 0.0 if self.at_rest or self.chance(0.3) else round(float(self.rng.normal(0, 2)), 2)
        out["start"] = {q: 0.0, v: speed, "fixed": True}
        if self.chance(0.6):
            out["friction"] = self.friction()
        if self.chance(0.45):
            out["limit"] = self.bounds() | {"restitution": self.one_of((0.0, 0.0, 0.4, 0.8, 1.0))}
        if self.chance(0.15):
            stiffness = self.magnitude(1e2, 1e5)
            out["stop"] = self.bounds() | {
                "stiffness": stiffness,
                "damping": self.one_of((0.0, 0.003 * stiffness)),
            }
        if self.chance(0.3):
            out |= {"stiffness": self.magnitude(1, 500), "spring_reference": self.one_of((0.0, 0.3, -0.05))}
        if self.chance(0.3):
            out["damping"] = self.magnitude(0.01, 3)
        return out

    def friction(self) -> dict[str, float]:
        coulomb = 0.0 if self.chance(0.05) else self.magnitude(0.05, 20)
        out = {"coulomb": coulomb}
        if self.chance(0.5):
            out["static"] = coulomb * self.one_of((1.0, 1.1, 1.5)) + self.one_of((0.0, 0.1))
            if self.chance(0.5):
                out["stribeck"] = self.one_of((0.01, 0.1, 1.0))
        return out

    def bounds(self) -> dict[str, float]:
        """A lower bound, an upper one, or both; at the start position, near to it, or far."""
        distances = (0.0, 0.0, 0.02, 0.2, 1.0)
        both = {"lower": -self.one_of(distances), "upper": self.one_of(distances[2:])}
        if self.chance(0.2):
            both = {"lower": -both["upper"], "upper": -both["lower"]}
        wanted = self.one_of((("lower",), ("upper",), ("lower", "upper")))
        return {name: both[name] + 0.0 for name in wanted}

    def torque(self, joint: dict[str, Any], ratio: float) -> float:
        """Nothing, next to nothing, at or beside the limit of friction, some, or very much."""
        friction = joint.get("friction", {"coulomb": 1.0})
        limit: float = friction.get("static", friction["coulomb"])
        at_limit = limit / ratio * self.one_of((1.0, 1 - 1e-12, 1 + 1e-12, 1 + 1e-6))
        some = round(float(self.rng.normal(0, 8)), 2)
        choice = self.one_of(
            (0.0, 1e-9, at_limit, at_limit, friction["coulomb"] / ratio, some, some, some, 1e3)
        )
        return float(choice * self.one_of((1, -1)))

    def close_loops(self, joints: dict[str, Any]) -> None:
        """A loop through all bodies, and sometimes one more; in space with a joint that can be cut."""
        for parent, child in (("b0", f"b{self.count - 1}"), ("b0", f"b{self.count - 2}"))[
            : 1 + self.chance(0.15)
        ]:
            on = "ground" if self.chance(0.8) else parent
            if self.planar:
                closing = self.joint(on, child)
            else:
                closing = {
                    "type": "spherical",
                    "parent": on,
                    "child": child,
                    "at": {"position": self.point(1.0)},
                }
            joints[f"C{child}"] = closing
        # In a loop, one start speed determines others.
        for i, entry in enumerate(joints.values()):
            if i > 0 and "start" in entry:
                entry["start"] = {COORDINATES[entry["type"]][0]: 0.0}

    def trial(self) -> Trial:
        bodies = {f"b{i}": self.body() for i in range(self.count)}
        joints = {}
        for i in range(self.count):
            on_last = self.closed or self.chance(0.7)
            before = i if on_last else int(self.rng.integers(0, i + 1))
            joints[f"J{i}"] = self.joint(f"b{before - 1}" if before else "ground", f"b{i}")
        if self.closed:
            self.close_loops(joints)
        gravity = self.one_of(([0, 0, 0], [0, 0, -GRAVITY], [0, 0, -GRAVITY], [3.0, 0, -8.0]))
        out = {"gelenk": 1, "gravity": gravity, "bodies": bodies, "joints": joints}
        driven = [
            name for name, entry in joints.items() if entry["type"] in COORDINATES and self.chance(0.4)
        ][:2]
        ratios = {name: self.one_of((1.0, 1.0, -3.0, 20.0)) for name in driven}
        out["motors"] = {
            f"M{name}": {"joint": name, "gear_ratio": ratio, "rotor_inertia": self.one_of((0.0, 0.0, 1e-3))}
            for name, ratio in ratios.items()
        }
        if self.chance(0.2):
            ends = {"from": {"body": "ground", "position": self.point(2.0)}, "to": f"b{self.count - 1}"}
            out["forces"] = {
                "F": {"type": "spring_damper", **ends, "stiffness": self.magnitude(1, 300), "length": 0.3}
            }
        out["sensors"] = {"E": {"type": "energy"}}
        if self.chance(0.5):
            out["sensors"] |= {f"R{name}": {"type": "reaction", "joint": name} for name in joints}
        effort = {name: "tau" if joints[name]["type"] != "prismatic" else "f" for name in driven}
        schedule = [
            {f"M{name}.{effort[name]}": self.torque(joints[name], ratio) for name, ratio in ratios.items()}
            for _ in range(SEGMENTS)
        ]
        return Trial(out, self.one_of(INTEGRATORS), self.one_of((1e-5, 1e-6, 1e-7, 1e-8, 1e-9)), schedule)
