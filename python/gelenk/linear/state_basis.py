# SPDX-License-Identifier: BSD-3-Clause
"""Changes of the states of a linear model: to a complete set, or to fewer states that depend on no others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg

from gelenk.errors import UsageError
from gelenk.linear.minimal_realization import DEPENDENCY_TOLERANCE, Array, MinimalRealization

# Smallest singular value of the transformation between states, relative to the largest; the limit of the
# core.
SINGULAR_VALUE_RATIO_LIMIT = 1e-8


def completed(minimal: MinimalRealization, states: Sequence[str]) -> list[str]:
    """Complete a set of states with states of the plant, which are appended."""
    n = len(minimal.names)
    if len(states) == n:
        return list(states)
    T = np.array([minimal.row(state) for state in states])
    open_directions = scipy.linalg.null_space(T)
    _, _, order = scipy.linalg.qr(open_directions.T, pivoting=True)
    return [*states, *(minimal.names[i] for i in sorted(order[: n - len(states)]))]


def transformed(minimal: MinimalRealization, states: Sequence[str], time: float) -> tuple[Array, Array]:
    """Return the Jacobians of the states' rates and of all readings with respect to a complete set of states.

    Args:
        minimal: derivatives with respect to the plant's own minimal states.
        states: names of as many states.
        time: time of the operating point [s], for messages.

    Returns:
        tuple[Array, Array]: shapes (states, states) and (readings, states).

    Raises:
        UsageError: the states do not determine the others at the operating point.
    """
    n = len(states)
    by_x = np.array([minimal.rate(state)[0] for state in states]).reshape(n, n)
    if tuple(states) == minimal.names:
        return by_x, minimal.C
    T = np.array([minimal.row(state) for state in states])
    size = np.linalg.svd(T, compute_uv=False)
    # 1 is the derivative of a state of the plant with respect to itself.
    if size[-1] < SINGULAR_VALUE_RATIO_LIMIT * max(size[0], 1.0):
        raise UsageError(
            f"t = {time:g} s: the states {', '.join(states)} do not determine the others here (a loop is at "
            "a dead center for them), so that derivatives with respect to them do not exist"
        )
    return np.linalg.solve(T.T, by_x.T).T, np.linalg.solve(T.T, minimal.C.T).T


def dependencies(rows: Array, names: Sequence[str], kept: int, states: Sequence[str]) -> list[str]:
    """Return a message for each row that depends on states after the first `kept`: "der(x) depends on y".

    Args:
        rows: derivatives with respect to all states, shape (names, states).
        names: names of the rows.
        kept: number of states that may occur.
        states: names of all states.
    """
    out = []
    for name, row in zip(names, rows, strict=True):
        size = max(1.0, np.abs(row).max(initial=0.0))
        by = [states[k] for k in range(kept, len(states)) if abs(row[k]) > DEPENDENCY_TOLERANCE * size]
        if by:
            out.append(f"{name} depends on {', '.join(by)}")
    return out
