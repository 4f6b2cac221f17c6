# SPDX-License-Identifier: BSD-3-Clause
"""Factorizations of Jacobians and mass matrices against numpy's pseudoinverses, and their choice."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Random matrices here have condition numbers below 1e4, which amplify some hundred rounding errors of 1e-16.
CLOSE: dict[str, Any] = {"rtol": 1e-10, "atol": 1e-10}
ROUNDING = 1e-12  # pivots below this fraction of the largest count as zero (row_factor.h)
SIZES = [(1, 1), (3, 2), (6, 6), (9, 4), (4, 7), (20, 12)]


def dense_factor(units: Any, Y: Array, max_rank: int | None = None) -> Any:
    factor = units.RowFactor(*Y.shape)
    factor.factorize(Y.T.tolist(), Y.shape[1] if max_rank is None else max_rank)
    return factor


def onto(Y: Array, w: Array, gamma: Array) -> Array:
    """The vector nearest to w with Y^T w = gamma, in the least-squares sense if there is none."""
    return w + np.linalg.pinv(Y.T, rcond=1e-11) @ (gamma - Y.T @ w)


def assert_solves(factor: Any, Y: Array, rng: np.random.Generator) -> None:
    """Any right-hand side, including one for which redundant rows contradict each other."""
    n, m = Y.shape
    a, gamma = (rng.standard_normal((size,)) for size in (n, m))
    w = factor.constrain(a, gamma)
    np.testing.assert_allclose(w, onto(Y, a, gamma), **CLOSE)
    expected = np.linalg.pinv(Y, rcond=1e-11) @ (a - onto(Y, a, gamma))
    np.testing.assert_allclose(factor.multipliers(m), expected, **CLOSE)
    np.testing.assert_allclose(factor.shortest(gamma, n), onto(Y, np.zeros(n), gamma), **CLOSE)
    W, G = rng.standard_normal((n, 3)), rng.standard_normal((m, 3))
    by_columns = np.reshape(factor.constrain_columns(W.ravel(), G.ravel(), 3, False), (n, 3))
    for k in range(3):
        np.testing.assert_allclose(by_columns[:, k], factor.constrain(W[:, k], G[:, k]), **CLOSE)


@pytest.mark.parametrize("rank", ["full", "one less", "one"])
@pytest.mark.parametrize("size", SIZES)
def test_dense_rows_of_any_rank(units: Any, size: tuple[int, int], rank: str) -> None:
    rng = np.random.default_rng(size)
    most = min(size)
    wanted = {"full": most, "one less": max(most - 1, 1), "one": 1}[rank]
    Y = rng.standard_normal((size[0], wanted)) @ rng.standard_normal((wanted, size[1]))
    factor = dense_factor(units, Y)
    assert factor.rank == wanted
    assert_solves(factor, Y, rng)


def test_no_more_pivots_are_used_than_allowed(units: Any) -> None:
    """The largest of orthogonal rows are used."""
    Y = np.diag([3.0, 1.0, 2.0])
    factor = dense_factor(units, Y, 2)
    assert factor.rank == 2
    assert factor.pivot_ratio == pytest.approx(2 / 3, rel=1e-15)
    assert factor.shortest([3.0, 5.0, 2.0], 3) == pytest.approx([1.0, 0.0, 1.0], abs=1e-15)


@pytest.mark.parametrize(("ratio", "rank"), [(0.9, 2), (1.1, 3)])
def test_a_row_of_rounding_errors_is_not_counted(units: Any, ratio: float, rank: int) -> None:
    Q = np.linalg.qr(np.random.default_rng(7).standard_normal((5, 3)))[0]
    factor = dense_factor(units, Q * [1.0, 1e-3, ratio * ROUNDING])
    assert factor.rank == rank


def assert_weak_rows_are_weighted(factor: Any, Q: Array, pivots: Array, weak: float, largest: float) -> None:
    n, m = Q.shape
    rng = np.random.default_rng(11)
    a, gamma, expected = rng.standard_normal(n), rng.standard_normal(m) * pivots, rng.standard_normal(n)
    factor.set_weak(weak)
    ratios = pivots / largest / weak
    weight = ratios**2 / (ratios**2 + 1)  # of a correction
    of_equation = ratios**6 / (ratios**6 + 1)  # beside an extrapolation: of least variance
    constrained = gamma / pivots
    np.testing.assert_allclose(factor.constrain(a, gamma), a + Q @ (constrained - Q.T @ a), **CLOSE)
    along = of_equation * constrained + (1 - of_equation) * (Q.T @ expected)
    np.testing.assert_allclose(factor.constrain(a, gamma, expected), a + Q @ (along - Q.T @ a), **CLOSE)
    np.testing.assert_allclose(factor.shortest(gamma, n), Q @ (weight * constrained), **CLOSE)
    follows = factor.constrain_columns(a, gamma, 1, True)
    np.testing.assert_allclose(follows, a + Q @ (of_equation * constrained - Q.T @ a), **CLOSE)


def test_weak_rows_are_weighted_with_the_expected_solution(units: Any) -> None:
    """For orthogonal rows each pivot is the norm of its row."""
    Q = np.linalg.qr(np.random.default_rng(5).standard_normal((6, 4)))[0]
    pivots = np.array([2.0, 0.5, 0.05, 0.004])
    assert_weak_rows_are_weighted(dense_factor(units, Q * pivots), Q, pivots, 0.03, 2.0)


# --- sparse ---


def banded(m: int, wide: int, rng: np.random.Generator) -> tuple[Array, list[list[int]]]:
    """M rows; both rows of a pair involve the same velocities and share some with the next pair."""
    touched = [list(range(3 * (r // 2), 3 * (r // 2) + wide)) for r in range(m)]
    Y = np.zeros((max(t[-1] for t in touched) + 1, m))
    for r, speeds in enumerate(touched):
        Y[speeds, r] = rng.standard_normal(wide)
    return Y, touched


@pytest.mark.parametrize("wide", [3, 4, 6])
@pytest.mark.parametrize("m", [1, 2, 9, 40])
def test_sparse_rows_agree_with_dense_ones(units: Any, m: int, wide: int) -> None:
    rng = np.random.default_rng([m, wide])
    Y, touched = banded(m, wide, rng)
    factor = units.SparseRowFactor(Y.shape[0], touched)
    assert factor.possible
    assert factor.factorize(Y.T.tolist())
    assert factor.rank == m
    assert_solves(factor, Y, rng)
    Y = np.where(Y != 0, rng.standard_normal(Y.shape), 0)  # at another position
    assert factor.factorize(Y.T.tolist())
    assert_solves(factor, Y, rng)


@pytest.mark.parametrize(("ratio", "taken"), [(0.9, False), (1.1, True)])
def test_a_redundant_sparse_row_is_rejected(units: Any, ratio: float, taken: bool) -> None:
    """Two rows on the same two velocities; the second has an independent part in units of the threshold."""
    own = ratio * ROUNDING
    factor = units.SparseRowFactor(2, [[0, 1], [0, 1]])
    assert factor.factorize([[1.0, 0.0], [0.5, own]]) == taken


def test_a_row_without_a_velocity_of_its_own_is_detected_in_the_pattern(units: Any) -> None:
    assert units.SparseRowFactor(2, [[0, 1], [0, 1]]).possible
    assert not units.SparseRowFactor(2, [[0, 1], [0, 1], [0, 1]]).possible
    assert not units.SparseRowFactor(3, [[0], [0], [1, 2]]).possible


def test_weak_sparse_rows_are_weighted_with_the_expected_solution(units: Any) -> None:
    pivots = np.array([2.0, 0.5, 0.05, 0.004])
    Q = np.zeros((8, 4))
    Q[np.arange(8), np.arange(8) // 2] = np.tile([0.6, 0.8], 4)
    factor = units.SparseRowFactor(8, [[2 * r, 2 * r + 1] for r in range(4)])
    assert factor.factorize((Q * pivots).T.tolist())
    assert factor.pivot_ratio == pytest.approx(0.002, rel=1e-14)
    assert_weak_rows_are_weighted(factor, Q, pivots, 0.03, 2.0)


# --- masses ---


def tree(n: int, rng: np.random.Generator) -> tuple[list[int], Array]:
    """Parents of velocities, some on the ground, and a factor with that pattern."""
    parent = [int(rng.integers(-1, i)) if i else -1 for i in range(n)]
    L = np.zeros((n, n))
    for i in range(n):
        L[i, i] = rng.uniform(0.5, 2)
        k = parent[i]
        while k >= 0:
            L[i, k] = rng.standard_normal() / 2
            k = parent[k]
    return parent, L


@pytest.mark.parametrize("n", [1, 2, 8, 30])
def test_a_mass_matrix_is_the_product_of_its_factor(units: Any, n: int) -> None:
    rng = np.random.default_rng(n)
    parent, L = tree(n, rng)
    M = L.T @ L
    factor = units.SparseFactor(parent)
    assert factor.factorize(M.tolist()) == -1
    np.testing.assert_allclose(factor.factor(), L, **CLOSE)
    x = rng.standard_normal(n)
    np.testing.assert_allclose(factor.multiply(x), L @ x, **CLOSE)
    # Condition numbers up to 1e5 here, from products along the longest branch.
    np.testing.assert_allclose(L @ factor.solve(x), x, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(L.T @ factor.solve_transposed(x), x, rtol=1e-9, atol=1e-9)
    X = rng.standard_normal((n, 4))
    for name in ("solve", "solve_transposed"):
        found = np.reshape(getattr(factor, f"{name}_columns")(X.ravel(), 4), (n, 4))
        for k in range(4):
            np.testing.assert_allclose(found[:, k], getattr(factor, name)(X[:, k]), rtol=1e-9, atol=1e-9)


def test_a_velocity_without_inertia_is_returned_with_its_motion(units: Any) -> None:
    rng = np.random.default_rng(4)
    parent, L = tree(8, rng)
    L[3, 3] = 0.0
    M = L.T @ L
    M[3, 3] -= 1e-9  # beyond rounding
    factor = units.SparseFactor(parent)
    assert factor.factorize(M.tolist()) == 3
    z = np.array(factor.null_motion(3))
    assert z[3] == 1.0
    assert not z[:3].any()
    np.testing.assert_allclose((M @ z)[4:], 0, atol=1e-12)


# --- the choice ---


def chains(count: int) -> tuple[list[int], list[list[int]]]:
    """Pairs of velocities on the ground, and rows that each connect the end of one pair to the next."""
    parent = [i - 1 if i % 2 else -1 for i in range(2 * count)]
    return parent, [[2 * r + 1, 2 * r + 3] for r in range(count - 1)]


def assert_equations_hold(
    units: Any, parent: list[int], touched: list[list[int]], J: Array, max_rank: int
) -> Any:
    """M vdot + J^T lambda = tau, J vdot = gamma."""
    n = len(parent)
    rng = np.random.default_rng(9)
    L = np.zeros((n, n))
    for i in range(n):
        L[i, i] = rng.uniform(1, 2)
        if parent[i] >= 0:
            L[i, parent[i]] = 0.5
    rows = units.WhitenedRows(parent, touched)
    rows.factorize((L.T @ L).tolist(), J.tolist(), max_rank)
    tau, target = rng.standard_normal(n), rng.standard_normal(n)
    gamma = J @ target  # consistent
    w, multipliers = rows.solve(np.linalg.solve(L.T, tau), gamma)
    vdot = np.linalg.solve(L, w)
    np.testing.assert_allclose(J @ vdot, gamma, **CLOSE)
    np.testing.assert_allclose(L.T @ L @ vdot + J.T @ multipliers, tau, **CLOSE)
    return rows


def values(touched: list[list[int]], n: int) -> Array:
    rng = np.random.default_rng(2)
    J = np.zeros((len(touched), n))
    for r, speeds in enumerate(touched):
        J[r, speeds] = rng.uniform(0.5, 2, len(speeds))
    return J


@pytest.mark.parametrize(("rows", "sparse"), [(7, False), (8, True), (30, True)])
def test_from_eight_rows_on_the_zeros_are_left_out(units: Any, rows: int, sparse: bool) -> None:
    parent, touched = chains(rows + 1)
    found = assert_equations_hold(units, parent, touched, values(touched, len(parent)), rows)
    assert found.by_pattern == sparse
    assert found.rank == rows


def test_an_impossible_pattern_is_dense(units: Any) -> None:
    parent, touched = chains(12)
    touched += [[1, 3], [1, 3]]  # four rows on the four speeds of two pairs, with what ties these to others
    touched = sorted([*touched, [1], [1], [1]])  # three on the two of one
    J = values(touched, len(parent))
    found = assert_equations_hold(units, parent, touched, J, len(touched))
    assert not found.by_pattern
    assert found.rank == np.linalg.matrix_rank(J)


def test_rows_redundant_at_one_position_are_dense_there_only(units: Any) -> None:
    """Dense at a position where rows are redundant, sparse elsewhere."""
    parent, touched = chains(12)
    touched = [t for t in touched for _ in range(2)]
    J = values(touched, len(parent))
    J[0] = 0.3 * J[1]
    found = assert_equations_hold(units, parent, touched, J, len(touched))
    assert not found.by_pattern
    assert found.rank == np.linalg.matrix_rank(J) < len(touched)


def test_rows_known_to_be_redundant_are_dense(units: Any) -> None:
    """Off the constraints they may look independent: the rank of closed loops limits the pivots."""
    parent, touched = chains(12)
    n, m = len(parent), len(touched)
    rows = units.WhitenedRows(parent, touched)
    for most, sparse in ((m, True), (m - 1, False), (m, True)):
        rows.factorize(np.eye(n).tolist(), values(touched, n).tolist(), most)
        assert (rows.by_pattern, rows.rank) == (sparse, most)
