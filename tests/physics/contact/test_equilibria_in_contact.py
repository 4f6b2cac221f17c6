# SPDX-License-Identifier: BSD-3-Clause
"""Poses that contacts hold: which are held, by which forces, against closed forms of statics."""

from __future__ import annotations

from math import atan, cos, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest
from models.standing import TURNED, UNTURNED, G, free_body
from scipy.optimize import brentq, linprog
from scipy.spatial.transform import Rotation

import gelenk

EXACT = 1e-10  # relative: positions are closed to 1e-10 m
NEAR = 1e-9  # relative distance from a limit at which the answer must be the right one

TURNS = pytest.mark.parametrize("turn", [UNTURNED, TURNED], ids=["upright", "turned"])


def held(source: dict[str, Any], **arguments: Any) -> gelenk.Equilibrium:
    return gelenk.equilibrium(gelenk.load(source), friction="present", **arguments)


def assert_not_held(why: str, source: dict[str, Any], **arguments: Any) -> None:
    with pytest.raises(gelenk.EquilibriumError, match=why):
        held(source, **arguments)


def on_a_slope(angle: float, friction: float, turn: Rotation = UNTURNED) -> dict[str, Any]:
    return free_body(
        {"box": [0.4, 0.3, 0.2]}, 2.0, [0.1] * 3, [0, 0, 0.1], friction=friction, turn=turn,
        gravity=(G * sin(angle), 0, -G * cos(angle)),
    )  # fmt: skip


@TURNS
@pytest.mark.parametrize("friction", [0.1, 0.5, 1.2])
def test_a_box_on_a_slope_holds_up_to_the_angle_of_friction(friction: float, turn: Rotation) -> None:
    limit = atan(friction)
    found = held(on_a_slope(limit * (1 - NEAR), friction, turn))
    assert found.margin == pytest.approx(0, abs=10 * NEAR)
    assert_not_held("contacts.floor would need a friction of", on_a_slope(limit * (1 + NEAR), friction, turn))
    half = held(on_a_slope(limit / 2, friction, turn))
    assert half.margin == pytest.approx(1 - tan(limit / 2) / friction, rel=EXACT)
    assert sum(p.normal for p in half.contact_points) == pytest.approx(2 * G * cos(limit / 2), rel=EXACT)
    total = np.sum([p.force for p in half.contact_points], axis=0)
    assert total == pytest.approx(
        turn.apply([-2 * G * sin(limit / 2), 0, 2 * G * cos(limit / 2)]), abs=20 * EXACT
    )


def table(feet: list[tuple[float, float]], load: tuple[float, float]) -> dict[str, Any]:
    """Balls under a plate whose center of mass is above `load`."""
    source = free_body({"sphere": 0.05}, 3.0, [0.2] * 3, [0, 0, 0.05], com=[*load, 0.3], friction=0.4)
    source["bodies"]["body"]["shapes"] = {
        f"foot_{k}": {"sphere": 0.05, "position": [*at, 0], "surface": "wood"} for k, at in enumerate(feet)
    }
    return source


def test_a_table_of_three_legs_is_determinate() -> None:
    feet = [(0.5, 0.1), (-0.4, 0.45), (-0.3, -0.5)]
    load = (-0.05, 0.08)
    found = held(table(feet, load))
    forces = np.linalg.solve(np.vstack([np.ones(3), np.transpose(feet)]), 3 * G * np.array([1, *load]))
    assert [p.normal for p in found.contact_points] == pytest.approx(forces.tolist(), rel=EXACT)
    assert max(p.friction for p in found.contact_points) <= 30 * EXACT
    assert_not_held("contacts.floor would have to pull", table(feet, (0.6, 0.1)))


def test_a_table_of_four_legs_has_the_forces_of_least_norm() -> None:
    feet = [(0.5, 0.4), (-0.5, 0.4), (-0.5, -0.4), (0.5, -0.4)]
    load = (0.12, -0.07)
    found = held(table(feet, load))
    statics = np.vstack([np.ones(4), np.transpose(feet)])
    least = np.linalg.pinv(statics) @ (3 * G * np.array([1, *load]))
    assert [p.normal for p in found.contact_points] == pytest.approx(least.tolist(), rel=EXACT)


@pytest.mark.parametrize("share", [1 - NEAR, 1 + NEAR])
@pytest.mark.parametrize("along", [(1.0, 1.0), (1.0, 0.3), (0.2, 1.0)])
def test_a_table_of_four_legs_stands_as_long_as_some_forces_push(
    along: tuple[float, float], share: float
) -> None:
    """By linear programming: also where those of least norm would have to pull."""
    feet = [(0.5, 0.4), (-0.5, 0.4), (-0.5, -0.4), (0.5, -0.4)]
    to_edge = 1 / max(along[0] / 0.5, along[1] / 0.4)
    load = (share * to_edge * along[0], share * to_edge * along[1])
    statics = np.vstack([np.ones(4), np.transpose(feet)])
    possible = linprog(np.zeros(4), A_eq=statics, b_eq=[1, *load], bounds=(0, None), method="highs-ds")
    assert (share < 1) == (possible.status == 0) or abs(share - 1) < 1e-7  # within its tolerance
    if share < 1:
        found = held(table(feet, load))
        assert min(p.normal for p in found.contact_points) >= 0
    else:
        assert_not_held("contacts.floor would have to pull", table(feet, load))


@TURNS
def test_a_ball_in_a_groove_presses_on_both_sides(turn: Rotation) -> None:
    """Without friction: N_1 cos a + N_2 cos b = m g, N_1 sin a = N_2 sin b."""
    a, b, r, m = 0.6, 0.9, 0.1, 2.0
    normals = [np.array([sin(a), 0, cos(a)]), np.array([-sin(b), 0, cos(b)])]
    sides = {f"side_{k}": {"plane": n.tolist()} for k, n in enumerate(normals)}
    center = np.linalg.solve([normals[0], [0, 1, 0], normals[1]], [r, 0, r])
    source = free_body({"sphere": r}, m, [0.01] * 3, center.tolist(), friction=0.0, on=sides, turn=turn)
    found = held(source)
    first = m * G * sin(b) / sin(a + b)
    second = m * G * sin(a) / sin(a + b)
    assert [p.normal for p in found.contact_points] == pytest.approx([first, second], rel=EXACT)


def test_a_ladder_holds_if_floor_and_wall_have_friction_enough() -> None:
    """With round ends, against a wall without friction: N (2 l sin a + r) = m g l cos a, N <= mu m g."""
    half, r, m, mu = 1.5, 0.02, 8.0, 0.4
    limit = brentq(lambda a: half * cos(a) - mu * (2 * half * sin(a) + r), 0.1, 1.5, xtol=1e-15)
    for angle, holds in ((limit * (1 + NEAR), True), (limit * (1 - NEAR), False)):
        along = np.array([-cos(angle), 0, sin(angle)])  # from the foot to the wall, which is at -x
        own = Rotation.align_vectors([along, [0, 1, 0]], [[0, 0, 1], [0, 1, 0]])[0]
        center = half * along * [-1, 0, 1] + [0, 0, r]
        source = free_body(
            {"capsule": {"radius": r, "length": 2 * half}}, m, [6, 6, 0.01], center.tolist(), own=own,
            friction=mu, on={"floor": {"plane": [0, 0, 1]}},
        )  # fmt: skip
        wall = {"plane": [1, 0, 0], "position": [center[0] - half * cos(angle) - r, 0, 0], "surface": "ice"}
        source["ground"]["shapes"]["wall"] = wall
        source["contacts"]["wall"] = {"between": ["wood", "ice"]}
        if holds:
            found = {p.contact: p for p in held(source).contact_points}
            assert found["floor"].normal == pytest.approx(m * G, rel=EXACT)
            assert found["wall"].normal == pytest.approx(
                m * G * half * cos(angle) / (2 * half * sin(angle) + r), rel=EXACT
            )
            assert found["floor"].friction == pytest.approx(found["wall"].normal, rel=EXACT)
        else:
            assert_not_held("contacts.floor would need a friction of", source)


def test_a_block_is_held_by_a_push_against_a_wall() -> None:
    """A horizontal push P holds it iff mu P >= m g."""
    m, mu = 2.0, 0.35
    source = free_body(
        {"box": [0.2, 0.2, 0.2]}, m, [0.02] * 3, [0.1, 0, 0], friction=mu,
        on={"wall": {"plane": [1, 0, 0]}},
    )  # fmt: skip
    push = m * G / mu
    found = held(source, input_values={"push.f[1]": -push * (1 + NEAR)})
    assert found.margin == pytest.approx(0, abs=10 * NEAR)
    assert_not_held(
        "contacts.floor would need a friction of", source, input_values={"push.f[1]": -push * (1 - NEAR)}
    )


@pytest.mark.parametrize("step", [0.05, 0.12])
def test_a_wheel_is_held_by_a_curb_up_to_the_pull_that_lifts_it(step: float) -> None:
    """A pull at its center lifts it at m g sqrt(h (2 r - h)) / (r - h)."""
    m, r = 4.0, 0.3
    at = sqrt(step * (2 * r - step))
    curb = {"box": [1, 2, step], "position": [at + 0.5, 0, step / 2], "surface": "stone"}
    source = free_body(
        {"sphere": r}, m, [0.1] * 3, [0, 0, r], friction=0.0, on={"floor": {"plane": [0, 0, 1]}, "curb": curb}
    )
    source["contacts"]["curb"] = {"between": ["wood", "stone"], "friction": 0.8}
    lifts = m * G * at / (r - step)
    below = held(source, input_values={"push.f[1]": lifts * (1 - NEAR)})
    assert len(below.contact_points) == 2
    assert_not_held(
        "contacts.floor would have to pull", source, input_values={"push.f[1]": lifts * (1 + 1e-7)}
    )


def gripper(friction: float) -> dict[str, Any]:
    """Two fingers on slides along x, each with a motor, and a ball of 0.5 kg between them."""
    finger = {"box": [0.02, 0.04, 0.1], "surface": "rubber"}
    fingers = {f"finger_{k}": {"mass": 0.2, "inertia": [1e-3] * 3, "shapes": {"pad": finger}} for k in "ab"}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            **fingers,
            "part": {
                "mass": 0.5, "inertia": [1e-3] * 3, "shapes": {"skin": {"sphere": 0.03, "surface": "steel"}}
            },
        },
        "joints": {
            "a": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "finger_a",
                  "start": {"s": -0.04, "fixed": True}},
            "b": {"type": "prismatic", "axis": [-1, 0, 0], "parent": "ground", "child": "finger_b",
                  "start": {"s": -0.04, "fixed": True}},
            "J": {"type": "free", "parent": "ground", "child": "part",
                  "start": {"r": [0, 0, 0], "fixed": True}},
        },
        "motors": {"grip_a": {"joint": "a"}, "grip_b": {"joint": "b"}},
        "contacts": {"pads": {"between": ["rubber", "steel"], "friction": friction}},
    }  # fmt: skip


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_a_gripper_holds_from_the_force_that_friction_needs(friction: float) -> None:
    """Each pad carries half the weight: F >= m g / (2 mu)."""
    least = 0.5 * G / (2 * friction)
    grip = {"grip_a.f": least * (1 + NEAR), "grip_b.f": least * (1 + NEAR)}
    found = held(gripper(friction), input_values=grip)
    assert found.margin == pytest.approx(0, abs=10 * NEAR)
    assert [p.friction for p in found.contact_points] == pytest.approx([0.25 * G] * 2, rel=EXACT)
    loose = dict.fromkeys(grip, least * (1 - NEAR))
    assert_not_held("contacts.pads would need a friction of", gripper(friction), input_values=loose)
    uneven = {"grip_a.f": 2 * least, "grip_b.f": 2 * least + 0.1}  # nothing balances the difference
    assert_not_held(r"do not hold this pose; \S+ = -?0.111111 m/s2", gripper(friction), input_values=uneven)


def test_a_lever_lies_on_its_stop() -> None:
    """A lever on a hinge lies on a ball: N b = m g a; a torque of its motor lifts it beyond m g a."""
    a, b, mass = 0.6, 0.9, 3.0
    source = {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "lever": {
                "mass": mass, "com": [a, 0, 0], "inertia": [0.1] * 3,
                "shapes": {"bar": {"box": [2.0, 0.1, 0.04], "surface": "wood"}},
            }
        },
        "ground": {"shapes": {"stop": {"sphere": 0.05, "position": [b, 0, -0.07], "surface": "floor"}}},
        "joints": {"A": {"type": "revolute", "axis": [0, -1, 0], "parent": "ground", "child": "lever"}},
        "motors": {"lift": {"joint": "A"}},
        "contacts": {"floor": {"between": ["wood", "floor"]}},
    }  # fmt: skip
    moment = mass * G * a
    [point] = held(source).contact_points
    assert point.normal == pytest.approx(moment / b, rel=EXACT)
    assert point.bodies == ("lever", "ground")
    [point] = held(source, input_values={"lift.tau": 0.75 * moment}).contact_points
    assert point.normal == pytest.approx(0.25 * moment / b, rel=10 * EXACT)
    assert_not_held(
        "contacts.floor would have to pull", source, input_values={"lift.tau": moment * (1 + 1e-6)}
    )


def test_equilibria_with_open_contacts_are_found() -> None:
    """A pendulum above a floor hangs; where the floor is higher than its lowest point, it is refused."""

    def pendulum(height: float) -> dict[str, Any]:
        return {
            "gelenk": 1,
            "gravity": [0, 0, -G],
            "bodies": {
                "bob": {
                    "mass": 1.0, "com": [0, 0, -1], "inertia": [0.01] * 3,
                    "shapes": {"ball": {"sphere": 0.1, "position": [0, 0, -1], "surface": "wood"}},
                }
            },
            "ground": {
                "shapes": {"plane": {"plane": [0, 0, 1], "position": [0, 0, height], "surface": "floor"}}
            },
            "joints": {
                "A": {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "bob",
                      "start": {"phi": 0.9}}
            },
            "contacts": {"floor": {"between": ["wood", "floor"], "friction": 0.3}},
        }  # fmt: skip

    found = gelenk.equilibrium(pendulum(-1.2))
    assert found.values["A.phi"] == pytest.approx(0, abs=1e-8)
    assert found.values["floor.gap"] == pytest.approx(0.1, abs=1e-8)
    with pytest.raises(gelenk.EquilibriumError, match=r"contacts.floor has a gap of -0.2 m"):
        gelenk.equilibrium(pendulum(-0.9))
    started = gelenk.load(pendulum(-1.2)).with_parameters({"solver.start": "equilibrium"})
    run = gelenk.simulate(started, stop=0.1, outputs=["A.phi"])
    assert np.abs(run["A.phi"]).max() <= 1e-8
    with pytest.raises(gelenk.AssemblyError, match=r"contacts.floor is closed at the equilibrium found"):
        gelenk.simulate(
            gelenk.load(pendulum(-0.9)).with_parameters({"solver.start": "equilibrium"}), stop=0.1
        )
