# SPDX-License-Identifier: BSD-3-Clause
"""A prescribed motion that jumps is an impact; what it does not move stays at rest."""

from __future__ import annotations

import math
from typing import Any

import pytest
from mechanisms import GRAVITY, frame, joint, rod, scene

import gelenk

STEP = 0.02  # s
# A horizontal link: its weight needs far more than sliding friction, and less than static friction.
MASS, LENGTH = 1.0, 0.5
MOMENT = MASS * GRAVITY * LENGTH / 2


def held_beside_a_slide(loop: bool) -> Any:
    """A link that static friction holds, in a loop or not, and a slide whose position is an input."""
    bodies = {"slide": {"mass": 1.0}, "arm": rod(MASS, LENGTH)}
    joints = {
        "drive": joint("prismatic", frame("ground", (0, 1, 0)), frame("slide"), axis=(1, 0, 0)),
        "pivot": joint(
            "revolute", frame("ground"), frame("arm"), axis=(0, 1, 0),
            friction={"coulomb": 0.01 * MOMENT, "static": 10 * MOMENT},
            start={"phi": 0.0, "w": 0.0, "fixed": True},
        ),
    }  # fmt: skip
    if loop:  # of five links, of which the others swing
        lengths = {"arm": LENGTH, "one": 0.4, "two": 0.45, "three": 0.3}
        guesses = {"one": 1.1, "two": -0.28, "three": 2.61}
        bodies |= {name: rod(0.1, length) for name, length in list(lengths.items())[1:]}
        for (inner, length), outer in zip(lengths.items(), list(lengths)[1:], strict=False):
            joints[outer] = joint(
                "revolute",
                frame(inner, (length, 0, 0)),
                frame(outer),
                axis=(0, 1, 0),
                start={"phi": guesses[outer]},
            )
        joints["one"]["start"] |= {"w": 2.0, "fixed": True}
        joints["far"] = joint(
            "revolute", frame("three", (0.3, 0, 0)), frame("ground", (0.7, 0, -0.6)), axis=(0, 1, 0)
        )
    source = scene(bodies, joints, gravity=[0, 0, -GRAVITY])
    source["constraints"] = {"m": {"type": "motion", "joint": "drive", "input": "position"}}
    source["forces"] = {
        "spring": {"type": "spring_damper", "from": "arm", "to": "slide", "stiffness": 1e-9, "length": 1.0}
    }
    source["solver"] = {"integrator": "erk"}
    return source


def set_motion(plant: gelenk.Simulation, position: float, speed: float) -> None:
    plant.set_input("m.s_ref", position)
    plant.set_input_derivative("m.s_ref", 1, speed)


@pytest.mark.parametrize("loop", [False, True])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "rk4"])
def test_what_a_jump_does_not_move_stays_at_rest(integrator: str, loop: bool) -> None:
    """It had no static friction for an instant, and slid from there, without an event."""
    source = held_beside_a_slide(loop)
    source["solver"]["integrator"] = integrator
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, 1e-8)
    for k in range(50):
        set_motion(plant, 0.1 * (k % 3), 1.0 - k % 2)
        plant.step_to((k + 1) * STEP)
        assert plant.output("pivot.phi") == pytest.approx(0, abs=1e-12)
        assert plant.output("pivot.w") == 0
        assert plant.output("pivot.friction.mode") == 0
        assert not [text for _, text in plant.events if "pivot" in text]


@pytest.mark.parametrize(
    ("tolerance", "jump", "slides"),
    [
        (1e-8, 0.5, True),
        (1e-8, 2e-6, True),
        (1e-8, 3e-7, False),
        (1e-9, 2e-7, True),
        (1e-11, 2e-9, True),
        (1e-11, 3e-10, False),
    ],
)
def test_what_a_jump_moves_slides_and_says_so(tolerance: float, jump: float, slides: bool) -> None:
    """The slide carries the link: friction exerts no impulse, and cannot stop it from there.

    The impact sets the link in motion with 0.15 /m of the jump [m/s]; below ten times the tolerance, or
    1e-10 rad/s, it may be one of the derivatives that a master sends, which end with some order.
    """
    source = held_beside_a_slide(loop=False)
    source["joints"]["pivot"]["parent"] = frame("slide")
    del source["forces"]
    source["joints"]["pivot"]["start"]["phi"] = 0.05
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, tolerance)
    set_motion(plant, 0.0, 0.0)
    plant.step_to(STEP)
    assert plant.output("pivot.w") == 0
    set_motion(plant, 0.0, jump)
    plant.step_to(1.5 * STEP)
    assert any(text.startswith("pivot.phi slips") and t == STEP for t, text in plant.events) == slides
    assert (plant.output("pivot.friction.mode") != 0) == slides
    assert (plant.output("pivot.w") != 0) == slides


@pytest.mark.parametrize("jump", [5e-10, -5e-10])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida"])
def test_what_a_small_jump_moves_one_way_and_a_force_the_other_starts_from_rest(
    integrator: str, jump: float
) -> None:
    """Where friction ends at the same time: steps of cvode, and of dirk, became as short as rounding.

    The block on the slide is at rest, held by friction against a force of 1 N. At STEP the friction ends,
    and the slide jumps by less than the tolerance, so that the block moves a little, forwards or
    backwards, before it is accelerated forwards. From rest, each method makes less than 100 steps to the next
    communication point, of up to 7 stages with 2 or 3 iterations: 2,000 evaluations are enough. Steps as
    short as rounding take any number of them.
    """
    source = scene(
        {"slide": {"mass": 1.0}, "block": {"mass": 1.0}},
        {
            "drive": joint("prismatic", frame("ground"), frame("slide"), axis=(1, 0, 0)),
            "track": joint(
                "prismatic", frame("slide"), frame("block"), axis=(1, 0, 0),
                friction={"coulomb": 2.0, "input": "engagement"},
                start={"s": 0.0, "v": 0.0, "fixed": True}, stiffness=10.0,
            ),
        },
        gravity=[0, 0, 0],
        constraints={"m": {"type": "motion", "joint": "drive", "input": "position"}},
        motors={"push": {"joint": "track"}},
        solver={"integrator": integrator, "max_evaluations": 2000},
    )  # fmt: skip
    plant = gelenk.Simulation(source)
    plant.set_input("track.friction.engagement", 1.0)
    plant.set_input("push.f", 1.0)
    plant.initialize(0.0, 1e-8)
    set_motion(plant, 0.0, 0.0)
    plant.step_to(STEP)
    assert plant.output("track.v") == 0
    set_motion(plant, 0.0, jump)
    plant.set_input("track.friction.engagement", 0.0)
    plant.step_to(2 * STEP)
    assert plant.output("track.v") == pytest.approx(math.sin(math.sqrt(10) * STEP) / math.sqrt(10), abs=1e-7)


@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside a wheel that turns"])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida"])
def test_derivatives_that_end_with_some_order_do_not_shake_what_is_held_loose(
    integrator: str, beside: bool
) -> None:
    """A block on a table that is shaken, with five derivatives of its position every 20 ms.

    Between static and sliding friction it remains at rest. At each communication point the speed jumps by
    what the series leaves out, 6e-9 m/s: the block broke away, unless something else turned quickly.
    """
    amplitude, frequency, mass = 1.0, 2.5, 1.6  # m, rad/s, kg
    most = mass * amplitude * frequency**2  # N, at t = 0
    source = scene(
        {"table": {"mass": 1.0}, "block": {"mass": mass}, "wheel": rod(1.0, 0.5)},
        {
            "drive": joint("prismatic", frame("ground"), frame("table"), axis=(1, 0, 0)),
            "slide": joint(
                "prismatic", frame("table"), frame("block"), axis=(1, 0, 0),
                friction={"coulomb": 0.5 * most, "static": 1.2 * most},
                start={"s": 0.0, "v": 0.0, "fixed": True},
            ),
            "hub": joint(
                "revolute", frame("ground", (0, 1, 0)), frame("wheel"), axis=(0, 0, 1),
                start={"phi": 0.0, "w": 5.0 if beside else 0.0, "fixed": True},
            ),
        },
        gravity=[0, 0, 0],
    )  # fmt: skip
    source["constraints"] = {"m": {"type": "motion", "joint": "drive", "input": "position"}}
    source["solver"] = {"integrator": integrator, "reductions": {"all": False}}
    plant = gelenk.Simulation(source)

    def send(t: float) -> None:
        for order in range(6):
            value = amplitude * frequency**order * math.cos(frequency * t + order * math.pi / 2)
            if order == 0:
                plant.set_input("m.s_ref", value)
            else:
                plant.set_input_derivative("m.s_ref", order, value)

    send(0.0)
    plant.initialize(0.0, 1e-8)
    for k in range(10):
        send(k * STEP)
        plant.step_to((k + 1) * STEP)
        assert plant.output("slide.friction.mode") == 0
    assert plant.output("slide.s") == pytest.approx(0, abs=1e-9)
    assert not plant.events
