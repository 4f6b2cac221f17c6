# SPDX-License-Identifier: BSD-3-Clause
"""What holds at rest in time steps does not creep when the positions of others are corrected."""

from math import asin
from typing import Any

import pytest

import gelenk

ROD = {"mass": 1.0, "com": [0.2, 0, 0], "inertia": [0.001, 0.02, 0.02]}
HOLDS: dict[str, dict[str, Any]] = {
    "lock": {"lock": {"engaged": True}},
    "friction": {"friction": {"coulomb": 1e5}},
    "one_way": {"one_way": {"free": "positive"}},
}


def striking_arm(held: dict[str, Any], step: float) -> dict[str, Any]:
    """Two rods that fall onto a limit of the first joint; the second joint is held."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "solver": {"integrator": "moreau-jean", "step": step},
        "bodies": {"upper": ROD, "lower": ROD},
        "joints": {
            "shoulder": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": "ground",
                "child": "upper",
                "limit": {"upper": 0.2, "restitution": 0.6},
            },
            "elbow": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": {"body": "upper", "position": [0.4, 0, 0]},
                "child": "lower",
                **held,
            },
        },
    }


@pytest.mark.parametrize("step", [2e-3, 5e-4])
@pytest.mark.parametrize("holds", HOLDS)
def test_impacts_of_other_joints_leave_what_holds_in_place(holds: str, step: float) -> None:
    """Steps lead the shoulder beyond its limit by up to h/2 times its speed, which is corrected.

    The elbow takes no part in the correction. A one-way clutch, which may turn, only does not turn back.
    """
    plant = gelenk.Simulation(striking_arm(HOLDS[holds], step))
    plant.initialize()
    last = 0.0
    for k in range(1, 101):
        plant.step_to(k * 0.02)
        shoulder, elbow = plant.values(["shoulder.phi", "elbow.phi"])
        assert shoulder <= 0.2 + 1e-9
        assert elbow >= last - 1e-11
        if holds != "one_way":
            assert elbow == pytest.approx(0, abs=1e-11)
        last = elbow
    assert shoulder > 0.19


@pytest.mark.parametrize("step", [2e-3, 5e-4])
@pytest.mark.parametrize("holds", ["lock", "friction"])
def test_friction_of_what_strikes_does_not_keep_it_beyond_its_limit(holds: str, step: float) -> None:
    """The shoulder is at rest after its impact, held by friction, and returns to its limit alone."""
    scene = striking_arm(HOLDS[holds], step)
    scene["joints"]["shoulder"] |= {"limit": {"upper": 0.2, "restitution": 0.0}, "friction": {"coulomb": 0.5}}
    plant = gelenk.Simulation(scene)
    plant.initialize()
    for k in range(1, 51):
        plant.step_to(k * 0.02)
        shoulder, elbow = plant.values(["shoulder.phi", "elbow.phi"])
        assert shoulder <= 0.2 + 1e-9
        assert elbow == pytest.approx(0, abs=1e-11)
    assert shoulder == pytest.approx(0.2, abs=1e-9)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("start", [0.0, -0.0004])
def test_lock_that_engages_in_motion_stops_at_the_limit(start: float, side: int) -> None:
    """The first half of the step moves by 0.5 mm, beyond a nearer limit; then the lock ends the motion."""
    limit = {"upper": 0.0} if side > 0 else {"lower": 0.0}
    scene = {
        "gelenk": 1,
        "solver": {"integrator": "moreau-jean", "step": 1e-3},
        "bodies": {"slider": {"mass": 1.0}},
        "joints": {
            "slide": {
                "type": "prismatic",
                "axis": [1, 0, 0],
                "parent": "ground",
                "child": "slider",
                "limit": limit,
                "lock": {"engaged": True},
                "start": {"s": side * start, "v": side * 1.0, "fixed": True},
            }
        },
    }
    plant = gelenk.Simulation(scene)
    plant.initialize()
    for k in range(1, 11):
        plant.step_to(k * 1e-3)
        s, v = plant.values(["slide.s", "slide.v"])
        assert side * s == pytest.approx(0, abs=1e-9)
        assert v == pytest.approx(0, abs=1e-9)


def test_penetration_that_only_a_held_joint_can_end_ends() -> None:
    """A brake holds a ball 0.1 mm within the floor: the joint moves, as where none holds."""
    scene = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "solver": {"integrator": "moreau-jean", "step": 1e-3},
        "bodies": {"ball": {"mass": 1.0, "shapes": {"hull": {"sphere": 0.05, "surface": "ball"}}}},
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "joints": {
            "slide": {
                "type": "prismatic",
                "axis": [0, 0, 1],
                "parent": "ground",
                "child": "ball",
                "lock": {"engaged": True},
                "start": {"s": 0.0499, "v": 0.0, "fixed": True},
            }
        },
        "contacts": {"touch": {"between": ["ball", "floor"], "friction": 0.0, "restitution": 0.0}},
    }
    plant = gelenk.Simulation(scene)
    plant.initialize()
    plant.step_to(0.01)
    assert plant.values(["slide.s"])[0] == pytest.approx(0.05, abs=1e-9)


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("holds", ["lock", "friction"])
def test_redundant_brakes_hold_a_linkage_in_place(holds: str, count: int) -> None:
    """One brake holds a linkage of one degree of freedom; the others repeat its equation."""
    plant_scene = striking_arm({}, 2e-3)
    link = {"mass": 1.0, "com": [0.1, 0, 0], "inertia": [0.001, 0.01, 0.01]}
    plant_scene["bodies"] = {"upper": ROD, "crank": link, "coupler": link, "rocker": link}
    ends: dict[str, tuple[Any, Any]] = {
        "A": ({"body": "upper", "position": [0.1, 0, 0]}, "crank"),
        "B": ({"body": "crank", "position": [0.2, 0, 0]}, "coupler"),
        "D": ({"body": "upper", "position": [0.35, 0, 0]}, "rocker"),
        "C": ({"body": "coupler", "position": [0.25, 0, 0]}, {"body": "rocker", "position": [0.2, 0, 0]}),
    }
    joints = {"shoulder": plant_scene["joints"]["shoulder"]}
    for k, (name, (parent, child)) in enumerate(ends.items()):
        held = HOLDS[holds] if k < count else {}
        joints[name] = {"type": "revolute", "axis": [0, 1, 0], "parent": parent, "child": child, **held}
    joints["A"]["start"] = {"phi": 0.9}
    plant_scene["joints"] = joints
    plant = gelenk.Simulation(plant_scene)
    plant.initialize()
    angles = ["A.phi", "B.phi", "D.phi"]
    start = plant.values(angles)
    for k in range(1, 51):
        plant.step_to(k * 0.02)
        assert plant.values(angles) == pytest.approx(start, abs=1e-11)
    assert plant.values(["shoulder.phi"])[0] > 0.19


@pytest.mark.parametrize("step", [2e-3, 5e-4])
def test_what_friction_holds_gives_way_to_a_correction_before_what_is_locked(step: float) -> None:
    """A rod on a locked one lands with its tip, and friction ends its motion: it alone returns to the floor.

    The locked joint is at its limit. It moved beyond it, by as much as the tip had sunk in.
    """
    height, length, radius = 0.15, 0.4, 0.02
    scene = striking_arm({"friction": {"coulomb": 8.0}}, step)
    shoulder = scene["joints"]["shoulder"]
    shoulder |= {"lock": {"engaged": True}, "limit": {"lower": -0.5, "upper": 0.0}}
    shoulder["parent"] = {"body": "ground", "position": [0, 0, height]}
    scene["joints"]["elbow"]["start"] = {"phi": 0.0, "w": 12.0, "fixed": True}
    scene["bodies"]["lower"] = ROD | {
        "shapes": {"tip": {"sphere": radius, "position": [length, 0, 0], "surface": "ball"}}
    }
    scene["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}}
    scene["contacts"] = {"touch": {"between": ["ball", "floor"], "friction": 0.0, "restitution": 0.0}}
    plant = gelenk.Simulation(scene)
    plant.initialize()
    plant.step_to(0.2)
    shoulder_angle, elbow = plant.values(["shoulder.phi", "elbow.phi"])
    assert shoulder_angle == pytest.approx(0, abs=1e-12)
    # A correction, of at most half a step's turn, leaves what is of second order in it.
    assert elbow == pytest.approx(asin((height - radius) / length), abs=(12 * step / 2) ** 2)
