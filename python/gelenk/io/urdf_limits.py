# SPDX-License-Identifier: BSD-3-Clause
"""Limits of position of URDF joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def bounds_of(joint: Any) -> tuple[float, float] | None:
    """Return the limits of position; None if there are none, as where both have the default 0."""
    if joint.type not in ("revolute", "prismatic") or joint.limit is None:
        return None
    lower, upper = (float(x or 0.0) for x in (joint.limit.lower, joint.limit.upper))
    return (lower, upper) if lower < upper else None


def start_within(bounds: tuple[float, float]) -> float:
    """Return the position at which a joint starts: 0 or, if that is beyond a limit, the middle."""
    lower, upper = bounds
    return 0.0 if lower <= 0 <= upper else (lower + upper) / 2


def limit_notes(movable: Sequence[Any], converted: bool) -> list[str]:
    """Return the notes on limits of position, velocity and effort."""
    given = [j for j in movable if j.limit is not None]
    bounded = [j for j in given if bounds_of(j)]
    notes = []
    if bounded and not converted:
        notes.append(f"limits of position are left out, as requested: {_names(bounded)}")
    if bounded and converted:
        notes.append(f"joints with hard limits: {_names(bounded)}")
    for j in bounded if converted else []:
        if (start := start_within(bounds_of(j) or (0, 0))) != 0:
            unit = "rad" if j.type == "revolute" else "m"
            notes.append(f"joint {j.name}: starts at {start:g} {unit}, since its limits do not contain 0")
    for j in given:
        if j.limit.lower is not None and j.limit.upper is not None and j.limit.lower > j.limit.upper:
            notes.append(f"joint {j.name}: its lower limit exceeds its upper one; both are left out")
        elif (
            j.limit.lower is not None
            and j.limit.lower == j.limit.upper
            and j.type in ("revolute", "prismatic")
        ):
            notes.append(
                f"joint {j.name}: its lower limit equals its upper one, {j.limit.lower:g}; both are left "
                "out, and it moves freely: give it the type fixed if it is not to move"
            )
    if given:
        notes.append(f"limits of velocity and effort are not modeled: {_names(given)}")
    return notes


def _names(joints: Sequence[Any]) -> str:
    return ", ".join(joint.name for joint in joints)
