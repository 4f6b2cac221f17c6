# SPDX-License-Identifier: BSD-3-Clause
"""A double pendulum compared with its textbook equations of motion (two absolute angles),
integrated by SciPy at 1e-12.
"""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, scene
from models.double_pendulum import DoublePendulum
from models.running import INTEGRATORS, assert_close, run
from scipy.integrate import solve_ivp

pytestmark = warned.TIGHT

M1, C1, J1, L1 = 1.3, 0.41, 0.052, 0.83  # upper body: mass, its center of mass, moment of inertia, distance
# to the second pin
M2, C2, J2 = 0.9, 0.33, 0.047
TEXTBOOK = DoublePendulum(M1, C1, J1, L1, M2, C2, J2)
START = (0.7, -0.4, 0.3, 0.9)  # phi1, phi2 relative, w1, w2 relative


def double_pendulum() -> Scene:
    """The pendulum hangs along -y and both pins are along z.
    The other moments of inertia are chosen such that confusing them would show.
    """
    names = dict(zip(("phi", "w"), (START[0], START[2]), strict=True))
    return scene(
        {"upper": body(M1, (0, -C1, 0), (0.04, 0.03, J1)), "lower": body(M2, (0, -C2, 0), (0.02, 0.035, J2))},
        {
            "P1": joint("revolute", frame("ground"), frame("upper"), axis=[0, 0, 1], start=names),
            "P2": joint(
                "revolute",
                frame("upper", (0, -L1, 0)),
                frame("lower"),
                axis=[0, 0, 1],
                start={"phi": START[1], "w": START[3]},
            ),
        },
        gravity=[0, -GRAVITY, 0],
        sensors={"E": {"type": "energy"}},
    )


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_double_pendulum_matches_textbook_equations(integrator: str) -> None:
    """Over 3 s neighboring motions diverge by a factor of about 50, so 5000 rtol are allowed."""
    times = np.linspace(0, 3, 31)
    y0 = [START[0], START[0] + START[1], START[2], START[2] + START[3]]
    truth = solve_ivp(TEXTBOOK.rates, (0, 3), y0, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=times).y
    found = run(double_pendulum(), times, tolerance=1e-11, integrator=integrator)
    assert_close("P1.phi", found["P1.phi"], truth[0], 5e-8, "5000 rtol")
    assert_close("P2.phi", found["P2.phi"], truth[1] - truth[0], 5e-8, "5000 rtol")
    assert_close("P1.w", found["P1.w"], truth[2], 5e-7, "ten times the angles")


def test_double_pendulum_conserves_energy_for_a_minute() -> None:
    """The motion is chaotic, but T + V is constant: to 1e-9 of 10 J over 60 s at rtol 1e-12.
    A wrong Coriolis term gives 1.
    """
    found = run(double_pendulum(), np.linspace(0, 60, 121), tolerance=1e-12)
    total = found["E.total"]
    assert_close("energy", total, total[0], 1e-8, "1000 rtol x 10 J")
