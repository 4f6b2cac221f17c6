# SPDX-License-Identifier: BSD-3-Clause
"""Outputs at a communication point where `auto` exchanges its scheme are those of the scheme before."""

from __future__ import annotations

from typing import Any

import numpy as np
from models.vibrating import BOX_MASS, STEPPING_BOXES, resting_boxes

import gelenk

SceneData = dict[str, Any]
EVENTS, STEPPING = 0, 1  # solver.scheme
G = 9.81  # m/s2
COULOMB, STIFFNESS = 0.3, 40.0  # N, N/m


def boxes_and_a_slide(count: int) -> SceneData:
    """Boxes that rest on the floor, and a block that slides above them, held to them by weak springs."""
    scene = resting_boxes(count)
    joints = {
        "s": {
            "type": "prismatic", "axis": [1, 0, 0], "parent": {"body": "ground", "position": [0, -1, 1]},
            "child": "m", "friction": {"coulomb": COULOMB}, "start": {"s": 0.0, "v": 1.0, "fixed": True},
        },
        **scene["joints"],
    }  # fmt: skip
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {"m": {"mass": 1.0}, **scene["bodies"]},
        "joints": joints,
        "forces": {
            f"c{k}": {"type": "spring_damper", "from": "m", "to": f"b{k}", "stiffness": 1e-9, "length": 1.0}
            for k in range(count)
        },
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {"k": {"between": ["wood", "floor"], "friction": 0.5}},
    }  # fmt: skip


def test_forces_where_time_steps_begin() -> None:
    """Twenty points of contact are too many for events: weight and friction are transmitted throughout."""
    names = ["k.f[3]", "s.friction.f", "s.friction.mode", "solver.scheme"]
    run = gelenk.simulate(boxes_and_a_slide(STEPPING_BOXES), outputs=names, stop=0.02, step=1e-3)
    assert run["solver.scheme"][0] == EVENTS
    assert run["solver.scheme"][-1] == STEPPING
    weight = STEPPING_BOXES * BOX_MASS * G
    # What the cone solver leaves: 1e-8 of the velocities that a step without forces would give.
    np.testing.assert_allclose(np.abs(run["k.f[3]"]), weight, rtol=1e-6)
    np.testing.assert_allclose(run["s.friction.f"], -COULOMB, rtol=1e-6)
    assert set(run["s.friction.mode"]) == {1}


def test_forces_where_located_events_return() -> None:
    """Two of five boxes are lifted off; the others transmit their weight before and after the return."""
    scene = boxes_and_a_slide(STEPPING_BOXES)
    lifted = ("b3", "b4")
    scene["forces"] |= {f"lift_{name}": {"type": "wrench", "body": name, "input": True} for name in lifted}
    names = ["k.f[3]", "s.friction.f", "solver.scheme"]
    lift = {f"lift_{name}.f[3]": lambda t: 0.0 if t < 0.01 else 2 * BOX_MASS * G for name in lifted}
    run = gelenk.simulate(scene, inputs=lift, outputs=names, stop=0.1, step=1e-3)
    back = int(np.argmax(np.diff(run["solver.scheme"]) < 0)) + 1
    assert run["solver.scheme"][back - 1] == STEPPING
    assert run["solver.scheme"][back] == EVENTS
    weight = (STEPPING_BOXES - len(lifted)) * BOX_MASS * G
    near = slice(back - 5, back + 5)
    np.testing.assert_allclose(np.abs(run["k.f[3]"][near]), weight, rtol=1e-6)
    np.testing.assert_allclose(run["s.friction.f"][near], -COULOMB, rtol=1e-6)
