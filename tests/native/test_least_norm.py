# SPDX-License-Identifier: BSD-3-Clause
"""Solutions of least norm of small systems, compared with pseudo-inverses by singular values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array

THRESHOLD = 1e-11


def solved(units: Any, G: Array, r: Array) -> Array:
    return np.array(units.least_norm(G.tolist(), r.tolist(), THRESHOLD))


@pytest.mark.parametrize("rank", [1, 3, 6])
@pytest.mark.parametrize("size", [7, 12, 24])
@pytest.mark.parametrize("spread", [1.0, 1e-3])
def test_redundant_systems(units: Any, size: int, rank: int, spread: float) -> None:
    """Eigenvalues of 1 to `spread`: x is accurate to rounding over their ratio, squared by (L^T L)^-2."""
    rng = np.random.default_rng(size + rank)
    Q = np.linalg.qr(rng.normal(size=(size, rank)))[0]
    G = Q @ np.diag(np.geomspace(1, spread, rank)) @ Q.T
    r = G @ rng.normal(size=size)
    found = solved(units, G, r)
    np.testing.assert_allclose(found, np.linalg.pinv(G, 1e-9) @ r, atol=1e-14 / spread**2)
    np.testing.assert_allclose(G @ found, r, atol=1e-13)


def test_zero_rank(units: Any) -> None:
    assert solved(units, np.diag([1.0, 0.0]), np.array([3.0, 0.0])) == pytest.approx([3, 0])


@pytest.mark.parametrize(
    "G",
    [
        np.eye(3),
        -np.ones((1, 1)),
        np.array([[1.0, 2.0], [2.0, 1.0]]),  # indefinite
        np.array([[0.0, 1.0], [-3.0, 1.0]]),  # not symmetric
        np.array([[1.0, 1.0], [1.0 + 1e-6, 1.0]]),
    ],
)
def test_regular_systems(units: Any, G: Array) -> None:
    r = np.arange(1.0, 1 + len(G))
    np.testing.assert_allclose(solved(units, G, r), np.linalg.solve(G, r), rtol=1e-15 * np.linalg.cond(G))


@pytest.mark.parametrize(
    "G",
    [
        -np.ones((2, 2)),
        np.zeros((2, 2)),
        np.zeros((1, 1)),
        np.array([[1.0, 1.0], [2.0, 2.0]]),
        np.array([[0.0, 1.0], [0.0, 0.0]]),
    ],
)
def test_other_singular_systems(units: Any, G: Array) -> None:
    """The right-hand side is not in their range: x has the least error."""
    r = np.arange(1.0, 1 + len(G))
    np.testing.assert_allclose(solved(units, G, r), np.linalg.pinv(G) @ r, atol=1e-14)


@pytest.mark.parametrize("rank", [1, 3, 6])
@pytest.mark.parametrize("size", [7, 12, 24])
@pytest.mark.parametrize("spread", [1.0, 1e-3])
@pytest.mark.parametrize("in_range", [True, False])
def test_singular_systems_that_are_not_symmetric(
    units: Any, size: int, rank: int, spread: float, in_range: bool
) -> None:
    """Singular values of 1 to `spread`, which pivots do not resolve: hence their ratio, squared by L^T L."""
    rng = np.random.default_rng(100 * size + rank)
    left, right = (np.linalg.qr(rng.normal(size=(size, rank)))[0] for _ in range(2))
    G = left @ np.diag(np.geomspace(1, spread, rank)) @ right.T
    r = G @ rng.normal(size=size) if in_range else rng.normal(size=size)
    found = solved(units, G, r)
    np.testing.assert_allclose(found, np.linalg.pinv(G, 1e-9) @ r, atol=1e-13 / spread**2)
    if in_range:
        np.testing.assert_allclose(G @ found, r, atol=1e-14)
