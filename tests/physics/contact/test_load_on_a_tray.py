# SPDX-License-Identifier: BSD-3-Clause
"""A box slides on the thin coupler of a parallelogram linkage and is thrown off it, with located contacts."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
import warned
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import gelenk

from .test_contacts_of_mechanisms import G, tray

type Array = NDArray[np.float64]
type Torque = Callable[[float], float]

# Of the scene, in SI units; the tray does not turn, so that its moment of inertia has no part.
LENGTH, ARM, ARM_INERTIA, TRAY, LOAD, FRICTION = 0.4, 0.5, 7e-3, 1.0, 0.4, 0.3
ARM_ABOUT_PIVOT = ARM_INERTIA + ARM * 0.2**2
HEIGHT = 0.06  # m: of the load's center above that of the tray


def rates(y: Array, tau: float, sliding: float) -> tuple[Array, float]:
    """Derivatives of (angle, its rate, place and speed of the load along the tray), and the normal force.

    sliding: sign of the relative speed. The load is carried in translation; both are in one plane.
    """
    phi, w, _, speed = y
    along, up = LENGTH * np.array([-np.sin(phi), np.cos(phi)])  # of the tray, by angle
    inertia = 2 * ARM_ABOUT_PIVOT + TRAY * LENGTH**2
    # N = m (up a - L sin(phi) w2 + g) with the angular acceleration a; friction is -sliding mu N on the load.
    lever = up - sliding * FRICTION * along  # of N about the pivots, against the motion
    falling = -LENGTH * np.sin(phi) * w**2 + G
    torque = tau - G * np.cos(phi) * (2 * ARM * 0.2 + TRAY * LENGTH)
    a = (torque - lever * LOAD * falling) / (inertia + lever * LOAD * up)
    normal = LOAD * (up * a + falling)
    carried = along * a - LENGTH * np.cos(phi) * w**2
    return np.array([w, a, speed, -sliding * FRICTION * normal / LOAD - carried]), normal


def flying(y: Array, tau: float) -> Array:
    """Derivatives of (angle, its rate, x, z, their rates) after the load has left; x and z in the world."""
    phi, w = y[:2]
    inertia = 2 * ARM_ABOUT_PIVOT + TRAY * LENGTH**2
    a = (tau - G * np.cos(phi) * (2 * ARM * 0.2 + TRAY * LENGTH)) / inertia
    return np.array([w, a, y[4], y[5], 0.0, -G])


def thrown_off(end: float) -> tuple[Array, float]:
    """Angle, and place of the load on the tray, at the end; and the time at which it leaves. No torque."""

    def normal(_: float, y: Array) -> float:
        return rates(y, 0.0, -1.0)[1]

    normal.terminal = True  # type: ignore[attr-defined]
    start = np.array([pi / 3, 0, 0.25, 0])
    slides = solve_ivp(
        lambda _, y: rates(y, 0.0, -1.0)[0],
        (0, end),
        start,
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
        events=normal,
    )
    assert slides.y[3, 1:].max() < 0  # slides back all the way
    phi, w, x, speed = slides.y[:, -1]
    left = slides.t[-1]
    tray_at = LENGTH * np.array([np.cos(phi), np.sin(phi)])
    tray_v = LENGTH * w * np.array([-np.sin(phi), np.cos(phi)])
    free = [phi, w, tray_at[0] + x, tray_at[1] + HEIGHT, tray_v[0] + speed, tray_v[1]]
    flies = solve_ivp(lambda _, y: flying(y, 0.0), (left, end), free, method="DOP853", rtol=1e-13, atol=1e-14)
    phi, _, x, z = flies.y[:4, -1]
    return np.array([phi, x - LENGTH * np.cos(phi), z - LENGTH * np.sin(phi)]), left


def still_tray(integrator: str, tolerance: float) -> gelenk.Scene:
    scene = tray()
    scene["joints"]["D"]["start"] = {"phi": pi / 3}
    scene["joints"]["B"]["start"] = {"phi": -pi / 3}
    scene["solver"] = {"integrator": integrator}
    scene["experiment"]["tolerance"] = tolerance
    return gelenk.load(scene)


@warned.TIGHT
@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "dirk"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_a_load_slides_on_a_falling_tray_and_leaves(integrator: str, tolerance: float) -> None:
    """The corners of the load touch the upper face alone, although the lower one is nearer than any side."""
    exact, left = thrown_off(0.4)
    run = gelenk.simulate(
        still_tray(integrator, tolerance),
        stop=0.4,
        step=0.1,
        outputs=["A.phi", "L.r[1]", "L.r[3]", "grip.mode"],
    )
    found = [run["A.phi"][-1], run["L.r[1]"][-1], run["L.r[3]"][-1]]
    np.testing.assert_allclose(found, exact, rtol=0, atol=100 * tolerance)
    leaves = [t for t, text in run.events if "leaves" in text]
    np.testing.assert_allclose(leaves, left, rtol=0, atol=100 * tolerance)
    assert leaves
    assert run["grip.mode"].tolist() == [2, 2, 2, 0, 0]


@pytest.mark.parametrize("integrator", ["auto", "erk"])
def test_a_shaken_load_never_sinks_into_the_tray(integrator: str) -> None:
    """It slides, sticks, leaves and lands, for a second; what overlaps is rounding."""
    run = gelenk.simulate(
        still_tray(integrator, 1e-8),
        stop=1,
        step=0.002,
        outputs=["grip.gap", "grip.mode"],
        inputs={"drive.tau": lambda t: 5 + 12 * np.sin(20 * t)},
    )
    assert {0, 1, 2} <= set(run["grip.mode"])
    # What counts as touching is 1e-10 m.
    assert run["grip.gap"].min() > -2e-10
