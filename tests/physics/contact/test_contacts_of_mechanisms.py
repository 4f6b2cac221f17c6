# SPDX-License-Identifier: BSD-3-Clause
"""Contacts of bodies in chains, in closed loops and in stacks."""

from math import pi

import numpy as np
import pytest
from models.touching import SceneData, inertia_of_box, stack

import gelenk

G = 9.81  # m/s2


def tray() -> SceneData:
    """A parallelogram linkage whose coupler, a tray, carries a block; motor torque at the crank."""
    arm = {"mass": 0.5, "com": [0.2, 0, 0], "inertia": [1e-4, 7e-3, 7e-3]}
    hinge = {"type": "revolute", "axis": [0, -1, 0]}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "crank": arm,
            "rocker": arm,
            "tray": {
                "mass": 1.0,
                "com": [0.25, 0, 0],
                "inertia": inertia_of_box(1.0, [0.7, 0.3, 0.02]),
                "shapes": {"plate": {"box": [0.7, 0.3, 0.02], "position": [0.25, 0, 0], "surface": "plate"}},
            },
            "load": {
                "mass": 0.4,
                "inertia": inertia_of_box(0.4, [0.1, 0.1, 0.1]),
                "shapes": {"cube": {"box": [0.1, 0.1, 0.1], "surface": "load"}},
            },
        },
        "joints": {
            "A": {**hinge, "parent": "ground", "child": "crank", "start": {"phi": pi / 3, "fixed": True}},
            "B": {**hinge, "parent": {"body": "crank", "position": [0.4, 0, 0]}, "child": "tray"},
            "D": {**hinge, "parent": {"body": "ground", "position": [0.5, 0, 0]}, "child": "rocker"},
            "C": {
                **hinge,
                "parent": {"body": "tray", "position": [0.5, 0, 0]},
                "child": {"body": "rocker", "position": [0.4, 0, 0]},
            },
            "L": {"type": "free", "parent": "tray", "child": "load", "start": {"r": [0.25, 0, 0.06]}},
        },
        "motors": {"drive": {"joint": "A"}},
        "contacts": {"grip": {"between": ["load", "plate"], "friction": 0.3}},
        "experiment": {"step": 1e-3},
    }


def test_loops_are_closed_to_rounding_while_a_load_slides() -> None:
    """The tray is shaken so that the load slips back and forth; the linkage itself has closed loops."""
    scene = tray()
    scene["joints"]["D"]["start"] = {"phi": pi / 3}
    scene["joints"]["B"]["start"] = {"phi": -pi / 3}
    outputs = ["constraints.position", "constraints.velocity", "grip.mode", "L.r[1]", "grip.gap", "L.w[2]"]
    run = gelenk.simulate(
        scene, stop=1, step=0.002, outputs=outputs, inputs={"drive.tau": lambda t: 5 + 12 * np.sin(20 * t)}
    )
    assert run["constraints.position"].max() <= 1e-13
    # Projection ends at 1e-14 of the largest velocity, or where rounding stalls it; here 97 rad/s.
    assert run["constraints.velocity"].max() <= 1e-13 * np.abs(run["L.w[2]"]).max()
    modes = set(run["grip.mode"])
    assert {1, 2} <= modes  # sticks and slides
    assert np.ptp(run["L.r[1]"]) > 1e-3
    # Penetration is removed in the step in which it arises, up to h2 times the acceleration, < 100 m/s2.
    assert run["grip.gap"].min() > -1e-4


def test_load_at_rest_on_a_still_tray_is_carried_by_the_drive() -> None:
    """By virtual work, tau = g cos(phi) (2 m_arm c + (m_tray + m_load) L)."""
    scene = tray()
    scene["joints"]["D"]["start"] = {"phi": pi / 3}
    scene["joints"]["B"]["start"] = {"phi": -pi / 3}
    torque = G * np.cos(pi / 3) * (2 * 0.5 * 0.2 + 1.4 * 0.4)
    run = gelenk.simulate(scene, stop=0.5, step=0.1, inputs={"drive.tau": torque})
    assert run["A.phi"][-1] == pytest.approx(pi / 3, abs=1e-9)
    assert run["grip.f[3]"][-1] == pytest.approx(0.4 * G, rel=1e-9)


@pytest.mark.parametrize("boxes", [2, 10])
def test_stacks_rest(boxes: int) -> None:
    """Four points at each of the faces carry the weight, redundantly: no creep over 1000 steps."""
    run = gelenk.simulate(stack(boxes), stop=1, step=0.1)
    for i in range(boxes):
        assert run[f"j{i}.r[3]"][-1] == pytest.approx(0.1 * (i + 0.5), abs=1e-9)
        for k in (1, 2):
            assert abs(run[f"j{i}.r[{k}]"][-1]) <= 1e-12
        for name in ("v", "w"):
            assert max(abs(run[f"j{i}.{name}[{k}]"][-1]) for k in (1, 2, 3)) <= 1e-11


def test_pendulum_strikes_a_wall() -> None:
    """A rod falls from the horizontal, strikes a wall with e = 0.5 and rises to a quarter of the height.

    The impact is up to a step early or late.
    """
    scene = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "rod": {
                "mass": 1,
                "com": [0.5, 0, 0],
                "inertia": [0, 1 / 12, 1 / 12],
                "shapes": {"tip": {"sphere": 0.05, "position": [1, 0, 0], "surface": "tip"}},
            }
        },
        "ground": {"shapes": {"wall": {"plane": [1, 0, 0], "position": [-0.05, 0, 0], "surface": "wall"}}},
        "joints": {
            "A": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": "ground",
                "child": "rod",
                "start": {"phi": 0, "fixed": True},
            }
        },
        "contacts": {"hit": {"between": ["tip", "wall"], "restitution": 0.5}},
        "experiment": {"step": 1e-4},
    }
    run = gelenk.simulate(scene, stop=1.4, step=1e-3)
    impact = int((run["A.w"] < 0).argmax())
    assert run["A.phi"][impact] == pytest.approx(pi / 2, abs=6e-3)  # within 1 ms at 5.4 rad/s
    assert run["A.w"][impact] == pytest.approx(-0.5 * run["A.w"][impact - 1], rel=1e-3)
    highest = run["A.phi"][impact : impact + 700].min()
    assert np.sin(highest) == pytest.approx(0.75, abs=1e-3)


def test_bodies_that_share_a_joint_touch_only_if_asked() -> None:
    """Two balls on arms overlap at their common joint."""

    def swing(adjacent: bool) -> gelenk.Result:
        arm = {
            "mass": 1,
            "inertia": [0.01] * 3,
            "shapes": {"ball": {"sphere": 0.1, "position": [0.05, 0, 0], "surface": "ball"}},
        }
        return gelenk.simulate(
            {
                "gelenk": 1,
                "bodies": {"a": arm, "b": arm},
                "joints": {
                    "A": {"type": "weld", "parent": "ground", "child": "a"},
                    "B": {
                        "type": "prismatic",
                        "axis": [1, 0, 0],
                        "parent": "a",
                        "child": "b",
                        "start": {"s": 0.15},
                    },
                },
                "contacts": {"c": {"between": ["ball", "ball"], "adjacent": adjacent}},
            },
            stop=0.1,
            step=0.05,
        )

    with pytest.raises(gelenk.SceneError, match="adjacent: true"):
        swing(False)
    assert swing(True)["B.s"][-1] == pytest.approx(0.2, abs=1e-9)  # pushed apart, without speed
    assert abs(swing(True)["B.v"][-1]) < 1e-12
