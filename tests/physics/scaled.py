# SPDX-License-Identifier: BSD-3-Clause
"""The same mechanism in other sizes: lengths times one factor, masses times another, times and angles as
they are.
"""

from __future__ import annotations

import copy
import re
from typing import Any

from mechanisms import Scene

# Exponents of mass and length in the symbols of units.
SYMBOLS = {
    "kg": (1, 0), "m": (0, 1), "N": (1, 1), "J": (1, 2),
    "s": (0, 0), "rad": (0, 0), "Hz": (0, 0), "1": (0, 0),
}  # fmt: skip
SLIDES = {"s", "s_x", "s_y", "r", "v", "v_x", "v_y"}
# Of coordinates by kind of joint: whether it slides.
COORDINATES = {
    "revolute": [False],
    "prismatic": [True],
    "planar": [True, True, False],
    "cylindrical": [True, False],
    "universal": [False, False],
    "spherical": [False] * 3,
    "free": [True] * 3 + [False] * 3,
}


def size(unit: str, length: float, mass: float) -> float:
    """What a quantity of this unit is multiplied by."""
    factor = 1.0
    for sign, part in zip((1, -1), unit.partition("/")[::2], strict=True):
        for name, power in re.findall(r"(kg|rad|Hz|[mNJs1])(\d?)", part):
            of_mass, of_length = SYMBOLS[name]
            factor *= (mass**of_mass * length**of_length) ** (sign * int(power or 1))
    return factor


def scaled(source: Scene, length: float, mass: float) -> Scene:
    """The scene with all lengths times `length` and all masses times `mass`, gravity and loads to match."""
    out = copy.deepcopy(source)
    moment = mass * length**2

    def times(entry: dict[str, Any], factors: dict[str, float]) -> None:
        for key, factor in factors.items():
            if key in entry:
                value = entry[key]
                entry[key] = [factor * x for x in value] if isinstance(value, list) else factor * value

    times(out, {"gravity": length})
    for body in out["bodies"].values():
        times(body, {"mass": mass, "com": length, "inertia": moment})
    for joint in out["joints"].values():
        for side in ("parent", "child"):
            if isinstance(joint[side], dict):
                times(joint[side], {"position": length})
        slide = COORDINATES[joint["type"]]
        times(joint.get("start", {}), dict.fromkeys(SLIDES, length))
        for key in ("damping", "stiffness", "spring_reference"):
            if key not in joint:
                continue
            values = joint[key] if isinstance(joint[key], list) else [joint[key]]
            of_slide, of_turn = (length, 1.0) if key == "spring_reference" else (mass, moment)
            found = [x * (of_slide if s else of_turn) for x, s in zip(values, slide, strict=True)]
            joint[key] = found if isinstance(joint[key], list) else found[0]
    for motor in out.get("motors", {}).values():
        slide = COORDINATES[out["joints"][motor["joint"]]["type"]]
        times(motor, {"rotor_inertia": mass if slide == [True] else moment})
    for force in out.get("forces", {}).values():
        times(force, {"position": length, "length": length, "stiffness": mass, "damping": mass})
        times(force, {"force": mass * length, "torque": moment})
        for side in ("from", "to"):
            if isinstance(force.get(side), dict):
                times(force[side], {"position": length})
    for constraint in out.get("constraints", {}).values():
        times(constraint, {"position": length, "radius": length})
        if isinstance(constraint.get("on"), dict):
            times(constraint["on"], {"position": length})
    for sensor in out.get("sensors", {}).values():
        times(sensor, {"position": length})
    return out
