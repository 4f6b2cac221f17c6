# SPDX-License-Identifier: BSD-3-Clause
"""Contacts that begin and end within a step: an oscillator that grazes a stop,
compared with its closed-form solution.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk

MASS, SPRING, STOP = 1.0, 4.0, 4e4  # kg, N/m, N/m
SLOW, FAST = math.sqrt(SPRING / MASS), math.sqrt((SPRING + STOP) / MASS)  # rad/s: free, and in contact
AMPLITUDE = 1.0  # m
ADAPTIVE = ["auto", "erk", "dirk", "ida", "cvode", "cvode-adams"]
SWINGS = 3


def oscillator(bound: float, **solver: Any) -> Scene:
    """A mass between a soft spring and an undamped stop that begins at `bound` [m]."""
    return scene(
        {"block": body(MASS)},
        {
            "J": joint(
                "prismatic",
                frame("ground"),
                frame("block"),
                axis=[1, 0, 0],
                start={"s": 0.0, "v": AMPLITUDE * SLOW, "fixed": True},
                stiffness=SPRING,
                stop={"stiffness": STOP, "upper": bound},
            )
        },
        solver=solver,
    )


def times_of_contact(bound: float) -> list[float]:
    """Begin and end times of contact [s]: an arc of the oscillation is replaced by
    one of the stiffer oscillation.
    """
    touch = math.asin(bound / AMPLITUDE) / SLOW
    speed = SLOW * math.sqrt(AMPLITUDE**2 - bound**2)
    rest = bound * STOP / (SPRING + STOP)  # equilibrium of the oscillation in contact
    duration = 2 / FAST * math.atan2(speed / FAST, bound - rest)
    period = 2 * touch + duration + math.pi / SLOW
    return [n * period + t for n in range(SWINGS) for t in (touch, touch + duration)]


@pytest.mark.parametrize("integrator", ADAPTIVE)
@pytest.mark.parametrize(("depth", "tolerance"), [(1e-2, 1e-5), (1e-3, 1e-6), (1e-4, 1e-7), (1e-5, 1e-8)])
def test_grazing_contacts_are_detected(integrator: str, depth: float, tolerance: float) -> None:
    bound = AMPLITUDE * (1 - depth)
    expected = times_of_contact(bound)
    found = gelenk.simulate(
        oscillator(bound, integrator=integrator),
        stop=expected[-1] + 1,
        step=expected[-1] + 1,
        tolerance=tolerance,
    )
    assert [text.split()[1] for _, text in found.events] == ["meets", "leaves"] * SWINGS
    # s: contact occurs at sqrt(2 depth) of the maximum speed, and position errors shift its time by that much
    # more.
    limit = 30 * tolerance / (SLOW * math.sqrt(2 * depth))
    assert np.abs(np.array([t for t, _ in found.events]) - expected).max() < limit


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_oscillation_short_of_the_stop_has_no_events(integrator: str) -> None:
    bound = AMPLITUDE * (1 + 1e-4)
    found = gelenk.simulate(oscillator(bound, integrator=integrator), stop=10.0, step=10.0, tolerance=1e-7)
    assert not found.events
    assert found["J.s"][-1] == pytest.approx(AMPLITUDE * math.sin(SLOW * 10), abs=1e-5)
