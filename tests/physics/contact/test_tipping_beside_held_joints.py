# SPDX-License-Identifier: BSD-3-Clause
"""A sliding box that tips over, beside a joint that friction holds: against a closed form.

The box slides on a floor; the moment of friction about its center, mu N h, exceeds N b, the most that the
normal forces balance. It turns about its leading edge, which slides on. Joints elsewhere make no difference.
"""

from __future__ import annotations

from typing import Any

import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk

G, MASS, I = 10.0, 2.0, 0.3  # m/s2, kg, kg m2  # noqa: E741
HALF = (0.1, 0.15, 0.3)  # m
SPEED, TIME = 3.0, 0.02  # m/s, s
EVENTS = ["auto", "erk", "cvode", "ida", "dirk"]
BESIDE: dict[str, dict[str, Any]] = {
    "nothing": {},
    "friction": {"friction": {"coulomb": 5.0}},
    "a limit": {"limit": {"upper": 0.0}},
    "a one-way clutch": {"one_way": {"free": "negative"}},
}


def sliding(mu: float, beside: str) -> Scene:
    """The box on its floor, and a level arm that is held, in the same island of equations."""
    block = body(MASS, inertia=(I,) * 3)
    block["shapes"] = {"block": {"box": [2 * half for half in HALF], "surface": "wood"}}
    of = scene(
        {"box": block, "arm": body(0.1, (0.5, 0, 0), (0.01,) * 3)},
        {
            "box": joint(
                "free",
                frame("ground"),
                frame("box"),
                start={"r": [0, 0, HALF[2]], "v": [SPEED, 0, 0], "w": [0, 0, 0], "fixed": True},
            ),
            "arm": joint(
                "revolute",
                frame("ground", (0, 5, 5)),
                frame("arm"),
                axis=[0, 1, 0],
                start={"phi": 0.0, "w": 0.0, "fixed": True},
                **BESIDE[beside],
            ),
        },
        gravity=[0, 0, -G],
    )
    of["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}}
    of["contacts"] = {"floor": {"between": ["wood", "floor"], "friction": mu}}
    of["solver"] = {"reductions": {"all": False}}
    return of


def tipping(integrator: str, mu: float, beside: str) -> float:
    """Angular velocity about the leading edge after TIME seconds, in rad/s."""
    of = sliding(mu, beside)
    of["solver"] |= {"integrator": integrator}
    plant = gelenk.Simulation(of)
    plant.initialize(tolerance=1e-9)
    plant.step_to(TIME)
    if beside != "nothing":
        assert plant.output("arm.w") == pytest.approx(0, abs=1e-12)
    return float(plant.output("box.w[2]"))


@pytest.mark.parametrize("beside", BESIDE)
@pytest.mark.parametrize("integrator", EVENTS)
def test_a_sliding_box_tips_over_beside_what_holds_a_joint(integrator: str, beside: str) -> None:
    """With m z'' = N - m g = m b alpha: I alpha = N (mu h - b). The lever grows by 0.5 % within the time."""
    mu = 0.6
    lever = mu * HALF[2] - HALF[0]
    alpha = MASS * G * lever / (I - MASS * HALF[0] * lever)
    found = tipping(integrator, mu, beside)
    assert found == pytest.approx(alpha * TIME, rel=0.01)
    assert found == pytest.approx(tipping(integrator, mu, "nothing"), rel=1e-6)


@pytest.mark.parametrize("beside", BESIDE)
@pytest.mark.parametrize("mu", [0.33, 0.34])
def test_a_box_begins_to_tip_where_friction_outweighs_its_weight(mu: float, beside: str) -> None:
    """The limit is where mu h = b, at 1 / 3."""
    lever = mu * HALF[2] - HALF[0]
    alpha = MASS * G * lever / (I - MASS * HALF[0] * lever)
    assert tipping("erk", mu, beside) == pytest.approx(max(0.0, alpha) * TIME, rel=0.05, abs=1e-12)
