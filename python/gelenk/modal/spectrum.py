# SPDX-License-Identifier: BSD-3-Clause
"""Eigenvalues with their Jordan chains, as far as a matrix that was rounded can tell them.

Rounding parts an eigenvalue of a chain of n vectors into n values about eps^(1/n) away, so none of them tells
anything alone; their mean does. Which ones belong together is a matter of the distance to the next matrix in
which they are one: two eigenvalues can be made one by changing the matrix by d where they lie in one piece of
{z: least singular value of A - z <= d} (Alam & Bora 2005, Linear Algebra Appl. 396, 273-301). From there on
a cluster's invariant subspace is worked on, by an ordered Schur form, not its eigenvectors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, matrix_balance, rsf2csf, schur

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROUNDING = 1e-12  # what exact derivatives of a mechanism differ by between ways to compute them, relative
FLOOR = 1e-12  # 1/s2: 1e-6 rad/s, a turn in ten weeks, is what rounding leaves of accelerations that cancel


BETWEEN = (0.46, 0.21, 0.77)  # of the way from one eigenvalue to another: where no third one stands by design


@dataclass(frozen=True)
class Cluster:
    """Eigenvalues that are one, or as good as one; of a pair the one with the positive imaginary part.

    Attributes:
        value: their mean [1/s]; real or imaginary to the digit where rounding hides the other part.
        error: that it may have [1/s].
        size: how many they are.
        lengths: of their Jordan chains, longest first; all 1 where there are as many eigenvectors.
        vectors: the eigenvectors that lead the chains, shape (n, chains).
    """

    value: complex
    error: float
    size: int
    lengths: tuple[int, ...]
    vectors: Complex


def spectrum(A: Array, rounding: float = ROUNDING) -> list[Cluster]:
    """All eigenvalues of a real matrix, those with a negative imaginary part left out.

    Args:
        A: shape (n, n), finite.
        rounding: error of the matrix that is reckoned with, relative to its norm.
    """
    n = len(A)
    if n == 0:
        return []
    scale = _scales(A)
    real, Q = schur(A * scale / scale[:, None], output="real")
    T, Z = rsf2csf(real, Q)  # in this order, so that pairs stay pairs
    uncertain = max(rounding, 10 * n * np.finfo(float).eps) * float(np.linalg.norm(real, 2))
    found = []
    for members in _clusters(T, _pairs(real), uncertain):
        for block, basis, share in _without_zeros(*_first(T, Z, members), uncertain):
            found.append(_cluster(block, scale[:, None] * basis, uncertain / share))
    return found


def _cluster(S: Complex, basis: Complex, error: float) -> Cluster:
    size = len(S)
    mean = complex(np.trace(S)) / size
    lengths, leads = _chains(S - mean * np.eye(size), error * size)
    value = complex(*(0.0 if abs(part) <= error else part for part in (mean.real, mean.imag)))
    return Cluster(value, error, size, lengths, basis @ leads)


def _without_zeros(
    S: Complex, basis: Complex, share: float, uncertain: float
) -> list[tuple[Complex, Complex, float]]:
    """A cluster; or its zeros and the rest of it, if it has both.

    A coordinate that rests anywhere and has a little damping, 0 and -d, is next to a double zero. But what is
    0 and what is not can be told: by kernels, not by eigenvalues.
    """
    counts, U = _kernels(S, uncertain / share)
    zeros = sum(counts)
    if zeros in (0, len(S)):
        return [(S, basis, share)]
    S = U.conj().T @ S @ U
    rest, Q = schur(S[zeros:, zeros:], output="complex")
    S[:zeros, zeros:] @= Q
    U[:, zeros:] @= Q
    T = np.block([[np.zeros((zeros, zeros)), S[:zeros, zeros:]], [np.zeros((len(rest), zeros)), rest]])
    T[:zeros, :zeros] = np.triu(S[:zeros, :zeros], 1)
    block, others, _ = _first(T, U, list(range(zeros, len(S))))
    return [(T[:zeros, :zeros], basis @ U[:, :zeros], share), (block, basis @ others, share)]


def _scales(A: Array) -> Array:
    """Units for the states in which the entries are of a size. What may be rounding is not scaled up."""
    size = np.abs(A)
    least = np.maximum(1e-11 * size.max(axis=1, keepdims=True), FLOOR * min(1.0, float(size.max())))
    _, (scale, _) = matrix_balance(np.where(size > least, A, 0.0), permute=False, separate=True)
    return np.asarray(scale, np.float64)


def _pairs(T: Array) -> NDArray[np.int64]:
    """Of a real Schur form: each eigenvalue's place -> that of its conjugate."""
    partner = np.arange(len(T))
    for i in np.flatnonzero(np.diag(T, -1)):
        partner[i], partner[i + 1] = i + 1, i
    return partner


def _first(T: Complex, Z: Complex, members: list[int]) -> tuple[Complex, Complex, float]:
    """With these eigenvalues first: their block, a basis of their subspace, 1 / their projector's norm."""
    chosen = np.zeros(len(T), np.int32)
    chosen[members] = 1
    T, Z, _, size, share, _, info = lapack.ztrsen(chosen, T, Z, job="E", lwork=len(T) ** 2)
    assert info == 0
    return T[:size, :size], Z[:, :size], max(float(share), float(np.finfo(float).eps))


def _joined(T: Complex, a: complex, b: complex, uncertain: float) -> bool:
    """Whether a change of the matrix by `uncertain` can make the two eigenvalues one."""
    return all(
        np.linalg.svd(T - (a + share * (b - a)) * np.eye(len(T)), compute_uv=False)[-1] <= uncertain
        for share in BETWEEN
    )


def _clusters(T: Complex, partner: NDArray[np.int64], uncertain: float) -> list[list[int]]:
    """Places of eigenvalues that are one, along the shortest tree between those of the upper half plane.

    A pair's halves are one where they meet on the real axis; else the lower ones are left out.
    """
    values = np.diag(T)
    values = np.where(partner == np.arange(len(T)), values.real, 0.5 * (values + values[partner].conj()))
    half = [i for i in range(len(values)) if values[i].imag >= 0]
    group = {half[0]: [half[0]]}
    rest = half[1:]
    while rest:
        _, a, b = min((abs(values[a] - values[b]), a, b) for a in group for b in rest)
        group[b] = group[a] if _joined(T, values[a], values[b], uncertain) else []
        group[b].append(b)
        rest.remove(b)
    out = []
    for i in sorted(group, key=lambda i: (abs(values[i]), i)):
        members = group[i]
        if i != members[0]:
            continue
        lowest = min(members, key=lambda k: values[k].imag)
        if _joined(T, values[lowest], values[lowest].conjugate(), uncertain):
            members = sorted({*members, *map(int, partner[members])})
        out.append(members)
    return out


def _chains(N: Complex, error: float) -> tuple[tuple[int, ...], Complex]:
    """Of a matrix that is nilpotent but for rounding: lengths of its Jordan chains, and their leads.

    How many chains have a k-th vector is the nullity of what N does to what lies outside its first k - 1
    kernels (the staircase; Kublanovskaya 1966, Golub & Wilkinson 1976).
    """
    counts, _ = _kernels(N, error)
    counts += [1] * (len(N) - sum(counts))  # what a wider error has made one is a chain
    lengths = tuple(sum(count > i for count in counts) for i in range(counts[0]))
    return lengths, _leads(N, counts)


def _kernels(N: Complex, error: float) -> tuple[list[int], Complex]:
    """Growth of the kernels of N, N^2, ... and a unitary matrix whose columns are in this order."""
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


def _leads(N: Complex, counts: list[int]) -> Complex:
    """Orthonormal eigenvectors, one for each chain, longest first: N^(k-1) of the kernel of N^k."""
    leads = np.zeros((len(N), 0), np.complex128)
    for k in range(len(counts), 0, -1):
        _, _, V = np.linalg.svd(np.linalg.matrix_power(N, k))
        kernel = V[len(N) - sum(counts[:k]) :].conj().T
        image = np.linalg.matrix_power(N, k - 1) @ kernel
        found = np.linalg.svd(image)[0][:, : counts[k - 1]]
        new = counts[k - 1] - leads.shape[1]
        others = found - leads @ (leads.conj().T @ found)
        leads = np.hstack([leads, np.linalg.svd(others)[0][:, :new]])
    return leads
