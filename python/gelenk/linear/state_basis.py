# SPDX-License-Identifier: BSD-3-Clause
"""Other states than the plant's own: as many that determine all, or fewer that nothing else acts on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg

from gelenk.errors import UsageError
from gelenk.linear.minimal import Array, Minimal

DETERMINED = (
    1e-8  # least singular value of what states mean to others, over the largest: the core's own limit
)
NOT_FELT = 1e-10  # an entry of A or C against the largest in its row, or 1: rounding of what vanishes


def completed(minimal: Minimal, states: Sequence[str]) -> list[str]:
    """The states and, behind them, those of the plant's own that make up the rest."""
    n = len(minimal.names)
    if len(states) == n:
        return list(states)
    T = np.array([minimal.row(state) for state in states])
    open_directions = scipy.linalg.null_space(T)
    _, _, order = scipy.linalg.qr(open_directions.T, pivoting=True)
    return [*states, *(minimal.names[i] for i in sorted(order[: n - len(states)]))]


def transformed(minimal: Minimal, states: Sequence[str], time: float) -> tuple[Array, Array]:
    """The slopes of the states' rates, and of all readings, by these states, as many as the mechanism has.

    Raises:
        UsageError: they do not determine the others at the point.
    """
    n = len(states)
    by_x = np.array([minimal.rate(state)[0] for state in states]).reshape(n, n)
    if tuple(states) == minimal.names:
        return by_x, minimal.C
    T = np.array([minimal.row(state) for state in states])
    size = np.linalg.svd(T, compute_uv=False)
    if size[-1] < DETERMINED * max(size[0], 1.0):  # 1: what a state of the plant means to itself
        raise UsageError(
            f"t = {time:g} s: the states {', '.join(states)} do not determine the others here (a loop stands "
            "at a dead centre for them): derivatives by them do not exist there"
        )
    return np.linalg.solve(T.T, by_x.T).T, np.linalg.solve(T.T, minimal.C.T).T


def felt(rows: Array, names: Sequence[str], kept: int, states: Sequence[str]) -> list[str]:
    """Rows, by name, that change with states behind the first `kept`: "der(x) changes with y"."""
    out = []
    for name, row in zip(names, rows, strict=True):
        size = max(1.0, np.abs(row).max(initial=0.0))
        by = [states[k] for k in range(kept, len(states)) if abs(row[k]) > NOT_FELT * size]
        if by:
            out.append(f"{name} changes with {', '.join(by)}")
    return out
