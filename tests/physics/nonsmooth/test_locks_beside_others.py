# SPDX-License-Identifier: BSD-3-Clause
"""Locks of joints beside other locks, losses of gears and limits, where what they hold and strike meets."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from mechanisms import Scene, body, four_bar, frame, joint, rod, scene
from models.locks import LOCK, started
from models.running import assert_close

import gelenk

CORNERS = ((0.54, 0.84), (-0.81, 0.59), (-0.97, -0.22), (-0.28, -0.96), (0.85, -0.53), (1.2, 0.1))  # m


def closed_chain() -> Scene:
    """Five rods between two points of the ground, with a lock in each joint of the tree."""
    bodies, joints = {}, {}
    parent, heading = frame("ground", (*CORNERS[0], 0)), 0.0
    for i, (a, b) in enumerate(itertools.pairwise(CORNERS)):
        x, y = np.subtract(b, a)
        length, angle = float(np.hypot(x, y)), float(np.arctan2(y, x))
        bodies[f"b{i}"] = rod(1 + 0.3 * i, length)
        start = {"phi": angle - heading} | ({"w": 1.0, "fixed": True} if i == 0 else {})
        joints[f"J{i}"] = joint("revolute", parent, frame(f"b{i}"), start=start, lock=LOCK)
        parent, heading = frame(f"b{i}", (length, 0, 0)), angle
    joints["closing"] = joint("revolute", frame("ground", (*CORNERS[-1], 0)), parent)
    return scene(bodies, joints, gravity=[0, -9.81, 0])


@pytest.mark.parametrize("integrator", ["erk", "dirk", "cvode", "ida"])
def test_restored_in_another_instance_where_one_of_two_locks_is_released(integrator: str) -> None:
    """What remains locked is stopped with the factors of this position, not with those of a former one."""
    plant = started(closed_chain(), integrator, 1e-8)
    for t, inputs in (
        (0.2, {"J3": 1.0}),
        (0.4, {"J1": 1.0}),
        (0.6, {"J3": 0.0}),
        (0.8, {"J1": 0.0, "J3": 1.0}),
        (1.0, {"J1": 1.0}),
    ):
        plant.step_to(t)
        for name, value in inputs.items():
            plant.set_input(f"{name}.lock.engagement", value)
        other = started(closed_chain(), integrator, 1e-8)
        other.restore(plant.save())
        for each in (plant, other):
            each.step_to(t + 0.1)
        np.testing.assert_array_equal(other.values(), plant.values())


MOMENTS = {"a": 0.98, "b": 0.27, "c": 0.2}  # kg m2


def geared(efficiency: float, engaged: bool) -> Scene:
    """Two shafts with a gear at rest, and a disk on the second one that turns."""
    at = {"axis": [1, 0, 0]}
    return scene(
        {name: body(1, inertia=(moment,) * 3) for name, moment in MOMENTS.items()},
        {
            "A": joint(
                "revolute",
                frame("ground"),
                frame("a"),
                start={"w": 0.0, "fixed": True},
                friction={"coulomb": 0.0},
                **at,
            ),
            "B": joint("revolute", frame("ground", (0, 1, 0)), frame("b"), **at),
            "C": joint(
                "revolute",
                frame("b"),
                frame("c"),
                start={"w": 1.0, "fixed": True},
                lock={**LOCK, "engaged": engaged},
                **at,
            ),
        },
        constraints={
            "g": {"type": "gear", "joint": "A", "with": "B", "ratio": 1.0, "efficiency": efficiency}
        },
    )


@pytest.mark.parametrize("integrator", ["erk", "cvode", "moreau-jean"])
@pytest.mark.parametrize("efficiency", [0.4, 0.9])
@pytest.mark.parametrize("engaged", [True, False])
def test_losses_of_gears_do_not_feel_the_impulses(integrator: str, efficiency: float, engaged: bool) -> None:
    """A self-locking gear is set in motion as one without losses, and turns on without a load."""
    solver = {"step": 1e-3} if integrator == "moreau-jean" else {}
    plant = started(geared(efficiency, engaged), integrator, 1e-9, **solver)
    if not engaged:
        plant.step_to(0.01)
        plant.set_input("C.lock.engagement", 1.0)
    plant.step_to(0.02)
    common = MOMENTS["c"] / sum(MOMENTS.values())
    assert_close("A.w", plant.output("A.w"), common, 1e-12, "rounding")
    plant.step_to(0.05)
    assert_close("A.w", plant.output("A.w"), common, 1e-12, "rounding")
    assert_close("C.w", plant.output("C.w"), 0, 1e-12, "rounding")


@pytest.mark.parametrize("integrator", ["erk", "moreau-jean"])
def test_no_scheme_passes_over_a_lock_of_what_a_motion_moves(integrator: str) -> None:
    """Time steps find no impulses, and say so; released, the run goes on."""
    turning = scene(
        {"a": body(1, inertia=(0.5,) * 3), "b": body(1, (0.2, 0, 0), (0.2,) * 3)},
        {
            "A": joint("revolute", frame("ground"), frame("a"), lock=LOCK),
            "B": joint("revolute", frame("a", (0.5, 0, 0)), frame("b")),
        },
        constraints={"M": {"type": "motion", "joint": "A", "polynomial": [0, 1.0, 0.5]}},
    )
    solver = {"step": 1e-3} if integrator == "moreau-jean" else {}
    plant = started(turning, integrator, 1e-8, **solver)
    plant.step_to(0.1)
    plant.set_input("A.lock.engagement", 1.0)
    with pytest.raises(
        gelenk.StepError, match=r"A is locked, where no force can|A\.lock: it is engaged, and the"
    ):
        plant.step_to(0.2)
    plant.set_input("A.lock.engagement", 0.0)
    plant.step_to(0.2)
    assert_close("A", plant.output("A.phi"), 0.2 + 0.5 * 0.2**2, 1e-9, "the motion")


@pytest.mark.parametrize("locked", "ABCD")
def test_time_steps_stop_a_loop_in_motion(locked: str) -> None:
    """In the step of the impact, closing the loop leaves speeds of first order; later, none."""
    turning = four_bar()
    turning["joints"]["A"]["start"]["w"] = 15.0
    turning["joints"][locked]["lock"] = LOCK
    plant = started(turning, "moreau-jean", 1e-8, step=1e-3)
    plant.step_to(0.1)
    before = plant.diagnostics["energy.kinetic"]
    plant.set_input(f"{locked}.lock.engagement", 1.0)
    plant.step_to(0.101)
    assert plant.diagnostics["energy.kinetic"] < 1e-4 * before
    plant.step_to(0.2)
    assert_close("w", [plant.output(f"{name}.w") for name in "ABCD"], 0, 1e-9, "what solvers leave")


def slide_on_a_carriage(beside: str) -> Scene:
    """A slide of 4 kg on a carriage of 1 kg that is locked in the instant in which the slide meets its limit.

    Of its own, or beside something else that loses energy in the same instant, and never touches it.
    """
    bodies = {"carriage": body(1.0), "slide": body(4.0)}
    rail = joint("prismatic", frame("ground"), frame("carriage"), axis=[1, 0, 0], lock=LOCK)
    guide = joint("prismatic", frame("carriage"), frame("slide"), axis=[1, 0, 0])
    joints = {
        "rail": rail | {"start": {"s": 0.0, "v": -1.0, "fixed": True}},
        "guide": guide
        | {"start": {"s": 0.0, "v": 1.0, "fixed": True}, "limit": {"upper": 0.0, "restitution": 1.0}},
    }
    if beside != "nothing":
        bodies["rotor"] = body(1.0, inertia=(5.0,) * 3)
        joints["shaft"] = joint(
            "revolute", frame("ground", (0, 3, 0)), frame("rotor"), axis=[1, 0, 0],
            start={"phi": 0.0, "w": 9.0, "fixed": True}, **({"lock": LOCK} if beside == "lock" else {}),
        )  # fmt: skip
    if beside == "limit":
        joints["shaft"]["limit"] = {"upper": 0.0, "restitution": 0.0}
    return scene(bodies, joints, gravity=[0, 0, 0])


@pytest.mark.parametrize("beside", ["nothing", "lock", "limit"])
@pytest.mark.parametrize("all_reductions", [True, False])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "moreau-jean"])
def test_what_is_lost_elsewhere_pays_for_no_restitution(
    integrator: str, all_reductions: bool, beside: str
) -> None:
    """The slide is at rest when the carriage is locked: by Newton's law it would leave with 2 J out of 0.5 J.

    Restitution is reduced to what adds no energy, 4 kg v^2 / 2 = 1 kg (1 m/s)^2 / 2. A lock or a limit
    elsewhere lost more than that: all of the restitution was kept, in time steps also beside nothing.
    """
    of = slide_on_a_carriage(beside)
    of["solver"] = {"integrator": integrator, "step": 1e-4, "reductions": {"all": all_reductions}}
    plant = gelenk.Simulation(of)
    for name in [signal.name for signal in plant.inputs]:
        plant.set_input(name, 1.0)
    plant.initialize()
    plant.step_to(0.01)
    assert plant.output("rail.v") == pytest.approx(0, abs=1e-12)
    assert plant.output("guide.v") == pytest.approx(-0.5, abs=1e-5)
    assert plant.output("shaft.w") == pytest.approx(0, abs=1e-9) if beside != "nothing" else True


@pytest.mark.parametrize("integrator", ["erk", "moreau-jean"])
def test_impacts_that_no_impulses_permit_end_none_elsewhere(integrator: str) -> None:
    """A limit with restitution on a joint that a one-way clutch does not let return only stops it; another
    limit, which it does not touch, throws back as it did.
    """

    def shaft(y: float, name: str, **laws: object) -> dict[str, object]:
        start = {"phi": 0.0, "w": 2.0, "fixed": True}
        return joint("revolute", frame("ground", (0, y, 0)), frame(name), axis=[1, 0, 0], start=start, **laws)

    limit = {"upper": 0.0, "restitution": 0.5}
    of = scene(
        {"a": body(1.0, inertia=(1.0,) * 3), "b": body(1.0, inertia=(1.0,) * 3)},
        {
            "alone": shaft(0.0, "a", limit=limit),
            "clutched": shaft(1.0, "b", limit=limit, one_way={"free": "positive"}),
        },
        gravity=[0, 0, 0],
    )
    of["solver"] = {"integrator": integrator, "step": 1e-4, "reductions": {"all": False}}
    plant = gelenk.Simulation(of)
    plant.initialize()
    plant.step_to(0.01)
    assert plant.output("alone.w") == pytest.approx(-1.0, abs=1e-9)
    assert plant.output("clutched.w") == pytest.approx(0, abs=1e-9)
