# SPDX-License-Identifier: BSD-3-Clause
"""Conditions that read the time and change twice within a step; the motion alone needs no shorter one."""

from __future__ import annotations

import itertools
import math

import pytest
from circuits import rotor, values

import gelenk


def rectifier(frequency: float, integrator: str) -> dict[str, object]:
    """A capacitor behind a diode: for most of each period it does nothing but discharge, slowly."""
    return {
        "gelenk": 1,
        "name": "rectifier",
        "bodies": {"b": {"mass": 1, "inertia": [1, 1, 1]}},
        "joints": {"A": {"type": "revolute", "parent": "ground", "child": "b"}},
        "states": {"u": f"max(0, (sin({frequency}*t) - u)/0.01) - u"},
        "solver": {"integrator": integrator},
    }


def charged(frequency: float, end: float) -> float:
    """The voltage at the end, by the exact solution from one change of the diode to the next."""
    a, w = 1 + 1 / 0.01, frequency

    def conducting(t: float) -> float:  # the particular solution of u' = (sin(w t) - u)/0.01 - u
        return (a * math.sin(w * t) - w * math.cos(w * t)) / (a * a + w * w) / 0.01

    def first_zero(g: object, low: float, high: float) -> float:
        assert callable(g)
        n = 400
        grid = [low + (high - low) * k / n for k in range(n + 1)]
        for left, right in itertools.pairwise(grid):
            if g(left) > 0 >= g(right):
                for _ in range(60):
                    middle = (left + right) / 2
                    left, right = (middle, right) if g(middle) > 0 else (left, middle)
                return right
        return high

    t, u, conducts = 0.0, 0.0, True
    while t < end:
        start, value = t, u

        def voltage(s: float, start: float = start, value: float = value, on: bool = conducts) -> float:
            if not on:
                return value * math.exp(start - s)
            return conducting(s) + (value - conducting(start)) * math.exp(-a * (s - start))

        sign = 1 if conducts else -1
        t = first_zero(
            lambda s, v=voltage, sign=sign: sign * (math.sin(w * s) - v(s)) + 1e-15,
            start + 1e-9,
            min(end, start + 2 * math.pi / w),
        )
        u, conducts = voltage(t), not conducts
    return u


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"])
@pytest.mark.parametrize("frequency", [7.0, 20.0, 60.0, 64 * math.pi, 200.0])
def test_a_diode_conducts_in_each_period(frequency: float, integrator: str) -> None:
    """Whole periods were missed in communication steps of 2 s; within the tolerance of a step."""
    plant = gelenk.Simulation(rectifier(frequency, integrator))
    plant.initialize(0.0, 1e-6)
    plant.step_to(2.0)
    assert plant.output("u") == pytest.approx(charged(frequency, 2.0), abs=1e-6)


@pytest.mark.parametrize("wanted", ["if(t > 0, 4, -4)", "4*sign(sin(2*t))", "4*if(sin(2*t) > 0, 1, -1)"])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida", "rk4"])
def test_a_condition_that_changes_at_the_start_meets_a_limit(wanted: str, integrator: str) -> None:
    """0.8 N m from the start on, as the limit of a controller that is switched at t = 0."""
    source = rotor(effort=f"clip({wanted} - w, -0.8, 0.8)", solver={"integrator": integrator, "step": 1e-3})
    assert values(source, ["A.w"], [1.0], 1e-8)[0, 0] == pytest.approx(1.6, rel=1e-9)
