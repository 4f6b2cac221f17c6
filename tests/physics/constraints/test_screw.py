# SPDX-License-Identifier: BSD-3-Clause
"""A nut on a screw against closed forms, as tree joint and as loop-closing joint, over many revolutions."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

import gelenk

MASS, MOMENT, PITCH = 2.0, 0.003, 0.02  # kg, kg m2, m/rad
TIMES = 2.0  # s: thirty revolutions and more


def nut(pitch: float = PITCH, **more: object) -> Scene:
    """A nut under gravity on a vertical screw; a motor drives it."""
    return scene(
        {"nut": body(MASS, (0, 0, 0), (MOMENT, MOMENT, MOMENT))},
        {"S": joint("screw", frame("ground"), frame("nut"), axis=[0, 0, 1], pitch=pitch, **more)},
        gravity=[0, 0, -GRAVITY],
        motors={"drive": {"joint": "S"}},
        sensors={"at": {"type": "frame", "body": "nut"}, "bearing": {"type": "reaction", "joint": "S"}},
        experiment={"stop": TIMES, "step": 0.1, "tolerance": 1e-11},
    )


def press(pitch: float = PITCH) -> Scene:
    """A spindle rotates about, and a ram slides along, the vertical: the screw between them closes a loop."""
    return scene(
        {
            "spindle": body(1.0, (0, 0, 0), (MOMENT, MOMENT, MOMENT)),
            "ram": body(MASS, (0, 0, 0), (0.01, 0.01, 0.01)),
        },
        {
            "R": joint("revolute", frame("ground"), frame("spindle"), axis=[0, 0, 1]),
            "P": joint("prismatic", frame("ground"), frame("ram"), axis=[0, 0, 1]),
            "S": joint("screw", frame("ram"), frame("spindle"), axis=[0, 0, 1], pitch=pitch),
        },
        gravity=[0, 0, -GRAVITY],
        motors={"drive": {"joint": "R"}},
        experiment={"stop": TIMES, "step": 0.1, "tolerance": 1e-11},
    )


@pytest.mark.parametrize("pitch", [PITCH, -PITCH, 1.5, 1e-3])
@pytest.mark.parametrize("torque", [0.0, 0.3])
def test_nut_accelerates_by_torque_and_weight(pitch: float, torque: float) -> None:
    """(I + m p^2) phi'' = tau - m g p."""
    plant = gelenk.simulate(nut(pitch), inputs={"drive.tau": torque})
    rate = (torque - MASS * GRAVITY * pitch) / (MOMENT + MASS * pitch**2)
    phi = rate * plant.time**2 / 2
    scale = max(1.0, abs(phi).max())
    np.testing.assert_allclose(plant["S.phi"], phi, atol=1e-10 * scale)  # ten times the tolerance
    np.testing.assert_allclose(plant["at.r[3]"], pitch * phi, atol=1e-10 * scale * max(1.0, abs(pitch)))


@pytest.mark.parametrize("pitch", [PITCH, -PITCH, 0.5])
@pytest.mark.parametrize("reduced", [True, False])
def test_loop_closing_screw_counts_revolutions(pitch: float, reduced: bool) -> None:
    """The ram descends by p per radian: s = -p phi_R, (I + m p^2) phi'' = tau + m g p."""
    source = press(pitch)
    if not reduced:
        source["solver"] = {"reductions": {"all": False}}
    plant = gelenk.simulate(source, inputs={"drive.tau": 0.3})
    rate = (0.3 + MASS * GRAVITY * pitch) / (MOMENT + MASS * pitch**2)
    phi = rate * plant.time**2 / 2
    scale = max(1.0, abs(phi).max())
    np.testing.assert_allclose(plant["R.phi"], phi, atol=1e-9 * scale)  # loops are closed to 1e-10
    np.testing.assert_allclose(plant["P.s"], -pitch * phi, atol=1e-9 * scale * max(1.0, abs(pitch)))
    np.testing.assert_allclose(plant["S.phi"], phi, atol=1e-9 * scale * max(1.0, 1 / abs(pitch)) * PITCH)


def test_reaction_of_the_screw_balances_weight_and_inertia() -> None:
    """f_z = m (g + z''), t_z = I phi''."""
    plant = gelenk.Simulation(nut())
    plant.initialize()
    rate = -MASS * GRAVITY * PITCH / (MOMENT + MASS * PITCH**2)
    assert plant.output("bearing.f[3]") == pytest.approx(MASS * (GRAVITY + PITCH * rate), rel=1e-12)
    assert plant.output("bearing.t[3]") == pytest.approx(MOMENT * rate, rel=1e-12)


def test_spring_and_damper_of_a_screw_act_on_its_angle() -> None:
    """I phi'' + c phi' + k phi = 0 without gravity: a damped oscillation."""
    k, c, phi_0 = 0.8, 0.02, 0.7
    source = nut(stiffness=k, damping=c, start={"phi": phi_0, "fixed": True})
    source["gravity"] = [0, 0, 0]
    plant = gelenk.simulate(source)
    inertia = MOMENT + MASS * PITCH**2
    s = np.sqrt(complex(c**2 - 4 * k * inertia))
    roots = (-c + s) / (2 * inertia), (-c - s) / (2 * inertia)
    phi = (roots[0] * np.exp(roots[1] * plant.time) - roots[1] * np.exp(roots[0] * plant.time)) * phi_0
    np.testing.assert_allclose(
        plant["S.phi"], (phi / (roots[0] - roots[1])).real, atol=1e-9
    )  # 100 x tolerance
