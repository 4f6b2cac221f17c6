# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms with one freedom: their motion by quadrature, without integrating anything.

Energy E = M(x) x'^2 / 2 + V(x) gives dt = s(x) dx, s = sqrt(M / (2 (E - V))), for a coordinate x that only
grows; t(x) by Gauss and Legendre's rule in panels, x(t) by Newton's method. It knows nothing of loops or of
the singular positions that these pass.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gelenk.chart.case import Array

PANEL = 0.05  # rad
POINTS = 16  # of the rule in a panel: beyond rounding for functions that are smooth over a radian
NEWTON = 8  # steps, from within a panel

type Profile = Callable[[Array], Array]


def passing(
    slowness: Profile, start: float, times: Array, panel: Callable[[float], float] | None = None
) -> Array:
    """Coordinates at times [s] >= 0 of a motion that starts at `start` and goes on growing; shape (times,).

    Args:
        slowness: dt/dx > 0 [s].
        start: coordinate at t = 0.
        times: [s].
        panel: width over which the slowness is smooth, of the place.
    """
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)

    def passed(begin: Array, width: Array) -> Array:
        places = begin[:, None] + width[:, None] * (nodes + 1) / 2
        found: Array = width / 2 * (slowness(places.ravel()).reshape(places.shape) @ weights)
        return found

    edges, clock = [start], [0.0]
    while clock[-1] <= times.max():
        width = PANEL if panel is None else panel(edges[-1])
        clock.append(clock[-1] + float(passed(np.array([edges[-1]]), np.array([width]))[0]))
        edges.append(edges[-1] + width)
    place = np.searchsorted(clock, times, side="right") - 1
    begin, rest = np.array(edges)[place], times - np.array(clock)[place]
    most = np.array(edges)[place + 1] - begin
    way = np.minimum(most, rest / slowness(begin))
    for _ in range(NEWTON):
        way = np.clip(way - (passed(begin, way) - rest) / slowness(begin + way), 0.0, most)
    found: Array = begin + way
    return found


def turning(mass: Profile, potential: Profile, phi: float, w: float, times: Array) -> tuple[Array, Array]:
    """Angle [rad] and rate [rad/s] at times [s] of a motion that never turns back; shapes (times,).

    Args:
        mass: generalised mass [kg m2] of the angle.
        potential: energy [J] of the angle.
        phi: angle at t = 0 [rad].
        w: rate at t = 0 [rad/s], not 0.
        times: [s].

    Raises:
        ValueError: the energy does not suffice to turn on.
    """
    direction = 1.0 if w > 0 else -1.0
    here = np.array([phi])
    energy = float((mass(here) * w * w / 2 + potential(here))[0])

    def slowness(way: Array) -> Array:
        angle = phi + direction * way
        spare = energy - potential(angle)
        if not (spare > 0).all():
            raise ValueError("the energy does not suffice to turn on")
        found: Array = np.sqrt(mass(angle) / (2 * spare))
        return found

    way = passing(slowness, 0.0, times)
    return phi + direction * way, direction / slowness(way)
