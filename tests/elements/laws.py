# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the elements' laws share: cases over the whole registry, poses and motions, units."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from joints.laws import EPS, QUOTIENT, ROUND_OFF, STEP, Array, moved, rotated, skew

from gelenk._core import elements

__all__ = ["EPS", "QUOTIENT", "ROUND_OFF", "STEP", "Array", "moved", "rotated", "skew"]

Numbers = dict[str, Any]
Kind = dict[str, Any]

KINDS: dict[str, list[Kind]] = elements.kinds()
# Expressions in place of numbers, which exclude these (test_tire_curves.py).
INSTEAD = {"tire": ("force_long", "force_lat")}
for kinds in KINDS.values():
    for one in kinds:
        one["fields"] = [f for f in one["fields"] if f["name"] not in INSTEAD.get(one["name"], ())]

# Powers of length, mass and time.
BASE = {"m": (1, 0, 0), "kg": (0, 1, 0), "s": (0, 0, 1), "rad": (0, 0, 0), "1": (0, 0, 0), "": (0, 0, 0),
        "Hz": (0, 0, -1), "N": (1, 1, -2), "J": (2, 1, -2), "W": (2, 1, -3)}  # fmt: skip
FORCE, TORQUE = BASE["N"], (2, 1, -2)
OF_COORDINATE = {
    True: {"{q}": "rad", "{v}": "rad/s", "{f}": "N.m", "{J}": "kg.m2"},
    False: {"{q}": "m", "{v}": "m/s", "{f}": "N", "{J}": "kg"},
}


def dimension(unit: str, angle: bool = True) -> tuple[int, int, int]:
    """Of a unit as FMI spells it: "N.m.s2/rad2" is (2, 1, 0). angle: what {q} is."""
    for placeholder, by in OF_COORDINATE[angle].items():
        unit = unit.replace(placeholder, by)
    total = np.zeros(3, int)
    over, *under = unit.split("/")
    for sign, factors in [(1, over), *((-1, part) for part in under)]:
        for factor in factors.split("."):
            found = re.fullmatch(r"([A-Za-z]*|1)(-?\d*)", factor)
            assert found, unit
            total += sign * int(found[2] or 1) * np.array(BASE[found[1]])
    return (int(total[0]), int(total[1]), int(total[2]))


def is_damping(field: Kind) -> bool:
    """Whether it multiplies a speed, with a unit of a stiffness times s, or s^2, or is friction or slip."""
    of_slip = ("coulomb", "static", "slip_stiffness", "cornering_stiffness")
    return bool(re.search(r"\.s\d?\b", field["unit"])) or field["name"] in of_slip


def is_load(field: Kind) -> bool:
    """Whether it is a force or a torque itself, which puts energy in."""
    return dimension(field["unit"]) in (FORCE, TORQUE) and not field["unit"].count("/")


FORMULAS = ("formula", "formulas")


def drawn(field: Kind, rng: np.random.Generator) -> Any:
    """Some number or list that the field allows; of a choice or a flag: its default."""
    signs = (1.0,) if field["range"] in ("positive", "not_negative") else (-1.0, 1.0)

    def number() -> float:
        if field["range"] == "fraction":
            return float(rng.uniform(0.3, 0.7))
        return float(rng.choice(signs) * rng.uniform(0.3, 2.0))

    if field["name"] == "exponent":
        return 1.0  # or 2
    if field["type"] == "number":
        return number()
    if field["type"] in ("vector", "direction"):
        return [number() for _ in range(3)]
    if field["type"] == "numbers":
        found = [number() for _ in range(max(3, field["size"]))]
        # In order, so that a table is a curve through which pchip depends on each of its points.
        return sorted(abs(x) for x in found) if field["unit"] == "s" else sorted(found)
    if field["type"] in FORMULAS:
        # Both spellings of a coordinate are one variable; forces do not depend on the place in the world.
        names = [name for name in field["variables"] if name not in ("s", "v", "x", "y", "z")]
        text = "0.9" + "".join(f" - {number():.3f}*{name} - 0.2*{name}^3" for name in names)
        return text if field["type"] == "formula" else [text, "0.3", f"-({text})"]
    return field["default"]


def is_number(field: Kind) -> bool:
    return field["type"] in ("number", "vector")


@dataclass(frozen=True)
class Case:
    """A kind with its numbers by the names of its fields."""

    kind: Kind
    numbers: Numbers
    label: str

    def __str__(self) -> str:
        return f"{self.kind['name']}-{self.label}" if self.label else str(self.kind["name"])

    @property
    def force(self) -> Any:
        return elements.Force(self.kind["name"], self.numbers)

    @property
    def along(self) -> Any:
        return elements.Along(self.kind["name"], self.numbers)

    @property
    def fields(self) -> list[Kind]:
        """Those that are numbers or vectors of them."""
        return [field for field in self.kind["fields"] if is_number(field)]

    def with_number(self, name: str, value: Any) -> Case:
        return replace(self, numbers={**self.numbers, name: value})

    def without(self, *names: str) -> Case:
        """The same with these at zero."""
        zeros = {f["name"]: [0.0] * 3 if f["type"] == "vector" else 0.0 for f in self.fields}
        return replace(self, numbers={**self.numbers, **{name: zeros[name] for name in names}})


def words_and_flags(kind: Kind) -> Iterator[tuple[str, Numbers]]:
    """Each combination of the kind's flags and words, with a label."""
    fields = [f for f in kind["fields"] if f["type"] in ("flag", "choice")]
    ranges = [range(2) if f["type"] == "flag" else range(len(f["words"])) for f in fields]
    for values in product(*ranges):
        numbers = {f["name"]: float(x) for f, x in zip(fields, values, strict=True)}
        yield "-".join(f"{name}={x:g}" for name, x in numbers.items()), numbers


def is_formula(case: Case) -> bool:
    """Whether the force is what the user writes, in SI units, with any power."""
    return any(field["type"] in FORMULAS for field in case.kind["fields"])


def by_way(kind: Kind) -> Iterator[tuple[str, Kind]]:
    """The kind with the fields of each of its alternatives, with a label if there are several."""
    ways = sorted({f["way"] for f in kind["fields"] if f["way"]}) or [0]
    for way in ways:
        fields = [f for f in kind["fields"] if f["way"] in (0, way)]
        yield f"way={way}" if len(ways) > 1 else "", {**kind, "fields": fields}


def general_cases(of: Kind) -> Iterator[Case]:
    """With numbers without zeros and symmetries, that fit each other."""
    make = elements.Force if of in KINDS["forces"] else elements.Along
    rng = np.random.default_rng(20261122)
    for way, kind, label, words in [(*one, *more) for one in by_way(of) for more in words_and_flags(one[1])]:
        for _ in range(100):
            described = [f for f in kind["fields"] if is_number(f) or f["type"] in FORMULAS]
            numbers = {f["name"]: drawn(f, rng) for f in described} | words
            if make(kind["name"], numbers).is_sound:
                break
        yield Case(kind, numbers, "-".join(x for x in (way, label) if x))


def special_cases(kind: Kind) -> Iterator[Case]:
    """The general ones, and those with each number at zero, and with all others at zero."""
    for case in general_cases(kind):
        yield case
        may_vanish = [f["name"] for f in case.fields if f["range"] in ("any", "not_negative")]
        may_vanish = [n for n in may_vanish if not next(f for f in case.fields if f["name"] == n)["required"]]
        sets = [(name,) for name in may_vanish]
        sets += [tuple(n for n in may_vanish if n != name) for name in may_vanish]
        for names in dict.fromkeys(sets):
            labels = [case.label, "no-" + "-".join(names)]
            yield replace(case.without(*names), label="-".join(x for x in labels if x))


def all_cases(section: str) -> list[Case]:
    return [case for kind in KINDS[section] for case in special_cases(kind)]


def rotation(axis: Any, angle: float) -> Array:
    K = skew(np.asarray(axis, float) / np.linalg.norm(axis))
    turn: Array = np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K
    return turn


def pose(R: Array, p: Any) -> Array:
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, p
    return X


def random_pose(rng: np.random.Generator) -> Array:
    return pose(rotation(rng.normal(size=3), rng.uniform(-2, 2)), rng.uniform(-1, 1, 3))


# Where frames are against each other: apart, come together, and turned by round angles. Half a turn is
# where a rotation vector jumps, and no place to ask for derivatives.
RELATIVE = {
    "together": np.eye(4),
    "same-axes": pose(np.eye(3), [0.3, -0.4, 0.9]),
    "same-point": pose(rotation([0.3, -0.5, 0.8], 0.7), [0, 0, 0]),
    "quarter-turn": pose(np.round(rotation([0, 0, 1], math.pi / 2)), [1, 0, 0]),
    "quarter-turn-about-x": pose(np.round(rotation([1, 0, 0], -math.pi / 2)), [0, 0, -2]),
    "hardly-turned": pose(rotation([1, -2, 0.5], 1e-7), [0.4, 0, 0]),
    "a-little-turned": pose(rotation([1, -2, 0.5], 1e-3), [0.4, 0.3, 0]),
    "tenth-of-a-radian": pose(rotation([1, -2, 0.5], 0.1), [0.4, 0.1, 0.3]),
    "nearly-half-a-turn": pose(rotation([1, -2, 0.5], 3.0), [-0.6, 0.1, 0.3]),
}


@dataclass(frozen=True)
class Place:
    """Where the ports are, how they move, what the inputs are, and the world's axes along these."""

    name: str
    poses: list[Array]
    velocities: list[Array]
    inputs: Array
    R_0W: Array

    def act(self, force: Any) -> list[Array]:
        return list(force.act(self.poses, self.velocities, self.inputs, self.R_0W))

    def jacobians(self, force: Any) -> Any:
        return force.jacobians(self.poses, self.velocities, self.inputs, self.R_0W)

    def derivatives_by_duals(self, force: Any) -> dict[str, Any]:
        return dict(force.derivatives_by_duals(self.poses, self.velocities, self.inputs, self.R_0W))

    def after(self, dt: float) -> list[Array]:
        """The ports' poses a short time later."""
        return [moved(X, V, dt) for X, V in zip(self.poses, self.velocities, strict=True)]

    @property
    def size(self) -> float:
        """Of lengths and speeds, for bounds on rounding."""
        return 1 + max(float(np.abs(X[:3, 3]).max()) for X in self.poses)


def places(force: Any) -> list[Place]:
    """Random ones, and special positions and speeds."""
    rng = np.random.default_rng(11)
    count = sum(group["size"] for group in force.inputs)

    def place(name: str, poses: list[Array], still: bool = False) -> Place:
        velocities = [rng.uniform(-2, 2, 6) * (0 if still else 1) for _ in poses]
        R_0W = rotation(rng.normal(size=3), 1.1)
        return Place(name, poses, velocities, rng.uniform(-2, 2, count), R_0W)

    found = [place(f"random-{k}", [random_pose(rng) for _ in range(force.ports)]) for k in range(8)]
    for name, X in RELATIVE.items():
        first = random_pose(rng)
        poses = [X] if force.ports == 1 else [first, first @ X]
        if force.undefined(poses):
            continue
        found += [place(name, poses), place(f"{name}-still", poses, still=True)]
    return found


def scale_of(wrenches: list[Array], place: Place) -> float:
    """The largest force or torque, with what a force does about the origin."""
    return (1 + max(float(np.abs(F).max()) for F in wrenches)) * place.size
