# SPDX-License-Identifier: BSD-3-Clause
"""What can remain at rest does, where normal forces are redundant and Coulomb's law permits motion, too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, matrix, rotation, scene

import gelenk

GRAVITY, FRICTION, RADIUS = 10.0, 0.5, 0.02  # m/s2, 1, m
CARRIAGE, ARM = 0.85, 0.65  # kg
STATIC, FADING, TORQUE = 2.0, 0.5, 0.5  # N m, 1/s, N m
# All of the weight may rest on the tip of the arm, whose friction helps the brake as it fades.
SLIPS = (1 - (TORQUE - FRICTION * RADIUS * (CARRIAGE + ARM) * GRAVITY) / STATIC) / FADING  # s


def two_tips(R: Any) -> dict[str, Any]:
    """A carriage in a vertical guide stands on a ball beside that of its arm, which a brake holds.

    The arm turns about the line through the balls, which is horizontal; R turns everything.
    """

    def ball(x: float) -> dict[str, Any]:
        return {"tip": {"sphere": RADIUS, "position": [x, 0, 0], "surface": "tip"}}

    return scene(
        {
            "carriage": body(CARRIAGE, inertia=(0.01,) * 3) | {"shapes": ball(0.3)},
            "arm": body(ARM, inertia=(0.004,) * 3) | {"shapes": ball(0.18)},
        },
        {
            "guide": joint(
                "prismatic", frame("ground") | {"rotation": matrix(R)}, frame("carriage"), axis=[0, 0, 1],
                start={"s": RADIUS, "v": 0.0, "fixed": True},
            ),
            "brake": joint(
                "revolute", frame("carriage", [0.3, 0, 0]), frame("arm"), axis=[1, 0, 0],
                start={"phi": 0.0, "w": 0.0, "fixed": True},
                friction={"coulomb": STATIC, "input": "engagement"},
            ),
        },
        motors={"drive": {"joint": "brake"}},
        ground={"shapes": {"road": {"plane": (R @ np.array([0.0, 0, 1])).tolist(), "surface": "road"}}},
        contacts={"foot": {"between": ["tip", "road"], "friction": FRICTION}},
        gravity=(R @ np.array([0.0, 0, -GRAVITY])).tolist(),
    )  # fmt: skip


def slip_time(plant: gelenk.Simulation, step: float) -> float:
    """When the brake slips [s]: by its event, or at the end of the step."""
    plant.set_input("drive.tau", TORQUE)
    plant.set_input("brake.friction.engagement", 1.0)
    plant.initialize(tolerance=1e-9)
    for k in range(round(2.0 / step)):
        plant.set_input("brake.friction.engagement", 1.0 - FADING * k * step)
        plant.set_input_derivative("brake.friction.engagement", 1, -FADING)
        plant.step_to((k + 1) * step)
        slips = [t for t, text in plant.events if "brake.phi slips" in text]
        if slips:
            return slips[0]
        if abs(plant.output("brake.w")) > 1e-6:
            return (k + 1) * step
    return np.inf


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.0, 2.0, 2.7])
@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "dirk", "moreau-jean"])
def test_a_brake_slips_when_no_distribution_of_the_weight_holds(integrator: str, turn: float) -> None:
    R = rotation([0.3, 0.5, 0.8], turn)
    of = two_tips(R) | {"solver": {"integrator": integrator, "step": 1e-3}}
    in_steps = integrator == "moreau-jean"
    found = slip_time(gelenk.Simulation(of), 1e-3 if in_steps else 0.02)
    assert found == pytest.approx(SLIPS, abs=2e-3 if in_steps else 1e-6)
