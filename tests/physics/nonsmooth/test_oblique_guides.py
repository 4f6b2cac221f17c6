# SPDX-License-Identifier: BSD-3-Clause
"""A ball on an oblique guide strikes a floor: normal and tangential impulses act along the same line, so that
others have the same effect, and only Coulomb's law tells them apart.
"""

from __future__ import annotations

import math
from typing import Any

import pytest

import gelenk

SPEED = 1.0


def guided(integrator: str, friction: float, restitution: float, angle: float) -> dict[str, Any]:
    """A guide at an angle to the floor."""
    solver: dict[str, Any] = {"integrator": integrator}
    if integrator == "moreau-jean":
        solver["step"] = 1e-3
    return {
        "gelenk": 1,
        "solver": solver,
        "gravity": [0, 0, 0],
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "bodies": {"ball": {"mass": 1.5, "shapes": {"skin": {"sphere": 0.1, "surface": "skin"}}}},
        "joints": {
            "guide": {
                "type": "prismatic",
                "axis": [math.cos(angle), 0, math.sin(angle)],
                "parent": {"body": "ground", "position": [0, 0, 0.13]},
                "child": "ball",
                "start": {"s": 0, "v": -SPEED, "fixed": True},
            }
        },
        "contacts": {"c": {"between": ["skin", "floor"], "friction": friction, "restitution": restitution}},
    }


@pytest.mark.parametrize("integrator", ["erk", "moreau-jean"])
def test_rebounds_by_newtons_law(integrator: str) -> None:
    """Friction below the tangent of the angle cannot hold it: the normal speed is that of the restitution."""
    for angle in (0.4, 0.9273, 1.3):
        for part in (0.0, 0.3, 0.8, 0.95):
            for restitution in (0.0, 0.3, 0.6, 0.8, 0.9):
                source = guided(integrator, part * math.tan(angle), restitution, angle)
                result = gelenk.simulate(source, stop=0.2, step=0.01)
                # The velocities of the cone problem are solved for to 1e-10 and better.
                assert result["guide.v"][-1] == pytest.approx(restitution * SPEED, abs=1e-8)


def test_both_schemes_where_friction_holds() -> None:
    """Above the tangent several motions agree with the laws (Painleve): without restitution it stops."""
    for integrator in ("erk", "moreau-jean"):
        result = gelenk.simulate(guided(integrator, 2.0, 0.0, 0.9273), stop=0.2, step=0.01)
        assert result["guide.v"][-1] == pytest.approx(0, abs=1e-8)
