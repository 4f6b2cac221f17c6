# SPDX-License-Identifier: BSD-3-Clause
"""A disc that rolls on a rotating table, which is either driven or free and driven by the disc."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import GRAVITY, Array, Scene
from models.disc import ACROSS, AXIAL, MASS, RADIUS, disc_on_a_table
from models.modelica_truths import quaternion_rate, solved
from models.running import Recording, assert_close, run
from scipy.spatial.transform import Rotation

TIMES = np.linspace(0, 3, 61)
TURNING, MOMENT = 0.7, 0.9  # rad/s, kg m2
MOMENTS = np.diag([ACROSS, AXIAL, ACROSS])
UP = np.array([0, 0, 1.0])
LEAN = Rotation.from_rotvec([0.2, 0, 0])
START = {
    "r": [0.5, 0.1, RADIUS * np.cos(0.2)],
    "rotation": {"axis": [1, 0, 0], "angle": 0.2},
    "w": [0.2, 9.0, 0.4],
}


def on_the_table(moment: float | None) -> Scene:
    return disc_on_a_table(TURNING, moment, START)


def driven_truth(times: Array) -> dict[str, Array]:
    """Newton-Euler equations in the world frame; no slip, v + w x rho = Omega x (r + rho), is differentiated.

    With F = m (dv/dt + g), the moment of the contact force is rho x F: linear in dw/dt.
    """
    omega = TURNING * UP

    def geometry(q: Array, w_body: Array) -> tuple[Array, Array, Array, Array]:
        R = Rotation.from_quat(q).as_matrix()
        w, axis = R @ w_body, R[:, 1]
        d_axis = np.cross(w, axis)
        down = (UP @ axis) * axis - UP
        d_down = (UP @ d_axis) * axis + (UP @ axis) * d_axis
        size = np.linalg.norm(down)
        rho = RADIUS * down / size
        d_rho = RADIUS * (d_down / size - down * (down @ d_down) / size**3)
        return R, w, rho, d_rho

    def center_velocity(r: Array, w: Array, rho: Array) -> Array:
        out: Array = np.cross(omega, r + rho) - np.cross(w, rho)
        return out

    def rates(_t: float, y: Array) -> Array:
        R, w, rho, d_rho = geometry(y[3:7], y[7:])
        v = center_velocity(y[:3], w, rho)
        J = R @ MOMENTS @ R.T
        rest = np.cross(omega, v + d_rho) - np.cross(w, d_rho)  # dv/dt without dw/dt
        K = np.array([[0, -rho[2], rho[1]], [rho[2], 0, -rho[0]], [-rho[1], rho[0], 0]])
        # J dw + w x J w = rho x m (rest + g - dw x rho), and rho x (dw x rho) = -K K dw
        moment = np.cross(rho, MASS * (rest + GRAVITY * UP)) - np.cross(w, J @ w)
        dw = np.linalg.solve(J - MASS * K @ K, moment)
        return np.concatenate([v, quaternion_rate(y[3:7], y[7:]), R.T @ dw])

    y = solved(rates, np.array([*START["r"], *LEAN.as_quat(), *START["w"]]), times)
    return {"free.r": y[:3].T, "free.Q": y[3:7].T, "free.w": y[7:].T}


def test_disc_on_a_driven_table_follows_the_newton_euler_equations() -> None:
    found = run(on_the_table(None), TIMES, tolerance=1e-11)
    expected = driven_truth(TIMES)
    for name in ("free.r", "free.w"):
        assert_close(name, found.vector(name), expected[name], 1e-8, "1000 rtol, of 10 rad/s")
    turn = Rotation.from_quat(found.vector("free.Q")) * Rotation.from_quat(expected["free.Q"]).inv()
    assert_close("turn", turn.magnitude(), 0, 1e-8, "1000 rtol, of 30 rad")
    assert_close("table", found["table.phi"], TURNING * TIMES, 1e-12, "held")


def contact_velocities(found: Recording) -> tuple[Array, Array]:
    """Velocities of the points of disc and table in contact."""
    at = found.vector("tyre.r")
    w = Rotation.from_quat(found.vector("free.Q")).apply(found.vector("free.w"))
    disc = found.vector("hub.v") + np.cross(w, at - found.vector("hub.r"))
    return disc, np.cross(np.outer(found["table.w"], UP), at)


@pytest.mark.parametrize("moment", [None, MOMENT])
def test_disc_does_not_slip_on_the_table(moment: float | None) -> None:
    disc, table = contact_velocities(run(on_the_table(moment), TIMES, tolerance=1e-11))
    assert_close("slip", disc, table, 1e-11, "projected; 3 m/s")


def test_work_of_the_drive_is_the_change_of_energy() -> None:
    """By Simpson's rule over steps of 1 ms: h^4 / 180 times fourth derivatives, about 10 W (10 rad/s)^4."""
    times = np.linspace(0, 1, 1001)
    found = run(on_the_table(None), times, tolerance=1e-11)
    power = found["engine.tau"] * TURNING
    work = (power[:-2:2] + 4 * power[1::2] + power[2::2]).sum() * 1e-3 / 3
    gained = found["energy.total"][-1] - found["energy.total"][0]
    assert abs(gained) > 0.05
    assert_close("work", work, gained, 1e-9, "Simpson's rule")


def test_free_table_is_driven_by_the_disc_and_momentum_and_energy_are_conserved() -> None:
    found = run(on_the_table(MOMENT), TIMES, tolerance=1e-11)
    R = Rotation.from_quat(found.vector("free.Q"))
    spin = R.apply(found.vector("free.w") @ MOMENTS)
    orbit = MASS * np.cross(found.vector("hub.r"), found.vector("hub.v"))
    total = MOMENT * found["table.w"] + (spin + orbit)[:, 2]
    assert_close("momentum about the axis", total, total[0], 1e-9, "100 rtol")
    assert np.ptp(found["energy.total"]) < 1e-9 * abs(found["energy.total"][0])
    assert np.ptp(found["table.w"]) > 0.1
