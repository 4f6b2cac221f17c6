# SPDX-License-Identifier: BSD-3-Clause
"""Eigenvalues and Jordan chains of a matrix with rounding errors.

Rounding splits an eigenvalue with a Jordan chain of n vectors into n values at distances of about eps^(1/n).
Their mean is insensitive to rounding, the values themselves are not. Eigenvalues are therefore grouped into
clusters by
the distance to the nearest matrix in which they coincide: two eigenvalues can be made equal by a perturbation
of norm d if they lie in one component of {z: smallest singular value of A - z <= d} (Alam & Bora 2005, Linear
Algebra Appl. 396, 273-301). The Jordan chains of a cluster follow from its invariant subspace, which is
computed from an ordered Schur form, not from eigenvectors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, matrix_balance, rsf2csf, schur

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROUNDING = 1e-12  # relative difference between exact derivatives of a mechanism computed by different methods
# 1/s2. Accelerations that cancel leave rounding errors of this size; the frequency 1e-6 rad/s is a turn in
# ten weeks.
MIN_SCALED_ENTRY = 1e-12
# Fractions of the line between two eigenvalues at which the smallest singular value is evaluated; chosen so
# that a third eigenvalue is unlikely to be there.
PROBE_FRACTIONS = (0.46, 0.21, 0.77)


@dataclass(frozen=True)
class Cluster:
    """Eigenvalues that are equal within rounding; of a complex pair those with positive imaginary part.

    Attributes:
        value: mean of the eigenvalues [1/s]; a real or imaginary part below `error_bound` is set to 0.
        error_bound: bound of the error of `value` [1/s].
        size: number of eigenvalues.
        chain_lengths: lengths of the Jordan chains, longest first; all 1 for a semisimple eigenvalue.
        vectors: one eigenvector for each Jordan chain, shape (n, chains).
    """

    value: complex
    error_bound: float
    size: int
    chain_lengths: tuple[int, ...]
    vectors: Complex


def spectrum(A: Array, rounding: float = ROUNDING) -> list[Cluster]:
    """Return all eigenvalues of a real matrix in clusters, without those with negative imaginary part.

    Args:
        A: matrix with finite entries, shape (n, n) [1/s].
        rounding: assumed error of the matrix relative to its norm.
    """
    n = len(A)
    if n == 0:
        return []
    scale = _scales(A)
    real, Q = schur(A * scale / scale[:, None], output="real")
    T, Z = rsf2csf(real, Q)  # from the real form, so that pairs are exact conjugates
    uncertain = max(rounding, 10 * n * np.finfo(float).eps) * float(np.linalg.norm(real, 2))
    found = []
    for members in _clusters(T, _pairs(real), uncertain):
        for block, basis, condition in _separate_zeros(*_reordered(T, Z, members), uncertain):
            found.append(_cluster(block, scale[:, None] * basis, uncertain / condition))
    return found


def _cluster(S: Complex, basis: Complex, error: float) -> Cluster:
    size = len(S)
    mean = complex(np.trace(S)) / size
    lengths, vectors = _chains(S - mean * np.eye(size), error * size)
    value = complex(*(0.0 if abs(part) <= error else part for part in (mean.real, mean.imag)))
    return Cluster(value, error, size, lengths, basis @ vectors)


def _separate_zeros(
    S: Complex, basis: Complex, condition: float, uncertain: float
) -> list[tuple[Complex, Complex, float]]:
    """Split a cluster into its zero eigenvalues and the others, if it has both.

    The eigenvalues 0 and -d of a slightly damped coordinate without restoring force are close to a double
    zero. Ranks distinguish them, eigenvalues do not.
    """
    counts, U = _kernels(S, uncertain / condition)
    zeros = sum(counts)
    if zeros in (0, len(S)):
        return [(S, basis, condition)]
    S = U.conj().T @ S @ U
    rest, Q = schur(S[zeros:, zeros:], output="complex")
    S[:zeros, zeros:] @= Q
    U[:, zeros:] @= Q
    T = np.block([[np.zeros((zeros, zeros)), S[:zeros, zeros:]], [np.zeros((len(rest), zeros)), rest]])
    T[:zeros, :zeros] = np.triu(S[:zeros, :zeros], 1)
    block, others, _ = _reordered(T, U, list(range(zeros, len(S))))
    return [(T[:zeros, :zeros], basis @ U[:, :zeros], condition), (block, basis @ others, condition)]


def _scales(A: Array) -> Array:
    """Return units of the states that balance the matrix; entries that may be rounding errors are ignored."""
    size = np.abs(A)
    least = np.maximum(
        1e-11 * size.max(axis=1, keepdims=True), MIN_SCALED_ENTRY * min(1.0, float(size.max()))
    )
    _, (scale, _) = matrix_balance(np.where(size > least, A, 0.0), permute=False, separate=True)
    return np.asarray(scale, np.float64)


def _pairs(T: Array) -> NDArray[np.int64]:
    """Return the index of the conjugate of each eigenvalue of a real Schur form, shape (n,)."""
    partner = np.arange(len(T))
    for i in np.flatnonzero(np.diag(T, -1)):
        partner[i], partner[i + 1] = i + 1, i
    return partner


def _reordered(T: Complex, Z: Complex, members: list[int]) -> tuple[Complex, Complex, float]:
    """Move eigenvalues to the front of a Schur form.

    Returns their block, a basis of their invariant subspace, and 1 / norm of their spectral projector.
    """
    chosen = np.zeros(len(T), np.int32)
    chosen[members] = 1
    T, Z, _, size, condition, _, info = lapack.ztrsen(chosen, T, Z, job="E", lwork=len(T) ** 2)
    assert info == 0
    return T[:size, :size], Z[:, :size], max(float(condition), float(np.finfo(float).eps))


def _can_coincide(T: Complex, a: complex, b: complex, uncertain: float) -> bool:
    """Whether a perturbation of the matrix by `uncertain` can make two eigenvalues coincide."""
    return all(
        np.linalg.svd(T - (a + fraction * (b - a)) * np.eye(len(T)), compute_uv=False)[-1] <= uncertain
        for fraction in PROBE_FRACTIONS
    )


def _clusters(T: Complex, partner: NDArray[np.int64], uncertain: float) -> list[list[int]]:
    """Return the indices of the eigenvalues in each cluster.

    Eigenvalues of the closed upper half-plane are joined along their minimum spanning tree. Their conjugates
    belong to the same cluster if the two can coincide on the real axis; otherwise, they are omitted.
    """
    values = np.diag(T)
    values = np.where(partner == np.arange(len(T)), values.real, 0.5 * (values + values[partner].conj()))
    half = [i for i in range(len(values)) if values[i].imag >= 0]
    group = {half[0]: [half[0]]}
    rest = half[1:]
    while rest:
        _, a, b = min((abs(values[a] - values[b]), a, b) for a in group for b in rest)
        group[b] = group[a] if _can_coincide(T, values[a], values[b], uncertain) else []
        group[b].append(b)
        rest.remove(b)
    out = []
    for i in sorted(group, key=lambda i: (abs(values[i]), i)):
        members = group[i]
        if i != members[0]:
            continue
        lowest = min(members, key=lambda k: values[k].imag)
        if _can_coincide(T, values[lowest], values[lowest].conjugate(), uncertain):
            members = sorted({*members, *map(int, partner[members])})
        out.append(members)
    return out


def _chains(N: Complex, error: float) -> tuple[tuple[int, ...], Complex]:
    """Return lengths and eigenvectors of the Jordan chains of a matrix that is nilpotent within rounding.

    The number of chains with a k-th vector is the nullity of N restricted to the complement of the kernel of
    N^(k-1) (staircase algorithm; Kublanovskaya 1966, Golub & Wilkinson 1976).
    """
    counts, _ = _kernels(N, error)
    counts += [1] * (len(N) - sum(counts))  # eigenvalues that only a larger error made coincide form a chain
    lengths = tuple(sum(count > i for count in counts) for i in range(counts[0]))
    return lengths, _chain_eigenvectors(N, counts)


def _kernels(N: Complex, error: float) -> tuple[list[int], Complex]:
    """Return the increments of the nullities of N, N^2, ..., and a unitary basis that begins with kernels."""
    counts: list[int] = []
    U = np.eye(len(N), dtype=np.complex128)
    done = 0
    while done < len(N):
        M = U[:, done:].conj().T @ N @ U[:, done:]
        _, size, V = np.linalg.svd(M)
        kernel = int((size <= error).sum())
        if not kernel:
            break
        counts.append(min([kernel, *counts[-1:]]))
        U[:, done:] = U[:, done:] @ V[::-1].conj().T
        done += counts[-1]
    return counts, U


def _chain_eigenvectors(N: Complex, counts: list[int]) -> Complex:
    """Return orthonormal eigenvectors, one for each chain, longest first: N^(k-1) applied to the kernel of
    N^k.
    """
    vectors = np.zeros((len(N), 0), np.complex128)
    for k in range(len(counts), 0, -1):
        _, _, V = np.linalg.svd(np.linalg.matrix_power(N, k))
        kernel = V[len(N) - sum(counts[:k]) :].conj().T
        image = np.linalg.matrix_power(N, k - 1) @ kernel
        found = np.linalg.svd(image)[0][:, : counts[k - 1]]
        new = counts[k - 1] - vectors.shape[1]
        others = found - vectors @ (vectors.conj().T @ found)
        vectors = np.hstack([vectors, np.linalg.svd(others)[0][:, :new]])
    return vectors
