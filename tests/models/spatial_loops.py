# SPDX-License-Identifier: BSD-3-Clause
"""Reference: spatial slider-crank loops with one degree of freedom, as functions of the crank angle."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from mechanisms import cylinder, inertia_matrix

from models.one_dof import Jet, Moving, acos, atan2, cos, jet, sin, sqrt

Triple = Sequence[Jet]
Rows = Sequence[Sequence[Jet]]


def turn_x(phi: Jet) -> Rows:
    c, s, o, e = cos(phi), sin(phi), jet(0), jet(1)
    return [[e, o, o], [o, c, -s], [o, s, c]]


def turn_y(phi: Jet) -> Rows:
    c, s, o, e = cos(phi), sin(phi), jet(0), jet(1)
    return [[c, o, s], [o, e, o], [-s, o, c]]


def turn_z(phi: Jet) -> Rows:
    c, s, o, e = cos(phi), sin(phi), jet(0), jet(1)
    return [[c, -s, o], [s, c, o], [o, o, e]]


def product(A: Rows, B: Rows) -> Rows:
    return [[sum((A[i][k] * B[k][j] for k in range(3)), jet(0)) for j in range(3)] for i in range(3)]


def applied(A: Rows, x: Sequence[Jet | float]) -> Triple:
    return [A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2] for i in range(3)]


def plus(a: Sequence[Jet | float], b: Sequence[Jet | float]) -> Triple:
    return [jet(x) + y for x, y in zip(a, b, strict=True)]


@dataclass(frozen=True)
class ModelicaFourbar1:
    """MultiBody.Examples.Loops.Fourbar1: crank b1 about x at the origin with its tip at (0, 0.5, 0.1);
    slider b2 along x, its tip at (1.2 + s, 0.2, 0); rod b3 from there, universal (y then z) at the slider
    and spherical at the crank, (-1, 0.3, 0.1) long. All cylinders of 50 mm; all coordinates zero except s =
    -0.2.
    """

    b1 = cylinder((0, 0.5, 0.1), 0.05)
    b2 = cylinder((0, 0.2, 0), 0.05)
    b3 = cylinder((-1, 0.3, 0.1), 0.05)

    def slider(self, phi: Jet) -> Jet:
        """S [m] as a function of the crank angle: the rod's length is sqrt(1.1) m."""
        tip = applied(turn_x(phi), (0.0, 0.5, 0.1))
        y, z = tip[1] - 0.2, tip[2]
        return sqrt(1.1 - y * y - z * z) - 1.2

    def rod(self, phi: Jet) -> tuple[Jet, Jet]:
        """(alpha, beta): the rod's rotations about y and then about z."""
        tip = applied(turn_x(phi), (0.0, 0.5, 0.1))
        end = (self.slider(phi) + 1.2, jet(0.2), jet(0))
        d = [a - b for a, b in zip(tip, end, strict=True)]
        # y of Rot_z(beta) (-1, 0.3, 0.1): 0.3 cos - sin = sqrt(1.09) cos(beta + atan2(1, 0.3))
        beta = acos(d[1] / math.sqrt(1.09)) - math.atan2(1, 0.3)
        x = -cos(beta) - 0.3 * sin(beta)
        return atan2(d[0], d[2]) - atan2(x, jet(0.1)), beta

    def geometry(self, phi: Jet) -> Iterator[Moving]:
        R1 = turn_x(phi)
        yield Moving(self.b1["mass"], applied(R1, self.b1["com"]), R1, inertia_matrix(self.b1))
        s = self.slider(phi)
        still = turn_x(jet(0))
        yield Moving(
            self.b2["mass"], plus((s + 1.2, 0.0, 0.0), self.b2["com"]), still, inertia_matrix(self.b2)
        )
        alpha, beta = self.rod(phi)
        R3 = product(turn_y(alpha), turn_z(beta))
        com = plus((s + 1.2, 0.2, 0.0), applied(R3, self.b3["com"]))
        yield Moving(self.b3["mass"], com, R3, inertia_matrix(self.b3))


@dataclass(frozen=True)
class SliderCrank:
    """The IFToMM library's spatial slider-crank (after Haug): see test_spatial_slider_crank.py."""

    place = (0.0, 0.1, 0.12)
    crank, length = 0.08, 0.3
    rod_inertia = (0.0004, 0.004, 0.004)  # along the rod, along the cross axis, along the third axis

    def tip(self, phi: Jet) -> Triple:
        return plus(self.place, applied(turn_x(phi), (0.0, 0.0, self.crank)))

    def slider(self, phi: Jet) -> Jet:
        _, y, z = self.tip(phi)
        return sqrt(self.length**2 - y * y - z * z)

    def geometry(self, phi: Jet) -> Iterator[Moving]:
        middle = plus(self.place, applied(turn_x(phi), (0.0, 0.0, self.crank / 2)))
        yield Moving(0.12, middle, turn_x(phi), np.diag([1e-4, 1e-4, 1e-5]))
        x, tip = self.slider(phi), self.tip(phi)
        n = [c / self.length for c in (tip[0] - x, tip[1], tip[2])]
        across = sqrt(n[1] * n[1] + n[2] * n[2])
        b = [jet(0), -n[2] / across, n[1] / across]  # x cross n
        c = [n[1] * b[2] - n[2] * b[1], n[2] * b[0] - n[0] * b[2], n[0] * b[1] - n[1] * b[0]]
        R = [[n[i], b[i], c[i]] for i in range(3)]
        com = [x + 0.5 * self.length * n[0], 0.5 * tip[1], 0.5 * tip[2]]
        yield Moving(0.5, com, R, np.diag(self.rod_inertia))
        yield Moving(2.0, [x, jet(0), jet(0)], jet(0), 1e-4)
