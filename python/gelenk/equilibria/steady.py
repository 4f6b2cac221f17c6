# SPDX-License-Identifier: BSD-3-Clause
"""Steady motion: which speeds stay constant, and whether they do for longer than a moment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import qr

from gelenk.equilibria.rest import Pose
from gelenk.errors import UsageError
from gelenk.linear.minimal import Minimal
from gelenk.linear.model import STANDS
from gelenk.model.values import number, unknown

DEPENDENT = 1e-8  # of the largest: singular values below are speeds that others decide
NOTICED = (
    1e-6  # of speeds and their rates in own units: by more than this loops do not gape, however they are held
)
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
    named = [name for name in steady if not _is_driven(minimal, name, steady[name])]
    rows = np.array([minimal.row(name)[n:] for name in named]).reshape(len(named), len(free))
    _, size, V = np.linalg.svd(rows)
    rank = int((size > DEPENDENT * size.max(initial=0.0)).sum())
    if rank < len(named):
        raise UsageError(
            f"steady: {', '.join(named)} cannot be chosen together, {rank} of them decide the others"
        )
    order = qr(V[rank:], pivoting=True, mode="r")[1] if rank < len(free) else []
    return named + [free[int(i)] for i in sorted(order[: len(free) - rank])]


def _is_driven(minimal: Minimal, name: str, value: float | None) -> bool:
    """Whether constraints alone make this speed what it is. Raises UsageError: and that is another one."""
    if np.abs(minimal.row(name)).max(initial=0.0) > DEPENDENT:
        return False
    there = minimal.value(name)
    if value is not None and abs(there - value) > DEPENDENT * max(1.0, abs(there)):
        size = minimal.of.size(name)
        raise UsageError(
            f"steady: {name} is {size * there:.6g} by a constraint, it cannot be {size * value:g}"
        )
    return True


def advancing(pose: Pose) -> dict[str, float]:
    """Coordinates of joints that do not stay where they are, and their speeds; J.theta[i] of quaternions."""
    minimal = pose.minimal
    speeds = {name: minimal.speed(name) for name in minimal.candidates if minimal.is_coordinate(name)}
    values = {name: (speed, pose.found.values[speed]) for name, speed in speeds.items()}
    return {name: pose.in_si(speed, value) for name, (speed, value) in values.items() if abs(value) > STANDS}


def pushed(pose: Pose) -> dict[str, float]:
    """What goes on by no state, but by a motion that is given as a function of time: rates of coordinates and
    of speeds, by their names, as far as no state tells of them.
    """
    minimal, found = pose.minimal, pose.found
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    out = {}
    for name in minimal.candidates:
        rate = minimal.rate(name)[2]
        own = rate - float(minimal.row(name) @ rates)
        if abs(own) > NOTICED * max(1.0, abs(rate)):
            out[minimal.speed(name) if minimal.is_coordinate(name) else found.rates[name]] = own
    return out


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
