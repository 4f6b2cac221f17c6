# SPDX-License-Identifier: BSD-3-Clause
"""A hundred cone-constrained quadratic programs whose solutions are known by construction.

    minimize 1/2 x^T G x + b^T x,  x in the product of the cones |(x1, x2)| <= mu x0

All numbers follow from the number of the problem, which seeds splitmix64 (Steele, Lea & Flood 2014). A
solution x and a velocity u = G x + b in the dual cone, orthogonal to x, are drawn first; b follows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

COUNT = 100
_BITS = (1 << 64) - 1
_GOLDEN = 0x9E3779B97F4A7C15


class _Draw:
    """Uniform and normal numbers, the same in every language."""

    def __init__(self, seed: int) -> None:
        self._state = (seed * _GOLDEN + 0x1234567) & _BITS

    def uniform(self) -> float:
        """Return a number in [0, 1)."""
        self._state = (self._state + _GOLDEN) & _BITS
        z = self._state
        for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
            z = ((z ^ (z >> shift)) * factor) & _BITS
        return float((z ^ (z >> 31)) >> 11) / 2.0**53

    def normal(self) -> float:
        """Return a standard normal number, by the method of Box & Muller."""
        radius = math.sqrt(-2 * math.log(1 - self.uniform()))
        return radius * math.cos(2 * math.pi * self.uniform())

    def unit_vector(self, n: int) -> Array:
        """Return a direction in n dimensions."""
        v = np.array([self.normal() for _ in range(n)])
        return np.array(v / np.linalg.norm(v))


@dataclass(frozen=True)
class ConeProblem:
    """One problem: G (3 m by 3 m), b (3 m), friction (m), and a solution x with u = G x + b."""

    number: int
    kind: str
    G: Array
    b: Array
    friction: Array
    x: Array
    u: Array

    @property
    def cones(self) -> int:
        """Return the number m of cones."""
        return len(self.friction)

    @property
    def objective(self) -> float:
        """Return the least value."""
        return float(0.5 * self.x @ self.G @ self.x + self.b @ self.x)

    def residual(self, x: Array) -> float:
        """Return the norm of the natural map with one scale for all cones, relative to the norm of b."""
        tau = len(x) / np.trace(self.G)
        projected = np.concatenate(
            [
                project(z, mu)
                for z, mu in zip((x - tau * (self.G @ x + self.b)).reshape(-1, 3), self.friction, strict=True)
            ]
        )
        return float(np.linalg.norm(x - projected) / tau / np.linalg.norm(self.b))


def project(z: Array, mu: float) -> Array:
    """Return the nearest point to z of the cone |(z1, z2)| <= mu z0."""
    length = math.hypot(z[1], z[2])
    if length <= mu * z[0]:
        return z.copy()
    if mu * length <= -z[0]:
        return np.zeros(3)
    normal = (z[0] + mu * length) / (1 + mu * mu)
    return np.array([normal, *(normal * mu / length * z[1:])])


def _dense(draw: _Draw, n: int, condition: float) -> Array:
    """Eigenvalues from 1 to 1 / condition, evenly spread in the exponent, turned by six reflections."""
    G: Array = np.diag([condition ** (-i / (n - 1)) for i in range(n)])
    for _ in range(6):
        v = draw.unit_vector(n)
        w = G @ v
        G = G - 2 * np.outer(v, w) - 2 * np.outer(w, v) + 4 * (v @ w) * np.outer(v, v)
    return G


def _chain(draw: _Draw, n: int, condition: float) -> Array:
    """A stack: contact i between the bodies i - 1 and i of unequal masses; body 0 does not move."""
    contacts = n // 3
    masses = [10 ** (math.log10(condition) / 2 * (draw.uniform() - 0.5)) for _ in range(contacts + 1)]
    inverse = [0.0, *(1 / m for m in masses[1:])]
    G = np.zeros((contacts, contacts))
    for i in range(contacts):
        G[i, i] = inverse[i + 1] + inverse[i]
        if i:
            G[i, i - 1] = G[i - 1, i] = -inverse[i]
    return np.array(np.kron(G, np.eye(3)))


def _redundant(draw: _Draw, n: int) -> Array:
    """More unknowns than degrees of freedom: G of half its rank."""
    D = np.array([[draw.normal() for _ in range(n // 2)] for _ in range(n)])
    return np.array(D @ D.T / n)


def _pair(draw: _Draw, mu: float) -> tuple[Array, Array]:
    """An impulse in the cone and a velocity in its dual, orthogonal to it: open, sticking or sliding."""
    choice, angle = draw.uniform(), 2 * math.pi * draw.uniform()
    t = np.array([math.cos(angle), math.sin(angle)])
    impulse, speed = (10 ** (2 * draw.uniform() - 1) for _ in range(2))
    fraction = 0.95 * draw.uniform()
    nothing = np.zeros(3)
    if choice < 0.3:
        if mu > 0:
            return nothing, speed * np.array([mu * fraction + 1, *(fraction * t)])
        return nothing, speed * np.array([1, *(0.3 * t)])
    if mu == 0:
        return impulse * np.array([1, 0, 0]), speed * np.array([0, *t])
    if choice < 0.65:
        return impulse * np.array([1, *(mu * fraction * t)]), nothing
    return impulse * np.array([1, *(-mu * t)]), speed * np.array([mu, *t])


@cache
def cone_problem(number: int) -> ConeProblem:
    """Return one of the problems 0 to 99."""
    draw = _Draw(number)
    kind = ("dense", "dense", "chain", "redundant")[number % 4]
    n = 3 * (5 + int(36 * draw.uniform()))
    condition = 10 ** (1 + 5 * draw.uniform())
    if kind == "dense":
        G = _dense(draw, n, condition)
    elif kind == "chain":
        G = _chain(draw, n, condition)
    else:
        G = _redundant(draw, n)
    G = (G + G.T) / 2
    friction = np.array([0.0 if draw.uniform() < 0.1 else 0.1 + 1.1 * draw.uniform() for _ in range(n // 3)])
    pairs = [_pair(draw, mu) for mu in friction]
    x, u = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return ConeProblem(number, kind, G, u - G @ x, friction, x, u)
