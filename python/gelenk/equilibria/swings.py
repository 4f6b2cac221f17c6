# SPDX-License-Identifier: BSD-3-Clause
"""Limits of ball joints, and isotropic friction of joints, which equilibria treat as contacts."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

Z_AXIS = (0.0, 0.0, 1.0)


def swing_limits(joints: Mapping[str, Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Return the limits of the swing among the joints of a scene, by the names of joints."""
    limits = {name: joint.get("limit", {}) for name, joint in joints.items()}
    return {name: limit for name, limit in limits.items() if "swing" in limit}


def has_isotropic_friction(outputs: Iterable[str]) -> bool:
    """Return whether a joint has friction along several velocities together, by the names of outputs."""
    return any(re.search(r"\.friction(\.\w+)?\.(tau|f)\[1\]$", name) for name in outputs)


def room(limit: Mapping[str, Any], Q: Sequence[float]) -> float:
    """Return how far a ball joint with the quaternion Q is from such a limit [rad]; negative beyond it."""
    v, s = np.array(Q[:3]), Q[3]
    parent = np.array(limit.get("parent_axis", Z_AXIS), float)
    child = np.array(limit.get("child_axis", Z_AXIS), float)
    turned = child + 2 * s * np.cross(v, child) + 2 * np.cross(v, np.cross(v, child))
    angle = math.atan2(float(np.linalg.norm(np.cross(parent, turned))), float(parent @ turned))
    return float(limit["swing"]) - angle


def path_of_law(law: str) -> str:
    """Return the place in a scene of a contact, or of the limit of a joint, by its name."""
    return f"joints.{law}" if "." in law else f"contacts.{law}"


def unit_of_law(law: str) -> str:
    """Return the unit of its force: of a limit, or of the friction of a rotation, that of a torque."""
    return "N m" if "." in law and not law.endswith(".translation") else "N"


def is_friction_of_joint(law: str) -> bool:
    """Return whether it is the friction of a joint, which has no normal force."""
    return ".friction" in law
