# SPDX-License-Identifier: BSD-3-Clause
"""Painleve's rod slides towards the side to which it leans: no forces agree with the laws at high friction.

A uniform rod of length 2 l, at the angle theta above the floor, slides with its lower end ahead (Painleve
1895; Genot & Brogliato 1999). Per normal force, that end accelerates upwards by
(1 + 3 cos(theta) (cos(theta) - mu sin(theta))) / m, which is negative for mu > (1 + 3 cos2) / (3 sin cos):
at least 4/3, at tan(theta) = 2.
"""

from math import atan, cos, pi, sin
from typing import Any

import pytest

import gelenk

G = 9.81  # m/s2
ANGLES = [0.5, 1.0, atan(2), 1.3]  # rad
# Of the coefficient of friction; the tip of the rod, a ball of 1e-6 m, changes the critical one by 1e-6.
NEAR = 1e-3


def critical(theta: float) -> float:
    return (1 + 3 * cos(theta) ** 2) / (3 * sin(theta) * cos(theta))


def rod(theta: float, friction: float, speed: float, rate: float = 0) -> dict[str, Any]:
    """A rod of 1 kg and 2 m; speed [m/s] of its center, positive: with its end behind; rate [rad/s]."""
    length, radius = 1.0, 1e-6
    half = (pi / 2 - theta) / 2
    start = {
        "r": [length * cos(theta), 0, radius + length * sin(theta)],
        "Q": [0, sin(half), 0, cos(half)],
        "v": [speed + rate * length * sin(theta), 0, -rate * length * cos(theta)],
        "w": [0, rate, 0],
        "fixed": True,
    }
    tip = {"sphere": radius, "position": [0, 0, -length], "surface": "chalk"}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {"rod": {"mass": 1.0, "inertia": [1 / 3, 1 / 3, 1e-6], "shapes": {"tip": tip}}},
        "ground": {"shapes": {"board": {"plane": [0, 0, 1], "surface": "board"}}},
        "joints": {"J": {"type": "free", "parent": "ground", "child": "rod", "start": start}},
        "contacts": {"slide": {"between": ["chalk", "board"], "friction": friction}},
        "solver": {"integrator": "erk"},
    }


@pytest.mark.parametrize("theta", ANGLES)
def test_forces_up_to_the_critical_friction(theta: float) -> None:
    """The normal force grows beyond all bounds towards it."""
    for part in (0.5, 0.9, 1 - NEAR):
        mu = part * critical(theta)
        simulation = gelenk.Simulation(rod(theta, mu, -1))
        simulation.initialize()
        exact = G / (1 + 3 * cos(theta) * (cos(theta) - mu * sin(theta)))
        # The tip changes the denominator by 1e-6.
        assert simulation.output("slide.f[3]") == pytest.approx(exact, rel=1e-5 / (1 - part))
        assert simulation.output("slide.f[1]") == pytest.approx(
            mu * simulation.output("slide.f[3]"), rel=1e-9
        )


@pytest.mark.parametrize("theta", ANGLES)
def test_beyond_it_the_run_is_refused(theta: float) -> None:
    simulation = gelenk.Simulation(rod(theta, (1 + NEAR) * critical(theta), -1))
    simulation.initialize()
    with pytest.raises(
        gelenk.StepError, match=r"rod touches the ground, and no contact forces .* Painlev"
    ) as said:
        simulation.step_to(1e-3)
    assert "The state is unchanged at t = 0 s" in str(said.value)
    assert simulation.time == 0


@pytest.mark.parametrize("theta", ANGLES)
def test_in_the_other_direction_there_is_no_paradox(theta: float) -> None:
    simulation = gelenk.Simulation(rod(theta, 10 * critical(theta), 1))
    simulation.initialize()
    simulation.step_to(1e-3)
    assert simulation.diagnostics["solver.ambiguous"] == 0


def test_friction_beyond_the_critical_one_does_not_hold_what_rises() -> None:
    """Where the end would rise without contact, flight is consistent, too (the indeterminate case)."""
    theta = 1.0
    rate = 2 * (G / sin(theta)) ** 0.5  # of which the centrifugal acceleration is four times that of gravity
    simulation = gelenk.Simulation(rod(theta, 1.5 * critical(theta), -1, rate))
    simulation.initialize()
    simulation.step_to(1e-3)
    assert simulation.output("slide.mode") == 0


@pytest.mark.parametrize("theta", ANGLES)
@pytest.mark.parametrize("turns", [1, -1])
@pytest.mark.parametrize(("part", "lift", "solutions"), [(1.5, 1.2, 2), (1.5, 3.0, 2), (0.9, 1.2, 1)])
def test_two_solutions_are_counted(
    theta: float, turns: int, part: float, lift: float, solutions: int
) -> None:
    """The end rises without contact, with `lift` times gravity by its centrifugal acceleration; beyond the
    critical friction contact would draw it to the floor.
    """
    rate = turns * (lift * G / sin(theta)) ** 0.5
    simulation = gelenk.Simulation(rod(theta, part * critical(theta), -1, rate))
    simulation.initialize()
    simulation.step_to(1e-4)
    assert simulation.output("slide.mode") == 0
    assert simulation.diagnostics["solver.ambiguous"] == solutions - 1
