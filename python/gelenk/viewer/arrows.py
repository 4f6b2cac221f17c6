# SPDX-License-Identifier: BSD-3-Clause
"""Forces and torques as arrows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]
type Wrench = tuple[str, str, str, int, list[float]]  # of `_core.wrenches`


@dataclass(frozen=True)
class Arrow:
    """A force or a torque over time.

    Attributes:
        name: of the element that exerts it.
        kind: "load": a force between bodies or along a joint; "reaction": of a joint; "contact".
        unit: "N" or "N.m".
        body: in whose frame the points are.
        points: where it acts [m], shape (3,), or (frames, 3) if it moves in the body.
        vectors: in the world [unit], shape (frames, 3).
    """

    name: str
    kind: str
    unit: str
    body: str
    points: Array
    vectors: Array


def arrows_of(frames: Sequence[Sequence[Wrench]]) -> list[Arrow]:
    """Return the forces and torques that are not 0 in all frames.

    Args:
        frames: what acts on bodies in each frame. What is missing in some, such as a contact, is 0 there.
    """
    tables: dict[Any, Array] = {}
    for k, wrenches in enumerate(frames):
        for *key, numbers in wrenches:
            table = tables.setdefault(tuple(key), np.zeros((len(frames), 9)))
            table[k, :3] = numbers[:3]
            table[k, 3:] += numbers[3:]  # those of one name along a joint act at the same point
    out = []
    for (kind, name, body, _), table in tables.items():
        acting = np.flatnonzero(np.nan_to_num(table[:, 3:]).any(axis=1))
        if not len(acting):
            continue
        # Before it acts, and afterwards, it stays at the next, or last, point.
        points = table[acting[np.searchsorted(acting[1:], range(len(frames)), side="right")], :3]
        if (points == points[0]).all():
            points = points[0]
        vectors = {"N": table[:, 3:6], "N.m": table[:, 6:]}
        out += [Arrow(name, kind, unit, body, points, v) for unit, v in vectors.items() if v.any()]
    return out
