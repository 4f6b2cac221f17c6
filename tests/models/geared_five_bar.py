# SPDX-License-Identifier: BSD-3-Clause
"""A geared five-bar (two cranks coupled by gears, and two bars joined at their ends):
its scene and its geometry.
"""

from __future__ import annotations

import math
from typing import Any

from mechanisms import GRAVITY, Scene, body, frame, joint, scene

from models.one_dof import Geometry, Jet, Moving, acos, atan2, cos, jet, sin, sqrt

CRANK, BAR, BASE = 0.3, 0.8, 0.7
CRANK_MASS, BAR_MASS = 1.1, 0.7


def five_bar(phi: float, ratio: float, offset: float) -> Scene:
    """Cranks A and E on the ground, bars B and D on them, connected at C; E = ratio A + offset."""
    about_z: dict[str, Any] = {"axis": [0, 0, 1]}
    rod = {"crank": (CRANK_MASS, CRANK), "bar": (BAR_MASS, BAR)}

    def link(kind: str) -> dict[str, Any]:
        mass, length = rod[kind]
        return body(mass, (length / 2, 0, 0), (0, mass * length**2 / 12, mass * length**2 / 12))

    left, right = (angle.x for angle in five_bar_jets(Jet(phi, 1.0), ratio, offset))
    other = ratio * phi + offset
    return scene(
        {"left": link("crank"), "right": link("crank"), "up": link("bar"), "down": link("bar")},
        {
            "A": joint("revolute", frame("ground"), frame("left"), **about_z,
                       start={"phi": phi, "w": 0.0, "fixed": True}),
            "B": joint("revolute", frame("left", (CRANK, 0, 0)), frame("up"), **about_z,
                       start={"phi": left - phi}),
            "C": joint("revolute", frame("up", (BAR, 0, 0)), frame("down", (BAR, 0, 0)), **about_z,
                       start={"phi": right - left}),
            "D": joint("revolute", frame("right", (CRANK, 0, 0)), frame("down"), **about_z,
                       start={"phi": right - other}),
            "E": joint("revolute", frame("ground", (BASE, 0, 0)), frame("right"), **about_z,
                       start={"phi": other}),
        },
        gravity=[0, -GRAVITY, 0],
        constraints={"wheels": {"type": "gear", "joint": "E", "with": "A", "ratio": ratio, "offset": offset}},
    )  # fmt: skip


def five_bar_jets(phi: Jet, ratio: float, offset: float) -> tuple[Jet, Jet]:
    """Absolute angles of the bars: their ends meet above the line between the tips of the cranks."""
    other = ratio * phi + offset
    x = BASE + CRANK * cos(other) - CRANK * cos(phi)
    y = CRANK * sin(other) - CRANK * sin(phi)
    apart = sqrt(x * x + y * y)
    along, opening = atan2(y, x), acos(apart / (2 * BAR))
    return along + opening, along - opening + math.pi


def five_bar_bodies(ratio: float, offset: float) -> Geometry:
    def bodies(phi: Jet) -> list[Moving]:
        other = ratio * phi + offset
        left, right = five_bar_jets(phi, ratio, offset)
        out = []
        for mass, length, x, y, angle in (
            (CRANK_MASS, CRANK, jet(0), jet(0), phi),
            (CRANK_MASS, CRANK, jet(BASE), jet(0), other),
            (BAR_MASS, BAR, CRANK * cos(phi), CRANK * sin(phi), left),
            (BAR_MASS, BAR, BASE + CRANK * cos(other), CRANK * sin(other), right),
        ):
            com = (x + length / 2 * cos(angle), y + length / 2 * sin(angle), jet(0))
            out.append(Moving(mass, com, angle, mass * length**2 / 12))
        return out

    return bodies
