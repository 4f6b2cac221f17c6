# SPDX-License-Identifier: BSD-3-Clause
"""Hard limits of joints: contact, release and impacts,
compared with closed forms and with a published problem.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, rod, scene
from models.running import assert_close

import gelenk

from .test_joint_friction import plant, read

pytestmark = warned.GUESSES

INTEGRATORS = ("auto", "erk", "cvode", "cvode-adams", "ida", "dirk", "rk4")


def ball(restitution: float, height: float = 1.0, floor: float = 0.1) -> Scene:
    """A body of 0.7 kg on a vertical guide above its lower limit, with a motor."""
    return scene(
        {"ball": body(0.7)},
        {
            "J": joint(
                "prismatic",
                frame("ground"),
                frame("ball"),
                limit={"lower": floor, "restitution": restitution},
                start={"s": floor + height, "v": 0.0, "fixed": True},
            )
        },
        motors={"lift": {"joint": "J"}},
        gravity=[0, 0, -GRAVITY],
    )


def bounces(restitution: float, height: float, time: float) -> tuple[float, float]:
    """Closed form: height above the floor and speed of a bouncing ball."""
    v = math.sqrt(2 * GRAVITY * height)
    t = time - v / GRAVITY
    if t < 0:
        return height - GRAVITY * time**2 / 2, -GRAVITY * time
    for _ in range(200):
        v *= restitution
        if t < 2 * v / GRAVITY:
            return v * t - GRAVITY * t**2 / 2, v - GRAVITY * t
        t -= 2 * v / GRAVITY
    return 0.0, 0.0


@warned.TIGHT
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_bouncing_ball_comes_to_rest(integrator: str, tolerance: float) -> None:
    """Infinitely many impacts until 1.3546 s; simulated are those higher than rounding."""
    simulation = plant(ball(0.5), tolerance, integrator)
    for t in (0.3, 0.6, 1.0, 1.2, 1.3, 1.35):
        simulation.step_to(t)
        height, speed = bounces(0.5, 1.0, t)
        # 100 times the tolerance is the goal; constant accelerations are easy
        assert_close("J.s", read(simulation, "J.s"), 0.1 + height, 10 * tolerance, "see above")
        assert_close("J.v", read(simulation, "J.v"), speed, 100 * tolerance, "see above")
    simulation.step_to(5.0)
    assert read(simulation, "J.v") == 0
    assert read(simulation, "J.a") == 0
    assert_close("J.s", read(simulation, "J.s"), 0.1, 2e-12, "lower rebounds are contact")
    first = math.log2(math.sqrt(2 * GRAVITY))
    last = math.log2(math.sqrt(2 * GRAVITY * 2e-12))  # lower rebounds are contact
    assert simulation.diagnostic("solver.events") == math.ceil(first - last)


def test_ball_without_restitution_stays() -> None:
    simulation = plant(ball(0.0))
    simulation.step_to(math.sqrt(2 / GRAVITY) + 1e-6)
    assert read(simulation, "J.v") == 0
    assert simulation.diagnostic("solver.events") == 1


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_elastic_impacts_keep_the_energy(integrator: str) -> None:
    """Ten bounces, which all reach the same height."""
    simulation = plant(ball(1.0), 1e-9, integrator)
    period = 2 * math.sqrt(2 / GRAVITY)
    for n in range(1, 11):
        simulation.step_to(n * period)
        # 1e-9 per step, some steps and 10 impacts
        assert_close("J.s", read(simulation, "J.s"), 1.1, 1e-7, "see above")
    assert simulation.diagnostic("solver.events") == 10


def test_contact_pushes_and_does_not_pull() -> None:
    """A motor lifts the ball from its limit where its force exceeds the weight."""
    simulation = plant(ball(0.3, height=0.0), lift__f=0.0)
    simulation.step_to(1.0)
    assert read(simulation, "J.s") == 0.1
    assert read(simulation, "J.v") == 0
    weight = 0.7 * GRAVITY
    simulation.set_input("lift.f", 0.999 * weight)
    simulation.step_to(2.0)
    assert read(simulation, "J.v") == 0
    simulation.set_input("lift.f", 1.5 * weight)
    assert_close("J.a", read(simulation, "J.a"), GRAVITY / 2, 1e-12, "one division")
    simulation.step_to(3.0)
    assert_close("J.s", read(simulation, "J.s"), 0.1 + GRAVITY / 4, 1e-7, "10 times the tolerance")
    assert simulation.diagnostic("solver.events") == 1


def test_contact_ends_within_a_step_where_its_force_becomes_zero() -> None:
    """The torque on a body at its limit grows from -1 to 1 N m in one step."""
    inertia = 0.5
    limited = wheel(inertia, limit={"lower": 0.4, "upper": 2.0}, phi=0.4, w=0.0)
    simulation = plant(limited, 1e-10, drive__tau=-1.0)
    simulation.set_input_derivative("drive.tau", 1, 2.0)
    simulation.step_to(1.0)
    assert_close(
        "J.phi", read(simulation, "J.phi"), 0.4 + 0.5**3 / (3 * inertia), 1e-9, "10 times the tolerance"
    )
    assert_close("J.w", read(simulation, "J.w"), 0.5**2 / inertia, 1e-9, "10 times the tolerance")
    (event,) = simulation.events
    assert event[0] == pytest.approx(0.5, abs=1e-11)
    assert event[1] == "J.phi leaves its lower limit"


def wheel(inertia: float, **fields: Any) -> Scene:
    """A wheel with a motor about a fixed axis."""
    start = {name: fields.pop(name) for name in ("phi", "w")}
    return scene(
        {"wheel": body(1.0, inertia=(0, 0, inertia))},
        {"J": joint("revolute", frame("ground"), frame("wheel"), start={**start, "fixed": True}, **fields)},
        motors={"drive": {"joint": "J"}},
    )


# Angle and speed by event-driven extrapolation in 80-bit arithmetic, checked by another integrator; the first
# impact also by an elliptic integral. Their own error is below 1e-15.
PENDULUM = {
    0.3: (0.5453382991036296, -5.902278094013525),
    0.5: (-0.0023764758975950875, 4.608590004931206),
    1.0: (0.8319367479805393, -2.5947649730758515),
    2.0: (0.20284344950118818, -3.241655715839608),
    3.0: (-0.11350936169573407, -2.5142319443031704),
    5.0: (-0.09604863525306835, -1.6998067691359462),
}
PENDULUM_IMPACTS = (
    0.4343581510950843,
    1.2795567990906487,
    2.152438167917506,
    3.0790572910897733,
    4.074387868026992,
)


@warned.TIGHT
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_pendulum_against_a_limit(integrator: str, tolerance: float) -> None:
    source = scene(
        {"p": {"mass": 1.2, "com": [0, 0, -0.4], "inertia": [0.02, 0.02, 0.02]}},
        {
            "J": joint(
                "revolute",
                frame("ground"),
                frame("p"),
                axis=[0, -1, 0],
                limit={"lower": -0.3, "restitution": 0.7},
                start={"phi": 1.5, "w": 0.0, "fixed": True},
            )
        },
        gravity=[0, 0, -GRAVITY],
    )
    simulation = plant(source, tolerance, integrator)
    impacts = []
    for t, (phi, w) in PENDULUM.items():
        simulation.step_to(t)
        impacts += [event[0] for event in simulation.events]
        # 2 times the tolerance measured, with cvode at 1e-10, which rounding limits to 1e-9; usually 0.1
        assert_close("J.phi", read(simulation, "J.phi"), phi, 20 * tolerance, "see above")
        assert_close("J.w", read(simulation, "J.w"), w, 20 * tolerance, "see above")
    assert_close("impacts", impacts, PENDULUM_IMPACTS, 20 * tolerance, "see above")


def elbow(restitution: float) -> Scene:
    """Two rods in a plane without gravity; the elbow is limited."""
    return scene(
        {"upper": rod(2.0, 1.0), "fore": rod(1.0, 0.8)},
        {
            "S": joint(
                "revolute", frame("ground"), frame("upper"), axis=[0, -1, 0], start={"phi": 0.3, "w": 0.5}
            ),
            "E": joint(
                "revolute",
                frame("upper", (1.0, 0, 0)),
                frame("fore"),
                axis=[0, -1, 0],
                limit={"lower": 0.0, "restitution": restitution},
                start={"phi": 1.0, "w": -2.0},
            ),
        },
        sensors={"total": {"type": "energy"}},
    )


@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_impact_of_an_elbow(restitution: float) -> None:
    """The angular momentum about the shoulder and Newton's law determine both speeds."""
    simulation = plant(elbow(restitution), 1e-11)
    while not simulation.events:
        simulation.step_to(simulation.time + 1e-3)
    after = read(simulation, "S.w"), read(simulation, "E.w")
    free = elbow(restitution)
    del free["joints"]["E"]["limit"]
    reference = plant(free, 1e-11)
    (event,) = simulation.events
    reference.step_to(event[0])
    before = read(reference, "S.w"), read(reference, "E.w")
    # straight: moments of inertia of both about the shoulder, of the forearm about both joints
    both = 2 / 3 + 0.8**2 / 12 + 1.4**2
    fore = 0.8**2 / 12 + 0.4 * 1.4
    expected_elbow = -restitution * before[1]
    expected_shoulder = before[0] + fore / both * (before[1] - expected_elbow)
    # the rest of the step of 1 ms after the impact
    simulation = plant(elbow(restitution), 1e-11)
    simulation.step_to(math.nextafter(event[0], 10))
    after = read(simulation, "S.w"), read(simulation, "E.w")
    assert_close("speeds", after, (expected_shoulder, expected_elbow), 1e-9, "100 times the tolerance")


def four_bar(limited: str = "", **limit: float) -> Scene:
    """A four-bar linkage without gravity, one joint of which is limited; its loop may be cut there."""
    joints = {
        "A": joint(
            "revolute",
            frame("ground"),
            frame("crank"),
            axis=[0, -1, 0],
            start={"phi": 1.0, "w": 1.0, "fixed": True},
        ),
        "B": joint("revolute", frame("crank", (0.5, 0, 0)), frame("coupler"), axis=[0, -1, 0]),
        "C": joint("revolute", frame("coupler", (1.75, 0, 0)), frame("rocker", (1.5, 0, 0)), axis=[0, -1, 0]),
        "D": joint(
            "revolute", frame("ground", (2, 0, 0)), frame("rocker"), axis=[0, -1, 0], start={"phi": 1.9}
        ),
    }
    if limited:
        joints[limited]["limit"] = limit
    return scene({"crank": rod(1, 0.5), "coupler": rod(3.5, 1.75), "rocker": rod(3, 1.5)}, joints)


@pytest.mark.parametrize("name", ["A", "B", "C", "D"])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_any_joint_of_a_linkage_can_be_limited(name: str, restitution: float) -> None:
    """With one degree of freedom, an impact multiplies all speeds by -restitution."""
    free = plant(four_bar(), 1e-11)
    free.step_to(0.3)
    bound = read(free, f"{name}.phi")
    side = "upper" if read(free, f"{name}.w") > 0 else "lower"
    before = np.array([read(free, f"{joint}.w") for joint in "ABCD"])
    limited = plant(four_bar(name, **{side: bound, "restitution": restitution}), 1e-11)
    limited.step_to(0.29)
    assert not limited.events
    limited.step_to(0.3 + 1e-9)
    after = np.array([read(limited, f"{joint}.w") for joint in "ABCD"])
    # 100 times the tolerance, and 1 ns with accelerations of some rad/s2
    assert_close("speeds", after, -restitution * before, 1e-8, "see above")
    limited.step_to(0.6)
    if restitution == 0:
        assert_close("A.w", read(limited, "A.w"), 0, 1e-14, "rounding")
    else:
        # backward at half the speed
        free = plant(four_bar(), 1e-11)
        free.step_to(0.15)
        assert_close("A.phi", read(limited, "A.phi"), read(free, "A.phi"), 1e-8, "as above")


def test_limits_of_two_joints_stop_a_linkage_together() -> None:
    """Both are reached at the same instant; one of them is redundant."""
    free = plant(four_bar(), 1e-11)
    free.step_to(0.3)
    source = four_bar()
    for name in "AD":
        side = "upper" if read(free, f"{name}.w") > 0 else "lower"
        source["joints"][name]["limit"] = {side: read(free, f"{name}.phi"), "restitution": 0.5}
    limited = plant(source, 1e-11)
    limited.step_to(0.6)
    free = plant(four_bar(), 1e-11)
    free.step_to(0.15)
    assert_close("A.phi", read(limited, "A.phi"), read(free, "A.phi"), 1e-8, "1000 times the tolerance")


def test_friction_holds_at_a_limit_too() -> None:
    """A wheel rests at its limit until the torque away from it exceeds friction."""
    source = wheel(0.5, limit={"upper": 1.0}, friction={"coulomb": 2.0}, phi=1.0, w=0.0)
    simulation = plant(source, drive__tau=50.0)
    for t, torque in enumerate((50.0, -1.9, 0.0, -1.9), 1):
        simulation.set_input("drive.tau", torque)
        simulation.step_to(float(t))
        assert read(simulation, "J.phi") == 1.0
        assert read(simulation, "J.w") == 0
    simulation.set_input("drive.tau", -2.5)
    simulation.step_to(5.0)
    assert_close("J.w", read(simulation, "J.w"), -0.5 / 0.5, 1e-8, "the tolerance")


def test_friction_acts_during_the_flight() -> None:
    """Impacts end when friction has taken the energy; closed form of each flight."""
    inertia, moment, tau, e = 0.5, 0.2, -1.0, 0.8
    source = wheel(
        inertia, limit={"lower": 0.0, "restitution": e}, friction={"coulomb": moment}, phi=1.0, w=0.0
    )
    simulation = plant(source, 1e-10, drive__tau=tau)
    down, up = (-tau - moment) / inertia, (-tau + moment) / inertia
    t = math.sqrt(2 / down)
    speed = down * t
    heights = []
    for _ in range(5):
        speed *= e
        heights.append(speed**2 / (2 * up))
        t += speed / up
        simulation.step_to(t)
        assert_close("J.phi", read(simulation, "J.phi"), heights[-1], 1e-9, "10 times the tolerance")
        t += math.sqrt(2 * heights[-1] / down)
        speed = math.sqrt(2 * heights[-1] * down)


@pytest.mark.parametrize("time", [0.2, 1.3, 1.3545, 2.0])
def test_restored_run_continues_with_the_same_bits(time: float) -> None:
    """In flight, within the series of impacts, near its end, and at rest."""
    first = plant(ball(0.5))
    first.step_to(time)
    saved = first.save()
    second = plant(ball(0.5))
    second.restore(saved)
    for simulation in (first, second):
        simulation.step_to(time + 0.3)
        simulation.set_input("lift.f", 10.0)
        simulation.step_to(time + 0.6)
        simulation.set_input("lift.f", 0.0)
        simulation.step_to(time + 3.0)
    assert list(first.values()) == list(second.values())


def test_reading_outputs_does_not_change_the_run() -> None:
    """A force that would lift the ball is set, outputs are read, and it is removed again."""
    first, second = (plant(ball(0.5, height=0.0), lift__f=0.0) for _ in range(2))
    first.set_input("lift.f", 10.0)
    assert read(first, "J.a") == pytest.approx(10 / 0.7 - GRAVITY, abs=1e-12)
    first.set_input("lift.f", 0.5)
    second.set_input("lift.f", 0.5)
    for simulation in (first, second):
        simulation.step_to(1.0)
    assert list(first.values()) == list(second.values())
    assert read(first, "J.v") == 0


def test_start_beyond_a_limit_is_refused() -> None:
    source = wheel(0.5, limit={"upper": 0.9}, phi=1.0, w=0.0)
    with pytest.raises(
        gelenk.SceneError, match=r"joints.J.limit.upper: found a start with phi 0.1 rad beyond it, expected"
    ):
        plant(source)


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ({"lower": 1.0, "upper": 0.5}, "joints.J.limit.lower: found 1 rad, expected less than upper"),
        ({"lower": 0.0, "restitution": 1.1}, "joints.J.limit.restitution: found 1.1, expected 0 to 1"),
        ({"restitution": 0.5}, "joints.J.limit: "),
    ],
)
def test_wrong_limits_are_refused(limit: dict[str, float], message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.load(wheel(0.5, limit=limit, phi=0.2, w=0.0))
