# SPDX-License-Identifier: BSD-3-Clause
"""Eigenvalues and Jordan chains of matrices that have been made with known ones, and of rounded ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import block_diag

from gelenk.modal.eigenvalues import Cluster, spectrum

Array = NDArray[np.float64]


def chain(value: complex, length: int) -> Array:
    """A real Jordan block, of pairs where the value is not real."""
    ones = np.diag(np.ones(length - 1), 1)
    if not value.imag:
        return value.real * np.eye(length) + ones
    turn = np.array([[value.real, value.imag], [-value.imag, value.real]])
    out: Array = np.kron(np.eye(length), turn) + np.kron(ones, np.eye(2))
    return out


def second_order(K: Array, D: Array | None = None) -> Array:
    """Of q'' = -K q - D q'."""
    n = len(K)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-K, -(np.zeros((n, n)) if D is None else D)]])


def count(found: list[Cluster]) -> int:
    return sum(c.size * (2 if c.value.imag else 1) for c in found)


@pytest.mark.parametrize("seed", range(40))
def test_jordan_chains_are_found_in_other_coordinates(seed: int) -> None:
    """Up to three chains of up to three vectors, equal eigenvalues among them, states of other sizes."""
    rng = np.random.default_rng(seed)
    blocks = []
    for _ in range(rng.integers(1, 4)):
        imag = float(rng.integers(0, 3))
        blocks.append((complex(rng.integers(-2, 2), imag), int(rng.integers(1, 4))))
    J = block_diag(*(chain(value, length) for value, length in blocks))
    T = np.linalg.qr(rng.normal(size=J.shape))[0] * 10.0 ** rng.uniform(-1, 1, len(J))
    A = T @ J @ np.linalg.inv(T)
    found = spectrum(A)
    assert count(found) == len(A)
    # Means of clusters are as good as the matrix: 1e-14 and what T and clusters magnify, found below 1e-9.
    told = sorted((round(c.value.real, 7), round(c.value.imag, 7), n) for c in found for n in c.chain_lengths)
    assert told == sorted((value.real, value.imag, length) for value, length in blocks)
    for cluster in found:
        rest = A @ cluster.vectors - cluster.value * cluster.vectors
        assert np.linalg.norm(rest) < 1e-6 * np.linalg.norm(A) * np.linalg.norm(cluster.vectors)


@pytest.mark.parametrize("noise", [0.0, 1e-17, -1e-15, 3e-14])
def test_a_rigid_body_that_rounding_has_made_a_slow_oscillator_drifts(noise: float) -> None:
    """Eigenvalues as large as 2e-7 each; together they are a double zero."""
    (found,) = spectrum(np.array([[0.0, 1.0], [noise, 0.0]]))
    assert (found.value, found.chain_lengths) == (0, (2,))


@pytest.mark.parametrize("stiffness", [1e-9, -1e-9])
def test_a_weak_spring_is_none_of_it(stiffness: float) -> None:
    found = spectrum(np.array([[0.0, 1.0], [-stiffness, 0.0]]))
    values = sorted(abs(c.value) for c in found)
    assert values == pytest.approx([math.sqrt(1e-9)] * len(values), rel=1e-6)
    assert all(c.value.real == 0 for c in found) == (stiffness > 0)


@pytest.mark.parametrize("damping", [1e-3, 1e-7, 1e-10])
def test_little_damping_of_what_rests_anywhere_is_told_from_a_drift(damping: float) -> None:
    """0 and -d lie next to a double zero, but there are kernels to tell them apart."""
    rest, slow = sorted(spectrum(np.array([[0, 1], [0, -damping]])), key=lambda c: abs(c.value))
    assert (rest.value, rest.chain_lengths) == (0, (1,))
    assert slow.value == pytest.approx(-damping, rel=1e-4)


def test_slow_motion_beside_a_fast_one_keeps_its_digits() -> None:
    """A pendulum with a little damping beside a contact of 1e4 rad/s."""
    found = spectrum(second_order(np.diag([1e8, 9.81]), np.diag([0, 1e-4])))
    slow, fast = sorted((c.value for c in found), key=abs)
    assert slow.real == pytest.approx(-5e-5, rel=1e-3)
    assert slow.imag == pytest.approx(math.sqrt(9.81 - 2.5e-9), rel=1e-9)
    assert fast == pytest.approx(1e4j, rel=1e-12)


def test_units_do_not_decide() -> None:
    """The same in millimeters and milliseconds, kilometers and kiloseconds."""
    A = second_order(np.array([[4.0, 1.0], [0.0, 4.0]]))  # +-2i, of a chain of two
    for mm, ms in ((1.0, 1.0), (1e3, 1e-3), (1e-3, 1e3)):
        scale = np.array([mm, 1, mm / ms, 1 / ms])
        (found,) = spectrum(A * scale[:, None] / scale * ms)
        assert found.chain_lengths == (2,)
        assert found.value == pytest.approx(2j * ms, rel=1e-9)


def test_an_empty_matrix_has_no_eigenvalues() -> None:
    assert spectrum(np.zeros((0, 0))) == []


@pytest.mark.parametrize(("damping", "told"), [(1e-14, False), (1e-13, False), (1e-10, True), (1e-8, True)])
def test_damping_is_told_where_it_is_more_than_rounding(damping: float, told: bool) -> None:
    """The oscillator q'' = -q - 2 d q' has -d +- i sqrt(1 - d2); derivatives are good to 1e-12."""
    (found,) = spectrum(second_order(np.eye(1), np.array([[2 * damping]])))
    assert found.value.imag == pytest.approx(1.0, abs=1e-14)
    assert found.value.real == (pytest.approx(-damping, abs=1e-15) if told else 0.0)
