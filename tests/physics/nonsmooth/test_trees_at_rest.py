# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates of trees that friction and limits keep at rest are left out of the recursion along the tree.

With a closed loop anywhere in the model they are constraint equations instead: both ways must agree.
"""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Scene, body, frame, joint, rod, scene

import gelenk

TOLERANCE = 1e-9
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def tree(seed: int) -> Scene:
    """A tree of six bodies in space, in whose joints things come to rest and are struck."""
    r = random.Random(seed)
    bodies, joints = {}, {}
    for i in range(6):
        bodies[f"b{i}"] = body(
            r.uniform(0.5, 2), (0.1, 0.05 * r.random(), 0.15), (0.02, 0.03 * r.uniform(1, 1.3), 0.025)
        )
        parent = "ground" if i == 0 else f"b{r.randrange(i)}"
        slides = r.random() < 0.2
        fields: dict[str, Any] = {
            "start": {"s" if slides else "phi": 0.0, "v" if slides else "w": r.uniform(-2, 2), "fixed": True}
        }
        if r.random() < 0.7:
            fields["friction"] = {"coulomb": r.uniform(0.5, 8)}
        if r.random() < 0.5:
            fields["limit"] = {"upper": r.uniform(0.02, 0.5), "lower": -0.3, "restitution": 0.0}
        joints[f"j{i}"] = joint(
            "prismatic" if slides else "revolute", frame(parent, (0.2, 0.1 * i, 0.1)), frame(f"b{i}"),
            axis=r.choice([X, Y, Z]), **fields,
        )  # fmt: skip
    return scene(bodies, joints, gravity=[0, 0, -GRAVITY])


def with_loop(source: Scene) -> Scene:
    """The same beside a parallelogram, in one set of equations."""
    for i, (of, x) in enumerate((("ground", 0.0), ("ground", 1.0))):
        source["bodies"][f"crank{i}"] = rod(1.0, 0.5)
        source["joints"][f"foot{i}"] = joint(
            "revolute", frame(of, (x, 5, 0)), frame(f"crank{i}"), axis=Y,
            start={"phi": -1.0, "w": 0.0, "fixed": True} if i == 0 else {"phi": -1.0},
        )  # fmt: skip
    source["bodies"]["bar"] = rod(1.0, 1.0)
    source["joints"]["over0"] = joint(
        "revolute", frame("crank0", (0.5, 0, 0)), frame("bar"), axis=Y, start={"phi": 1.0}
    )
    source["joints"]["over1"] = joint(
        "revolute", frame("bar", (1, 0, 0)), frame("crank1", (0.5, 0, 0)), axis=Y
    )
    source["solver"] = {"reductions": {"islands": False, "weld": False, "static": False}}
    return source


def course(source: Scene, integrator: str) -> tuple[np.ndarray[Any, Any], int]:
    """The coordinates, speeds and forces of the tree's joints every 20 ms; the number of its events."""
    source["solver"] = source.get("solver", {}) | {"integrator": integrator}
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, TOLERANCE)
    kinds = (".phi", ".w", ".s", ".v", ".friction.tau", ".friction.f", ".limit.tau", ".limit.f")
    names = [n for n in (str(of.name) for of in plant.outputs) if n[0] == "j" and n.endswith(kinds)]
    rows, events = [], 0
    for k in range(1, 41):
        plant.step_to(0.02 * k)
        rows.append(plant.values(names))
        events += sum(text.startswith("j") for _, text in plant.events)
    return np.array(rows), events


@pytest.mark.parametrize("integrator", ["auto", "dirk"])
def test_a_loop_elsewhere_changes_nothing(integrator: str) -> None:
    """Deviations are those of two runs with these tolerances; impacts amplify them."""
    total = 0
    for seed in range(12):
        found, events = course(tree(seed), integrator)
        other, others = course(with_loop(tree(seed)), integrator)
        assert events == others, seed
        assert found == pytest.approx(other, abs=2e-5, rel=2e-5), seed
        total += events
    assert total > 100  # things come to rest


def test_a_chain_at_rest_bears_its_weight() -> None:
    """Three rods held out straight: each joint bears the moment of all that is beyond it."""
    n, length, mass = 3, 0.4, 1.5
    bodies = {f"b{i}": rod(mass, length) for i in range(n)}
    joints = {
        f"j{i}": joint(
            "revolute", frame(f"b{i - 1}", (length, 0, 0)) if i else frame("ground"), frame(f"b{i}"), axis=Y,
            friction={"coulomb": 100.0}, start={"phi": 0.0, "w": 0.0, "fixed": True},
        )
        for i in range(n)
    }  # fmt: skip
    plant = gelenk.Simulation(scene(bodies, joints, gravity=[0, 0, -GRAVITY]))
    plant.initialize()
    plant.step_to(0.1)
    for i in range(n):
        arm = length * sum(j - i + 0.5 for j in range(i, n))
        assert abs(plant.output(f"j{i}.friction.tau")) == pytest.approx(mass * GRAVITY * arm, rel=1e-12)
        assert plant.output(f"j{i}.w") == 0


def test_what_is_at_rest_moves_as_one_body() -> None:
    """A pendulum of two links whose second joint is held is a rigid one of the same inertia."""
    length, mass = 0.5, 1.0
    bodies = {f"b{i}": rod(mass, length) for i in range(2)}
    held = {"friction": {"coulomb": 100.0}}
    joints = {
        "j0": joint(
            "revolute", frame("ground"), frame("b0"), axis=Y, start={"phi": 0.3, "w": 0.0, "fixed": True}
        ),
        "j1": joint(
            "revolute", frame("b0", (length, 0, 0)), frame("b1"), axis=Y,
            start={"phi": 0.0, "w": 0.0, "fixed": True}, **held,
        ),
    }  # fmt: skip
    plant = gelenk.Simulation(scene(bodies, joints, gravity=[0, 0, -GRAVITY]))
    plant.initialize(0.0, TOLERANCE)
    plant.step_to(0.5)
    whole, out_of = 2 * mass, 2 * length
    inertia = whole * out_of**2 / 3
    # Energy of the rigid rod: w^2 / 2 = m g (l / 2) (sin phi - sin phi0) / inertia.
    phi, w = plant.output("j0.phi"), plant.output("j0.w")
    expected = 2 * whole * GRAVITY * out_of / 2 * (math.sin(phi) - math.sin(0.3)) / inertia
    assert w**2 == pytest.approx(expected, rel=1e-7)
    a = whole * GRAVITY * out_of / 2 * math.cos(phi) / inertia
    assert plant.output("j0.a") == pytest.approx(a, rel=1e-7)
    # What accelerates the outer half: its moment about the held joint.
    moment = mass * GRAVITY * length / 2 * math.cos(phi) - a * mass * (length**2 / 3 + length * length / 2)
    assert abs(plant.output("j1.friction.tau")) == pytest.approx(abs(moment), rel=1e-7)


def test_a_clutch_between_coaxial_disks_holds_them_together() -> None:
    """Its joint closes a loop without equations of its own: its coordinate is that of two joints."""
    inertias = (0.7, 0.2)
    bodies = {f"disk{i}": body(1.0, inertia=(J, 1.0, 1.0)) for i, J in enumerate(inertias)}
    joints = {
        f"j{i}": joint(
            "revolute",
            frame("ground"),
            frame(f"disk{i}"),
            axis=X,
            start={"phi": 0.0, "w": 0.0, "fixed": True},
        )
        for i in range(2)
    }
    joints["clutch"] = joint("revolute", frame("disk0"), frame("disk1"), axis=X, friction={"coulomb": 5.0})
    plant = gelenk.Simulation(scene(bodies, joints, motors={"m": {"joint": "j0"}}))
    plant.initialize()
    plant.set_input("m.tau", 3.0)
    plant.step_to(0.1)
    for i in range(2):
        assert plant.output(f"j{i}.w") == pytest.approx(3.0 * 0.1 / sum(inertias), rel=1e-9)
    assert abs(plant.output("clutch.friction.tau")) == pytest.approx(3.0 * 0.2 / sum(inertias), rel=1e-9)


def test_motion_without_inertia_is_refused_beside_rest() -> None:
    """A point mass slides to the axis of its turning, on an arm at rest; Euler's steps meet it exactly."""
    bodies = {"arm": rod(1.0, 0.5), "turning": {"mass": 0}, "point": {"mass": 1.0}}
    joints = {
        "hold": joint(
            "revolute", frame("ground"), frame("arm"), axis=Z, friction={"coulomb": 100.0},
            start={"phi": 0.0, "w": 0.0, "fixed": True},
        ),
        "turn": joint(
            "revolute", frame("arm", (0.5, 0, 0)), frame("turning"), axis=Z,
            start={"phi": 0.0, "w": 0.0, "fixed": True},
        ),
        "slide": joint(
            "prismatic", frame("turning"), frame("point"), axis=X, start={"s": -0.25, "v": 1.0, "fixed": True}
        ),
    }  # fmt: skip
    source = scene(bodies, joints, solver={"integrator": "euler", "step": 0.125})
    plant = gelenk.Simulation(source)
    plant.initialize()
    with pytest.raises(gelenk.StepError, match="inertia"):
        plant.step_to(0.5)


def test_a_limit_does_not_pull_at_any_torque() -> None:
    """Beyond the square root of the largest number, what counts as rounding was infinite."""
    source = scene(
        {"rod": rod(1.0, 0.5)},
        {
            "j0": joint(
                "revolute", frame("ground"), frame("rod"), axis=Z, limit={"lower": 0.0},
                start={"phi": 0.0, "w": 0.0, "fixed": True},
            )
        },
        motors={"m": {"joint": "j0"}},
    )  # fmt: skip
    plant = gelenk.Simulation(source)
    plant.initialize()
    plant.set_input("m.tau", -1.0)
    plant.step_to(0.1)
    assert plant.output("j0.limit.mode") == -1
    plant.set_input("m.tau", 1e160)
    plant.step_to(0.2)
    assert plant.output("j0.limit.mode") == 0
    assert plant.output("j0.limit.tau") == 0
    assert plant.output("j0.phi") > 0


def test_linear_models_of_both_ways_agree() -> None:
    """With what is at rest locked; poles of the tree are poles of both."""
    for seed in range(6):
        models = []
        for source in (tree(seed), with_loop(tree(seed))):
            for of in source["joints"].values():
                of.pop("limit", None)
                if "start" in of:
                    of["start"] |= {name: 0.0 for name in ("w", "v") if name in of["start"]}
            source["motors"] = {"m": {"joint": "j5"}}
            with pytest.warns(gelenk.OperatingPointWarning):
                models.append(gelenk.linearize(source, friction="locked"))
        poles = np.linalg.eigvals(models[1].A)
        for pole in np.linalg.eigvals(models[0].A):
            assert np.abs(poles - pole).min() <= 1e-6 * (1 + abs(pole)), seed
