# SPDX-License-Identifier: BSD-3-Clause
"""Kapitza's pendulum: a rod that is stable upright because its pivot oscillates vertically."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Array, Scene, body, frame, joint, scene
from models.driven import Slave, follow, run, sine
from models.running import assert_close
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import gelenk

MASS, REACH, MOMENT = 0.7, 0.15, 2.1e-3  # kg, m to the center of mass, kg m2 about it
# The length of the equivalent point pendulum, m.
LENGTH = (MOMENT + MASS * REACH**2) / (MASS * REACH)
AMPLITUDE, START = 0.01, 0.1  # m, rad from upright
FREQUENCY = 60.0  # Hz: a w / sqrt(2 g l) = 1.9


def pendulum(start: float = START, **motion: Any) -> Scene:
    """The pivot slides along y; phi is the angle of the rod from upright."""
    return scene(
        {"pivot": body(0.3), "rod": body(MASS, (0, REACH, 0), (MOMENT, 0, MOMENT))},
        {
            "slide": joint("prismatic", frame("ground"), frame("pivot"), axis=[0, 1, 0]),
            "hinge": joint(
                "revolute",
                frame("pivot"),
                frame("rod"),
                axis=[0, 0, 1],
                start={"phi": start, "w": 0.0, "fixed": True},
            ),
        },
        name="Kapitza",
        gravity=[0, -GRAVITY, 0],
        constraints={"shake": {"type": "motion", "joint": "slide", **motion}},
    )


TIMES = np.linspace(0, 10, 1001)


def shaken(frequency: float = FREQUENCY, start: float = START) -> Scene:
    return pendulum(start, sine={"amplitude": AMPLITUDE, "frequency": frequency})


def integrate_pendulum(
    lift: Callable[[float], float], start: float, times: Array = TIMES
) -> tuple[Array, Array]:
    """Integrate l phi'' = (g + y'') sin phi, where lift(t) = y'', and return phi,
    phi' at the times (Kapitza 1951).
    """

    def rates(t: float, x: Array) -> list[float]:
        return [x[1], (GRAVITY + lift(t)) * math.sin(x[0]) / LENGTH]

    found = solve_ivp(rates, (0, times[-1]), [start, 0.0], "DOP853", times, rtol=1e-13, atol=1e-14)
    assert found.success
    return found.y[0], found.y[1]


@cache
def reference() -> tuple[Array, Array]:
    law = sine(AMPLITUDE, FREQUENCY)
    return integrate_pendulum(lambda t: law(t)[2], START)


def test_upright_motion_matches_independent_integration() -> None:
    phi, w = reference()
    assert np.abs(phi).max() < 0.25
    found = run(shaken(), TIMES, 1e-10)
    assert_close("hinge.phi", found["hinge.phi"], phi, 1e-8, "requested tolerance")
    assert_close("hinge.w", found["hinge.w"], w, 1e-8, "twenty times the observed error")
    omega = 2 * math.pi * FREQUENCY
    slide = np.array([sine(AMPLITUDE, FREQUENCY)(t)[:3] for t in TIMES]).T
    # Round-off in sin(omega t) at omega t = 4000: about 1e-12.
    for k, name in enumerate(("slide.s", "slide.v", "slide.a")):
        assert_close(name, found[name], slide[k], 1e-12 * AMPLITUDE * omega**k, "relative to the largest")


def test_pivot_force_equals_momentum_balance() -> None:
    """The reaction is sum m (y'' + g), of the pivot and of the center of the rod at y + reach cos phi."""
    found = run(shaken(), TIMES[:200], 1e-10)
    phi, w, a = (found[f"hinge.{q}"] for q in ("phi", "w", "a"))
    lift = found["slide.a"]
    needed = (0.3 + MASS) * (lift + GRAVITY) - MASS * REACH * (np.sin(phi) * a + np.cos(phi) * w**2)
    assert_close("shake.f", found["shake.f"], needed, 1e-9, "round-off of 1700 N")


@pytest.mark.parametrize("kind", ["position", "speed"])
def test_motion_from_an_input_with_derivatives(kind: str) -> None:
    """Taylor polynomials of order 5 over 0.2 ms: omega H = 0.075."""
    name, derived = {"position": ("shake.s_ref", 0), "speed": ("shake.v_ref", 1)}[kind]
    law = sine(AMPLITUDE, FREQUENCY, derived=derived)
    found = follow(pendulum(input=kind), {name: law}, 50_000, 2e-4, 1e-10)
    assert_close("hinge.phi", found["hinge.phi"][::50], reference()[0], 1e-8, "requested tolerance")


def test_motion_from_an_fmu_input_with_derivatives(tmp_path: Path) -> None:
    fmu = gelenk.export_fmu(gelenk.load(pendulum(input="position")), tmp_path / "Kapitza.fmu")
    slave = Slave(fmu, tmp_path / "unpacked")
    law = sine(AMPLITUDE, FREQUENCY)
    slave.start(1e-10, {"shake.s_ref": law(0.0)})
    size, rows = 2e-4, [slave.get("hinge.phi")[0]]
    for k in range(50_000):
        slave.give("shake.s_ref", law(k * size))
        slave.fmi.doStep(k * size, size)
        if k % 50 == 49:
            rows.append(slave.get("hinge.phi")[0])
    slave.free()
    assert_close("hinge.phi", rows, reference()[0], 1e-8, "requested tolerance")


@pytest.mark.thorough
def test_motion_from_a_periodic_table() -> None:
    """The table has 24 points per period; y'' is linear between them."""
    period = 1 / FREQUENCY
    time = np.linspace(0, period, 25)
    value = AMPLITUDE * np.sin(2 * np.pi * np.arange(25) / 24)
    value[-1] = value[0]
    lift = CubicSpline(time, value, bc_type="periodic")(time, 2)
    found = run(
        pendulum(table={"time": time.tolist(), "value": value.tolist(), "periodic": True}), TIMES[:101], 1e-10
    )
    phi, _ = integrate_pendulum(lambda t: float(np.interp(t % period, time, lift)), START, TIMES[:101])
    assert_close(
        "hinge.phi", found["hinge.phi"], phi, 1e-8, "kinks at each point, which both integrations step across"
    )


def stability_limit() -> float:
    """Return the frequency at which the Floquet multipliers of small oscillations become real, Hz."""

    def spare(frequency: float) -> float:
        law = sine(AMPLITUDE, frequency)

        def rates(t: float, x: Array) -> Array:
            pull = (GRAVITY + law(t)[2]) / LENGTH
            return np.array([x[2], x[3], pull * x[0], pull * x[1]])

        turn = solve_ivp(rates, (0, 1 / frequency), [1, 0, 0, 1], "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        return float(turn[0] + turn[3] - 2)

    return float(brentq(spare, 20.0, 45.0, xtol=1e-9))


def test_pendulum_falls_below_the_stability_limit() -> None:
    """The upright position is stable while a omega > sqrt(2 g l) for the averaged motion; this agrees with
    Floquet's bound within one percent.
    """
    averaged = math.sqrt(2 * GRAVITY * LENGTH) / (2 * math.pi * AMPLITUDE)
    sharp = stability_limit()
    assert sharp == pytest.approx(averaged, rel=0.02)  # some a / l squared
    times = np.linspace(0, 10, 501)
    above = run(shaken(1.01 * sharp, 1e-3), times, 1e-9)["hinge.phi"]
    below = run(shaken(0.99 * sharp, 1e-3), times, 1e-9)["hinge.phi"]
    assert np.abs(above).max() < 0.02
    assert np.abs(below).max() > 1.0
