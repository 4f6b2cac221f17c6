# SPDX-License-Identifier: BSD-3-Clause
"""What is said to act on bodies moves them: Newton and Euler, for every kind of force in the registry."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import gelenk
from gelenk import _core

from . import laws
from .laws import Array, Case

MASS, INERTIA = 2.0, np.array([0.3, 0.4, 0.5])  # kg, kg m2, of all bodies
FORCES = [case for kind in laws.KINDS["forces"] for case in laws.general_cases(kind)]
ALONG = [
    case for kind in (*laws.KINDS["motors"], *laws.KINDS["joints"]) for case in laws.general_cases(kind)
]  # fmt: skip
ROUNDING = 1e-11  # of accelerations


def entry(case: Case) -> dict[str, Any]:
    """The element's fields as in a scene."""
    fields = {f["name"]: f for f in case.kind["fields"]}
    out: dict[str, Any] = {}
    for name, value in case.numbers.items():
        field = fields[name]
        is_choice, is_flag = field["type"] == "choice", field["type"] == "flag"
        out[name] = field["words"][int(value)] if is_choice else bool(value) if is_flag else value
    return out


def started(scene: dict[str, Any]) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load({"gelenk": 1, "gravity": [0, 0, 0], **scene}))
    for k, signal in enumerate(plant.inputs):
        plant.set_input(signal.name, 0.7 + 0.1 * k)
    plant.initialize()
    return plant


def of_two(case: Case) -> dict[str, Any]:
    """The first port on the body a, the second on b."""
    rng = np.random.default_rng(5)
    element = entry(case) | {"type": case.kind["name"]}
    for port, body in zip(case.kind["ports"], "ab", strict=False):
        at: dict[str, Any] = {"body": body}
        if port["kind"] != "body":
            at["position"] = rng.uniform(-0.1, 0.1, 3).tolist()
        if port["kind"] == "frame":
            at["rotation"] = {"axis": rng.normal(size=3).tolist(), "angle": 0.4}
        element |= {port["name"]: at} if port["name"] else at

    def start() -> dict[str, Any]:
        v, w = (rng.uniform(-1, 1, 3).tolist() for _ in range(2))
        turn = Rotation.from_rotvec(rng.uniform(-0.3, 0.3, 3))
        return {"r": rng.uniform(-0.15, 0.15, 3).tolist(), "Q": turn.as_quat().tolist(), "v": v, "w": w}

    return {
        "bodies": {name: {"mass": MASS, "inertia": INERTIA.tolist()} for name in "ab"},
        "joints": {f"J{n}": {"type": "free", "parent": "ground", "child": n, "start": start()} for n in "ab"},
        "forces": {"F": element},
    }


def vector(plant: gelenk.Simulation, name: str) -> Array:
    return np.array(plant.values([f"{name}[{k}]" for k in (1, 2, 3)]))


@pytest.mark.parametrize("case", FORCES, ids=str)
def test_bodies_move_by_the_forces_that_are_said_to_act_on_them(case: Case) -> None:
    plant = started(of_two(case))
    found = _core.wrenches(plant._core)
    assert {name for _, name, *_ in found} == {"F"}
    assert len(found) == len(case.kind["ports"])
    largest = 0.0
    for body in "ab":
        R = plant.pose(body)[0]
        f, n = np.zeros(3), np.zeros(3)
        for _, _, on, _, numbers in found:
            if on == body:
                p, force, torque = np.split(np.array(numbers), 3)
                f += force
                n += torque + np.cross(R @ p, force)
        w = vector(plant, f"J{body}.w")
        rate = INERTIA * vector(plant, f"J{body}.z") + np.cross(w, INERTIA * w)
        scale = ROUNDING * (1 + np.abs([f, n]).max())
        assert_allclose(f, MASS * vector(plant, f"J{body}.a"), atol=scale)
        assert_allclose(R.T @ n, rate, atol=scale)
        largest = max(largest, float(np.abs([f, n]).max()))
    assert largest > 1e-3


@warned.PRESSED
@pytest.mark.parametrize("case", ALONG, ids=str)
def test_a_joint_moves_by_the_torques_that_are_said_to_act_along_it(case: Case) -> None:
    """A body that turns about an axis of symmetry; beyond a soft stop, and away from hard limits."""
    fields = entry(case)
    q, v = 0.1, 0.7
    if "upper" in fields:
        q = fields["upper"] + 0.05 if "stiffness" in fields else (fields["lower"] + fields["upper"]) / 2
    joint: dict[str, Any] = {
        "type": "revolute", "parent": "ground", "child": "b", "axis": [1, 2, 2], "start": {"phi": q, "w": v},
    }  # fmt: skip
    scene: dict[str, Any] = {"bodies": {"b": {"mass": MASS, "inertia": [0.3] * 3}}, "joints": {"J": joint}}
    name = "J"
    if case.kind in laws.KINDS["motors"]:
        scene["motors"] = {"M": {"type": case.kind["name"], "joint": "J", **fields}}
        name = "M"
    elif group := case.kind["group"]:
        joint[group] = fields
        name = f"J.{group}"
    else:
        joint |= fields
    plant = started(scene)
    effort = case.along.effort(q, v, np.array([plant.input(s.name) for s in plant.inputs]))
    found = _core.wrenches(plant._core)
    assert {tuple(key[:3]) for *key, _ in found} == {("load", name, "b")}
    force, torque = np.split(np.sum([numbers[3:] for *_, numbers in found], axis=0), 2)
    axis = np.array([1, 2, 2]) / 3
    assert_allclose(torque, effort * axis, atol=ROUNDING * (1 + abs(effort)))
    assert not force.any()
    acceleration = plant.output("J.a") * (0.3 + case.along.inertia)
    assert_allclose(acceleration, effort, atol=ROUNDING * (1 + abs(effort)))


def test_some_of_these_torques_are_large() -> None:
    assert (
        sum(abs(case.along.effort(5.0, 0.7, np.full(len(case.along.inputs), 0.7))) > 0.1 for case in ALONG)
        > 3
    )
