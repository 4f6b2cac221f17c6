# SPDX-License-Identifier: BSD-3-Clause
"""Hand-written equations of motion of three example scenes, integrated with SciPy's DOP853 at 1e-13."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from gelenk.chart.case import Array
from gelenk.chart.mechanisms import GRAVITY


def _integrated(rates: Callable[[float, Array], list[float]], start: list[float], times: Array) -> Array:
    found = solve_ivp(rates, (0.0, float(times.max())), start, "DOP853", times, rtol=1e-13, atol=1e-14)
    states: Array = found.y
    return states


def pendulum(times: Array) -> dict[str, Array]:
    """Return the states of the scene pendulum: a rod of 0.256 kg m², phi from the horizontal."""

    def rates(_t: float, y: Array) -> list[float]:
        return [y[1], (-1.2 * GRAVITY * 0.4 * np.cos(y[0]) - 0.02 * y[1]) / 0.256]

    phi, w = _integrated(rates, [0.3, 0.0], times)
    return {"pin.phi": phi, "pin.w": w}


def double_pendulum(times: Array) -> dict[str, Array]:
    """Return the states of the scene double_pendulum; a, b are the angles of the rods from the horizontal."""
    of_a = 0.0408333333333333 + 1.0 * 0.35**2 + 0.6 * 0.7**2
    of_b, both = 0.0125 + 0.6 * 0.25**2, 0.6 * 0.7 * 0.25
    weight_a, weight_b = GRAVITY * (1.0 * 0.35 + 0.6 * 0.7), GRAVITY * 0.6 * 0.25

    def rates(_t: float, y: Array) -> list[float]:
        a, b, da, db = y
        c, s = both * np.cos(b - a), both * np.sin(b - a)
        right = [s * db**2 - weight_a * np.cos(a), -s * da**2 - weight_b * np.cos(b)]
        return [da, db, *np.linalg.solve([[of_a, c], [c, of_b]], right)]

    a, b, da, db = _integrated(rates, [0.0, 0.4, 0.0, 0.0], times)
    return {"shoulder.phi": a, "shoulder.w": da, "elbow.phi": b - a, "elbow.w": db - da}


def cart_pole(times: Array) -> dict[str, Array]:
    """Return the states of the scene cart_pole under 0.7 N; theta is measured from the upright."""
    mass, moment, whole = 0.2 * 0.3, 0.006 + 0.2 * 0.3**2, 1.2

    def rates(_t: float, y: Array) -> list[float]:
        _, theta, v, w = y
        c, s = mass * np.cos(theta), mass * np.sin(theta)
        right = [s * w**2 + 0.7 - 0.1 * v, GRAVITY * s - 0.002 * w]
        return [v, w, *np.linalg.solve([[whole, c], [c, moment]], right)]

    x, theta, v, w = _integrated(rates, [0.0, 0.05, 0.0, 0.0], times)
    return {"track.s": x, "track.v": v, "hinge.phi": theta, "hinge.w": w}
