# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms with one freedom that turn on and on: their motion by quadrature, without integrating anything.

Energy E = M(phi) w^2 / 2 + V(phi) gives dt = sqrt(M / (2 (E - V))) dphi; t(phi) by Gauss and Legendre's rule
in panels, phi(t) by Newton's method. It knows nothing of loops or of the singular positions that these pass.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gelenk.chart.case import Array

PANEL = 0.05  # rad
POINTS = 16  # of the rule in a panel: beyond rounding for functions that are smooth over a radian
NEWTON = 6  # steps, from within a panel

type Profile = Callable[[Array], Array]


def turning(mass: Profile, potential: Profile, phi: float, w: float, times: Array) -> tuple[Array, Array]:
    """Angle [rad] and rate [rad/s] at times [s] >= 0; shapes (times,).

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
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)

    def slowness(angle: Array) -> Array:
        spare = energy - potential(angle)
        if not (spare > 0).all():
            raise ValueError("the energy does not suffice to turn on")
        found: Array = np.sqrt(mass(angle) / (2 * spare))
        return found

    def passed(start: Array, width: Array) -> Array:
        """Time [s] from the angles `start` over `width` [rad] >= 0."""
        angles = start[:, None] + direction * width[:, None] * (nodes + 1) / 2
        found: Array = width / 2 * (slowness(angles.ravel()).reshape(angles.shape) @ weights)
        return found

    edges, clock = [phi], [0.0]
    while clock[-1] <= times.max():
        clock.append(clock[-1] + float(passed(np.array([edges[-1]]), np.array([PANEL]))[0]))
        edges.append(phi + direction * PANEL * len(edges))
    place = np.searchsorted(clock, times, side="right") - 1
    start, rest = np.array(edges)[place], times - np.array(clock)[place]
    width = rest / slowness(start)
    for _ in range(NEWTON):
        width = np.maximum(0.0, width - (passed(start, width) - rest) / slowness(start + direction * width))
    angle: Array = start + direction * width
    return angle, direction / slowness(angle)
