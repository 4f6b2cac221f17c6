# SPDX-License-Identifier: BSD-3-Clause
"""Types of URDF joints, and joints that follow others (mimic)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

KINDS = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "weld",
    "floating": "free",
    "planar": "planar",
}
DRIVEN = ("revolute", "prismatic")


def coupling_of(joint: Any, by_name: Mapping[str, Any], joints: Mapping[str, str]) -> dict[str, Any] | None:
    """Return the constraint of a joint that follows another one, or None if it does not or cannot.

    Args:
        joint: the joint in the URDF file.
        by_name: all joints of the file.
        joints: their names in the scene.
    """
    leader = None if joint.mimic is None else by_name.get(joint.mimic.joint)
    if leader is None or leader is joint or {KINDS[joint.type], KINDS[leader.type]} - {*DRIVEN}:
        return None
    given = joint.mimic.multiplier, joint.mimic.offset
    ratio, offset = (float(otherwise if x is None else x) for x, otherwise in zip(given, (1, 0), strict=True))
    if ratio == 0:
        return None
    here, there = joints[joint.name], joints[leader.name]
    if KINDS[joint.type] == KINDS[leader.type]:
        entry: dict[str, Any] = {"type": "coupling", "joint": here, "with": there, "ratio": ratio}
    elif KINDS[joint.type] == "prismatic":
        entry = {"type": "rack", "rack": here, "pinion": there, "radius": ratio}
    else:  # the angle is ratio * travel + offset
        entry = {"type": "rack", "rack": there, "pinion": here, "radius": 1 / ratio}
        offset = -offset / ratio
    return entry | ({"offset": offset} if offset else {})


def mimicry(joint: Any, by_name: Mapping[str, Any]) -> str:
    """Return the note on a joint that follows another one in the file."""
    if coupling_of(joint, by_name, {name: name for name in by_name}) is not None:
        return f"joint {joint.name}: follows {joint.mimic.joint} (mimic) by a constraint, and has no motor"
    free = "here it moves freely" + (" and has a motor" if KINDS[joint.type] in DRIVEN else "")
    return f"joint {joint.name}: follows {joint.mimic.joint} in the file (mimic); {free}"
