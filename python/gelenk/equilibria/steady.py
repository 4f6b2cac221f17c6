# SPDX-License-Identifier: BSD-3-Clause
"""Steady motion: which velocities are constant, and whether they remain constant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import qr

from gelenk.equilibria.pose import LinearizedPose
from gelenk.errors import UsageError
from gelenk.linear.minimal_realization import MinimalRealization
from gelenk.linear.model import EQUILIBRIUM_RATE_TOLERANCE
from gelenk.model.values import number, unknown

SINGULAR_VALUE_RATIO_LIMIT = 1e-8  # relative to the largest; below it, velocities are determined by others
# Rates of velocities and accelerations that are not due to the states, relative to the rate or 1 in own
# units; larger than those that any formulation's closure errors cause.
DRIVEN_RATE_TOLERANCE = 1e-6
DRIFT_ROUNDING_TOLERANCE = (
    1e-10  # of derivatives of accelerations times rates of coordinates: rounding errors
)


def steady_given(steady: Mapping[str, float | None] | Sequence[str] | str) -> dict[str, float | None]:
    """Return velocities by name with their values, None if a value is to be determined.

    Args:
        steady: the argument of `gelenk.equilibrium`.

    Raises:
        UsageError: a value is not a finite number.
    """
    if isinstance(steady, str):
        steady = [steady]
    if not isinstance(steady, Mapping):
        return dict.fromkeys(steady)
    return {name: None if value is None else number(name, value, "real") for name, value in steady.items()}


def constant_speeds(minimal: MinimalRealization, steady: Mapping[str, float | None]) -> list[str]:
    """Return the named velocities, and as many others, which are 0, as determine all remaining ones.

    Args:
        minimal: the plant's derivatives.
        steady: velocities by name, with their values in own units or None.

    Raises:
        UsageError: a name is not a velocity, or the velocities depend on each other.
    """
    known = [name for name in minimal.candidates if not minimal.is_coordinate(name)]
    faults = [unknown(name, "velocity", known) for name in steady if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    free = [name for name in minimal.names if not minimal.is_coordinate(name)]
    n = len(minimal.names) - len(free)
    named = [name for name in steady if not _is_driven(minimal, name, steady[name])]
    rows = np.array([minimal.row(name)[n:] for name in named]).reshape(len(named), len(free))
    _, size, V = np.linalg.svd(rows)
    rank = int((size > SINGULAR_VALUE_RATIO_LIMIT * size.max(initial=0.0)).sum())
    if rank < len(named):
        raise UsageError(
            f"steady: {', '.join(named)} are not independent; {rank} of them determine the others"
        )
    order = qr(V[rank:], pivoting=True, mode="r")[1] if rank < len(free) else []
    return named + [free[int(i)] for i in sorted(order[: len(free) - rank])]


def _is_driven(minimal: MinimalRealization, name: str, value: float | None) -> bool:
    """Whether constraints alone determine this velocity. Raises UsageError if they give it another value."""
    if np.abs(minimal.row(name)).max(initial=0.0) > SINGULAR_VALUE_RATIO_LIMIT:
        return False
    there = minimal.value(name)
    if value is not None and abs(there - value) > SINGULAR_VALUE_RATIO_LIMIT * max(1.0, abs(there)):
        size = minimal.of.size(name)
        raise UsageError(
            f"steady: found {name} = {size * value:g}, but a constraint makes it {size * there:.6g}"
        )
    return True


def advancing(pose: LinearizedPose) -> dict[str, float]:
    """Return the coordinates that change, with their rates in SI units; J.theta[i] for quaternions."""
    minimal = pose.minimal
    speeds = {name: minimal.speed(name) for name in minimal.candidates if minimal.is_coordinate(name)}
    values = {name: (speed, pose.found.values[speed]) for name, speed in speeds.items()}
    return {
        name: pose.in_si(speed, value)
        for name, (speed, value) in values.items()
        if abs(value) > EQUILIBRIUM_RATE_TOLERANCE
    }


def driven_rates(pose: LinearizedPose) -> dict[str, float]:
    """Return velocities and accelerations that prescribed motions cause, in own units.

    Only the parts that do not follow from the states are returned, by the names of velocities and
    accelerations.
    """
    minimal, found = pose.minimal, pose.found
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    out = {}
    for name in minimal.candidates:
        rate = minimal.rate(name)[2]
        own = rate - float(minimal.row(name) @ rates)
        if abs(own) > DRIVEN_RATE_TOLERANCE * max(1.0, abs(rate)):
            out[minimal.speed(name) if minimal.is_coordinate(name) else found.rates[name]] = own
    return out


def acceleration_drift(pose: LinearizedPose) -> tuple[str, float, float]:
    """Return the largest rate of change of an acceleration: its name, the rate, and the bound of rounding
    errors.

    da/dt = (da/dx) dx/dt vanishes in a steady motion, in which nothing depends on the coordinates that
    advance.
    """
    minimal = pose.minimal
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    worst = ("", 0.0, EQUILIBRIUM_RATE_TOLERANCE)
    for name in pose.conditions:
        row = minimal.rate(name)[0]
        found = float(row @ rates)
        bound = EQUILIBRIUM_RATE_TOLERANCE * max(
            1.0, float(np.abs(rates).max())
        ) + DRIFT_ROUNDING_TOLERANCE * float(np.abs(row * rates).sum())
        bound += DRIFT_ROUNDING_TOLERANCE * float(np.abs(row).max()) * float(np.abs(rates).max())
        if abs(found) / bound > abs(worst[1]) / worst[2]:
            worst = (pose.found.rates[name], found, bound)
    return worst
