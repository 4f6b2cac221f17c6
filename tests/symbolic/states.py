# SPDX-License-Identifier: BSD-3-Clause
"""States at which equations are compared: random ones, and such that satisfy the constraints."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from gelenk import Equations, _core

type Numbers = NDArray[np.float64]
type State = tuple[Numbers, Numbers, Numbers]


def random_states(equations: Equations, count: int, seed: int = 7) -> list[State]:
    """Positions near the start, which do not close loops, with any velocities and inputs."""
    rng = np.random.default_rng(seed)
    start = np.array([of.start for of in equations.q])
    inputs = np.array([of.start for of in equations.u])
    return [
        (
            start + 0.3 * rng.normal(size=len(start)),
            rng.normal(size=len(equations.v)),
            inputs + 0.1 * rng.normal(size=len(inputs)),
        )
        for _ in range(count)
    ]


def closed_states(equations: Equations, functions: SimpleNamespace, count: int, seed: int = 7) -> list[State]:
    """The same after projection: by Newton's method onto Phi = 0, then onto the velocities that J permits."""
    out = []
    for q, v, u in random_states(equations, 3 * count, seed):
        for _ in range(20):
            dv = -np.linalg.lstsq(functions.J(q), functions.Phi(q, u), rcond=1e-9)[0]
            if not np.abs(dv).max(initial=0) < 10:
                break  # it diverges
            q = q + functions.qdot(q, dv)
        if equations.rows and not np.abs(functions.Phi(q, u)).max() < 1e-12:
            continue
        J = functions.J(q)
        if equations.rows:
            _, sizes, Vt = np.linalg.svd(J)
            rank = int((sizes > 1e-6 * sizes[0]).sum())
            if rank < len(sizes) and sizes[rank] > 1e-10 * sizes[0]:
                continue  # near a singular position
            v = Vt[rank:].T @ (Vt[rank:] @ v)
        out.append((q, v, u))
    return out[:count]


def by_kernels(equations: Equations, state: State) -> _core.EquationValues:
    """The same by the kernels that simulations run."""
    q, v, u = (of.tolist() for of in state)
    return equations._system.traced.values(q, v, u)


def closeness(found: object, expected: object) -> float:
    """The largest error, relative to the largest number."""
    a, b = np.asarray(found, float).ravel(), np.asarray(expected, float).ravel()
    assert a.shape == b.shape
    assert np.isfinite(a).all()
    return float(np.abs(a - b).max(initial=0) / np.abs(b).max(initial=1e-300)) if np.any(a != b) else 0.0
