# SPDX-License-Identifier: BSD-3-Clause
"""Parallelogram linkages compared with closed-form pendulums: their couplers only translate.

At their change points (all bars in line) another branch opens; these tests avoid them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, frame_sensor, joint, scene, with_sensors
from models.running import INTEGRATORS, assert_close, run
from scipy.integrate import solve_ivp
from scipy.special import ellipj

from gelenk.chart import mechanisms

pytestmark = warned.TIGHT

ABOUT_Z = {"axis": [0, 0, 1]}


def four_bar_chain(n: int, upright: float, rate: float) -> Scene:
    """The N-four-bar (IFToMM A02) with a sensor at the tip of the first crank."""
    return with_sensors(mechanisms.four_bar_chain(n, upright, rate), tip=frame_sensor("crank0", (1, 0, 0)))


def falling(n: int, upright: float, rate: float, times: np.ndarray) -> np.ndarray:
    """I phi'' = P g sin phi, I = (n+1)/3 + n, P = (n+1)/2 + n per kg and meter, phi from the vertical."""
    k = GRAVITY * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)
    found = solve_ivp(
        lambda _t, y: [y[1], k * math.sin(y[0])],
        (0, times[-1]),
        [upright, rate],
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
        t_eval=times,
    )
    phi: np.ndarray = found.y[0]
    return phi


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("n", [2, 5])
def test_n_four_bar_falls_like_one_pendulum(n: int, integrator: str) -> None:
    """From upright with 1 rad/s to 1.4 rad, before the change point at pi/2 rad,
    where n degrees of freedom open.
    """
    times = np.linspace(0, 0.5, 26)
    phi = falling(n, 0.0, 1.0, times)
    times, phi = times[phi < 1.4], phi[phi < 1.4]
    found = run(four_bar_chain(n, 0.0, 1.0), times, tolerance=1e-11, integrator=integrator)
    expected = np.array([np.sin(phi), np.cos(phi)]).T
    assert_close("B0", found.vector("tip.r")[:, :2], expected, 1e-8, "1000 rtol near the change point")
    for i in range(n + 1):
        assert_close(f"A{i}.phi", found[f"A{i}.phi"], math.pi / 2 - phi, 1e-8, "as above")


def test_hanging_n_four_bar_matches_pendulum_for_20_s() -> None:
    """Below the horizontal there are no singular configurations:
    20 s of oscillation by 1 rad about the lower equilibrium.
    """
    times = np.linspace(0, 20, 81)
    phi = falling(2, math.pi - 1.0, 0.0, times)
    found = run(four_bar_chain(2, math.pi - 1.0, 0.0), times, tolerance=1e-12)
    assert_close("A0.phi", found["A0.phi"], math.pi / 2 - phi, 1e-8, "10^4 rtol: phase over 20 s")
    assert_close("constraints.position", found["constraints.position"], 0, 1e-10, "closure")


def test_parallelogram_has_the_exact_pendulum_period() -> None:
    """The coupler only translates, so the linkage is a pendulum with omega0^2 = g (2 m c + m_c L)/(2 I_O +
    m_c L^2) (Landau & Lifshitz, Mechanics, section 11). 60 degrees is well before the change point at 90.
    """
    I_O, m, c, L, m_c, width = 0.03, 0.5, 0.15, 0.3, 0.8, 0.37
    amplitude = math.pi / 3
    crank = body(m, (c, 0, 0), (0.001, 0.0195, I_O - m * c * c))
    hang = -math.pi / 2 + amplitude
    source = scene(
        {"left": crank, "right": crank, "coupler": body(m_c, (0.11, -0.04, 0), (0.002, 0.01, 0.011))},
        {
            "A": joint(
                "revolute", frame("ground"), frame("left"), **ABOUT_Z, start={"phi": hang, "fixed": True}
            ),
            "D": joint(
                "revolute", frame("ground", (width, 0, 0)), frame("right"), **ABOUT_Z, start={"phi": hang}
            ),
            "B": joint(
                "revolute", frame("left", (L, 0, 0)), frame("coupler"), **ABOUT_Z, start={"phi": -hang}
            ),
            "C": joint(
                "revolute",
                frame("coupler", (width, 0, 0)),
                frame("right", (L, 0, 0)),
                **ABOUT_Z,
                start={"phi": hang},
            ),
        },
        gravity=[0, -GRAVITY, 0],
    )
    omega0 = math.sqrt(GRAVITY * (2 * m * c + m_c * L) / (2 * I_O + m_c * L * L))
    times = np.linspace(0, 4, 81)
    k = math.sin(amplitude / 2)
    _, cn, dn, _ = ellipj(omega0 * times, k * k)
    found = run(source, times, tolerance=1e-11)
    assert_close(
        "A.phi", found["A.phi"], 2 * np.arcsin(k * cn / dn) - math.pi / 2, 1e-8, "1000 rtol, three periods"
    )
    assert_close("coupler's angle", found["A.phi"] + found["B.phi"], 0, 1e-11, "it only translates: closure")
