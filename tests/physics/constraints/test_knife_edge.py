# SPDX-License-Identifier: BSD-3-Clause
"""Knife-edge constraints against closed forms, energy and momentum, also on a moving table."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import GRAVITY
from models.running import Recording, assert_close, run
from models.sleighs import (
    MASS,
    MOMENT,
    TABLE_MOMENT,
    chaplygin_sleigh,
    on_a_turntable,
    skate,
    sleigh_truth,
)
from scipy.integrate import solve_ivp

import gelenk

TIMES = np.linspace(0, 4, 81)


def along(found: Recording, phi: str = "floor.phi") -> tuple[np.ndarray, np.ndarray]:
    """Velocities of the blade along and across it, in the plane of its joint."""
    c, s = np.cos(found[phi]), np.sin(found[phi])
    vx, vy = found["floor.v_x"], found["floor.v_y"]
    return c * vx + s * vy, c * vy - s * vx


@pytest.mark.parametrize(("u", "w"), [(-1.0, 0.4), (0.8, 3.0), (-2.0, -0.05)])
def test_chaplygins_sleigh(u: float, w: float) -> None:
    """A sleigh that starts backward turns around and ends forward: closed form, blade force, energy."""
    found = run(chaplygin_sleigh(u, w), TIMES, tolerance=1e-11)
    expected = sleigh_truth(u, w, TIMES)
    ahead, aside = along(found)
    assert_close("u", ahead, expected.pop("u"), 1e-9, "100 rtol")
    assert_close("aside", aside, 0, 1e-12, "projected")
    for name, value in expected.items():
        assert_close(name, found[name], value, 2e-9, "100 rtol, forces of 10 N")
    assert np.ptp(found["energy.total"]) < 1e-9 * found["energy.total"][0]  # 100 rtol


@pytest.mark.parametrize(("slope", "w"), [(0.3, 2.0), (1.2, -5.0)])
def test_skate_on_a_slope_draws_a_cycloid(slope: float, w: float) -> None:
    """It drifts across the slope, not down: Neimark & Fufaev 1972, ch. 2. u = g sin(slope) sin(w t) / w."""
    found = run(skate(slope, w), TIMES, tolerance=1e-11)
    pull = GRAVITY * np.sin(slope)
    angle = w * TIMES
    size = pull / (4 * w**2)
    assert_close("down", found["floor.s_x"], size * (1 - np.cos(2 * angle)), 1e-9, "100 rtol")
    assert_close("along", found["floor.s_y"], size * (2 * angle - np.sin(2 * angle)), 1e-9, "100 rtol")
    assert_close("force", found["blade.f"], 2 * MASS * pull * np.sin(angle), 1e-8, "rtol of 50 N, times 10")
    assert np.ptp(found["energy.total"]) < 1e-9  # J, of 40


def test_skate_on_a_rotating_table() -> None:
    """In the frame of the table: centrifugal force along the blade, Coriolis force across it on the blade."""
    turning = 0.7
    found = run(on_a_turntable(turning, driven=True), TIMES, tolerance=1e-11)

    def rates(_t: float, y: np.ndarray) -> list[float]:
        x, z, phi, u = y
        c, s = np.cos(phi), np.sin(phi)
        return [u * c, u * s, 1.5, turning**2 * (x * c + z * s)]

    y = solve_ivp(rates, (0, 4), [0.4, -0.1, 0.3, 0.5], "DOP853", TIMES, rtol=1e-12, atol=1e-13).y
    for name, value in zip(("floor.s_x", "floor.s_y", "floor.phi"), y[:3], strict=True):
        assert_close(name, found[name], value, 1e-9, "100 rtol")
    ahead, aside = along(found)
    assert_close("u", ahead, y[3], 1e-9, "100 rtol")
    assert_close("aside", aside, 0, 1e-12, "projected")
    # Across the blade: u (w + 2 turning) minus the centrifugal part.
    x, z, phi, u = y
    centrifugal = turning**2 * (z * np.cos(phi) - x * np.sin(phi))
    force = MASS * (u * (1.5 + 2 * turning) - centrifugal)
    assert_close("force", found["blade.f"], force, 1e-8, "1000 rtol, of 6 N")


def test_skate_and_free_table_conserve_their_angular_momentum() -> None:
    found = run(on_a_turntable(0.7, driven=False), TIMES, tolerance=1e-11)
    r, v = found.vector("blade_at.r"), found.vector("blade_at.v")
    spin = found.vector("blade_at.w")[:, 2]
    momentum = TABLE_MOMENT * found["table.w"] + MOMENT * spin + MASS * np.cross(r, v)[:, 2]
    assert_close("momentum", momentum, momentum[0], 1e-9, "100 rtol")
    assert np.ptp(found["energy.total"]) < 1e-9
    assert np.ptp(found["table.w"]) > 0.1  # the blade drives it
    assert_close("aside", along(found)[1], 0, 1e-12, "projected")


def test_states_of_the_sleigh() -> None:
    """Three coordinates, two velocities; stable forward, unstable backward: dw/dt = -m a u w / J."""
    J = MOMENT + MASS * 0.25**2
    for u in (1.0, -1.0):
        model = gelenk.linear.linear_model(chaplygin_sleigh(u, 0.0))
        assert len(model.states) == 5
        poles = sorted(np.linalg.eigvals(model.A), key=abs)
        assert abs(np.array(poles[:4])).max() < 1e-7  # zeros, among them a Jordan block: root of round-off
        assert_close("pole", poles[4].real, -MASS * 0.25 * u / J, 1e-11, "round-off")
