# SPDX-License-Identifier: BSD-3-Clause
"""Random scenes in which everything non-smooth meets, and what a master does with them.

A scene consists of one to three parts: a chain of joints, a closed loop, geared shafts, a wheel with a brake,
a thrown body, a body driven by its position. Joints have dry friction, clutches, limits, one-way clutches,
stops and springs, some of them locks; bodies touch the ground. Inputs jump, or follow polynomials whose
derivatives are given.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from .elements import COORDINATES, Elements, SceneData, Trial

FIRST_WITH_LOCKS = 40_000  # scenes before remain what they were


def drawn(seed: int) -> Trial:
    """Return the trial with this number; always the same."""
    draw = Draw(np.random.default_rng([4105, seed]))
    trial = draw.trial()
    if seed >= FIRST_WITH_LOCKS:
        draw.locks(trial)
    return trial


class Draw(Elements):
    """Draws one trial; names of its parts begin with a letter for each part."""

    def chain(self, part: str) -> None:
        count = int(self.rng.integers(1, 5))
        planar = self.chance(0.6)
        touches = self.chance(0.3)
        height = self.between(0.05, 0.6) if touches else self.between(1.5, 2)
        parent: Any = {"body": "ground", "position": [self.between(-1, 1), -6.0 - ord(part), height]}
        if self.carriers and self.chance(0.5):
            parent, touches = self.one_of(self.carriers), False
        for i in range(count):
            size, mass = self.number(0.1, 0.5), self.number(0.2, 3)
            name = f"{part}{i}"
            self.body(name, size, mass)
            kind = self.one_of(("revolute", "revolute", "prismatic"))
            axis = [0, 1, 0] if planar else self.one_of(([0, 1, 0], [0, 0, 1], [1, 0, 0], [0.6, 0, 0.8]))
            if kind == "prismatic" and planar:
                axis = self.one_of(([0, 0, 1], [1, 0, 0], [0.6, 0, 0.8]))
            q, v = COORDINATES[kind]
            self.joints[name] = {"type": kind, "axis": axis, "parent": parent, "child": name,
                                 "start": {q: 0.0, v: self.speed(), "fixed": True}}  # fmt: skip
            force = 9.81 * mass * (size if kind == "revolute" else 1.0)
            self.law(name, force, bounds=1.0 if kind == "revolute" else 0.3)
            if self.chance(0.3):
                self.motor(name, force)
            parent = {"body": name, "position": [size, 0, 0]}
            if touches and (self.chance(0.5) or i + 1 == count):
                radius = 0.02
                shape = {"sphere": radius, "position": [size, 0, 0], "surface": part}
                self.bodies[name]["shapes"] = {"tip": shape}
                self.contacts[f"{part}k"] = self.contact(part)

    def loop(self, part: str) -> None:
        """A plane loop of four to seven links; its guesses close it, or do not."""
        count = int(self.rng.integers(3, 7))
        exact = self.chance(0.6)
        angles = np.sort(self.rng.uniform(0.3, 2 * pi - 0.3, count))
        corners = [np.array([0.5 * np.cos(a), 0.4 * np.sin(a)]).round(3) for a in angles]
        corners.append(np.array([0.5, 0.0]))
        origin = np.array([self.between(-1, 1), 1.5])

        def on_ground(corner: np.ndarray) -> SceneData:
            x, z = (float(c) for c in origin + corner)
            return {"body": "ground", "position": [x, 8.0 + ord(part), z]}

        parent, heading = on_ground(corners[0]), 0.0
        for i in range(count):
            name = f"{part}{i}"
            link = corners[i + 1] - corners[i]
            length, angle = max(float(np.hypot(*link)), 0.05), float(np.arctan2(link[1], link[0]))
            mass = self.number(0.2, 3)
            self.body(name, length, mass)
            # About -y, angles are counterclockwise in the plane of x and z.
            guess = angle - heading if exact else self.between(-1, 1)
            joint = {"type": "revolute", "axis": [0, -1, 0], "parent": parent, "child": name}
            self.joints[name] = joint | {"start": {"phi": guess}}
            if i == 0 and exact:
                self.joints[name]["start"] |= {"w": self.speed(), "fixed": True}
            force = 9.81 * mass * length
            if self.chance(0.4):
                self.joints[name]["friction"] = self.friction(name, 0.3 * force)
            if self.chance(0.2):
                self.joints[name]["damping"] = force * self.number(0.01, 0.3)
            if exact and self.chance(0.25):
                lower = guess - self.one_of((0.02, 0.1, 0.5))
                self.joints[name]["limit"] = {"lower": lower, "restitution": self.one_of((0.0, 0.5, 0.9))}
            heading, parent = angle, {"body": name, "position": [length, 0, 0]}
        self.joints[f"{part}c"] = {
            "type": "revolute", "axis": [0, -1, 0], "parent": on_ground(corners[-1]), "child": parent,
        }  # fmt: skip
        if not exact:
            self.vary_guesses(part, count)
        if self.chance(0.5):
            self.motor(f"{part}0", 3.0)

    def vary_guesses(self, part: str, count: int) -> None:
        """Guesses that are all zero, and a link that slides on another one instead of turning."""
        if self.chance(0.6):
            for i in range(count):
                self.joints[f"{part}{i}"]["start"] = {"phi": 0.0}
        if count > 4 and self.chance(0.5):
            slide = self.joints[f"{part}{int(self.rng.integers(1, count))}"]
            slide |= {"type": "prismatic", "axis": self.one_of(([0, 0, 1], [1, 0, 0])), "start": {"s": 0.0}}
            for law in ("friction", "damping"):
                slide.pop(law, None)

    def shafts(self, part: str) -> None:
        """Two shafts with a gear, and a disk that a clutch or a one-way clutch connects with one of them."""
        for i in range(2):
            name = f"{part}{i}"
            moment = self.number(0.05, 1)
            self.bodies[name] = {"mass": 1.0, "inertia": [moment, moment, moment]}
            self.joints[name] = {
                "type": "revolute", "axis": [1, 0, 0], "start": {"phi": 0.0},
                "child": name, "parent": {"body": "ground", "position": [3, i, 2]},
            }  # fmt: skip
        ratio = self.one_of((1.0, 2.0, -3.0))
        w = self.speed(2.0)
        self.joints[f"{part}0"]["start"] = {"phi": 0.0, "w": w, "fixed": True}
        self.constraints[f"{part}g"] = {
            "type": "gear",
            "joint": f"{part}0",
            "with": f"{part}1",
            "ratio": ratio,
        }
        if self.chance(0.4):
            self.constraints[f"{part}g"]["efficiency"] = self.one_of((0.9, 0.6, 0.4))
            self.joints[f"{part}0"]["friction"] = {"coulomb": self.one_of((0.0, 0.5))}
        elif self.chance(0.5):
            self.joints[f"{part}0"]["friction"] = self.friction(f"{part}0", 1.0)
        name = f"{part}2"
        self.bodies[name] = {"mass": 1.0, "inertia": [0.2, 0.2, 0.2]}
        self.joints[name] = {
            "type": "revolute", "axis": [1, 0, 0],
            "child": name, "parent": {"body": f"{part}1", "position": [0.2, 0, 0]},
            "start": {"phi": 0.0, "w": self.one_of((0.0, 0.0, 1.0)), "fixed": True},
        }  # fmt: skip
        self.law(name, 2.0, bounds=0.5)
        self.motor(f"{part}0", 2.0)
        if self.chance(0.5):
            self.motor(name, 2.0)

    def wheel(self, part: str) -> None:
        """A wheel on the ground under a carriage that moves along x and z, with a brake and a motor."""
        radius, load = self.one_of((0.3, self.between(0.1, 0.4))), self.number(2, 10)
        x, z, w = f"{part}x", f"{part}z", f"{part}w"
        self.bodies |= {x: {"mass": 0}, z: {"mass": load}}
        shape = {"wheel": {"radius": radius}, "rotation": {"axis": [1, 0, 0], "angle": pi / 2}}
        if self.chance(0.3):
            shape = {"sphere": radius}
        mass = self.number(0.5, 3)
        moment = mass * radius**2 * self.one_of((0.4, 0.5, 1.0))
        self.bodies[w] = {
            "mass": mass,
            "inertia": [moment] * 3,
            "shapes": {"tread": {**shape, "surface": part}},
        }
        speed = self.one_of((0.0, 1.0, 5.0, -2.0))
        height = radius + self.one_of((0.0, 0.0, 0.0, 0.05))
        spin = self.one_of((0.0, speed / radius, self.speed(5.0)))
        at = {"body": "ground", "position": [0, -3.0, 0]}
        for name, kind, axis, parent, start in (
            (x, "prismatic", [1, 0, 0], at, {"s": 0.0, "v": speed}),
            (z, "prismatic", [0, 0, 1], x, {"s": height, "v": 0.0}),
            (w, "revolute", [0, 1, 0], z, {"phi": 0.0, "w": spin}),
        ):
            self.joints[name] = {
                "type": kind,
                "axis": axis,
                "parent": parent,
                "child": name,
                "start": start | {"fixed": True},
            }
        self.contacts[f"{part}k"] = self.contact(part)
        self.carriers.append({"body": z, "position": [0.1, 0, 0.2]})
        torque = 0.5 * 9.81 * (load + mass) * radius
        self.law(w, torque, bounds=1.0)
        if self.chance(0.4):
            self.joints[x]["friction"] = {"coulomb": self.number(0.05, 0.5) * load}
        if self.chance(0.3):
            self.joints[x]["limit"] = {
                "upper": self.one_of((0.1, 0.5)),
                "restitution": self.one_of((0.0, 0.5)),
            }
        if self.chance(0.7):
            self.motor(w, torque)

    def thrown(self, part: str) -> None:
        """A free body over the ground."""
        size, mass = self.number(0.1, 0.3), self.number(0.2, 3)
        moment = mass * size**2
        shape = self.one_of(
            (
                {"sphere": size / 2},
                {"box": [size, 0.7 * size, 0.5 * size]},
                {"capsule": {"radius": size / 4, "length": size}},
            )
        )
        self.bodies[part] = {
            "mass": mass, "inertia": [0.1 * moment, 0.12 * moment, 0.15 * moment],
            "shapes": {"hull": {**shape, "surface": part}},
        }  # fmt: skip
        if self.chance(0.4):
            Q = [0.0, 0.0, 0.0, 1.0]
            height = {"sphere": size / 2, "box": size / 4, "capsule": size / 4}[next(iter(shape))]
            if "capsule" in shape:
                Q = [0.0, float(np.sqrt(0.5)), 0.0, float(np.sqrt(0.5))]
            v, w = [self.speed(), self.speed(), 0.0], [0.0, 0.0, 0.0]
            height += self.one_of((0.0, 0.0, 0.05))
        else:
            turn = self.rng.normal(size=4)
            Q = (turn / np.linalg.norm(turn)).tolist()
            v, w = (self.rng.normal(size=3).round(2).tolist() for _ in range(2))
            height = size * self.between(1, 2)
        start = {"r": [self.between(-2, 2), 4.0 + ord(part), height], "Q": Q, "v": v, "w": w, "fixed": True}
        self.joints[part] = {"type": "free", "parent": "ground", "child": part, "start": start}
        self.contacts[f"{part}k"] = self.contact(part)
        self.carriers.append({"body": part, "position": [0, 0, size]})

    def driven(self, part: str) -> None:
        """A body whose position is an input, and one that a spring and a damper connect with it."""
        a, b = f"{part}0", f"{part}1"
        self.bodies |= {a: {"mass": 1.0}, b: {"mass": self.number(0.3, 3)}}
        self.joints[a] = {
            "type": "prismatic",
            "axis": [1, 0, 0],
            "parent": {"body": "ground", "position": [0, 2, 3]},
            "child": a,
        }
        self.joints[b] = {"type": "prismatic", "axis": [1, 0, 0], "parent": a, "child": b,
                          "start": {"s": 0.0, "v": 0.0, "fixed": True}}  # fmt: skip
        self.law(b, 5.0, bounds=0.1)
        self.joints[b] |= {"stiffness": self.number(10, 300), "damping": self.number(0.5, 10)}
        self.constraints[f"{part}m"] = {"type": "motion", "joint": a, "input": "position"}
        self.inputs[f"{part}m.s_ref"] = self.course((0.1, 0.3, 1.0), jumps=False)

    def trial(self) -> Trial:
        parts = {
            "chain": self.chain, "loop": self.loop, "shafts": self.shafts,
            "wheel": self.wheel, "thrown": self.thrown, "driven": self.driven,
        }  # fmt: skip
        names = ("chain", "chain", "loop", "loop", "shafts", "wheel", "wheel", "thrown", "driven")
        count = int(self.one_of((1, 1, 2, 3)))
        for letter in "abc"[:count]:
            parts[self.one_of(names)](letter)
        if count > 1 and self.chance(0.5):
            ends = [self.one_of([name for name in self.bodies if name[0] == letter]) for letter in "ab"]
            self.forces["spring"] = {
                "type": "spring_damper", "from": ends[0], "to": ends[1],
                "stiffness": self.number(1, 100), "damping": self.one_of((0.0, 1.0)), "length": 1.0,
            }  # fmt: skip
        scene: SceneData = {
            "gelenk": 1,
            "gravity": self.gravity,
            "bodies": self.bodies,
            "joints": self.joints,
        }
        for name in ("motors", "constraints", "forces", "contacts"):
            if section := getattr(self, name):
                scene[name] = section
        if self.contacts:
            scene["ground"] = {"shapes": {"road": {"plane": [0, 0, 1], "surface": "road"}}}
        self.inputs = {
            name: course
            for name, course in self.inputs.items()
            if ".friction." not in name or "friction" in self.joints[name.partition(".")[0]]
        }
        if self.contacts:  # gears with losses exclude them
            for constraint in self.constraints.values():
                constraint.pop("efficiency", None)
        tolerance = self.one_of((1e-6, 1e-8, 1e-8, 1e-10))
        return with_joint_names(Trial(scene, self.inputs, self.points, tolerance))


def with_joint_names(trial: Trial) -> Trial:
    """Joints are drawn under the names of their bodies; afterwards they begin with J."""
    scene = trial.scene
    scene["joints"] = {f"J{name}": joint for name, joint in scene["joints"].items()}
    for section in ("motors", "constraints"):
        for entry in scene.get(section, {}).values():
            entry |= {key: f"J{entry[key]}" for key in ("joint", "with") if key in entry}
    trial.inputs = {
        ("J" if ".friction." in name else "") + name: course for name, course in trial.inputs.items()
    }
    return trial
