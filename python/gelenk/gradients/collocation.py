# SPDX-License-Identifier: BSD-3-Clause
"""Integration of linear variational equations S' = A S + B between samples of A and B."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

# Lobatto IIIA of order 6 (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, II.7):
# collocation at both ends of a step and between.
NODES = np.array([0.0, 0.5 - np.sqrt(5) / 10, 0.5 + np.sqrt(5) / 10, 1.0])


def _quadrature(nodes: Array, to: Array) -> Array:
    """Return the weights of the values at `nodes` in the integrals from 0 to each entry of `to`."""
    powers = np.arange(len(nodes))
    moments = to[:, None] ** (powers + 1) / (powers + 1)
    return moments @ np.linalg.inv(np.vander(nodes, increasing=True))


_MATRIX = _quadrature(NODES, NODES)
WEIGHTS = _MATRIX[-1]
_EMBEDDED = np.append(_quadrature(NODES[:-1], np.ones(1))[0], 0.0)


@dataclass
class Sample:
    """What the plant is at one time.

    Attributes:
        A: derivatives of the rates by the states, shape (states, states).
        B: by inputs and parameters, shape (states, columns).
        noise: bounds on the rounding errors of B.
        rates: of the states, shape (states,).
        x: the states.
        C: derivatives of the outputs by the states.
        D: of the outputs by inputs and parameters.
        movable: derivatives of the states by themselves: the unit matrix, unless something is kept at rest.
    """

    A: Array
    B: Array
    noise: Array
    rates: Array
    x: Array
    C: Array
    D: Array
    movable: Array


def unit(sample: Sample) -> Array:
    """Return [F, G, P] of no time."""
    return np.eye(*np.hstack([sample.A, sample.B]).shape)


def product(right: Array, left: Array) -> Array:
    """Return [F, G, P] of two parts of a communication step, the first of them on the right-hand side."""
    n = len(right)
    both: Array = right[:, :n] @ left
    both[:, n:] += right[:, n:]
    return both


def advance(samples: list[Sample], h: float, largest: Array, fastest: Array) -> tuple[Array, float]:
    """Integrate from the unit matrix for the states, and from zero for inputs and parameters, over one step.

    Args:
        samples: at the nodes of the step.
        h: its length [s].
        largest: changes of the integrals of B in a communication step, with the largest B of the run.
        fastest: the same of the states, shape (states,).

    Returns:
        tuple[NDArray, float]: [F, G], shape (states, states + columns), and the estimated relative error, of
        it and of the states.
    """
    n, columns = samples[0].B.shape
    start = np.hstack([np.eye(n), np.zeros((n, columns))])
    forces = [np.hstack([np.zeros((n, n)), s.B]) for s in samples]
    unknowns = np.eye(3 * n)
    known = np.tile(start, (3, 1))
    first = samples[0].A @ start + forces[0]
    for i in range(3):
        rows = slice(i * n, (i + 1) * n)
        known[rows] += h * _MATRIX[i + 1, 0] * first
        for j in range(3):
            unknowns[rows, j * n : (j + 1) * n] -= h * _MATRIX[i + 1, j + 1] * samples[j + 1].A
            known[rows] += h * _MATRIX[i + 1, j + 1] * forces[j + 1]
    stages = np.linalg.solve(unknowns, known).reshape(3, n, n + columns)
    rates = np.stack([first, *(s.A @ S + f for s, S, f in zip(samples[1:], stages, forces[1:], strict=True))])
    sizes = np.maximum(np.abs(start), np.abs(stages).max(axis=0))
    sizes[:, n:] += largest
    noise = np.hstack([np.zeros((n, n)), np.stack([s.noise for s in samples]).max(axis=0)])
    error = _error(rates, h, sizes, noise)
    motion = np.stack([s.rates for s in samples])[:, :, None]
    return stages[-1], max(error, _error(motion, h, (np.abs(samples[0].x) + fastest)[:, None]))


def _error(rates: Array, h: float, sizes: Array, noise: Array | float = 0.0) -> float:
    """Return the estimated error of the quadrature of smooth rates, relative to the results.

    The difference to the embedded formula of order 3 is of order (h/T)^3 for rates that vary in a time T, the
    error about the square of it. Where rates have a kink, both are of the same size as their change.
    """
    if not rates.size:
        return 0.0
    embedded = h * np.maximum(np.abs(np.tensordot(WEIGHTS - _EMBEDDED, rates, 1)) - noise, 0.0)
    change = h * np.abs(rates).max(axis=0)
    error = embedded * np.minimum(1.0, embedded / np.maximum(change, 1e-300))
    scale = sizes + 1e-3 * sizes.max(axis=0)
    return float((error / np.maximum(scale, 1e-300)).max())
