# SPDX-License-Identifier: BSD-3-Clause
"""Andrews' squeezing mechanism compared with published values.

Schiehlen 1990; IVP Test Set of Lioen & de Swart / Mazzia & Magherini. Seven planar bodies, ten revolute
joints, three loops, 0.033 N m on the first body, no gravity, 0.03 s. Published final positions: PSIDE on a
Cray at 1e-14; an independent integration confirms nine digits of them.

From the Test Set's unknowns to joints and bars (its loop equations): O = origin, A, B, C on the ground;
  F = rr e(beta)                            K1 from O,       mass center ra from O
  E = F - d e(beta + Theta)                 K2 from F to E,  center da from F
  E = B + ss (sin gamma, -cos gamma)        K3 on B: E at (0, -ss), D at (sd, -sc), center at (sb, -sa)
  G = A + zt e(delta)                       K5 on A, center (ta, tb)
  E = G + e (sin(Phi + delta), -cos(..))    K4 on G: E at (0, -e), center e - ea from G towards E
  H = A + u (sin epsilon, -cos epsilon)     K7 on A: H at (0, -u), center (ua, -ub)
  E = H + zf e(Omega + epsilon)             K6 on H: E at (zf, 0), center zf - fa from H towards E
with e(x) = (cos x, sin x). A spring connects C and D.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene, body, frame, frame_sensor, joint, reaction, scene
from models.andrews import END, END_RATES
from models.running import INTEGRATORS, Recording, assert_close, run

pytestmark = warned.TIGHT

START = {
    "beta": -0.06171389001427645,
    "Theta": 0.0,
    "gamma": 0.45527981916307037,
    "Phi": 0.22266839016588588,
    "delta": 0.48736497954384256,
    "Omega": -0.22266839016588588,
    "epsilon": 1.2305474445498212,
}
START_ACCELERATIONS = {"beta": 14222.443919954114, "Theta": -10666.832939965585}  # the others are zero

# joint of the scene: the unknown that is its angle
HINGES = {"O": "beta", "F": "Theta", "B": "gamma", "A5": "delta", "G": "Phi", "A7": "epsilon", "H": "Omega"}
A, B, C = (-0.06934, -0.00227, 0), (-0.03635, 0.03273, 0), (0.014, 0.072, 0)


def squeezer() -> Scene:
    """The frame of each body is at its first joint, with the axes of the equations above."""

    def flat(mass: float, com: tuple[float, float], moment: float) -> dict[str, Any]:
        return body(mass, (*com, 0), (moment / 2, moment / 2, moment))

    def hinge(
        parent: dict[str, Any], child: str, angle: str, at: tuple[float, float] = (0, 0)
    ) -> dict[str, Any]:
        start = {"phi": START[angle], "w": 0.0, "fixed": angle == "beta"}
        return joint("revolute", parent, frame(child, (*at, 0)), axis=[0, 0, 1], start=start)

    def at_E(bar: str, place: tuple[float, float]) -> dict[str, Any]:
        return joint("revolute", frame("K3", (0, -0.035, 0)), frame(bar, (*place, 0)), axis=[0, 0, 1])

    return scene(
        {
            "K1": flat(0.04325, (0.00092, 0), 2.194e-06),
            "K2": flat(0.00365, (-0.0115, 0), 4.41e-07),
            "K3": flat(0.02373, (0.01043, -0.01874), 5.255e-06),
            "K4": flat(0.00706, (0, -0.00579), 5.667e-07),
            "K5": flat(0.0705, (0.02308, 0.00916), 1.169e-05),
            "K6": flat(0.00706, (0.00579, 0), 5.667e-07),
            "K7": flat(0.05498, (0.01228, -0.00449), 1.912e-05),
        },
        {
            "O": hinge(frame("ground"), "K1", "beta"),
            "F": hinge(frame("K1", (0.007, 0, 0)), "K2", "Theta"),
            "B": hinge(frame("ground", B), "K3", "gamma"),
            "A5": hinge(frame("ground", A), "K5", "delta"),
            "G": hinge(frame("K5", (0.04, 0, 0)), "K4", "Phi"),
            "A7": hinge(frame("ground", A), "K7", "epsilon"),
            "H": hinge(frame("K7", (0, -0.04, 0)), "K6", "Omega"),
            "E2": at_E("K2", (-0.028, 0)),
            "E4": at_E("K4", (0, -0.02)),
            "E6": at_E("K6", (0.02, 0)),
        },
        motors={"drive": {"joint": "O"}},
        forces={
            "spring": {
                "type": "spring_damper",
                "from": frame("ground", C),
                "to": frame("K3", (0.02, -0.018, 0)),
                "stiffness": 4530.0,
                "damping": 0.0,
                "length": 0.07785,
            }
        },
        sensors={
            "P2": frame_sensor("K2", (-0.028, 0, 0)),
            "P3": frame_sensor("K3", (0, -0.035, 0)),
            "P4": frame_sensor("K4", (0, -0.02, 0)),
            "P6": frame_sensor("K6", (0.02, 0, 0)),
            "R2": reaction("E2"),
            "R4": reaction("E4"),
            "R6": reaction("E6"),
            "E": {"type": "energy"},
        },
    )


@pytest.fixture(scope="module", params=INTEGRATORS)
def squeezed(request: pytest.FixtureRequest) -> Recording:
    times = np.linspace(0, 0.03, 61)
    return run(squeezer(), times, tolerance=1e-11, integrator=request.param, inputs={"drive.tau": 0.033})


def test_final_positions_match_published_values(squeezed: Recording) -> None:
    """To 1e-7, relative to each angle; 0.04 rad of gamma to 4e-9 rad."""
    for name, angle in HINGES.items():
        end = END[angle]
        assert_close(f"{angle} ({name}.phi)", squeezed[f"{name}.phi"][-1], end, 1e-7 * abs(end), "published")


def test_final_velocities_match_published_values(squeezed: Recording) -> None:
    """Confirmed by others to 5e-8 relative; 1e-7 of the angles at rates of 500 per second: 1e-5."""
    for name, angle in HINGES.items():
        end = END_RATES[angle]
        assert_close(f"{angle}' ({name}.w)", squeezed[f"{name}.w"][-1], end, 1e-5 * abs(end), "x 500/s x t")


def test_initial_accelerations_match_published_values(squeezed: Recording) -> None:
    """At rest at a dead center (crank and K2 in line):
    only these two bars accelerate, the rest by round-off.
    """
    for name, angle in HINGES.items():
        expected = START_ACCELERATIONS.get(angle, 0.0)
        # start angles have 16 digits; masses differ by 1e2, lengths by 1e1: condition 1e4 x 14000 x eps
        assert_close(f"{angle}'' ({name}.a)", squeezed[f"{name}.a"][0], expected, 1e-6, "round-off")


def test_reactions_match_published_multipliers(squeezed: Recording) -> None:
    """Lambda 1..6 are the world forces on K3, K4 and K6 at E, each relative to K2: confirmed by others
    to 1.3e-6; they follow the accelerations, so the bound is 1e-4 relative at the end, 1e-8 at the start.
    """
    published = {
        0: (98.56687039624109, -6.122688344255662, 0, 0, 0, 0),
        -1: (
            199.175333373191,
            -29.75531228015052,
            23.06654119098399,
            31.45271365475927,
            22.64249232082739,
            11.61740700019673,
        ),
    }
    for row, bound in ((0, 1e-8), (-1, 1e-4)):
        c, s = np.cos(squeezed["B.phi"][row]), np.sin(squeezed["B.phi"][row])
        R = np.array([[c, -s], [s, c]])  # F of the joints at E rotates with K3
        on_K2, on_K4, on_K6 = (R @ squeezed.vector(f"R{i}.f")[row, :2] for i in (2, 4, 6))
        expected = np.array(published[row]).reshape(3, 2)
        scale = float(np.abs(expected).max())
        assert_close("on K2", on_K2, -expected.sum(axis=0), bound * scale, "multipliers")
        assert_close("on K4", on_K4, expected[1], bound * scale, "multipliers")
        assert_close("on K6", on_K6, expected[2], bound * scale, "multipliers")


def test_four_bars_remain_joined_at_one_point(squeezed: Recording) -> None:
    """Three loops share E: all four bars have it at the same position at every output."""
    for bar in ("P2", "P4", "P6"):
        gap = squeezed.vector(f"{bar}.r") - squeezed.vector("P3.r")
        assert_close(f"gap {bar}", np.linalg.norm(gap, axis=1), 0, 1e-10, "closure, m")
        rate = squeezed.vector(f"{bar}.v") - squeezed.vector("P3.v")
        assert_close(f"rate {bar}", np.linalg.norm(rate, axis=1), 0, 1e-9, "closure, m/s")


def test_work_of_the_motor_equals_the_energy_gain(squeezed: Recording) -> None:
    """T + V - E0 = 0.033 N m (beta - beta0): the energy balance evaluated by the IFToMM library (A03)."""
    gain = squeezed["E.total"] - squeezed["E.total"][0]
    work = 0.033 * (squeezed["O.phi"] - squeezed["O.phi"][0])
    assert_close("energy", gain, work, 1e-8 * 0.5, "1000 rtol of 0.5 J")
