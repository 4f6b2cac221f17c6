# SPDX-License-Identifier: BSD-3-Clause
"""Friction and limits at the edge of their laws: no force at all, no friction,
a start that approaches a bound, rebounds that contradict each other, a departure that rounding hides,
contacts that open for an instant.
"""

from __future__ import annotations

import math

import pytest
import warned
from mechanisms import Scene, body, frame, joint, scene
from models.running import assert_close

from .test_joint_friction import plant, read, wheel
from .test_joint_limits import INTEGRATORS, ball, bounces, elbow, four_bar
from .test_joint_limits import wheel as limited_wheel

pytestmark = warned.GUESSES


def test_friction_of_zero_does_not_hold() -> None:
    simulation = plant(wheel({"coulomb": 0.0}, phi=0.0, w=0.0), drive__tau=1.0)
    simulation.step_to(1.0)
    assert read(simulation, "J.w") == pytest.approx(2.0, abs=1e-7)  # 10 times the tolerance
    simulation.set_input("drive.tau", -1.0)
    simulation.step_to(3.0)
    assert read(simulation, "J.w") == pytest.approx(-2.0, abs=1e-7)


@pytest.mark.parametrize("w", [0.0, 1.0])
def test_contact_without_any_force(w: float) -> None:
    """A wheel at its bound rests there, or leaves it."""
    source = wheel({"coulomb": 0.0}, phi=0.0, w=w)
    del source["joints"]["J"]["friction"]
    source["joints"]["J"]["limit"] = {"lower": 0.0}
    simulation = plant(source, drive__tau=0.0)
    simulation.step_to(1.0)
    assert read(simulation, "J.w") == w
    assert read(simulation, "J.phi") == pytest.approx(w, abs=1e-12)
    assert simulation.events == []


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_start_that_approaches_its_bound_is_an_impact(restitution: float) -> None:
    source = ball(restitution, height=0.0)
    speed = 2.0
    source["joints"]["J"]["start"]["v"] = -speed
    simulation = plant(source, lift__f=0.0)
    simulation.step_to(0.05)
    fall = speed / 9.81
    expected = bounces(restitution, speed**2 / (2 * 9.81), fall + 0.05) if restitution else (0.0, 0.0)
    assert read(simulation, "J.v") == pytest.approx(expected[1], abs=1e-7)  # 10 times the tolerance
    assert read(simulation, "J.s") == pytest.approx(0.1 + expected[0], abs=1e-7)
    assert simulation.events[0] == (0.0, "J.s meets its lower limit")


def test_rebounds_that_contradict_each_other_end_at_rest() -> None:
    """A linkage of one degree of freedom: a bound of D demands a rebound, which a bound of A forbids."""
    free = plant(four_bar(), 1e-11)
    side = "upper" if read(free, "D.w") > 0 else "lower"
    source = four_bar("D", **{side: read(free, "D.phi"), "restitution": 1.0})
    source["joints"]["A"]["limit"] = {"lower": 1.0}
    simulation = plant(source, 1e-9)
    simulation.step_to(0.1)
    assert read(simulation, "A.w") == pytest.approx(0.0, abs=1e-14)  # rounding
    assert len(simulation.events) <= 2


@pytest.mark.parametrize("w", [0.0, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("restitution", [0.0, 0.7])
def test_unlike_restitutions_do_not_add_energy(w: float, restitution: float) -> None:
    """The shoulder rebounds while the elbow touches its limit, or departs more slowly than it is struck."""
    source = elbow(restitution)
    shoulder, fore = source["joints"]["S"], source["joints"]["E"]
    shoulder |= {"start": {"phi": 0.3, "w": -1.0, "fixed": True}, "limit": {"lower": 0.3, "restitution": 1.0}}
    fore["start"] = {"phi": 0.0, "w": w, "fixed": True}
    simulation = plant(source)
    before = read(simulation, "total.total")
    simulation.step_to(1e-6)
    assert read(simulation, "total.total") <= before * (1 + 1e-11)  # rounding
    assert read(simulation, "S.w") > -1e-14
    assert read(simulation, "E.w") > -1e-14


def double_pendulum() -> Scene:
    return scene(
        {"b1": body(1.0, (0, 0, 1.0)), "b5": body(1.0, inertia=(0.172, 0.02, 0.1656))},
        {
            "J1": joint("revolute", frame("ground", (1, 0, 0)), frame("b1", (1, 0, 0)), axis=[0, 1, 0]),
            "J4": joint("revolute", frame("b1", (0, 0, -1)), frame("b5", (0, 0, -1)), axis=[0, 1, 0],
                        start={"phi": 0.0, "w": 1.0, "fixed": True}, limit={"upper": 0.02}),
        },
    )  # fmt: skip


def test_departure_after_an_impact_is_not_another_contact() -> None:
    """Where it leaves its bound, by centrifugal force, rounding has it beyond the bound and approaching."""
    simulation = plant(double_pendulum(), 1e-6)
    simulation.step_to(1.0)
    assert len(simulation.events) == 1
    assert simulation.diagnostic("solver.evaluations") < 3000
    assert read(simulation, "J4.w") < 0


@pytest.mark.parametrize("integrator", ["erk", "dirk", "ida", "cvode", "cvode-adams"])
def test_rest_is_exact_with_implicit_methods_too(integrator: str) -> None:
    """An elbow stuck by friction, on a shoulder that turns on."""
    source = scene(
        {"upper": body(1.0, inertia=(0.1, 0.18, 0.09)), "fore": body(1.0, inertia=(0.06, 0.1, 0.09))},
        {
            "S": joint("revolute", frame("ground"), frame("upper"), axis=[1, 0, 0], start={"w": 0.5}),
            "E": joint("revolute", frame("upper"), frame("fore"), axis=[0, 1, 1], friction={"coulomb": 1.0},
                       start={"phi": 0.0, "w": 1.0, "fixed": True}),
        },
    )  # fmt: skip
    simulation = plant(source, 1e-6, integrator)
    simulation.step_to(0.3)
    position = read(simulation, "E.phi")
    for k in range(20):
        simulation.step_to(0.3 + 0.05 * (k + 1))
        assert read(simulation, "E.w") == 0
        assert read(simulation, "E.phi") == position
    assert not math.isclose(read(simulation, "S.w"), 0)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("start", "speed"), [(0.2, 0.0), (0.3, -1.0)])
def test_contact_without_a_force_remains(integrator: str, start: float, speed: float) -> None:
    """Neither rounding nor a force of zero decides: there are no further events."""
    source = limited_wheel(0.5, limit={"lower": 0.2}, phi=start, w=speed)
    simulation = plant(source, 1e-8, integrator, drive__tau=0.0)
    simulation.step_to(1.0)
    assert read(simulation, "J.w") == 0
    assert_close("J.phi", read(simulation, "J.phi"), 0.2, 1e-12, "rounding of the impact")
    assert simulation.diagnostic("solver.events") == (1 if speed else 0)
    simulation.set_input("drive.tau", 1e-9)  # lifts it by 1e-9 rad in 1 s
    simulation.step_to(2.0)
    assert_close("J.phi", read(simulation, "J.phi"), 0.2 + 1e-9, 1e-11, "a hundredth of the motion")


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_impact_at_a_communication_point(integrator: str) -> None:
    """The bound is reached at the end of a step, within rounding: at 0.1 s."""
    source = limited_wheel(0.5, limit={"lower": 0.2, "restitution": 0.5}, phi=0.3, w=-1.0)
    simulation = plant(source, 1e-8, integrator, drive__tau=0.0)
    for k in range(1, 11):
        simulation.step_to(0.02 * k)
    assert_close("J.w", read(simulation, "J.w"), 0.5, 1e-12, "rounding")
    assert_close("J.phi", read(simulation, "J.phi"), 0.25, 1e-8, "the tolerance")
    assert simulation.diagnostic("solver.events") == 1


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_motion_begins_at_no_speed(integrator: str) -> None:
    """The torque overcomes friction; the speed at the start is rounding, in the other direction."""
    simulation = plant(wheel({"coulomb": 1.0}, phi=0.0, w=-1e-16), 1e-8, integrator, drive__tau=2.0)
    simulation.step_to(1e-20)
    assert read(simulation, "J.w") >= 0
    simulation.step_to(1.0)
    assert_close("J.w", read(simulation, "J.w"), 2.0, 1e-8, "the tolerance")
    assert simulation.diagnostic("solver.events") == 0


def two_fingers(inertia: float, coulomb: float, w: float) -> Scene:
    """Mirrored fingers, pressed against their limits by springs, on an arm that friction keeps at rest."""
    finger = {"inertia": (0, 0, 1e-3)}
    return scene(
        {"arm": body(1.0, inertia=(0, 0, inertia)), "f": body(1e-3, **finger), "g": body(1e-3, **finger)},
        {
            "A": joint("revolute", frame("ground"), frame("arm"), friction={"coulomb": coulomb},
                       start={"phi": 0.0, "fixed": True}),
            "F": joint("revolute", frame("arm"), frame("f"), limit={"lower": 0.0}, stiffness=1e-3,
                       spring_reference=-1.0, start={"phi": 0.1, "w": -1.0, "fixed": True}),
            "G": joint("revolute", frame("arm"), frame("g"), limit={"upper": 0.0}, stiffness=1e-3,
                       spring_reference=1.0, start={"phi": -0.2, "w": w, "fixed": True}),
        },
    )  # fmt: skip


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("inertia", "coulomb", "w"), [(0.1, 50.0, 1.0), (0.01, 1.0, 0.3)])
def test_contacts_that_an_impact_opens_for_an_instant(
    integrator: str, inertia: float, coulomb: float, w: float
) -> None:
    """An impact of one finger lets the arm slip, which pulls the other finger off for 1e-9 s and less, until
    the arm sticks. Each return throws off less, so that the series ends after some ten impacts.
    """
    simulation = plant(two_fingers(inertia, coulomb, w), integrator=integrator)
    simulation.step_to(1.0)
    assert [read(simulation, f"{name}.w") for name in "AFG"] == [0, 0, 0]
    assert [read(simulation, f"{name}.limit.mode") for name in "FG"] == [-1, 1]
    assert_close("phi", [read(simulation, f"{name}.phi") for name in "FG"], 0.0, 1e-12, "contact's tolerance")
    assert simulation.diagnostic("solver.impacts") <= 20
    assert simulation.diagnostic("solver.events") <= 60  # each impact lets the arm slip and stick
