# SPDX-License-Identifier: BSD-3-Clause
"""What can be chosen for a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gelenk.errors import UsageError

LARGEST_SIZE = 4096  # pixels
LARGEST_RATE = 50.0  # 1/s; GIF files count in 1/100 s, and browsers slow down what is faster
SHORTEST, LONGEST = 2.0, 10.0  # s; films of shorter runs are slowed down, of longer ones sped up
SPEEDS = (0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


@dataclass(frozen=True)
class PictureOptions:
    """What can be chosen for a picture.

    Attributes:
        size: width and height [pixels].
        camera: "start", "front", "side", "top", or azimuth and elevation [deg].
        span: first and last time [s]; a still picture shows the first one. None: the whole run.
        frame_rate: of films [1/s].
        speed: of films, relative to real time; None: 1, unless the film would last less than 2 s or more
            than 10 s.
        trails: whether the paths of points are shown.
        time_stamp: whether the time is shown.
        dark: whether the colors are dark.
    """

    size: tuple[int, int]
    camera: str | Sequence[float] = "start"
    span: Sequence[float] | None = None
    frame_rate: float = 20.0
    speed: float | None = None
    trails: bool = False
    time_stamp: bool = False
    dark: bool = False

    def __post_init__(self) -> None:
        if len(self.size) != 2 or not all(16 <= n <= LARGEST_SIZE for n in self.size):
            raise UsageError(
                f"size: found {self.size}, expected width and height from 16 to {LARGEST_SIZE} pixels"
            )
        if not 0 < self.frame_rate <= LARGEST_RATE:
            raise UsageError(
                f"frame_rate: found {self.frame_rate}, expected more than 0, up to {LARGEST_RATE:g} 1/s"
            )
        if self.speed is not None and not (math.isfinite(self.speed) and self.speed > 0):
            raise UsageError(f"speed: found {self.speed}, expected more than 0")

    def span_in(self, first: float, last: float) -> tuple[float, float]:
        """Return the times from which and to which a run is shown [s]. Raises UsageError."""
        if self.span is None:
            return first, last
        if len(self.span) != 2 or not first <= self.span[0] <= self.span[1] <= last:
            raise UsageError(f"span: found {self.span}, expected two times within {first:g} to {last:g} s")
        return float(self.span[0]), float(self.span[1])

    def speed_for(self, duration: float) -> float:
        """Return the speed at which a film of a duration [s] plays."""
        if self.speed is not None:
            return self.speed
        if SHORTEST <= duration <= LONGEST or duration <= 0:
            return 1.0
        fitting = [speed for speed in SPEEDS if SHORTEST <= duration / speed <= LONGEST]
        if not fitting:
            return duration / (SHORTEST if duration < SHORTEST else LONGEST)
        return fitting[-1] if duration < SHORTEST else fitting[0]
