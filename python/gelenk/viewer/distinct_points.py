# SPDX-License-Identifier: BSD-3-Clause
"""Points of which those at the same place count once."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]

SAME = 1e-9  # m: points up to this distance apart are at the same place


class DistinctPoints:
    """Points in a grid of cells of the size SAME, so that a new one is compared with its neighbors only."""

    def __init__(self) -> None:
        self.all: list[Array] = []
        self._cells: dict[tuple[int, ...], list[Array]] = {}

    def add(self, p: Array) -> bool:
        """Add a point, shape (3,) [m], unless there is one at the same place; return whether it was added."""
        cell = tuple(int(x // SAME) for x in p)
        for steps in itertools.product((-1, 0, 1), repeat=3):
            near = tuple(x + step for x, step in zip(cell, steps, strict=True))
            if any(np.linalg.norm(p - other) <= SAME for other in self._cells.get(near, ())):
                return False
        self._cells.setdefault(cell, []).append(p)
        self.all.append(p)
        return True
