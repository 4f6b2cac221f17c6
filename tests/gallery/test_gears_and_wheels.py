# SPDX-License-Identifier: BSD-3-Clause
"""Gears and wheels of the gallery: closed-form ratios and motions, published figures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Array
from models.car import BRAKES, CORNERS, car, mass, sliding_friction
from models.disc import steady
from models.whipple import linear_theory
from scipy.integrate import solve_ivp

import gelenk
from gallery.entries import assert_stated, file, ran, source, vectors


def test_gears() -> None:
    """The load sinks with v = V (1 - exp(-t/T)), V and T from the inertia and the brake, seen at the load."""
    run = ran("gears")
    r = 0.15
    mass = 50 + (0.3 + 4**2 * 0.05 + 16**2 * 0.002) / r**2
    brake = 16**2 * 0.1 / r**2
    V, T = 50 * GRAVITY / brake, mass / brake
    np.testing.assert_allclose(run["guide.v"], -V * (1 - np.exp(-run.time / T)), atol=1e-8)  # ten tolerances
    np.testing.assert_allclose(run["rotor_shaft.w"], 16 / r * run["guide.v"], rtol=1e-10, atol=1e-10)
    assert_stated("gears", V, "m/s")


def test_planetary_gear() -> None:
    """Willis 1841: (sun - carrier) / (ring - carrier) = -60/24; the torques are as 24 : 60 : -84."""
    run = ran("planetary_gear")
    carrier = 2 * math.pi / (1 + 60 / 24)
    np.testing.assert_allclose(run["carrier_shaft.w"], carrier, rtol=1e-12)  # rounding
    np.testing.assert_allclose(run["pin1.w"], -24 / 18 * (2 * math.pi - carrier), rtol=1e-12)
    load = 2 * carrier  # N m
    np.testing.assert_allclose(run["drive.tau"], load * 24 / 84, rtol=1e-10)  # sums of a few torques, rounded
    np.testing.assert_allclose(run["brake.tau"], load * 60 / 84, rtol=1e-10)
    for planet in (2, 3):  # redundant meshes: they share alike
        np.testing.assert_allclose(run[f"sun{planet}.tau"], run["sun1.tau"], rtol=1e-9)
    assert_stated("planetary_gear", load * 24 / 84, "N m")


def test_gear_shift() -> None:
    """The engine and all the rest, seen at the second wheel, exchange momentum until their speeds agree."""
    run = gelenk.simulate(file("gear_shift"), inputs={"clutch2.friction.engagement": 0.5})
    ratio = 12 / 14
    rest = ratio**2 * (3 + 0.02 / 0.3**2) + 0.02
    slip, torque = 10 - 3 / ratio, 1.0  # rad/s, N m
    end = slip / (torque * (1 / 0.2 + 1 / rest))
    common = 10 - torque / 0.2 * end
    assert [text for _, text in run.events] == ["clutch2.phi sticks"]
    assert run.events[0][0] == pytest.approx(end, abs=1e-8)
    expected = np.where(run.time < end, 10 - torque / 0.2 * run.time, common)
    np.testing.assert_allclose(run["in.w"], expected, atol=1e-7)  # ten tolerances
    np.testing.assert_allclose(run["out.w"], -ratio * run["wheel2.w"], rtol=1e-12)
    np.testing.assert_allclose(run["clutch1.friction.tau"], 0, atol=0)
    assert_stated("gear_shift", common, "rad/s")


def test_worm_hoist() -> None:
    """Losses of the worm gear brake the load evenly, and hold it at rest, where nothing else does."""
    run = ran("worm_hoist")
    weight, rotor, rest = 50 * 9.81 * 0.1 / 40, 0.02, (0.1 + 50 * 0.1**2) / 40**2  # seen at the worm
    braking = (weight / 0.45 + 0.1) / (rotor + rest / 0.45)
    end = 150 / braking
    assert [text for _, text in run.events] == ["motor.phi sticks"]
    assert run.events[0][0] == pytest.approx(end, abs=1e-8)
    np.testing.assert_allclose(run["motor.w"], np.maximum(150 - braking * run.time, 0), atol=1e-6)
    lifted = 0.1 / 40 * 150 * end / 2
    assert run["lift.s"][-1] == pytest.approx(lifted, abs=1e-8)
    held = run.time > end + 0.02
    assert (run["motor.w"][held] == 0).all()
    np.testing.assert_allclose(run["motor.friction.tau"][held], weight, rtol=1e-12)
    assert_stated("worm_hoist", 1e3 * lifted, "mm")


def strikes_of_the_backlash_drive(stop: float) -> list[float]:
    """Instants at which the table meets a flank, by integration from event to event."""
    rotor, table, half, stiffness, damping = 0.01, 0.03, 0.12, 4.0, 0.08
    strikes: list[float] = []
    t, y, side = 0.0, np.array([0.6, 0.0, 0.6, 0.0]), 0  # phi and w of the rotor, of the table
    while t < stop:
        inertia = rotor if side == 0 else rotor + table

        def rates(_t: float, y: Array, inertia: float = inertia, side: int = side) -> list[float]:
            a = -(stiffness * y[0] + damping * y[1]) / inertia
            return [y[1], a, y[3], a if side else 0.0]

        def ends(now: float, y: Array, side: int = side, start: float = t) -> float:
            # In contact, the flank would have to pull; else, the play is used up, but not where it begins.
            if side:
                return side * rates(0, y)[1]
            return half - abs(y[2] - y[0]) if now > start + 1e-6 else 1.0

        ends.terminal = True  # type: ignore[attr-defined]
        found = solve_ivp(rates, (t, stop), y, "DOP853", events=ends, rtol=1e-12, atol=1e-13, first_step=1e-4)
        t, y = found.t[-1], found.y[:, -1]
        if found.status == 0:
            break
        side = 0 if side else int(np.sign(y[2] - y[0]))
        if side:
            strikes.append(t)
            y[1] = y[3] = (rotor * y[1] + table * y[3]) / (rotor + table)
    return strikes


def test_backlash_drive() -> None:
    """The table strikes when an independent integration says so."""
    strikes = strikes_of_the_backlash_drive(2.0)
    run = ran("backlash_drive")
    found = [t for t, text in run.events if "meets" in text]
    np.testing.assert_allclose(found, strikes, atol=1e-7)  # ten tolerances
    assert len(strikes) == 5
    assert_stated("backlash_drive", strikes[-1], "s")


def test_differential() -> None:
    """In a circle, wheels turn as their distances from its center; the spider shares the torque evenly."""
    run = ran("differential")
    radius = 1.2 / math.tan(0.5)  # of the middle of the rear axle
    ratio = (radius + 0.45) / (radius - 0.45)
    np.testing.assert_allclose(run["right_hub.w"] / run["left_hub.w"], ratio, rtol=1e-10)
    np.testing.assert_allclose(
        2 * run["bearing.w"], run["left_hub.w"] + run["right_hub.w"], rtol=0, atol=1e-10
    )
    # The torques differ by what accelerates the spider about its pin, which also turns with the vehicle.
    yaw, turned = run["ride.w"], run["bearing.phi"]
    rate = run["spider_pin.a"] - run["ride.wd"] * np.sin(turned) - yaw * run["bearing.w"] * np.cos(turned)
    difference = run["right_mesh.tau"] - run["left_mesh.tau"]
    np.testing.assert_allclose(difference, 1e-4 * rate / 0.625, rtol=0, atol=1e-9)  # of 20 N m
    assert_stated("differential", ratio, "")


def test_rolling_disc() -> None:
    """Steady turn: the yaw rate solves a quadratic equation in lean and spin (models/disc.py)."""
    run = ran("rolling_disc")
    turn = steady(-0.4, 6.0)
    np.testing.assert_allclose(run["lean.phi"], -0.4, rtol=0, atol=1e-8)  # 100 tolerances
    np.testing.assert_allclose(run["base.w"], turn.yaw_rate, rtol=1e-8)
    contact = vectors(run, "contact.r")
    radius = 0.3 * 6.0 / turn.yaw_rate  # the contact moves by R times the spin
    np.testing.assert_allclose(
        np.hypot(contact[:, 0], contact[:, 1]), radius, rtol=1e-4
    )  # as the start has it
    assert_stated("rolling_disc", turn.yaw_rate, "rad/s")


# psi, h, theta, l, phi after 6 s for each drag c [N m s]: five coordinates with multipliers, DOP853 at 1e-13.
ROS = {
    0.0: (
        15.275231571044845,
        0.483542816244126,
        -0.010508494666374504,
        1.5634855231721154,
        46.80399512013649,
    ),
    10.0: (12.288303527873085, 1.0511821927051725, 0.3224026250333311, 1.8208946505186998, 37.43308577013671),
}


@pytest.mark.parametrize("c", ROS)
def test_mast_arm_disc(c: float) -> None:
    run = gelenk.simulate(
        file("mast_arm_disc"), parameters={"rolling_drag.damping": c}, tolerance=1e-11, step=0.5
    )
    found = [run[name][-1] for name in ("mast.phi", "mast.s", "hinge.phi", "shaft.s", "shaft.phi")]
    signs = (1, 1, 1, 1, -1)
    for x, sign, value in zip(found, signs, ROS[c], strict=True):
        assert sign * x == pytest.approx(value, abs=1e-9 * max(1.0, abs(value)))  # 100 tolerances
    if c:
        assert_stated("mast_arm_disc", ROS[c][1], "m")


def test_bicycle() -> None:
    """Weave at 5 m/s, by the published matrices of the linear theory."""
    expected = max(np.linalg.eigvals(linear_theory(5.0)), key=lambda s: s.imag)
    found = max(
        gelenk.modes(file("bicycle"), at={"lean.w": 0.0}).modes, key=lambda mode: mode.eigenvalue.imag
    ).eigenvalue
    assert abs(found - expected) < 1e-9  # positions of the scene have 15 digits
    assert_stated("bicycle", -expected.real, "1/s")
    assert_stated("bicycle", expected.imag, "rad/s")


def fastest_growth(M: Any, D: Any, K: Any) -> float:
    """The largest eigenvalue [1/s] of M q'' + D q' + K q = 0."""
    n = len(M)
    A: Array = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    return float(np.linalg.eigvals(A).real.max())


def test_balancing_robot() -> None:
    """Falling from upright: Lagrange's equations of a pendulum on an axle, for its position and pitch."""
    r, h, m = 0.1, 0.3, 8.0
    wheels = 2 * (0.6 + 0.003 / r**2)
    M = [[m + wheels, m * h], [m * h, 0.25 + m * h**2]]
    slip = np.array([1 / r, -1])  # of the hubs: the wheels against the chassis
    rate = fastest_growth(M, 2 * 0.02 * np.outer(slip, slip), [[0, 0], [0, -m * GRAVITY * h]])
    found = max(mode.eigenvalue.real for mode in gelenk.modes(file("balancing_robot")).modes)
    assert found == pytest.approx(rate, rel=1e-9)  # rounding of a block of zeros beside it
    assert_stated("balancing_robot", rate, "1/s")


def test_cart_pole() -> None:
    """Falling from upright: Lagrange's equations for cart and pole."""
    M = [[1.2, 0.2 * 0.3], [0.2 * 0.3, 0.006 + 0.2 * 0.3**2]]
    rate = fastest_growth(M, np.diag([0.1, 0.002]), [[0, 0], [0, -0.2 * GRAVITY * 0.3]])
    found = gelenk.modes(file("cart_pole"), at={"hinge.phi": 0.0})
    assert max(mode.eigenvalue.real for mode in found.modes) == pytest.approx(rate, rel=1e-9)
    assert source("cart_pole")["joints"]["hinge"]["start"]["phi"] == 0.05  # rad: from where it falls
    assert_stated("cart_pole", rate, "1/s")


def test_car() -> None:
    """Locked wheels brake with the Magic Formula at the slip -1, and the air helps."""
    start = {"ride.v_x_start": 65.0} | {f"hub_{corner}.w_start": 65 / 0.3 for corner in CORNERS}
    level = {f"tire_{corner}.bump_height": 0.0 for corner in CORNERS}
    run = gelenk.simulate(
        file("car"), stop=9, parameters=start | level, inputs=dict.fromkeys(BRAKES, 1.0), tolerance=1e-8
    )
    locked = sliding_friction(car()) * GRAVITY
    air = 0.4 * run["ride.v_x"][-1] ** 2 / mass(car())
    assert run["ride.a_x"][-1] == pytest.approx(-locked - air, rel=1e-4)  # its pitching has decayed
    assert_stated("car", locked, "m/s2")
