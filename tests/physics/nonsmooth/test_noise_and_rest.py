# SPDX-License-Identifier: BSD-3-Clause
"""What rests does not creep, and noise in the inputs causes no events but those of the motion."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

from .test_joint_friction import FOUR_BAR_REVERSALS, INTEGRATORS, four_bar_with_friction, plant, read, wheel

HOUR = 3600.0


def block(angle: float) -> Scene:
    """A block on an incline, held by a friction of 3 N."""
    axis = [math.cos(angle), 0, math.sin(angle)]
    return scene(
        {"block": body(1.0)},
        {
            "J": joint(
                "prismatic", frame("ground"), frame("block"), axis=axis,
                friction={"coulomb": 2.9, "static": 3.0}, start={"s": 0.2, "v": 0.0, "fixed": True},
            )
        },
        motors={"push": {"joint": "J"}},
        gravity=[0, 0, -GRAVITY],
    )  # fmt: skip


def held_four_bar() -> Scene:
    """At rest under gravity, held by more friction than it needs; a motor at its crank."""
    source = four_bar_with_friction()
    source["joints"]["A"]["start"]["w"] = 0.0
    for name in "ABCD":
        source["joints"][name]["friction"] = {"coulomb": 30.0}
    source["motors"] = {"push": {"joint": "A"}}
    return source


def held_elbow() -> Scene:
    """Two links in space, one beside the other, stretched out; both joints hold their weight."""
    link = body(1.0, com=(0.25, 0, 0), inertia=(0.01, 0.02, 0.02))
    hold = {"friction": {"coulomb": 25.0}, "start": {"phi": 0.0, "w": 0.0, "fixed": True}}
    return scene(
        {"upper": link, "lower": link},
        {
            "J": joint("revolute", frame("ground"), frame("upper"), axis=[0, 1, 0], **hold),
            "K": joint("revolute", frame("upper", (0.5, 0, 0)), frame("lower"), axis=[0, 0.8, 0.6], **hold),
        },
        motors={"push": {"joint": "K"}},
        gravity=[0, 0, -GRAVITY],
    )


@pytest.mark.parametrize(
    ("source", "push", "load"),
    [
        (wheel({"coulomb": 1.5, "static": 2.0}, phi=0.3, w=0.0), "drive.tau", 1.99),
        (block(math.asin(0.3)), "push.f", 0.04),  # 2.94 N of its weight and more
        (held_four_bar(), "push.tau", 5.0),
        (held_elbow(), "push.tau", 3.0),
    ],
    ids=["wheel", "block on an incline", "four-bar, held redundantly", "elbow in space"],
)
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_nothing_creeps_within_an_hour(source: Scene, push: str, load: float, integrator: str) -> None:
    """The position keeps its bits under a load that alternates every second."""
    simulation = plant(source, integrator=integrator)
    names = [s.name for s in simulation.outputs if s.name.rpartition(".")[2] not in ("tau", "f", "mode")]
    before = simulation.values(names).tolist()
    for k in range(360):
        simulation.set_input(push, load if k % 2 else -load / 3)
        simulation.step_to(HOUR / 360 * (k + 1))
    assert simulation.values(names).tolist() == before
    assert simulation.diagnostic("solver.events") == 0


def count_events(source: Scene, push: str, torque: Callable[[float], float], noise: float) -> float:
    """Run for 3 s in steps of 5 ms, with another noise in each."""
    random = np.random.default_rng(1)
    simulation = plant(source)
    for k in range(600):
        t = 0.005 * k
        simulation.set_input(push, torque(t) + noise * random.uniform(-1, 1))
        simulation.step_to(t + 0.005)
    return simulation.diagnostic("solver.events")


@pytest.mark.parametrize("noise", [1e-9, 1e-6])
def test_noise_does_not_cause_events(noise: float) -> None:
    """At rest below the limit, breaking away and stopping: as often as without noise."""
    source = wheel({"coulomb": 1.5, "static": 2.0}, phi=0.0, w=0.0)

    def torque(t: float) -> float:
        return 2.5 * math.sin(2 * math.pi * t)

    # It breaks away in each of the six half periods, and stops in the next one.
    assert count_events(source, "drive.tau", torque, 0.0) == 11
    assert count_events(source, "drive.tau", torque, noise) == 11
    assert count_events(source, "drive.tau", lambda _: 1.999, noise) == 0


@pytest.mark.parametrize("noise", [1e-9])
def test_noise_in_a_linkage_with_friction_in_all_joints(noise: float) -> None:
    """Reversals of single joints, with a motor on the crank, as often as without noise."""
    source = four_bar_with_friction()
    source["motors"] = {"push": {"joint": "A"}}
    simulation = plant(source)
    random = np.random.default_rng(2)
    for k in range(1200):
        simulation.set_input("push.tau", noise * random.uniform(-1, 1))
        simulation.step_to(0.005 * (k + 1))
    assert simulation.diagnostic("solver.events") == FOUR_BAR_REVERSALS
    assert read(simulation, "A.phi") == pytest.approx(
        33.61464192001791, abs=1e-6
    )  # moved by the noise by 1e-7
