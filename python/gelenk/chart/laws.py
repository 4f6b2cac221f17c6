# SPDX-License-Identifier: BSD-3-Clause
"""Test cases with laws by expressions and states of elements; none of their solutions comes from a run."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ellipj

from gelenk.chart.case import SAMPLES, Array, Case
from gelenk.chart.mechanisms import Scene, body, hinge, scene, slide
from gelenk.chart.quadrature import monotonic_motion

LINEAR, CUBIC, PULLED = 100.0, 1000.0, 0.5  # N/m, N/m3, m
# Gas spring: mass of the piston [kg], length of the gas at the pressure of the surroundings [m], force of
# that pressure [N], adiabatic exponent, length at the start [m]
PISTON, LENGTH, OUTSIDE, KAPPA, PRESSED = 2.0, 0.1, 200.0, 1.4, 0.02
MOTOR = {"R": 1.2, "L": 0.05, "k": 0.4, "d": 0.02}  # Ohm, H, N.m/A, N.m.s/rad
ROTOR = 0.5  # kg m²
CONTROLLER = {"kp": 4.0, "ki": 8.0, "tracking": 0.1, "most": 24.0}  # V.s/rad, V/rad, V.s/rad, V
TARGET, RATE = 8.0, 3.0  # rad/s: amplitude and angular frequency of the speed that is wanted
SCAN = 1e-3  # s; the limit is reached and left within tenths of a second


def duffing() -> Scene:
    """Return a mass of 1 kg on a hardening spring: s'' = -100 s - 1000 s³."""
    spring = {"law": {"effort": f"-{LINEAR}*s - {CUBIC}*s^3"}, "start": {"s": PULLED, "fixed": True}}
    return scene({"mass": body(1.0)}, {"S": slide("ground", "mass", **spring)})


def duffing_truth(times: Array) -> dict[str, Array]:
    """Return s = s0 cn(w t | m) (Abramowitz & Stegun 1964, 16.16), released from rest at s0."""
    omega = math.sqrt(LINEAR + CUBIC * PULLED**2)
    sn, cn, dn, _ = ellipj(omega * times, CUBIC * PULLED**2 / (2 * omega**2))
    return {"S.s": PULLED * cn, "S.v": -PULLED * omega * sn * dn}


def gas_spring() -> Scene:
    """Return a piston on enclosed gas, p V^1.4 = const, compressed to a fifth of its volume."""
    law = {"effort": "p0A*((l0/(l0 + s))^1.4 - 1)"}
    start = {"s": PRESSED - LENGTH, "fixed": True}
    return scene(
        {"piston": body(PISTON)},
        {"rod": slide("ground", "piston", law=law, start=start)},
        constants={"p0A": OUTSIDE, "l0": LENGTH},
    )


def _gas_energy(begin: Array | float, way: Array | float) -> Array:
    """Return V(begin + way) - V(begin) [J] by lengths of the gas [m], without cancellation for small ways.

    V = F0 (x + l0/(kappa - 1) (l0/x)^(kappa - 1)).
    """
    n = KAPPA - 1
    growth = np.expm1(-n * np.log1p(way / begin))
    found: Array = OUTSIDE * (way + LENGTH / n * (LENGTH / begin) ** n * growth)
    return found


def gas_spring_truth(times: Array) -> dict[str, Array]:
    """Return the motion between its two turning points, by quadrature of the energy.

    The length is PRESSED + 2 a sin²(psi/2), where psi grows; the energy is that beyond the nearer turning
    point, where the speed vanishes.
    """
    a = brentq(lambda a: float(_gas_energy(PRESSED, 2 * a)), LENGTH, 100 * LENGTH, xtol=1e-18, rtol=1e-15)
    far = PRESSED + 2 * a

    def slowness(psi: Array) -> Array:
        passed, left = (np.maximum(f(psi / 2) ** 2, 1e-60) for f in (np.sin, np.cos))
        spare = -np.where(
            passed < left, _gas_energy(PRESSED, 2 * a * passed), _gas_energy(far, -2 * a * left)
        )
        found: Array = 2 * a * np.sqrt(passed * left * PISTON / (2 * spare))
        return found

    psi = monotonic_motion(slowness, 0.0, times)
    way = 2 * a * np.sin(psi / 2) ** 2
    return {"rod.s": PRESSED - LENGTH + way, "rod.v": a * np.sin(psi) / slowness(psi)}


def speed_drive() -> Scene:
    """Return a DC motor with inductance and a PI controller of its speed, which limits the voltage.

    The integral is led back while the voltage is at its limit. The target oscillates too fast for the motor.
    """
    return scene(
        {"rotor": body(1.0, inertia=(ROTOR, ROTOR, ROTOR))},
        {"axle": hinge("ground", "rotor", law={"effort": "k*i - d*w"})},
        constants={**MOTOR, **CONTROLLER},
        expressions={
            "target": f"{TARGET}*sin({RATE}*t)",
            "wanted": "kp*(target - axle.w) + ki*sum",
            "u": "clip(wanted, -most, most)",
        },
        states={
            "sum": "target - axle.w + (u - wanted)/tracking",
            "i": {"rate": "(u - R*i - k*axle.w)/L", "unit": "A"},
        },
    )


def _drive_rates(side: int) -> tuple[Array, Array]:
    """Return A with z' = A z, and the row of the wanted voltage.

    z = (phi, w, sum, i, target, its rate / RATE, 1).

    Args:
        side: -1, 1: the voltage is at its lower, upper limit; 0: it is the wanted one.
    """
    R, L, k, d = MOTOR.values()
    kp, ki, tracking, most = CONTROLLER.values()
    w, total, i, target, ahead, one = np.eye(7)[1:]
    wanted = kp * (target - w) + ki * total
    voltage = side * most * one if side else wanted
    A = [
        w, (k * i - d * w) / ROTOR, target - w + (voltage - wanted) / tracking, (voltage - R * i - k * w) / L,
        RATE * ahead, -RATE * target, 0 * one,
    ]  # fmt: skip
    return np.array(A), wanted


def drive_pieces(stop: float) -> Iterator[tuple[float, float, Array, Array, int]]:
    """Generate the pieces in which the drive is linear: begin, end [s], A, z at the begin, side of the limit.

    At their ends the voltage reaches or leaves its limit.
    """
    t, z, side = 0.0, np.array([0.0, 0, 0, 0, 0, TARGET, 1]), 0
    while t < stop:
        A, wanted = _drive_rates(side)
        length, after = _piece_end(A, wanted, z, side, stop - t)
        yield t, t + length, A, z, side
        z = expm(A * length) @ z
        t, side = t + length, after


def _piece_end(A: Array, wanted: Array, z: Array, side: int, longest: float) -> tuple[float, int]:
    """Return the length of a piece [s] and the side after it."""
    most = CONTROLLER["most"]
    levels = ((side * most, 0),) if side else ((most, 1), (-most, -1))
    step, here, passed = expm(A * SCAN), z, 0.0
    while passed < longest:
        ahead = step @ here
        for level, after in levels:
            before, behind = float(wanted @ here) - level, float(wanted @ ahead) - level
            # A piece begins at a level, up to rounding, and departs from it.
            if before * behind < 0 and abs(before) > 1e-9:
                return passed + _crossing(A, wanted, here, level), after
        here, passed = ahead, passed + SCAN
    return longest, side


def _crossing(A: Array, wanted: Array, z: Array, level: float) -> float:
    """Return when the wanted voltage is at a level that it crosses within the time SCAN [s]."""
    found = brentq(lambda dt: float(wanted @ expm(A * dt) @ z) - level, 0.0, SCAN, xtol=1e-17, rtol=1e-15)
    return float(found)


def speed_drive_truth(times: Array) -> dict[str, Array]:
    """Return the motion of the drive by the exponentials of its linear pieces."""
    states = np.zeros((len(times), 7))
    for begin, end, A, z, _ in drive_pieces(float(times.max()) + SCAN):
        for row in np.flatnonzero((times > begin) & (times <= end)):
            states[row] = expm(A * (times[row] - begin)) @ z
    return dict(zip(("axle.phi", "axle.w", "sum", "i"), states.T[:4], strict=True))


def law_cases() -> list[Case]:
    """Return the cases of this module, with 20 samples each."""
    return [
        Case(
            "duffing", "A mass on a hardening spring, whose force is a law: 15 oscillations.",
            duffing(), 5.0, 5.0 / SAMPLES, truth=duffing_truth,
        ),
        Case(
            "gas-spring", "A piston on enclosed gas, whose force is an adiabatic law, bounces.",
            gas_spring(), 2.0, 2.0 / SAMPLES, truth=gas_spring_truth,
        ),
        Case(
            "speed-drive", "A DC motor with inductance and a PI controller of its speed: two states besides "
            "the motion; the voltage reaches or leaves its limit ten times.",
            speed_drive(), 5.0, 5.0 / SAMPLES, truth=speed_drive_truth,
        ),
    ]  # fmt: skip
