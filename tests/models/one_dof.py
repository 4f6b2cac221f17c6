# SPDX-License-Identifier: BSD-3-Clause
"""Reference: the motion of a mechanism with one degree of freedom,
from its geometry as a function of one coordinate.

With every position written as x(phi), the kinetic energy is T = 1/2 I(phi) w^2, and Lagrange's equation

    I phi'' + 1/2 (dI/dphi) w^2 = Q - dV/dphi          (Landau & Lifshitz, Mechanics, section 5)

requires only first and second derivatives of x(phi). They are computed exactly by jets
(second-order Taylor arithmetic), without constraints, Jacobians or any solver of Gelenk.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]


class Jet:
    """A value with its first and second derivatives with respect to phi."""

    __slots__ = ("d", "dd", "x")

    def __init__(self, x: float, d: float = 0.0, dd: float = 0.0) -> None:
        self.x, self.d, self.dd = x, d, dd

    def __add__(self, other: Jet | float) -> Jet:
        b = jet(other)
        return Jet(self.x + b.x, self.d + b.d, self.dd + b.dd)

    def __mul__(self, other: Jet | float) -> Jet:
        b = jet(other)
        return Jet(
            self.x * b.x, self.d * b.x + self.x * b.d, self.dd * b.x + 2 * self.d * b.d + self.x * b.dd
        )

    def __neg__(self) -> Jet:
        return Jet(-self.x, -self.d, -self.dd)

    def __sub__(self, other: Jet | float) -> Jet:
        return self + -jet(other)

    def __rsub__(self, other: float) -> Jet:
        return jet(other) - self

    def __truediv__(self, other: Jet | float) -> Jet:
        b = jet(other)
        return self * chain(b, 1 / b.x, -1 / b.x**2, 2 / b.x**3)

    def __rtruediv__(self, other: float) -> Jet:
        return jet(other) / self

    __radd__ = __add__
    __rmul__ = __mul__


def jet(value: Jet | float) -> Jet:
    return value if isinstance(value, Jet) else Jet(float(value))


def chain(u: Jet, f: float, df: float, ddf: float) -> Jet:
    """f(u), given f and its derivatives at u."""
    return Jet(f, df * u.d, ddf * u.d**2 + df * u.dd)


def sin(u: Jet) -> Jet:
    return chain(u, math.sin(u.x), math.cos(u.x), -math.sin(u.x))


def cos(u: Jet) -> Jet:
    return chain(u, math.cos(u.x), -math.sin(u.x), -math.cos(u.x))


def sqrt(u: Jet) -> Jet:
    r = math.sqrt(u.x)
    return chain(u, r, 0.5 / r, -0.25 / (r * u.x))


def acos(u: Jet) -> Jet:
    s = math.sqrt(1 - u.x**2)
    return chain(u, math.acos(u.x), -1 / s, -u.x / s**3)


def atan2(y: Jet, x: Jet) -> Jet:
    """Angle of (x, y); its derivative is (x dy - y dx) / r^2."""
    r2 = x * x + y * y
    d = (x.x * y.d - y.x * x.d) / r2.x
    dd = (x.x * y.dd - y.x * x.dd) / r2.x - d * r2.d / r2.x
    return Jet(math.atan2(y.x, x.x), d, dd)


@dataclass(frozen=True)
class Moving:
    """A rigid body whose center of mass and orientation are functions of phi.

    com: x, y, z [m] in the world. R: rows of the body's rotation matrix, or an angle about z.
    inertia: about the center of mass, in body axes [kg m2], or the moment about z.
    """

    mass: float
    com: Sequence[Jet]
    R: Sequence[Sequence[Jet]] | Jet
    inertia: Array | float

    def turn(self) -> tuple[Array, Array]:
        """The w with angular velocity = w phi', in body axes, and dw/dphi."""
        if isinstance(self.R, Jet):
            return np.array([0, 0, self.R.d]), np.array([0, 0, self.R.dd])
        R, dR, ddR = (np.array([[getattr(c, k) for c in row] for row in self.R]) for k in ("x", "d", "dd"))
        K, dK = R.T @ dR, R.T @ ddR  # the symmetric part of R^T R'' is dropped below
        return np.array([K[2, 1], K[0, 2], K[1, 0]]), 0.5 * np.array(
            [dK[2, 1] - dK[1, 2], dK[0, 2] - dK[2, 0], dK[1, 0] - dK[0, 1]]
        )

    def reduced(self) -> tuple[float, float]:
        """(I, dI/dphi), the contributions of this body."""
        J = np.diag([0, 0, self.inertia]) if np.isscalar(self.inertia) else np.asarray(self.inertia)
        w, dw = self.turn()
        I_phi = self.mass * sum(c.d**2 for c in self.com) + float(w @ J @ w)
        return I_phi, 2 * self.mass * sum(c.d * c.dd for c in self.com) + 2 * float(w @ J @ dw)


Geometry = Callable[[Jet], Iterable[Moving]]


@dataclass(frozen=True)
class OneDofMechanism:
    """A mechanism defined by its geometry, gravity [m/s2] and the generalized force Q(t, phi, w) on phi."""

    geometry: Geometry
    gravity: Sequence[float] = (0.0, 0.0, 0.0)
    Q: Callable[[float, float, float], float] = lambda _t, _phi, _w: 0.0

    def acceleration(self, t: float, phi: float, w: float) -> float:
        I_phi = dI = force = 0.0
        for body in self.geometry(Jet(phi, 1.0)):
            more, dmore = body.reduced()
            I_phi += more
            dI += dmore
            force += body.mass * sum(g * c.d for g, c in zip(self.gravity, body.com, strict=True))
        return (force + self.Q(t, phi, w) - 0.5 * dI * w * w) / I_phi

    def energy(self, phi: float, w: float) -> float:
        """Kinetic energy and potential energy of gravity [J]."""
        total = 0.0
        for body in self.geometry(Jet(phi, 1.0)):
            height = sum(g * c.x for g, c in zip(self.gravity, body.com, strict=True))
            total += 0.5 * body.reduced()[0] * w * w - body.mass * height
        return total

    def motion(self, phi: float, w: float, times: Array, rtol: float = 1e-12) -> tuple[Array, Array]:
        """Return phi and w at the times, starting from phi and w at the first of them."""
        found = solve_ivp(
            lambda t, y: [y[1], self.acceleration(t, y[0], y[1])],
            (times[0], times[-1]),
            [phi, w],
            method="DOP853",
            t_eval=times,
            rtol=rtol,
            atol=rtol,
        )
        assert found.success, found.message
        return found.y[0], found.y[1]
