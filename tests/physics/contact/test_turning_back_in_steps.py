# SPDX-License-Identifier: BSD-3-Clause
"""In time steps, too, what would turn back comes to rest before, and is held by static friction."""

from __future__ import annotations

import numpy as np
import pytest
from models.touching import inertia_of_box, on_plane

import gelenk

MASS, SIZE, GRAVITY = 1.3, (0.2, 0.2, 0.02), 10.0  # kg, m, m/s2
SLIDING, STATIC = 0.5, 1.1  # N
STEP = 1e-3  # s
SWING = (-0.0701, 0.695, 6.65, -66.0, -632.0, 6270.0)  # m, m/s, ...: 0.1 sin(9.745 t) from -0.78 rad on


@pytest.mark.parametrize("force", [0.8, 1.3])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.6, -0.8)])
@pytest.mark.parametrize("v0", [0.31, 0.3102, 0.3104, 0.3106, 0.3108])
def test_a_box_is_held_or_turns_back(v0: float, direction: tuple[float, float], force: float) -> None:
    """A force between sliding and static friction stops it, anywhere within a step; a larger one turns it."""
    along = np.array([*direction, 0.0])
    scene = on_plane(
        {"box": list(SIZE)},
        MASS,
        inertia_of_box(MASS, SIZE),
        {"r": [0, 0, SIZE[2] / 2], "v": (v0 * along).tolist()},
        {"friction": SLIDING / (MASS * GRAVITY), "static": STATIC / (MASS * GRAVITY)},
        step=STEP,
    )
    scene["gravity"] = [0, 0, -GRAVITY]
    scene["forces"] = {"push": {"type": "wrench", "body": "body", "force": (-force * along).tolist()}}
    run = gelenk.simulate(scene, stop=0.6, step=0.05)
    r = np.array([run[f"J.r[{i}]"] for i in (1, 2, 3)]).T @ along
    stopped = v0 * MASS / (force + SLIDING)  # s
    back = max(force - SLIDING, 0.0) / MASS if force > STATIC else 0.0
    exact = v0 * stopped / 2 - back * np.maximum(run.time - stopped, 0) ** 2 / 2
    after = run.time > stopped
    # Of order 1, where it stops: an error of the speed of up to a step, for 0.4 s.
    np.testing.assert_allclose(r[after], exact[after], rtol=0, atol=STEP * (v0 + 0.4 * force / MASS))
    if back == 0:
        np.testing.assert_allclose(r[after], r[-1], rtol=0, atol=1e-9)


def test_what_is_held_on_a_prescribed_motion_stays_held() -> None:
    """On a slide that swings, a load needs 13.3 to 10.4 N, between sliding and static friction.

    Projection onto the motion gives the load speeds of the third order in the step, which are no slip.
    """
    scene = {
        "gelenk": 1,
        "bodies": {"slide": {"mass": 1.0}, "load": {"mass": 2.0}},
        "joints": {
            "A": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "slide"},
            "B": {
                "type": "prismatic", "axis": [1, 0, 0], "parent": "slide", "child": "load",
                "friction": {"coulomb": 7.5, "static": 15.0}, "start": {"s": 0.0, "v": 0.0, "fixed": True},
            },
        },
        "constraints": {"drive": {"type": "motion", "joint": "A", "input": "position"}},
        "solver": {"integrator": "moreau-jean", "step": STEP},
    }  # fmt: skip
    plant = gelenk.Simulation(scene)
    for order, value in enumerate(SWING):
        if order == 0:
            plant.set_input("drive.s_ref", value)
        else:
            plant.set_input_derivative("drive.s_ref", order, value)
    plant.initialize()
    plant.step_to(0.02)
    assert plant.output("B.friction.mode") == 0
    # m: errors of the steps, of the second order: jerk STEP^2 t / 12 = 1.2e-7.
    assert abs(plant.output("B.s")) < 2e-7
    assert plant.output("B.friction.f") == pytest.approx(10.5, abs=0.1)
