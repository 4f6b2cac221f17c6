# SPDX-License-Identifier: BSD-3-Clause
"""An impact that rounding puts just before the end of a communication step, or just beyond it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk

SceneData = dict[str, Any]

MASS_OF_AXLE, MASS, RADIUS, INERTIA = 5.6, 0.88, 0.336, 0.04967424  # kg, m, kg m2
SPIN, FALL = -14.93, 1.0  # rad/s; m/s: from rest within 0.1 s with 10 m/s2
STEP = 0.02  # s


def spinning_wheel() -> SceneData:
    """Its carriage comes to rest at a limit before it falls on the ground, which throws it off the limit."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, -10.0],
        "bodies": {
            "carriage": {"mass": 0},
            "axle": {"mass": MASS_OF_AXLE},
            "wheel": {
                "mass": MASS,
                "inertia": [INERTIA] * 3,
                "shapes": {
                    "tread": {
                        "wheel": {"radius": RADIUS},
                        "rotation": {"axis": [1, 0, 0], "angle": np.pi / 2},
                        "surface": "tread",
                    }
                },
            },
        },
        "joints": {
            "along": {
                "type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "carriage",
                "start": {"s": 0.0, "v": 5.0, "fixed": True}, "friction": {"coulomb": 1.848},
                "limit": {"upper": 0.1, "restitution": 0.0},
            },
            "down": {
                "type": "prismatic", "axis": [0, 0, 1], "parent": "carriage", "child": "axle",
                "start": {"s": RADIUS + 0.05, "v": 0.0, "fixed": True},
            },
            "spin": {
                "type": "revolute", "axis": [0, 1, 0], "parent": "axle", "child": "wheel",
                "start": {"phi": 0.0, "w": SPIN, "fixed": True}, "one_way": {"free": "negative"},
            },
        },
        "contacts": {"k": {"between": ["tread", "road"], "friction": 0.8, "restitution": 0.0}},
        "ground": {"shapes": {"road": {"plane": [0, 0, 1], "surface": "road"}}},
    }  # fmt: skip


@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "dirk"])
def test_a_wheel_that_lands_as_a_step_ends(integrator: str) -> None:
    """It rolls from there: the angular momentum about the point of contact does not change."""
    inertia = INERTIA + (MASS_OF_AXLE + MASS) * RADIUS**2
    w = INERTIA * SPIN / inertia
    # In rolling, friction of the carriage decelerates it.
    deceleration = 1.848 * RADIUS / inertia
    source = spinning_wheel() | {"solver": {"integrator": integrator}}
    plant = gelenk.Simulation(source)
    for begin in np.linspace(0, 7, 141):
        plant.initialize(float(begin), 1e-8)
        for k in range(1, 7):
            plant.step_to(float(begin) + k * STEP)
        assert plant.output("spin.w") == pytest.approx(w + deceleration * STEP, abs=1e-6), begin
        assert plant.output("along.v") == pytest.approx(RADIUS * plant.output("spin.w"), abs=1e-9), begin
