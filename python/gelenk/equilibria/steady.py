# SPDX-License-Identifier: BSD-3-Clause
"""Steady motion: which velocities are constant, and whether they remain constant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import qr

from gelenk.errors import EquilibriumError, UsageError
from gelenk.linear.minimal_realization import MinimalRealization, check_complete
from gelenk.linear.model import EQUILIBRIUM_RATE_TOLERANCE
from gelenk.model.values import number, unknown
from gelenk.simulation.plant import Plant

SINGULAR_VALUE_RATIO_LIMIT = 1e-8  # relative to the largest; below it, velocities are determined by others
# Rates of velocities and accelerations that are not due to the states, relative to the rate or 1 in own
# units; larger than those that any formulation's closure errors cause.
DRIVEN_RATE_TOLERANCE = 1e-6
DRIFT_ROUNDING_TOLERANCE = (
    1e-10  # of derivatives of accelerations times rates of coordinates: rounding errors
)
# Largest driven velocity or acceleration after a communication step, in own units; rounding leaves less than
# 1e-9.
STEADY_TOLERANCE = 1e-6


def realization(plant: Plant, friction: str = "present") -> MinimalRealization:
    """Return the derivatives at the present state of a plant, in the mechanism's own units.

    Args:
        plant: the plant.
        friction: what joints with dry friction do, see `gelenk.linearize`.

    Raises:
        GelenkError: the plant's states do not determine its motion.
        UsageError: the configuration is singular.
    """
    minimal = MinimalRealization(plant.derivatives((), friction).in_own_units())
    check_complete(minimal)
    return minimal


def constant_speeds(
    minimal: MinimalRealization, steady: Mapping[str, float | None] | Sequence[str] | str
) -> dict[str, float | None]:
    """Return the named velocities, and as many others, which are 0, as determine all remaining ones.

    Args:
        minimal: the plant's derivatives.
        steady: the argument of `gelenk.equilibrium`.

    Returns:
        Velocities by name with their values [rad/s, m/s], None if a value is to be determined.

    Raises:
        UsageError: a name is not a velocity, a value is not a finite number, or the velocities depend on each
            other.
    """
    if isinstance(steady, str):
        steady = [steady]
    if not isinstance(steady, Mapping):
        steady = dict.fromkeys(steady)
    given = {name: None if value is None else number(name, value, "real") for name, value in steady.items()}
    known = [name for name in minimal.candidates if minimal.is_velocity(name)]
    faults = [unknown(name, "velocity", known) for name in given if name not in known]
    if faults:
        raise UsageError("\n".join(faults))
    free = [name for name in minimal.names if minimal.is_velocity(name)]
    columns = [minimal.names.index(name) for name in free]
    named = [name for name in given if not _is_driven(minimal, name, given[name])]
    rows = np.array([minimal.row(name)[columns] for name in named]).reshape(len(named), len(free))
    _, size, V = np.linalg.svd(rows)
    rank = int((size > SINGULAR_VALUE_RATIO_LIMIT * size.max(initial=0.0)).sum())
    if rank < len(named):
        raise UsageError(
            f"steady: {', '.join(named)} are not independent; {rank} of them determine the others"
        )
    order = qr(V[rank:], pivoting=True, mode="r")[1] if rank < len(free) else []
    others = [free[int(i)] for i in sorted(order[: len(free) - rank])]
    return {name: given[name] for name in named} | dict.fromkeys(others, 0.0)


def _is_driven(minimal: MinimalRealization, name: str, value: float | None) -> bool:
    """Whether constraints alone determine this velocity. Raises UsageError if they give it another value."""
    if np.abs(minimal.row(name)).max(initial=0.0) > SINGULAR_VALUE_RATIO_LIMIT:
        return False
    size = minimal.of.size(name)
    there = minimal.value(name)
    if value is not None and abs(there - value / size) > SINGULAR_VALUE_RATIO_LIMIT * max(1.0, abs(there)):
        raise UsageError(f"steady: found {name} = {value:g}, but a constraint makes it {size * there:.6g}")
    return True


def advancing(minimal: MinimalRealization) -> dict[str, float]:
    """Return the coordinates that change, with their rates in SI units; J.theta[i] for quaternions."""
    speeds = {name: minimal.speed(name) for name in minimal.candidates if minimal.is_coordinate(name)}
    values = {name: (speed, minimal.of.values[speed]) for name, speed in speeds.items()}
    return {
        name: value * minimal.of.size(speed)
        for name, (speed, value) in values.items()
        if abs(value) > EQUILIBRIUM_RATE_TOLERANCE
    }


def check_steady(minimal: MinimalRealization, conditions: Sequence[str]) -> None:
    """Check that accelerations do not change as coordinates advance.

    Args:
        minimal: the plant's derivatives in the motion.
        conditions: the velocities that are constant.

    Raises:
        EquilibriumError: one changes.
    """
    name, found, bound = _acceleration_drift(minimal, conditions)
    coordinates = list(advancing(minimal))
    if coordinates and abs(found) > bound:
        rate = found * minimal.of.size(name) / minimal.of.scales.time
        raise EquilibriumError(
            f"the motion does not remain steady: {name} changes at {rate:.6g} "
            f"{minimal.of.units.get(name, '1')} per second as {', '.join(coordinates)} "
            f"advance{'s' if len(coordinates) == 1 else ''}"
        )


def _acceleration_drift(minimal: MinimalRealization, conditions: Sequence[str]) -> tuple[str, float, float]:
    """Return the largest rate of change of an acceleration: its name, the rate, and the bound of rounding
    errors.

    da/dt = (da/dx) dx/dt vanishes in a steady motion, in which nothing depends on the coordinates that
    advance.
    """
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    worst = ("", 0.0, EQUILIBRIUM_RATE_TOLERANCE)
    for name in conditions:
        row = minimal.rate(name)[0]
        found = float(row @ rates)
        bound = EQUILIBRIUM_RATE_TOLERANCE * max(
            1.0, float(np.abs(rates).max())
        ) + DRIFT_ROUNDING_TOLERANCE * float(np.abs(row * rates).sum())
        bound += DRIFT_ROUNDING_TOLERANCE * float(np.abs(row).max()) * float(np.abs(rates).max())
        if abs(found) / bound > abs(worst[1]) / worst[2]:
            worst = (minimal.of.rates[name], found, bound)
    return worst


def check_prescribed_motions(plant: Plant, minimal: MinimalRealization, conditions: Sequence[str]) -> None:
    """Check that prescribed motions cause no accelerations, now and one communication step later.

    Args:
        plant: the plant in the motion; it is advanced by a step.
        minimal: its derivatives there.
        conditions: the velocities that are constant.

    Raises:
        EquilibriumError: they do.
    """
    if not _driven_rates(minimal):
        return
    _check_driven_rates(minimal, conditions, "")
    plant.advance(0.0, plant.step)
    _check_driven_rates(realization(plant), conditions, f", {plant.step:g} s later")


def _driven_rates(minimal: MinimalRealization) -> dict[str, float]:
    """Return velocities and accelerations that prescribed motions cause, in own units.

    Only the parts that do not follow from the states are returned, by the names of velocities and
    accelerations.
    """
    rates = np.array([minimal.rate(name)[2] for name in minimal.names])
    out = {}
    for name in minimal.candidates:
        rate = minimal.rate(name)[2]
        own = rate - float(minimal.row(name) @ rates)
        if abs(own) > DRIVEN_RATE_TOLERANCE * max(1.0, abs(rate)):
            out[minimal.speed(name) if minimal.is_coordinate(name) else minimal.of.rates[name]] = own
    return out


def _check_driven_rates(minimal: MinimalRealization, conditions: Sequence[str], when: str) -> None:
    found = minimal.of
    accelerations = {name: a for name, a in _driven_rates(minimal).items() if name not in found.rates}
    residual = {found.rates[name]: minimal.rate(name)[2] for name in conditions}
    largest = max(residual, key=lambda name: abs(residual[name]), default="")
    for name, a in (accelerations | {largest: residual.get(largest, 0.0)}).items():
        if abs(a) > STEADY_TOLERANCE:
            raise EquilibriumError(
                f"no steady motion: a prescribed motion causes {name} = {a * found.size(name):.6g} "
                f"{found.units.get(name, '1')}{when}"
            )
