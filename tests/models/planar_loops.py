# SPDX-License-Identifier: BSD-3-Clause
"""Reference: planar four-bars as functions of the crank angle, by triangle geometry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.one_dof import Geometry, Jet, Moving, acos, atan2, cos, jet, sin, sqrt

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Link:
    """A link from its first to its second pin: length [m], mass [kg], center of mass along it and to its
    left [m], moment of inertia about the center of mass [kg m2].
    """

    length: float
    mass: float
    along: float
    left: float
    moment: float


def uniform(line_density: float, length: float) -> Link:
    """A slender uniform rod."""
    mass = line_density * length
    return Link(length, mass, length / 2, 0.0, mass * length**2 / 12)


@dataclass(frozen=True)
class FourBar:
    """Crank from the origin, rocker from (ground, 0),
    coupler from the tip of the crank to that of the rocker.

    branch: +1, the coupler turned to the left from the diagonal (crank tip to rocker pin); -1, right.
    """

    crank: Link
    coupler: Link
    rocker: Link
    ground: float
    branch: int = 1

    def angles(self, phi: Jet) -> tuple[Jet, Jet]:
        """Absolute angles of coupler and rocker [rad], in (-pi, pi] or slightly outside.

        The triangle crank tip, rocker pin, rocker tip has the sides diagonal, rocker, coupler.
        """
        a, b, c = self.crank.length, self.coupler.length, self.rocker.length
        x, y = self.ground - a * cos(phi), -(a * sin(phi))
        diagonal = sqrt(x * x + y * y)
        theta = atan2(y, x) + self.branch * acos((b * b - c * c + diagonal * diagonal) / (2 * b * diagonal))
        return theta, atan2(b * sin(theta) - y, b * cos(theta) - x)

    def geometry(self) -> Geometry:
        def bodies(phi: Jet) -> Iterator[Moving]:
            theta, psi = self.angles(phi)
            yield place(self.crank, jet(0), jet(0), phi)
            yield place(self.coupler, self.crank.length * cos(phi), self.crank.length * sin(phi), theta)
            yield place(self.rocker, jet(self.ground), jet(0), psi)

        return bodies

    def joint_states(self, phi: Array, w: Array) -> dict[str, Array]:
        """Angles and speeds of the joints A, B, C, D of mechanisms.four_bar;
        C and D never make full turns.
        """
        rows = []
        for x, rate in zip(phi, w, strict=True):
            theta, psi = self.angles(Jet(float(x), 1.0))
            rows.append(
                [
                    x,
                    theta.x - x,
                    psi.x - theta.x,
                    psi.x,
                    rate,
                    (theta.d - 1) * rate,
                    (psi.d - theta.d) * rate,
                    psi.d * rate,
                ]
            )
        columns = np.array(rows).T
        return {
            f"{joint}.{kind}": columns[4 * level + i]
            for level, kind in enumerate(("phi", "w"))
            for i, joint in enumerate("ABCD")
        }


def place(link: Link, x: Jet, y: Jet, angle: Jet) -> Moving:
    c, s = cos(angle), sin(angle)
    com = (x + link.along * c - link.left * s, y + link.along * s + link.left * c, jet(0))
    return Moving(link.mass, com, angle, link.moment)
