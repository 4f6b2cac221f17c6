# SPDX-License-Identifier: BSD-3-Clause
"""Located contacts with friction and limits of joints, decided together: against closed forms."""

from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from models.running import assert_restored_run_continues

import gelenk

SceneData = dict[str, Any]
G = 9.81  # m/s2
INTEGRATORS = ["erk", "cvode", "ida", "dirk"]


def scene(bodies: SceneData, joints: SceneData, ground: SceneData, contacts: SceneData) -> SceneData:
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": bodies,
        "ground": {"shapes": ground},
        "joints": joints,
        "contacts": contacts,
        "sensors": {"E": {"type": "energy"}},
    }


def free(body: str, r: list[float], v: list[float] | None = None) -> SceneData:
    start = {"r": r, "v": v or [0, 0, 0], "fixed": True}
    return {"type": "free", "parent": "ground", "child": body, "start": start}


def slider(
    body: str, axis: list[float], start: SceneData, friction: SceneData | None, **more: SceneData
) -> SceneData:
    out = {
        "type": "prismatic",
        "axis": axis,
        "parent": "ground",
        "child": body,
        "start": start | {"fixed": True},
    }
    return out | ({"friction": friction} if friction else {}) | more


CART, BOX = 3.0, 2.0  # kg
EDGE, BUFFER = 0.2, 0.05  # m


def push(speed: float, coulomb: float, mu: float) -> SceneData:
    """A cart on a rail with dry friction, whose round buffer is 0.1 m before a box on the floor."""
    inertia = BOX * EDGE**2 / 6
    return scene(
        {
            "cart": {
                "mass": CART,
                "inertia": [1, 1, 1],
                "shapes": {"buffer": {"sphere": BUFFER, "surface": "rubber"}},
            },
            "box": {
                "mass": BOX,
                "inertia": [inertia] * 3,
                "shapes": {"hull": {"box": [EDGE] * 3, "surface": "wood"}},
            },
        },
        {
            "S": slider("cart", [1, 0, 0], {"s": 0, "v": speed}, {"coulomb": coulomb})
            | {"parent": {"body": "ground", "position": [0, 0, EDGE / 2]}},
            "J": free("box", [0.1 + BUFFER + EDGE / 2, 0, EDGE / 2]),
        },
        {"floor": {"plane": [0, 0, 1], "surface": "concrete"}},
        {
            "floor": {"between": ["wood", "concrete"], "friction": mu},
            "hit": {"between": ["rubber", "wood"]},
        },
    )


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("coulomb", "mu"), [(6.0, 0.4), (12.0, 0.1)], ids=["pushes", "lets go"])
def test_a_cart_with_friction_pushes_a_box(integrator: str, coulomb: float, mu: float) -> None:
    """Common speed after an inelastic impact, then both are braked by their friction, together or apart.

    The friction of the cart's joint exerts no impulse. The floor does not either, as the box is struck in
    the height of its center of mass.
    """
    speed = 2.0
    run = gelenk.simulate(push(speed, coulomb, mu), stop=2, step=0.05, tolerance=1e-9, integrator=integrator)
    before = sqrt(speed**2 - 2 * coulomb / CART * 0.1)
    after = CART * before / (CART + BOX)
    together = (coulomb + mu * BOX * G) / (CART + BOX)
    decelerations = (together, together) if coulomb / CART < mu * G else (coulomb / CART, mu * G)
    ways = [after**2 / (2 * a) for a in decelerations]
    start = 0.1 + BUFFER + EDGE / 2
    assert run["S.s"][-1] == pytest.approx(0.1 + ways[0], abs=1e-7)
    assert run["J.r[1]"][-1] == pytest.approx(start + ways[1], abs=1e-7)
    assert run["S.v"][-1] == 0
    assert abs(run["J.v[1]"][-1]) <= 1e-14
    times = [(t, text) for t, text in run.events if "touches" in text]
    assert [t for t, text in times if text.startswith("hit")] == pytest.approx(
        [(speed - before) / (coulomb / CART)], abs=1e-9
    )


LIFT, BALL = 4.0, 1.5  # kg


def lift(height: float, friction: SceneData, force: float, mu: float = 0.0) -> SceneData:
    """A ball this high above a lift, whose guide has friction and which a force supports."""
    bodies = {
        "lift": {
            "mass": LIFT,
            "inertia": [1, 1, 1],
            "shapes": {"top": {"box": [1, 1, 0.1], "surface": "steel"}},
        },
        "ball": {
            "mass": BALL,
            "inertia": [0.4 * BALL * 0.01] * 3,
            "shapes": {"s": {"sphere": 0.1, "surface": "ball"}},
        },
    }
    joints = {
        "S": slider("lift", [0, 0, 1], {"s": 0, "v": 0}, friction),
        "J": free("ball", [0.2, 0.1, 0.15 + height]),
    }
    out = scene(bodies, joints, {}, {"rest": {"between": ["ball", "steel"], "friction": mu}})
    del out["ground"]
    out["forces"] = {"up": {"type": "wrench", "frame": "world", "body": "lift", "force": [0, 0, force]}}
    return out


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_ball_falls_on_a_lift_that_friction_holds(integrator: str) -> None:
    """The impact moves both, as friction exerts no impulse; friction stops them again and then holds."""
    height, coulomb = 0.3, 40.0
    run = gelenk.simulate(
        lift(height, {"coulomb": coulomb}, LIFT * G),
        stop=1,
        step=0.02,
        tolerance=1e-9,
        integrator=integrator,
        outputs=["S.*", "J.*", "rest.*", "E.*"],
    )
    fall = sqrt(2 * G * height)
    both = BALL * fall / (BALL + LIFT)
    way = both**2 / (2 * (coulomb - BALL * G) / (BALL + LIFT))
    assert run["S.s"][-1] == pytest.approx(-way, abs=1e-8)
    assert run["S.v"][-1] == 0
    assert run["S.friction.f"][-1] == pytest.approx(BALL * G, abs=1e-9)
    assert run["rest.f[3]"][-1] == pytest.approx(BALL * G, abs=1e-9)
    moving = (run.time > fall / G) & (run["S.v"] != 0)
    lifts = BALL * (G + (coulomb - BALL * G) / (BALL + LIFT))
    assert run["rest.f[3]"][moving] == pytest.approx(lifts, abs=1e-8)


def test_the_weight_of_what_rests_on_a_lift_uses_up_its_friction() -> None:
    """Held while the unsupported weight is below static friction; else it falls against sliding friction."""
    static, coulomb = 30.0, 20.0
    friction = {"static": static, "coulomb": coulomb}
    for force, moves in (((LIFT + BALL) * G - 29.999, False), ((LIFT + BALL) * G - 30.001, True)):
        run = gelenk.simulate(lift(0, friction, force), stop=0.5, step=0.1, tolerance=1e-9, integrator="erk")
        a = ((LIFT + BALL) * G - force - coulomb) / (LIFT + BALL) if moves else 0
        assert run["S.v"][-1] == pytest.approx(-a * 0.5, abs=1e-9)
        assert run["J.v[3]"][-1] == pytest.approx(-a * 0.5, abs=1e-9)
        assert run["rest.f[3]"][-1] == pytest.approx(BALL * (G - a), abs=1e-8)


def test_a_ball_that_slides_along_an_arm_breaks_its_joint_away() -> None:
    """Without friction of the ball; the moment of its weight grows until the joint's friction is used up."""
    arm, friction, speed, x0 = 2.0, 25.0, 0.5, 0.2
    bodies = {
        "arm": {
            "mass": arm,
            "com": [0.5, 0, 0],
            "inertia": [0.01, 0.2, 0.2],
            "shapes": {"top": {"box": [2, 0.1, 0.1], "position": [1, 0, 0], "surface": "steel"}},
        },
        "ball": {
            "mass": BALL,
            "inertia": [0.4 * BALL * 0.01] * 3,
            "shapes": {"s": {"sphere": 0.1, "surface": "ball"}},
        },
    }
    joints = {
        "A": {
            "type": "revolute",
            "axis": [0, 1, 0],
            "parent": "ground",
            "child": "arm",
            "friction": {"coulomb": friction},
        },
        "J": free("ball", [x0, 0, 0.15], [speed, 0, 0]),
    }
    made = scene(bodies, joints, {}, {"rest": {"between": ["ball", "steel"]}})
    del made["ground"]
    run = gelenk.simulate(made, stop=2.6, step=0.01, tolerance=1e-10, integrator="erk")
    exact = ((friction - arm * G * 0.5) / (BALL * G) - x0) / speed
    begins = [t for t, text in run.events if text.startswith("A.phi")]
    assert begins[0] == pytest.approx(exact, abs=1e-9)
    rests = run.time < exact
    assert np.abs(run["A.phi"][rests]).max() == 0
    moment = arm * G * 0.5 + BALL * G * (x0 + speed * run.time)
    assert np.abs(run["A.friction.tau"] + moment)[rests].max() <= 1e-9
    assert run["A.w"][-1] > 0


LENGTH, BOB = 0.8, 0.1  # m


def pendulum(at_limit: float, at_wall: float, limits: SceneData, wall: SceneData) -> SceneData:
    """A pendulum, level at first; angles from below of its limit, and at which its bob touches a wall."""
    body = {
        "mass": 1.0,
        "com": [LENGTH, 0, 0],
        "inertia": [0, 0, 0],
        "shapes": {"bob": {"sphere": BOB, "position": [LENGTH, 0, 0], "surface": "bob"}},
    }
    joint = {
        "type": "revolute",
        "axis": [0, 1, 0],
        "parent": "ground",
        "child": "pendulum",
        "limit": {"upper": pi / 2 - at_limit, **limits},
    }
    plane = {
        "plane": [1, 0, 0],
        "position": [LENGTH * sin(at_wall) - BOB, 0, 0],
        "surface": "wall",
    }
    return scene(
        {"pendulum": body}, {"A": joint}, {"wall": plane}, {"hit": {"between": ["bob", "wall"], **wall}}
    )


@pytest.mark.parametrize(("limit", "wall"), [(0.3, 0.6), (0.6, 0.3), (0.0, 0.7), (0.5, 0.5)])
def test_a_limit_and_a_wall_are_struck_at_the_same_instant(limit: float, wall: float) -> None:
    """Newton's law for both: the larger restitution decides on the speed afterwards."""
    made = pendulum(0.2, 0.2, {"restitution": limit}, {"restitution": wall})
    w = sqrt(2 * G * cos(0.2) / LENGTH)
    run = gelenk.simulate(made, stop=1, step=1e-3, tolerance=1e-10, integrator="erk", outputs=["A.*", "E.*"])
    first = run.events[0][0]
    after = int(np.searchsorted(run.time, first))
    energy = run["E.kinetic"] + run["E.potential"]
    lowest = -G * LENGTH * cos(0.2)
    e = max(limit, wall)
    assert energy[after] - lowest == pytest.approx(e**2 * LENGTH**2 * w**2 / 2, rel=1e-8)
    assert {text for t, text in run.events if abs(t - first) < 1e-9} == {
        "A.phi meets its upper limit",
        "hit: pendulum touches the ground",
    }


@pytest.mark.parametrize("earlier", [0.0, 1e-3])
def test_a_limit_and_a_wall_end_in_rest(earlier: float) -> None:
    """One after the other, in turn: where the limit is first, the wall is never touched."""
    made = pendulum(0.2 + earlier, 0.2, {"restitution": 0.4}, {"restitution": 0.3})
    run = gelenk.simulate(made, stop=4, step=0.01, tolerance=1e-9, integrator="erk")
    assert run["A.w"][-1] == 0
    assert run["A.phi"][-1] == pytest.approx(pi / 2 - 0.2 - earlier, abs=1e-9)
    held = G * LENGTH * sin(0.2 + earlier)
    by_wall = run["hit.f[1]"][-1] * LENGTH * cos(0.2 + earlier)
    assert by_wall - run["A.limit.tau"][-1] == pytest.approx(held, abs=1e-8)
    if earlier:
        assert run["hit.f[1]"][-1] == 0


def two_links(integrator: str) -> SceneData:
    """Two links with friction and limits that fall on the floor, and a ball that falls on them."""

    def link(parent: str, child: str, x: float, limit: SceneData) -> SceneData:
        return {
            "type": "revolute",
            "axis": [0, 1, 0],
            "parent": {"body": parent, "position": [x, 0, 0.5 if parent == "ground" else 0]},
            "child": child,
            "friction": {"coulomb": 0.3},
            "limit": limit,
        }

    rod = {
        "mass": 1.0,
        "com": [0.3, 0, 0],
        "inertia": [0.001, 0.03, 0.03],
        "shapes": {
            "tube": {
                "capsule": {"radius": 0.03, "length": 0.6},
                "position": [0.3, 0, 0],
                "rotation": {"axis": [0, 1, 0], "angle": pi / 2},
                "surface": "tube",
            }
        },
    }
    out = scene(
        {
            "upper": rod,
            "lower": rod,
            "ball": {
                "mass": 0.5,
                "inertia": [0.4 * 0.5 * 0.0025] * 3,
                "shapes": {"s": {"sphere": 0.05, "surface": "ball"}},
            },
        },
        {
            "A": link("ground", "upper", 0, {"upper": 0.5, "restitution": 0.2}),
            "B": link("upper", "lower", 0.6, {"lower": -0.3, "upper": 0.6}),
            "J": free("ball", [0.25, 0, 0.75]),
        },
        {"floor": {"plane": [0, 0, 1], "surface": "floor"}},
        {
            "floor": {"between": ["tube", "floor"], "friction": 0.3},
            "top": {"between": ["ball", "tube"], "friction": 0.4},
            "end": {"between": ["ball", "floor"], "friction": 0.4},
        },
    )
    out["solver"] = {"integrator": integrator}
    return out


def test_steps_with_impulses_converge_to_located_events() -> None:
    """Of order 1 over a factor of 40 in the step: differences of at most 1 m/s or rad/s times the step.

    How far they are below varies with where impacts fall within steps: speeds here are up to 10 rad/s.
    """
    names = ["A.phi", "B.phi", "J.r[1]", "J.r[3]"]
    stop = 0.6
    exact = gelenk.simulate(two_links("erk"), stop=stop, step=0.05, tolerance=1e-10, outputs=[*names, "E.*"])
    energy = exact["E.kinetic"] + exact["E.potential"]
    assert np.diff(energy).max() <= 1e-8
    for step in (2e-3, 5e-4, 2e-4, 5e-5):
        made = two_links("moreau-jean") | {"experiment": {"step": step}}
        run = gelenk.simulate(made, stop=stop, step=step, outputs=names)
        rows = [int(np.abs(run.time - t).argmin()) for t in exact.time]
        assert max(np.abs(run[name][rows] - exact[name]).max() for name in names) <= step


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_integrators_agree(integrator: str) -> None:
    names = ["A.phi", "B.phi", "J.r[1]", "J.r[3]"]
    runs = [
        gelenk.simulate(two_links(which), stop=0.6, step=0.1, tolerance=1e-9, outputs=names)
        for which in ("erk", integrator)
    ]
    for name in names:
        assert np.abs(runs[0][name] - runs[1][name]).max() <= 1e-6


@pytest.mark.parametrize("time", [0.1, 0.25, 0.4, 0.6])
def test_a_restored_run_continues_with_the_same_bits(time: float) -> None:
    assert_restored_run_continues(two_links("erk"), time, [0.2, 0.4])
