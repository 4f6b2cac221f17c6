# SPDX-License-Identifier: BSD-3-Clause
"""States within a step, by the polynomial that its ends determine."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest


def circle(t: float, w: float) -> list[float]:
    """Coordinates cos(wt), sin(wt) and their rates."""
    c, s = math.cos(w * t), math.sin(w * t)
    return [c, s, -w * s, w * c]


def circling(w: float) -> Callable[[float, list[float]], list[float]]:
    return lambda _, y: [y[2], y[3], -w * w * y[0], -w * w * y[1]]


def circling_in_other_order(w: float) -> Callable[[float, list[float]], list[float]]:
    """Rates before coordinates, so that none is seen as the rate of another."""
    return lambda _, y: [-w * w * y[2], -w * w * y[3], y[0], y[1]]


@pytest.mark.parametrize("s", [0.0, 0.1, 0.5, 0.8, 1.0])
def test_the_polynomial_of_a_short_step_is_as_accurate_as_rounding(units: Any, s: float) -> None:
    """The quartic lacks w (wh)^5 / 3840 of a rate, 4e-15; rounding of coordinates is divided by h."""
    w, h = 5.0, 1e-3
    t0, t1 = 0.3, 0.3 + h
    t = t0 + s * h
    found = units.within_step(circling(w), (t0, circle(t0, w)), (t1, circle(t1, w)), t)
    assert found == pytest.approx(circle(t, w), abs=5e-13)
    assert found[:2] == pytest.approx(circle(t, w)[:2], abs=5e-16)


@pytest.mark.parametrize("s", [0.0, 0.1, 0.5, 0.8, 1.0])
def test_the_polynomial_by_rates_within_the_step_is_as_accurate(units: Any, s: float) -> None:
    w, h = 5.0, 1e-3
    t0, t1 = 0.3, 0.3 + h
    t = t0 + s * h

    def state(at: float) -> list[float]:
        y = circle(at, w)
        return [*y[2:], *y[:2]]

    found = units.within_step(circling_in_other_order(w), (t0, state(t0)), (t1, state(t1)), t)
    assert found == pytest.approx(state(t), abs=5e-13)


def test_a_throw_is_a_polynomial(units: Any) -> None:
    g, h = 9.81, 0.7

    def state(t: float) -> list[float]:
        return [1.3 * t - g * t * t / 2, 1.3 - g * t]

    found = units.within_step(lambda _, y: [y[1], -g], (0.0, state(0.0)), (h, state(h)), 0.25)
    assert found == pytest.approx(state(0.25), rel=1e-15)


@pytest.mark.parametrize("rates", [circling, circling_in_other_order])
@pytest.mark.parametrize(("wh", "accurate"), [(0.007, True), (0.01, False), (0.5, False)])
def test_the_polynomial_of_a_long_step_is_not_used(units: Any, rates: Any, wh: float, accurate: bool) -> None:
    """The cubic lacks (wh)^4 / 384 of a rate, by its largest value 1: 1e-11 at wh = 0.008."""
    ends = [(t, circle(t, 1.0)) for t in (0.3 - wh / 2, 0.3 + wh / 2)]
    if rates is circling_in_other_order:
        ends = [(t, [*y[2:], *y[:2]]) for t, y in ends]
    assert bool(units.within_step(rates(1.0), *ends, 0.3)) == accurate
