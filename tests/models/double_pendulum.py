# SPDX-License-Identifier: BSD-3-Clause
"""Reference: a double pendulum by its textbook equations of motion, in two absolute angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mechanisms import GRAVITY, Array


@dataclass(frozen=True)
class DoublePendulum:
    """Masses [kg], distances of the centers of mass from the pins [m], moments of inertia about them [kg m2];
    l1: between the pins [m].
    """

    m1: float
    c1: float
    j1: float
    l1: float
    m2: float
    c2: float
    j2: float

    def mass(self, y: Array) -> Array:
        """The mass matrix of the absolute angles."""
        c = self.m2 * self.l1 * self.c2 * np.cos(y[0] - y[1])
        first = self.j1 + self.m1 * self.c1**2 + self.m2 * self.l1**2
        return np.array([[first, c], [c, self.j2 + self.m2 * self.c2**2]])

    def rates(self, _t: float, y: Array) -> Array:
        """Rates of the absolute angles a, b from the downward vertical and of their velocities: Landau &
        Lifshitz, Mechanics, section 5, problem 1, with rotary inertia.
        """
        a, b, wa, wb = y
        k = self.m2 * self.l1 * self.c2
        f = np.array(
            [
                -k * wb**2 * np.sin(a - b) - (self.m1 * self.c1 + self.m2 * self.l1) * GRAVITY * np.sin(a),
                k * wa**2 * np.sin(a - b) - self.m2 * self.c2 * GRAVITY * np.sin(b),
            ]
        )
        out: Array = np.concatenate([[wa, wb], np.linalg.solve(self.mass(y), f)])
        return out
