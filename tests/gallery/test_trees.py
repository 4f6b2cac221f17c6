# SPDX-License-Identifier: BSD-3-Clause
"""Pendulums, tops and free bodies of the gallery, and a published run of a mechanism with three loops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mechanisms import GRAVITY
from models.andrews import END
from models.double_pendulum import DoublePendulum
from models.heavy_top import PRINTED, RECOMPUTED
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import gelenk
from gallery.entries import assert_stated, file, ran, vectors


def test_pendulum() -> None:
    """Without its damper: T = 4 K(sin2(a/2)) / omega0, the amplitude a from hanging down."""
    amplitude = math.pi / 2 + 0.3
    omega0 = math.sqrt(1.2 * GRAVITY * 0.4 / (0.064 + 1.2 * 0.4**2))
    period = 4 * ellipk(math.sin(amplitude / 2) ** 2) / omega0
    run = gelenk.simulate(
        file("pendulum"), stop=period, step=period / 4, tolerance=1e-11, parameters={"pin.damping": 0.0}
    )
    assert run["pin.phi"] == pytest.approx([0.3, -math.pi / 2, -math.pi - 0.3, -math.pi / 2, 0.3], abs=1e-9)
    assert_stated("pendulum", period, "s")


def test_double_pendulum() -> None:
    """Textbook equations, integrated by SciPy at 1e-12, over the first 2 s."""
    pendulum = DoublePendulum(1.0, 0.35, 0.0408333333333333, 0.7, 0.6, 0.25, 0.0125)
    run = gelenk.simulate(file("double_pendulum"), stop=2.0, step=0.1, tolerance=1e-11)
    start = [math.pi / 2, math.pi / 2 + 0.4, 0.0, 0.0]
    truth = solve_ivp(pendulum.rates, (0, 2), start, "DOP853", run.time, rtol=1e-12, atol=1e-13).y
    np.testing.assert_allclose(
        run["shoulder.phi"], truth[0] - math.pi / 2, rtol=0, atol=1e-9
    )  # 100 tolerances
    np.testing.assert_allclose(run["elbow.phi"], truth[1] - truth[0], rtol=0, atol=1e-9)
    assert_stated("double_pendulum", truth[0][10] - math.pi / 2, "rad")
    energy = ran("double_pendulum")["balance.total"]
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-6)  # 1000 tolerances of 1 J, over 5 s


def test_free_body() -> None:
    """Euler's equations in Jacobi's functions (Landau & Lifshitz, Mechanics, section 37): the period of the
    angular velocity is 4 K(m) / p.
    """
    inertia, w = np.array([1.0, 2.0, 3.0]), np.array([1e-3, 3.0, 1e-3])
    I1, I2, I3 = inertia
    E2, L2 = float((inertia * w) @ w), float((inertia * w) @ (inertia * w))
    if L2 < E2 * I2:  # it circles the other axis: the roles of I1 and I3 are exchanged
        I1, I3 = I3, I1
    p = math.sqrt((I3 - I2) * (L2 - E2 * I1) / (I1 * I2 * I3))
    m = (I2 - I1) * (E2 * I3 - L2) / ((I3 - I2) * (L2 - E2 * I1))
    period = 4 * ellipk(m) / p
    run = gelenk.simulate(file("free_body"), stop=period, step=period / 2, tolerance=1e-12)
    found = vectors(run, "flight.w")
    # Near the unstable axis a disturbance grows by w / 1e-3 = 3000 on the way to the flip, and as much on the
    # way back: 1e-12 times 3000 squared, times the rate.
    np.testing.assert_allclose(found[2], w, rtol=0, atol=3e-5)
    assert found[1][1] == pytest.approx(-3.0, abs=3e-5)
    assert_stated("free_body", period / 2, "s")


def test_heavy_top() -> None:
    """Printed values of another code, and an independent integration at 1e-13."""
    run = ran("heavy_top")
    k = int(np.argmin(np.abs(run.time - 0.4)))
    np.testing.assert_allclose(vectors(run, "tip.w")[k], PRINTED[0.4], rtol=0, atol=2e-4)  # five digits
    np.testing.assert_allclose(vectors(run, "com.r")[k], RECOMPUTED[0.4][1], rtol=0, atol=1e-6)
    assert_stated("heavy_top", RECOMPUTED[0.4][1][2], "m")


def test_andrews() -> None:
    """Final angles published with the Test Set for IVP Solvers."""
    run = ran("andrews")
    found = {name: run[f"{name}.phi"][-1] for name in END}
    assert found == pytest.approx(END, abs=1e-7)  # 100 tolerances; nine confirmed digits of 16 rad
    assert_stated("andrews", END["beta"], "rad")
