# SPDX-License-Identifier: BSD-3-Clause
"""Forces and torques as arrows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

type Array = NDArray[np.float64]


@dataclass(frozen=True)
class Arrow:
    """A force or a torque over time.

    Attributes:
        name: of the element that exerts it.
        kind: "load": forces and motors of the scene; "reaction": of a joint; "contact".
        unit: "N" or "N.m".
        body: in whose frame the points are.
        points: where it acts [m], shape (3,), or (frames, 3) if it moves in the body.
        vectors: in the world [unit], shape (frames, 3).
    """

    name: str
    kind: Literal["load", "reaction", "contact"]
    unit: Literal["N", "N.m"]
    body: str
    points: Array
    vectors: Array
