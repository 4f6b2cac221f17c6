# SPDX-License-Identifier: BSD-3-Clause
"""A trial of the failure map of contacts, and the scenes that they share."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.nonsmooth.trial import Trial

type Scene = dict[str, Any]

GRAVITY = 9.81  # m/s2
NEAR = 1e-6
UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ContactTrial(Trial):
    """A trial whose motion has a largest speed, of which the error of steps with impulses is a multiple."""

    speed: float = 1.0  # m/s


def share(x: float) -> str:
    """Return a label: "1 - 1e-6" where the number is that near to 1."""
    if x != 1 and abs(x - 1) < 1e-3:
        return f"1 {'-' if x < 1 else '+'} {abs(x - 1):.0e}".replace("e-0", "e-")
    return f"{x:g}"


def sphere(radius: float) -> Scene:
    return {"sphere": radius}


def moments(shape: Scene, mass: float) -> list[float]:
    """Return the moments of inertia of a sphere or a box [kg m2]."""
    if "sphere" in shape:
        return [0.4 * mass * shape["sphere"] ** 2] * 3
    x, y, z = (length**2 for length in shape["box"])
    return [mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y)]


def body(shape: Scene, mass: float) -> Scene:
    shapes = {"s": {**shape, "surface": "body"}}
    return {"mass": mass, "inertia": moments(shape, mass), "shapes": shapes}


def free(child: str, r: Sequence[float], **start: Any) -> Scene:
    values = {"r": list(r), **{k: list(v) for k, v in start.items()}, "fixed": True}
    return {"type": "free", "parent": "ground", "child": child, "start": values}


def on_plane(
    shape: Scene,
    r: Sequence[float],
    *,
    angle: float = 0.0,
    mass: float = 1.0,
    friction: float = 0.0,
    restitution: float = 0.0,
    gravity: float = GRAVITY,
    **start: Any,
) -> Scene:
    """Return a body on a plane through the origin that falls towards +x by an angle [rad]."""
    normal = [math.sin(angle), 0, math.cos(angle)]
    half = angle / 2
    turned = {"Q": [0, math.sin(half), 0, math.cos(half)]} if angle else {}
    contact = {"between": ["body", "floor"], "friction": friction, "restitution": restitution}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -gravity],
        "bodies": {"b": body(shape, mass)},
        "ground": {"shapes": {"floor": {"plane": normal, "surface": "floor"}}},
        "joints": {"J": free("b", r, **turned, **start)},
        "contacts": {"c": contact},
    }


def places(
    found: Sequence[Sequence[float]], joint: str = "J", axes: Sequence[int] = (1, 3)
) -> Mapping[str, list[float]]:
    return {f"{joint}.r[{k}]": [row[i] for row in found] for i, k in enumerate(axes)}
