# SPDX-License-Identifier: BSD-3-Clause
"""What joints meet and leave within a step is found, also where a contact of shapes ends this step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk

SceneData = dict[str, Any]

# A mass on a spring meets a stop only slightly: for 2 arccos(0.999) / OMEGA = 1.1 ms of a period of 80 ms.
OMEGA, AMPLITUDE, STOP = 79.0, 0.1, 0.0999  # rad/s, m, m
ACROSS = np.pi / OMEGA  # s: half a period, after which the stop is met
TOLERANCE = 1e-6


def scene(fall: float | None) -> SceneData:
    """The mass, and a ball that reaches the floor after this time [s]; None: without it."""
    out: SceneData = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {"m": {"mass": 1.0}},
        "joints": {
            "s": {
                "type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "m",
                "stiffness": OMEGA**2, "start": {"s": -AMPLITUDE, "v": 0.0, "fixed": True},
                "stop": {"upper": STOP, "stiffness": 20 * OMEGA**2, "damping": 0.0},
            }
        },
    }  # fmt: skip
    if fall is None:
        return out
    out["bodies"]["b"] = {"mass": 1.0, "shapes": {"s": {"sphere": 0.1, "surface": "ball"}}}
    out["joints"]["z"] = {
        "type": "prismatic", "axis": [0, 0, 1], "child": "b",
        "parent": {"body": "ground", "position": [0, 2, 0]},
        "start": {"s": 0.1 + 9.81 * fall**2 / 2, "v": 0.0, "fixed": True},
    }  # fmt: skip
    out["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}}
    out["contacts"] = {"k": {"between": ["ball", "floor"], "friction": 0.3}}
    # Couples the bodies, which otherwise were solved apart; so weak that nothing comes of it.
    out["forces"] = {
        "c": {"type": "spring_damper", "from": "m", "to": "b", "stiffness": 1e-12, "length": 2.0}
    }
    return out


def after(source: SceneData, integrator: str, stop: float) -> tuple[float, float, list[str]]:
    """Position, speed, and events of one communication step."""
    plant = gelenk.Simulation({**source, "solver": {"integrator": integrator}})
    plant.initialize(0.0, TOLERANCE)
    plant.step_to(stop)
    return plant.output("s.s"), plant.output("s.v"), [text for _, text in plant.events]


@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode"])
def test_a_stop_that_is_met_and_left_before_a_contact(integrator: str) -> None:
    """The ball changes nothing, whenever it lands; two runs may differ by some hundred tolerances."""
    stop = 1.6 * ACROSS
    alone = after(scene(None), "erk", stop)
    assert sum("stop" in text for text in alone[2]) == 2
    for fall in np.arange(1.03, 1.2, 0.01) * ACROSS:
        found = after(scene(fall), integrator, stop)
        assert sum("ground" in text for text in found[2]) == 1, found[2]
        assert sum("stop" in text for text in found[2]) == 2, (fall, found[2])
        np.testing.assert_allclose(found[0], alone[0], rtol=0, atol=300 * TOLERANCE * AMPLITUDE)
        np.testing.assert_allclose(found[1], alone[1], rtol=0, atol=300 * TOLERANCE * AMPLITUDE * OMEGA)
