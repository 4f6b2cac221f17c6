# SPDX-License-Identifier: BSD-3-Clause
"""A lock and a limit at the ends of a short link in a loop: forces along both do nearly the same."""

from __future__ import annotations

from typing import Any

import pytest

import gelenk

RESTITUTION = 0.9


def five_bar(length: float, **fields: Any) -> dict[str, Any]:
    """Of its two degrees of freedom a lock at the near end of the link with this length takes one.

    Ja2, at the far end, falls onto a limit. fields: of the first joint.
    """
    links = {
        "a0": (0.81, 0.72, [0.10, 0.17, 0.15]),
        "a1": (0.34, 0.03, [2e-4, 3e-4, 3e-4]),
        "a2": (0.22, 0.26, [0.007, 0.012, 0.011]),
        "a3": (0.47, 0.34, [0.033, 0.055, 0.05]),
    }
    bodies = {
        name: {"mass": mass, "com": [com, 0, 0], "inertia": inertia}
        for name, (mass, com, inertia) in links.items()
    }

    def hinge(parent: str, position: list[float], child: Any, phi: float, **others: Any) -> dict[str, Any]:
        place = {"body": parent, "position": position}
        return {
            "type": "revolute", "axis": [0, -1, 0], "parent": place, "child": child, "start": {"phi": phi},
            **others,
        }  # fmt: skip

    limit = {"lower": 0.349, "restitution": RESTITUTION}
    joints = {
        "A": hinge("ground", [0.635, 0, 1.663], "a0", -2.656, **fields),
        "B": hinge("a0", [0.932, 0, 0], "a1", 1.981, lock={"engaged": True}),
        "C": hinge("a1", [length, 0, 0], "a2", 0.369, damping=0.01, limit=limit),
        "D": hinge("a2", [0.409, 0, 0], "a3", 1.007, damping=0.8, lock={"input": "engagement"}),
        "E": hinge("ground", [0.678, 0, 1.5], {"body": "a3", "position": [0.618, 0, 0]}, 0.7),
    }
    joints["A"]["start"] |= {"w": 0.775, "fixed": True}
    joints["B"]["start"]["fixed"] = True
    return {"gelenk": 1, "gravity": [0, 0, -9.81], "bodies": bodies, "joints": joints}


def started(scene: dict[str, Any], time: float) -> gelenk.Simulation:
    plant = gelenk.Simulation(scene)
    plant.initialize(time)
    return plant


@pytest.mark.parametrize("time", [0.0, 3.0])
@pytest.mark.parametrize("integrator", ["erk", "cvode"])
@pytest.mark.parametrize("length", [0.05, 0.02, 0.005, 0.002])
def test_a_limit_beside_a_lock_throws_back(length: float, integrator: str, time: float) -> None:
    """With one degree of freedom left, an impact multiplies all velocities by minus the restitution."""
    scene = five_bar(length) | {"solver": {"integrator": integrator}}
    speeds, near = ["A.w", "C.w", "D.w"], 1e-7  # s; at up to 100 rad/s2, some 1e-5 of the speeds
    with started(scene, time) as plant:
        plant.step_to(time + 0.06)
        (at,) = [t for t, text in plant.events if text == "C.phi meets its lower limit"]
    with started(scene, time) as plant:
        plant.step_to(at - near)
        before = plant.values(speeds)
        assert plant.output("B.w") == 0
        plant.step_to(at + near)
        assert plant.values(speeds) == pytest.approx(-RESTITUTION * before, rel=1e-4)
        assert plant.output("B.w") == 0


@pytest.mark.parametrize("time", [0.0, 1.0, 3.0, 7.0])
def test_friction_that_locks_have_stopped_sticks_at_once(time: float) -> None:
    """Two locks hold the whole loop, so that friction bears nothing; while the joint slipped it was 0.955."""
    with started(five_bar(0.05, friction={"coulomb": 0.955}), time) as plant:
        plant.step_to(time + 0.03)
        assert abs(plant.output("A.friction.tau")) == pytest.approx(0.955)
        plant.set_input("D.lock.engagement", 1.0)
        for k in range(4, 12):
            plant.step_to(time + 0.01 * k)
            if k == 4:
                assert [text for _, text in plant.events] == ["A.phi sticks", "D is locked"]
            assert plant.output("A.friction.mode") == 0
            assert plant.output("A.friction.tau") == pytest.approx(0, abs=1e-9)
            assert plant.output("A.w") == pytest.approx(0, abs=1e-12)
