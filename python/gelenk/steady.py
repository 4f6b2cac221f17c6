# SPDX-License-Identifier: BSD-3-Clause
"""Steady motion: which speeds stay constant, and whether they do for longer than a moment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import qr

from gelenk.derivatives import Minimal
from gelenk.errors import UsageError
from gelenk.linear import STANDS
from gelenk.rest import Pose
from gelenk.scene import number, unknown

DEPENDENT = 1e-8  # of the largest: singular values below are speeds that others decide
NOISE = 1e-10  # of the slopes of accelerations, times how fast coordinates go on: rounding


def steady_given(steady: Mapping[str, float | None] | Sequence[str] | str) -> dict[str, float | None]:
    """Speeds and their values, None where these are to be found. Raises UsageError."""
    if isinstance(steady, str):
        steady = [steady]
    if not isinstance(steady, Mapping):
        return dict.fromkeys(steady)
    return {name: None if value is None else number(name, value, "real") for name, value in steady.items()}


def constant_speeds(minimal: Minimal, steady: Mapping[str, float | None]) -> list[str]:
    """The named speeds, and as many others as decide all the rest: these are 0.

    Raises:
        UsageError: names of no speeds, or of speeds that cannot be chosen together.
    """
    known = [name for name in minimal.candidates if not minimal.is_coordinate(name)]
    faults = [unknown(name, "speed", known) for name in steady if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    free = [name for name in minimal.names if not minimal.is_coordinate(name)]
    n = len(minimal.names) - len(free)
    named = list(steady)
    rows = np.array([minimal.row(name)[n:] for name in named]).reshape(len(named), len(free))
    _, size, V = np.linalg.svd(rows)
    rank = int((size > DEPENDENT * size.max(initial=0.0)).sum())
    if rank < len(named):
        raise UsageError(
            f"steady: {', '.join(named)} cannot be chosen together, {rank} of them decide the others"
        )
    order = qr(V[rank:], pivoting=True, mode="r")[1] if rank < len(free) else []
    return named + [free[int(i)] for i in sorted(order[: len(free) - rank])]


def advancing(pose: Pose) -> dict[str, float]:
    """Coordinates of joints that do not stay where they are, and their speeds; J.theta[i] of quaternions."""
    minimal = pose.minimal
    speeds = {
        name: pose.found.values[minimal.speed(name)]
        for name in minimal.candidates
        if minimal.is_coordinate(name)
    }
    return {name: speed for name, speed in speeds.items() if abs(speed) > STANDS}


def change(pose: Pose) -> tuple[str, float, float]:
    """How fast the accelerations change as the coordinates go on: the largest, and what may be rounding.

    With dx/dt known, da/dt = (da/dx) dx/dt: 0 in a steady motion, in which nothing depends on what goes on.
    """
    minimal = pose.minimal
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    worst = ("", 0.0, STANDS)
    for name in pose.conditions:
        row = minimal.rate(name)[0]
        found = float(row @ rates)
        bound = STANDS * max(1.0, float(np.abs(rates).max())) + NOISE * float(np.abs(row * rates).sum())
        bound += NOISE * float(np.abs(row).max()) * float(np.abs(rates).max())
        if abs(found) / bound > abs(worst[1]) / worst[2]:
            worst = (pose.found.rates[name], found, bound)
    return worst
