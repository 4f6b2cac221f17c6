# SPDX-License-Identifier: BSD-3-Clause
"""Limits and contacts do not push against each other without cause: rigid bodies permit any prestress."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import gelenk

G = 9.81  # m/s2


@dataclass(frozen=True)
class Case:
    """A carriage along x; on it a slanted guide with a one-way clutch, on which a ball moves to the ground.

    Args:
        speed: of the ball along its guide, downwards [m/s].
        friction: coefficient of the ground.
        carriage, ball: masses [kg].
        gap: between the ball and the ground [m].
    """

    speed: float
    friction: float
    carriage: float
    ball: float
    gap: float

    def scene(self, step: float) -> dict[str, Any]:
        place = {"body": "ground", "position": [0, 0, 0.02 + self.gap]}
        return {
            "gelenk": 1,
            "gravity": [0, 0, -G],
            "solver": {"integrator": "moreau-jean", "step": step},
            "bodies": {
                "carriage": {"mass": self.carriage},
                "ball": {"mass": self.ball, "shapes": {"s": {"sphere": 0.02, "surface": "ball"}}},
            },
            "joints": {
                "x": {
                    "type": "prismatic", "axis": [1, 0, 0], "parent": place, "child": "carriage",
                    "start": {"s": 0.0, "v": 0.0, "fixed": True}, "friction": {"coulomb": 5.9},
                },
                "u": {
                    "type": "prismatic", "axis": [0.6, 0, 0.8], "parent": "carriage", "child": "ball",
                    "start": {"s": 0.0, "v": -self.speed, "fixed": True}, "one_way": {"free": "negative"},
                },
            },
            "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
            "contacts": {"k": {"between": ["ball", "floor"], "friction": self.friction}},
        }  # fmt: skip

    def speed_after_impact(self, x: float, u: float) -> float:
        """Speed of the carriage after the impact of the ball, which slides, with these speeds of both joints.

        The clutch exerts no impulse: without it, the ball ends at rest on its guide. Momentum along x and
        along the guide; unknown: the speed of the carriage and the normal impulse.
        """
        A = [[self.carriage + self.ball, -self.friction], [0.6 * self.ball, -(0.6 * self.friction + 0.8)]]
        before = [(self.carriage + self.ball) * x + 0.6 * self.ball * u, self.ball * (0.6 * x + u)]
        speed, impulse = np.linalg.solve(A, before)
        assert impulse > 0
        assert speed < 0  # so that it slides on
        return float(speed)


CASES = (
    Case(2.952088346940575, 0.3, 1.0, 1.25, 0.017201514768913503),
    Case(2.725685880011981, 0.3, 1.0, 1.25, 0.016234424549731816),
    Case(0.5234759240529558, 0.2, 0.32, 0.3, 0.017652719050797613),
    Case(2.424475565916036, 0.2, 0.1, 1.25, 0.016743427358641136),
    Case(1.9115404477193148, 0.2, 0.1, 1.25, 0.016376385071099175),
    Case(2.9910125425978245, 0.2, 0.32, 0.3, 0.017005791594065834),
    Case(1.9201959510708104, 0.2, 0.32, 0.3, 0.016688255937256792),
    Case(2.0, 0.5, 0.5, 0.5, 0.017),
)


@pytest.mark.parametrize("step", [1e-3, 1e-4])
@pytest.mark.parametrize("case", CASES)
def test_a_one_way_clutch_does_not_wedge_a_contact(case: Case, step: float) -> None:
    """The ground and the clutch could hold the ball between them, and their friction the carriage."""
    plant = gelenk.Simulation(case.scene(step))
    plant.initialize()
    while plant.output("k.gap") > 1e-9:
        before = plant.output("x.v"), plant.output("u.v")
        plant.step_to(plant.time + step)
    # Gravity and friction change speeds by up to 60 m/s2 in the step of the impact.
    exact = case.speed_after_impact(*before)
    assert plant.output("x.v") == pytest.approx(exact, abs=60 * step)
    for _ in range(3):
        plant.step_to(plant.time + step)
        assert abs(plant.output("k.f[3]")) < 3 * case.ball * G
