# SPDX-License-Identifier: BSD-3-Clause
"""States of a plant that closed contacts hold: a minimal set of those that can still change.

Where contacts are closed, a plant projects changes of its states onto those that contacts permit: a change
dx of the states becomes P dx, with a projector P of less than full rank.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

# Entries of a projector, and its singular values, up to this are rounding.
PROJECTION_ROUNDING = 1e-8
# States are taken in the order of the plant as long as they determine the others this well: rests of rows of
# an orthonormal basis, which are at most 1.
GOOD_RESTS = (0.3, 0.1, 0.01, 1e-6)


def holds(projector: Array) -> bool:
    """Whether some states can only change with others. What is locked alone has a zero on the diagonal."""
    diagonal = np.diag(projector)
    is_alone = np.minimum(np.abs(diagonal), np.abs(diagonal - 1)) <= PROJECTION_ROUNDING
    return not (np.all(is_alone) and np.all(np.abs(projector - np.diag(diagonal)) <= PROJECTION_ROUNDING))


def permitted(
    projector: Array, is_coordinate: Sequence[bool], is_element: Sequence[bool]
) -> tuple[Array, Array, Array]:
    """Return bases of the changes of coordinates, velocities and element states that are permitted.

    Args:
        projector: changes of the states by their changes, shape (states, states).
        is_coordinate: which states are coordinates.
        is_element: which are states of elements.

    Returns:
        Three matrices with the changes of all states in columns. Velocities may change with coordinates.
    """
    coordinates = np.flatnonzero(is_coordinate)
    elements = np.flatnonzero(is_element)
    velocities = np.setdiff1d(np.arange(len(projector)), np.concatenate([coordinates, elements]))
    by_coordinates, by_velocities = (
        projector[:, of] @ _range(projector[np.ix_(of, of)]) for of in (coordinates, velocities)
    )
    return by_coordinates, by_velocities, projector[:, elements]


def _range(block: Array) -> Array:
    if block.size == 0:
        return np.zeros((len(block), 0))
    U, sizes, _ = np.linalg.svd(block)
    return np.asarray(U[:, : int(np.sum(sizes > PROJECTION_ROUNDING))])


def unchanged(basis: Array, rows: Sequence[int]) -> Array:
    """Return a basis of those changes with which the states of these rows do not change."""
    if not rows or basis.size == 0:
        return basis
    _, sizes, V = np.linalg.svd(basis[rows])
    return np.asarray(basis @ V[int(np.sum(sizes > PROJECTION_ROUNDING)) :].T)


def independent(
    basis: Array, names: Sequence[str], among: Sequence[str], preferred: Callable[[str], bool]
) -> list[str]:
    """Return as many states as a basis of changes has columns, which determine the others well.

    Args:
        basis: changes of all states, in columns.
        names: names of all states.
        among: the states that can be chosen.
        preferred: which are chosen before others.
    """
    place = {name: i for i, name in enumerate(names)}
    rest = np.linalg.qr(basis)[0] if basis.size else basis
    chosen: list[str] = []
    for least in GOOD_RESTS:
        for name in sorted(among, key=lambda name: not preferred(name)):
            if len(chosen) == basis.shape[1] or name in chosen:
                continue
            row = rest[place[name]]
            size = float(np.linalg.norm(row))
            if size <= least:
                continue
            chosen.append(name)
            rest = rest - np.outer(rest @ row, row) / size**2
    return [name for name in names if name in chosen]
