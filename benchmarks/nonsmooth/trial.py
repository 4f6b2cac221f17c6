# SPDX-License-Identifier: BSD-3-Clause
"""What a trial of the failure map is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from benchmarks.nonsmooth.problems import Scene, at, exactly, joint

Signals = Mapping[str, Sequence[float]]


@dataclass(frozen=True)
class Trial:
    """A scene with its inputs and its exact solution."""

    family: str
    row: str
    column: str
    scene: Scene
    times: Sequence[float]  # s
    exact: Signals  # by output, at the times
    events: float = math.nan  # NaN: not unique
    forces: Sequence[float] = ()  # of the input `force`, until each of the times
    force: str = ""
    bound: float = 1.0  # the scale of its positions and speeds [m, rad; m/s, rad/s]
    slopes: Sequence[float] = ()  # rates of the input, if it does not only jump
    refused: bool = False  # there is no motion, or more than one

    @property
    def name(self) -> str:
        """All its labels."""
        return f"{self.family}: {self.row}, {self.column}"


def grid(stop: float, count: int = 20) -> list[float]:
    return [stop * (k + 1) / count for k in range(count)]


def wheel(x: float, v: float, inertia: float = 0.5, **fields: object) -> Scene:
    """Return a wheel with a motor about a fixed axis."""
    start = exactly(phi=x, w=v)
    return {
        "gelenk": 1,
        "name": "wheel",
        "bodies": {"wheel": {"mass": 1.0, "inertia": [0, 0, inertia]}},
        "joints": {"J": joint("revolute", at("ground"), "wheel", [0, 0, 1], start=start, **fields)},
        "motors": {"drive": {"joint": "J"}},
    }


def coordinate(found: Sequence[tuple[float, float]], position: str = "J.phi", speed: str = "J.w") -> Signals:
    return {position: [x for x, _ in found], speed: [v for _, v in found]}
