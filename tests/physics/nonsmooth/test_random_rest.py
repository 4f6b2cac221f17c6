# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria at limits and poses held by friction, of random linkages: what is said is what a run does."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest
from looped import looped
from mechanisms import GRAVITY, Scene, body, frame, joint, scene

import gelenk

BOUND = 1e-12  # rad: what counts as contact (element/joint_forces/joint_limit.h)


def linkage(seed: int, friction: bool) -> Scene:
    """One to four links, hanging as a chain or closed to a loop, with springs and limits in some joints."""
    r = random.Random(seed)
    count = r.choice([1, 2, 3, 4])
    bodies, joints = {}, {}
    parent, end, angle, tip = "ground", 0.0, 0.0, [0.0, 0.0]
    for i in range(count):
        length, phi = r.uniform(0.5, 1.5), r.uniform(-1.5, 1.5)
        bodies[f"link{i}"] = body(r.uniform(0.5, 2), (length / 2, 0, 0), (0, 0, 0.05))
        fields: dict[str, Any] = {"start": {"phi": phi}}
        if r.random() < 0.5:
            fields |= {"stiffness": r.uniform(0.5, 20), "spring_reference": r.uniform(-1, 1)}
        if r.random() < 0.7:  # a fifth of them at the bound
            lower = phi - (0 if r.random() < 0.2 else r.uniform(0, 1))
            upper = phi + (0 if r.random() < 0.2 and lower < phi else r.uniform(0.01, 1))
            sides = r.choice([("lower",), ("upper",), ("lower", "upper")])
            fields["limit"] = {side: {"lower": lower, "upper": upper}[side] for side in sides}
        if friction and r.random() < 0.8:
            fields["friction"] = {"coulomb": r.uniform(0.5, 25)}
        joints[f"J{i}"] = joint(
            "revolute", frame(parent, (end, 0, 0)), frame(f"link{i}"), axis=[0, 0, 1], **fields
        )
        parent, end, angle = f"link{i}", length, angle + phi
        tip = [tip[0] + length * math.cos(angle), tip[1] + length * math.sin(angle)]
    if count > 2 and r.random() < 0.6:
        dry = {"friction": {"coulomb": r.uniform(0.5, 10)}} if friction else {}
        joints["C"] = joint(
            "revolute", frame(parent, (end, 0, 0)), frame("ground", (*tip, 0)), axis=[0, 0, 1], **dry
        )
    return scene(bodies, joints, gravity=[0, -GRAVITY, 0])


@looped("seed", range(150))
def test_equilibria_are_within_limits_and_runs_remain_there(seed: int) -> None:
    source = linkage(seed, friction=False)
    found = gelenk.equilibrium(source)
    for name, of in source["joints"].items():
        limit = of.get("limit", {})
        phi = found.values[f"{name}.phi"]
        assert limit.get("lower", -math.inf) - BOUND <= phi <= limit.get("upper", math.inf) + BOUND
    for of in found.held.values():
        assert of.contact >= 0 if of.bound == "lower" else of.contact <= 0
    plant = gelenk.Simulation(gelenk.load(source | {"solver": {"start": "equilibrium"}}))
    plant.initialize()
    names = [f"{name}.phi" for name in source["joints"]]
    start = plant.values(names)
    assert start == pytest.approx([found.values[name] for name in names], abs=1e-9)  # the same search
    plant.step_to(0.05)
    # The residual acceleration is at most 1e-8, and grows by less than 10 from an unstable equilibrium.
    assert plant.values(names) == pytest.approx(start, abs=1e-8)


@looped("seed", range(100))
def test_a_pose_is_held_if_a_run_remains_there(seed: int) -> None:
    source = linkage(seed, friction=True)
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    names = [f"{name}.phi" for name in source["joints"]]
    start = plant.values(names)
    plant.step_to(0.02)
    if (plant.values(names) == start).all():
        assert gelenk.equilibrium(source, friction="present").margin > 0
    else:
        with pytest.raises(gelenk.EquilibriumError, match="not hold this pose"):
            gelenk.equilibrium(source, friction="present")
