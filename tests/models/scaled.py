# SPDX-License-Identifier: BSD-3-Clause
"""The same mechanism at other scales: lengths multiplied by one factor, masses by another,
times and angles unchanged.

The factor of each number follows from its unit in the registry.
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
    """Return the factor of a quantity with this unit; angle: whether a coordinate in it is an angle."""
    of_length, of_mass, _ = dimension(unit, angle)
    return float(length**of_length * mass**of_mass)


def multiplied(value: Any, factor: float) -> Any:
    if isinstance(value, str):  # a formula without lengths and masses
        return f"({value})*{factor!r}"
    return [multiplied(x, factor) for x in value] if isinstance(value, list) else factor * value


def turns(joint: dict[str, Any]) -> list[bool]:
    """For each of the joint's velocities, whether it belongs to an angle."""
    return [unit.startswith("rad") for unit in JOINTS[joint["type"]]["v_units"]]


@dataclass(frozen=True)
class Factors:
    """The factors of lengths and masses; `times` and `times_fields` modify an entry of a scene."""

    length: float
    mass: float

    def times(self, entry: Any, units: dict[str, str]) -> None:
        """Multiply the values with these names, in these units;
        an entry may be a string instead of a mapping.
        """
        if isinstance(entry, dict):
            for key in set(units) & set(entry):
                entry[key] = multiplied(entry[key], size(units[key], self.length, self.mass))

    def times_fields(self, entry: dict[str, Any], fields: list[Kind], angle: bool) -> None:
        """Multiply the fields in the registry; angle: whether the coordinate of the entry is an angle."""
        for field in fields:
            if field["name"] not in entry:
                continue
            if field["type"] == "group":
                self.times_fields(entry[field["name"]], field["fields"], angle)
            elif field["unit"]:
                factor = size(field["unit"], self.length, self.mass, angle)
                entry[field["name"]] = multiplied(entry[field["name"]], factor)


def scaled(source: Scene, length: float, mass: float) -> Scene:
    """The scene with all lengths times `length` and all masses times `mass`,
    with matching gravity and loads.
    """
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
    """Scale its frames, start values, own fields, and the fields along its coordinates."""
    facts = JOINTS[joint["type"]]
    for side in ("parent", "child"):
        by.times(joint[side], {"position": "m"})
    for of in "qv":
        names = (name.split("[")[0] for name in facts[of])
        by.times(joint.get("start", {}), dict(zip(names, facts[f"{of}_units"], strict=True)))
    by.times_fields(joint, facts["fields"], angle=True)
    for entry, field, angles in along(joint):
        values = entry[field["name"]]
        each = values if isinstance(values, list) else [values]
        found = [
            multiplied(x, size(field["unit"], by.length, by.mass, angle))
            for x, angle in zip(each, angles, strict=True)
        ]
        entry[field["name"]] = found if isinstance(values, list) else found[0]


def scale_element(element: dict[str, Any], kind: Kind, joints: dict[str, Any], by: Factors) -> None:
    """Scale its fields, according to the coordinate of its joint, and its points of application."""
    at = [element[p["name"]] for p in kind["ports"] if p["kind"] == "joint" and p["name"] in element]
    own = JOINTS[joints[at[0]]["type"]]["q"] if at else ()
    k = own.index(element["coordinate"]) if element.get("coordinate") in own else 0
    by.times_fields(element, kind["fields"], turns(joints[at[0]])[k] if at else True)
    for port in kind["ports"]:
        if port["kind"] != "joint":
            by.times(element.get(port["name"]) if port["name"] else element, {"position": "m"})


def along(joint: dict[str, Any]) -> Iterator[tuple[dict[str, Any], Kind, list[bool]]]:
    """Yield the fields of a joint along its coordinates: mapping, field, which coordinates are angles."""
    angles = list(turns(joint))
    names = JOINTS[joint["type"]]["q"]
    for kind in KINDS["joints"]:
        entry = joint.get(kind["group"], {}) if kind["group"] else joint
        entries = [(entry, angles)]
        if kind["group"] and len(angles) > 1:  # by names
            entries = [(entry[n], [a]) for n, a in zip(names, angles, strict=False) if n in entry]
        for at, of in entries:
            for field in kind["fields"]:
                if field["name"] in at and field["unit"]:
                    yield at, field, of
