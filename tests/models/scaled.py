# SPDX-License-Identifier: BSD-3-Clause
"""The same mechanism in other sizes: lengths times one factor, masses times another, times and angles as
they are. What a number is multiplied by follows from its unit, which the registry tells.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from elements.laws import KINDS, Kind, dimension
from elements.scenes import JOINTS
from mechanisms import Scene

SECTIONS = {
    section: {kind["name"]: kind for kind in KINDS[section]} for section in KINDS if section != "joints"
}


def size(unit: str, length: float, mass: float, angle: bool = True) -> float:
    """What a quantity of this unit is multiplied by; angle: what a coordinate in it is."""
    of_length, of_mass, _ = dimension(unit, angle)
    return float(length**of_length * mass**of_mass)


def multiplied(value: Any, factor: float) -> Any:
    return [factor * x for x in value] if isinstance(value, list) else factor * value


def turns(joint: dict[str, Any]) -> list[bool]:
    """Of each of the joint's speeds, whether it is one of an angle."""
    return [unit.startswith("rad") for unit in JOINTS[joint["type"]]["v_units"]]


@dataclass(frozen=True)
class Factors:
    """What lengths and masses are multiplied by; `times` and `times_fields` change an entry of a scene."""

    length: float
    mass: float

    def times(self, entry: Any, units: dict[str, str]) -> None:
        """What is told by these names, in these units; an entry may be a word in place of a mapping."""
        if isinstance(entry, dict):
            for key in set(units) & set(entry):
                entry[key] = multiplied(entry[key], size(units[key], self.length, self.mass))

    def times_fields(self, entry: dict[str, Any], fields: list[Kind], angle: bool) -> None:
        """What the registry lists; angle: the coordinate that the entry is about is one."""
        for field in fields:
            if field["name"] not in entry:
                continue
            if field["type"] == "group":
                self.times_fields(entry[field["name"]], field["fields"], angle)
            elif field["unit"]:
                factor = size(field["unit"], self.length, self.mass, angle)
                entry[field["name"]] = multiplied(entry[field["name"]], factor)


def scaled(source: Scene, length: float, mass: float) -> Scene:
    """The scene with all lengths times `length` and all masses times `mass`, gravity and loads to match."""
    out = copy.deepcopy(source)
    by = Factors(length, mass)
    by.times(out, {"gravity": "m/s2"})
    for body in out["bodies"].values():
        by.times(body, {"mass": "kg", "com": "m", "inertia": "kg.m2"})
    for joint in out["joints"].values():
        scale_joint(joint, by)
    for section, kinds in SECTIONS.items():
        for element in out.get(section, {}).values():
            scale_element(element, kinds[element.get("type", next(iter(kinds)))], out["joints"], by)
    return out


def scale_joint(joint: dict[str, Any], by: Factors) -> None:
    """Its frames, its start, its own fields, and what it has along its coordinates."""
    facts = JOINTS[joint["type"]]
    for side in ("parent", "child"):
        by.times(joint[side], {"position": "m"})
    for of in "qv":
        names = (name.split("[")[0] for name in facts[of])
        by.times(joint.get("start", {}), dict(zip(names, facts[f"{of}_units"], strict=True)))
    by.times_fields(joint, facts["fields"], angle=True)
    for entry, field in along(joint):
        values = entry[field["name"]]
        each = values if isinstance(values, list) else [values]
        found = [
            x * size(field["unit"], by.length, by.mass, angle)
            for x, angle in zip(each, turns(joint), strict=True)
        ]
        entry[field["name"]] = found if isinstance(values, list) else found[0]


def scale_element(element: dict[str, Any], kind: Kind, joints: dict[str, Any], by: Factors) -> None:
    """Its fields, by the coordinate of the joint that it is at, and the points where it takes hold."""
    at = [element[p["name"]] for p in kind["ports"] if p["kind"] == "joint" and p["name"] in element]
    by.times_fields(element, kind["fields"], turns(joints[at[0]])[0] if at else True)
    for port in kind["ports"]:
        if port["kind"] != "joint":
            by.times(element.get(port["name"]) if port["name"] else element, {"position": "m"})


def along(joint: dict[str, Any]) -> Iterator[tuple[dict[str, Any], Kind]]:
    """(mapping, field) of what the joint has along its coordinates."""
    for kind in KINDS["joints"]:
        entry = joint.get(kind["group"], {}) if kind["group"] else joint
        for field in kind["fields"]:
            if field["name"] in entry:
                yield entry, field
