# SPDX-License-Identifier: BSD-3-Clause
"""Motion of conservative mechanisms with one degree of freedom by quadrature, without time integration.

Energy E = M(x) x'^2 / 2 + V(x) gives dt = s(x) dx, s = sqrt(M / (2 (E - V))), for a monotonically growing
coordinate x; t(x) is computed by Gauss-Legendre quadrature in panels, x(t) by Newton's method. Loops and
their singular configurations do not enter.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gelenk.chart.case import Array

PANEL = 0.05  # rad
POINTS = 16  # nodes per panel: exact to rounding for functions that are smooth over a radian
NEWTON = 8  # iterations, starting within the panel

type Profile = Callable[[Array], Array]


def monotonic_motion(
    slowness: Profile, start: float, times: Array, panel: Callable[[float], float] | None = None
) -> Array:
    """Return the coordinate of a monotonically growing motion at given times; shape (times,).

    Args:
        slowness: dt/dx > 0 [s/rad] as a function of the coordinate.
        start: Coordinate at t = 0 [rad].
        times: Times >= 0 [s], shape (times,).
        panel: Width [rad] of the quadrature panel that starts at a coordinate; `PANEL` by default.
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
    max_distance = np.array(edges)[place + 1] - begin
    distance = np.minimum(max_distance, rest / slowness(begin))
    for _ in range(NEWTON):
        distance = np.clip(
            distance - (passed(begin, distance) - rest) / slowness(begin + distance), 0.0, max_distance
        )
    found: Array = begin + distance
    return found


def rotation(mass: Profile, potential: Profile, phi: float, w: float, times: Array) -> tuple[Array, Array]:
    """Return angle [rad] and rate [rad/s] of a motion without reversal; shapes (times,).

    Args:
        mass: Generalized mass [kg m²] as a function of the angle.
        potential: Potential energy [J] as a function of the angle.
        phi: Angle at t = 0 [rad].
        w: Rate at t = 0 [rad/s], not 0.
        times: Times >= 0 [s], shape (times,).

    Raises:
        ValueError: the energy does not suffice to continue the rotation.
    """
    direction = 1.0 if w > 0 else -1.0
    here = np.array([phi])
    energy = float((mass(here) * w * w / 2 + potential(here))[0])

    def slowness(distance: Array) -> Array:
        angle = phi + direction * distance
        spare = energy - potential(angle)
        if not (spare > 0).all():
            raise ValueError("the energy does not suffice to continue the rotation")
        found: Array = np.sqrt(mass(angle) / (2 * spare))
        return found

    distance = monotonic_motion(slowness, 0.0, times)
    return phi + direction * distance, direction / slowness(distance)
