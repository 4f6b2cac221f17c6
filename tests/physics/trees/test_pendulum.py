# SPDX-License-Identifier: BSD-3-Clause
"""Pendulums with one revolute joint under gravity compared with closed-form solutions."""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, HINGE_AXES, Scene, body, frame, joint, matrix, rotation, scene
from models.running import INTEGRATORS, assert_close, run
from scipy.special import ellipj, ellipk

pytestmark = warned.TIGHT

# A compound pendulum: omega0^2 = m g c / (J + m c^2)
MASS, COM, MOMENT = 1.3, 0.37, 0.21  # kg, m, kg m2
OMEGA0 = math.sqrt(MASS * GRAVITY * COM / (MOMENT + MASS * COM**2))  # rad/s


def pendulum(angle: float, rate: float = 0.0, damping: float = 0.0) -> Scene:
    """The pendulum hangs along -y at angle 0 and turns about z."""
    return scene(
        {"bob": body(MASS, (0, -COM, 0), (0.3, 0.25, MOMENT))},
        {
            "P": joint(
                "revolute",
                frame("ground", (0.3, -0.2, 0.7)),
                frame("bob"),
                axis=[0, 0, 1],
                damping=damping,
                start={"phi": angle, "w": rate, "fixed": True},
            )
        },
        gravity=[0, -GRAVITY, 0],
    )


def exact_swing(amplitude: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From rest at `amplitude`: sin(phi/2) = k cd(omega0 t), k = sin(amplitude/2) (Landau & Lifshitz, 11)."""
    k = math.sin(amplitude / 2)
    sn, cn, dn, _ = ellipj(OMEGA0 * times, k * k)
    phi = 2 * np.arcsin(k * cn / dn)
    w = -2 * k * OMEGA0 * math.sqrt(1 - k * k) * sn / dn
    return phi, w


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("amplitude", [1e-3, 0.7, 2.2, 3.1])
def test_motion_matches_elliptic_functions(amplitude: float, integrator: str) -> None:
    """Small and large amplitudes, up to nearly the upright position. Over five seconds errors are about 100
    rtol. From 3.1 rad the way down amplifies an error by 2/(pi - 3.1) = 48, up and down again by 48^2 = 2300.
    """
    times = np.linspace(0, 5, 51)
    found = run(pendulum(amplitude), times, tolerance=1e-11, integrator=integrator)
    phi, w = exact_swing(amplitude, times)
    # where the pendulum passes the bottom, the error of w is omega0^2 times the error in time
    steep = 200 if amplitude > 3 else 3
    assert_close(
        "P.phi", found["P.phi"], phi, steep * 1e-9, "300 rtol; 2300 x 10 rtol near the upright position"
    )
    assert_close("P.w", found["P.w"], w, steep * 5e-9, "omega0 times as much")


def test_pendulum_returns_after_whole_periods() -> None:
    """After three periods 4 K(k)/omega0 the pendulum is at rest where it started:
    the error of phi is of second order only.
    """
    amplitude = 2.0
    period = 4 * ellipk(math.sin(amplitude / 2) ** 2) / OMEGA0
    found = run(pendulum(amplitude), np.array([0, 3 * period]), tolerance=1e-11)
    assert_close("P.phi", found["P.phi"][-1], amplitude, 1e-9, "100 rtol over three periods")
    assert_close("P.w", found["P.w"][-1], 0, 1e-8, "100 rtol x omega0^2")


def test_angle_counts_full_turns() -> None:
    """The initial velocity is large enough for full turns:
    phi exceeds 2 pi and is twice am(t w0/2), the Jacobi amplitude.
    """
    rate = 2.5 * OMEGA0
    times = np.linspace(0, 6, 61)
    m = (2 * OMEGA0 / rate) ** 2
    phi = 2 * ellipj(rate / 2 * times, m)[3]
    found = run(pendulum(0.0, rate), times, tolerance=1e-11)
    assert phi[-1] > 6 * math.pi
    assert_close("P.phi", found["P.phi"], phi, 1e-8, "1000 rtol: errors grow with the turns")


def test_full_turns_in_the_start_angle_do_not_change_the_motion() -> None:
    """The angle a + 2 pi n is the same pose as a. The motion is the same,
    and the count of turns is preserved.
    """
    times = np.linspace(0, 2, 11)
    turns = 2 * math.pi * 7
    near, far = (run(pendulum(0.8 + x), times, tolerance=1e-11)["P.phi"] for x in (0.0, turns))
    assert_close("P.phi", far - turns, near, 1e-9, "rtol of 44 rad")


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "spherical", "universal"])
def test_every_joint_type_that_permits_rotation_gives_the_same_period(kind: str) -> None:
    """Each of these joints acts as a hinge about the normal of the vertical plane;
    its other coordinates remain at rest.
    """
    axes = HINGE_AXES.get(kind, {})
    amplitude, times = 0.7, np.linspace(0, 3, 31)
    source = pendulum(amplitude)
    # the start angle is in the ground frame; the joint itself starts at zero
    R = rotation([0, 0, 1], amplitude)
    source["joints"]["P"] = joint(kind, {**frame("ground"), "rotation": matrix(R)}, frame("bob"), **axes)
    source["sensors"] = {"bob": {"type": "frame", "body": "bob", "position": [0.0, -COM, 0.0]}}
    found = run(source, times, tolerance=1e-11).vector("bob.r")
    phi, _ = exact_swing(amplitude, times)
    expected = COM * np.array([np.sin(phi), -np.cos(phi), 0 * phi]).T
    assert_close(
        "center of mass", found, expected, 1e-8, "300 rtol; axial displacement of a cylinder is zero"
    )


def test_benchmark_pendulum() -> None:
    """IFToMM library A01: 1 kg on a massless rod of 1 m, from rest at (-1, 0), 10 s. Positions are from
    elliptic functions, printed to 12 digits in the collection; that library requires the energy within 5e-5
    J.
    """
    source = scene(
        {"bob": body(1.0, (1, 0, 0))},
        {
            "P": joint(
                "revolute",
                frame("ground"),
                frame("bob"),
                axis=[0, 0, 1],
                start={"phi": math.pi, "fixed": True},
            )
        },
        gravity=[0, -GRAVITY, 0],
        sensors={
            "bob": {"type": "frame", "body": "bob", "position": [1.0, 0, 0]},
            "E": {"type": "energy"},
        },
    )
    found = run(source, [0, 1, 2, 5, 9.99, 10], tolerance=1e-12)
    expected = [
        (-1, 0),
        (0.986291751132, -0.165010853126),
        (-0.793566195343, -0.608483930444),
        (-0.942305435044, -0.334754338414),
        (-0.316436469913, -0.948613704576),
        (-0.275087462576, -0.961419205099),
    ]
    assert_close("bob", found.vector("bob.r")[:, :2], expected, 1e-9, "1000 rtol over 10 s")
    assert_close("energy", found["E.total"], found["E.total"][0], 1e-9, "100 rtol x 10 J")


def test_small_damped_oscillation_matches_linear_oscillator() -> None:
    """Phi'' = -omega0^2 phi - 2 D phi' for small phi. The linearization neglects phi^2/6 relative: 2e-9."""
    amplitude, damping = 1e-4, 0.3
    inertia = MOMENT + MASS * COM**2
    D = damping / (2 * inertia)
    ring = math.sqrt(OMEGA0**2 - D**2)
    times = np.linspace(0, 4, 41)
    expected = amplitude * np.exp(-D * times) * (np.cos(ring * times) + D / ring * np.sin(ring * times))
    found = run(pendulum(amplitude, damping=damping), times, tolerance=1e-13)
    assert_close("P.phi", found["P.phi"], expected, 2e-8 * amplitude, "phi^2/6 x omega0 t / 2, relative")
