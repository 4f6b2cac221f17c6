# SPDX-License-Identifier: BSD-3-Clause
"""Which constraint equations of a scene are independent, and the sizes of its equations."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from gelenk.symbolic import numpy_text
from gelenk.symbolic.system import System

type Numbers = NDArray[np.float64]

TRIED = 6  # positions: at a singular one, such as the start may be, fewer equations are independent
DEPENDENT = 1e-7  # what is left of an equation of size 1 is an error of the position
SMALL = (
    1e-6  # equations with coefficients below this, of the largest, may have hardly more than rounding errors
)


@dataclass(frozen=True)
class Independent:
    """What a solver without pivots needs to know.

    Attributes:
        rows: constraint equations of which no one follows from the others, at most positions.
        exponents: powers of 2 that make velocities, and then these equations, of order 1.
    """

    rows: tuple[int, ...]
    exponents: tuple[int, ...]


def independent(system: System) -> Independent:
    """Return the independent constraint equations, found at the start and at positions around it."""
    functions = numpy_text.functions(system)
    start = np.array([of.start for of in system.q], float)
    u = np.array([of.start for of in system.u], float)
    masses = np.diag(functions.M(start))
    scale = 1 / np.sqrt(np.where(masses > 0, masses, 1))
    rng = np.random.default_rng(1)
    found: list[int] = []
    J = functions.J(start)
    for k in range(TRIED if system.rows else 0):
        q = closed(functions, start + 0.1 * min(k, 1) * rng.normal(size=len(start)), u)
        if q is None:
            continue
        rows = largest(functions.J(q) * scale)
        if len(rows) > len(found):
            found, J = rows, functions.J(q)
    sizes = np.abs(J * scale).max(axis=1, initial=0)[found] if found else np.zeros(0)
    exponents = np.round(np.log2(np.concatenate([scale, 1 / sizes])))
    return Independent(tuple(found), tuple(int(k) for k in exponents))


def closed(functions: SimpleNamespace, q: Numbers, u: Numbers) -> Numbers | None:
    """Return the position after Newton's method onto Phi = 0; None where it does not converge."""
    for _ in range(20):
        gap = functions.Phi(q, u)
        if np.abs(gap).max(initial=0) < 1e-12:
            return q
        dv = -np.linalg.lstsq(functions.J(q), gap, rcond=1e-9)[0]
        if not np.abs(dv).max() < 10:
            return None
        q = q + functions.qdot(q, dv)
    return None


def largest(J: Numbers) -> list[int]:
    """Return the rows that elimination with pivots finds independent, in ascending order."""
    size = np.abs(J).max(axis=1, initial=0)
    largest = size.max(initial=0) or 1
    left = J / np.where(size > SMALL * largest, size, largest)[:, None]
    out: list[int] = []
    while len(out) < len(J):
        lengths = np.linalg.norm(left, axis=1)
        k = int(lengths.argmax())
        if not lengths[k] > DEPENDENT:
            break
        out.append(k)
        direction = left[k] / lengths[k]
        left = left - np.outer(left @ direction, direction)
    return sorted(out)
