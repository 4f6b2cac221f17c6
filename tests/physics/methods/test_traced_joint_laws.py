# SPDX-License-Identifier: BSD-3-Clause
"""Friction, limits, stops, locks and one-way clutches in programs that are made for a scene
(`solver.equations`): as by the general kernels, which take over while anything is held.
"""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest
from mechanisms import four_bar

import gelenk

type Scene = dict[str, Any]
STEP, STEPS = 0.01, 150
TOLERANCE = 1e-9
# Both locate the same events; errors of steps, which events pass on.
CLOSE = 1e-6

LAWS: dict[str, dict[str, Any]] = {
    "friction": {"friction": {"coulomb": 0.4}},
    "static friction": {"friction": {"coulomb": 0.3, "static": 0.6}},
    "Stribeck friction": {"friction": {"coulomb": 0.3, "static": 0.6, "stribeck": 0.2}},
    "limit": {"limit": {"lower": -0.5, "upper": 0.6, "restitution": 0.7}},
    "limit and friction": {
        "limit": {"lower": -0.5, "upper": 0.6, "restitution": 0.5},
        "friction": {"coulomb": 0.2},
    },
    "stop": {"stop": {"lower": -0.4, "upper": 0.5, "stiffness": 300.0, "damping": 1.0}},
    "stop and friction": {
        "stop": {"lower": -0.4, "upper": 0.5, "stiffness": 300.0, "damping": 1.0},
        "friction": {"coulomb": 0.2},
    },
    "brake": {"friction": {"coulomb": 8.0, "input": "engagement"}},
    "one-way clutch": {"one_way": {"free": "negative"}},
    "lock": {"lock": {"input": "engagement"}},
}
# Of the evaluations, those by a program, at least: what is held is left to the kernels. Most of the time, the
# one-way clutch is.
LEAST_SHARE = {"one-way clutch": 0.05}


def two_pendulums(joint: str, law: dict[str, Any]) -> Scene:
    """Two arms of different masses, in the vertical plane."""
    arm = {"mass": 1.0, "com": [0.5, 0.0, 0.0], "inertia": [0.0, 0.08, 0.08]}
    source: Scene = {
        "gelenk": 1,
        "gravity": [0.0, 0.0, -9.81],
        "bodies": {"first": dict(arm), "second": arm | {"mass": 0.6}},
        "joints": {
            "A": {
                "type": "revolute", "axis": [0.0, -1.0, 0.0], "parent": "ground", "child": "first",
                "start": {"phi": -0.3, "w": 2.0, "fixed": True}, "damping": 0.05,
            },
            "B": {
                "type": "revolute", "axis": [0.0, -1.0, 0.0],
                "parent": {"body": "first", "position": [1.0, 0.0, 0.0]}, "child": "second",
                "start": {"phi": 0.2, "w": -1.0, "fixed": True},
            },
        },
        "motors": {"drive": {"joint": "A"}},
    }  # fmt: skip
    source["joints"][joint] |= copy.deepcopy(law)
    return source


def linkage(law: dict[str, Any]) -> Scene:
    source = four_bar()
    # Bounds of angles measured from the start.
    moved = copy.deepcopy(law)
    for bounds in (moved.get("limit"), moved.get("stop")):
        for side in ("lower", "upper"):
            if bounds is not None:
                bounds[side] += 1.1
    source["joints"]["A"] |= moved
    return source


def run(
    source: Scene, kind: str, integrator: str, saved_every: int = 0
) -> tuple[list[float], list[str], float]:
    """The states at all communication points, the texts of events, and the share of the program."""
    scene = copy.deepcopy(source)
    scene["solver"] = {"integrator": integrator, "step": 1e-3, "equations": kind}
    plant = gelenk.Simulation(scene)
    plant.initialize(tolerance=TOLERANCE)
    names = [s.name for s in plant.outputs if s.name.split(".")[-1] in ("phi", "w")]
    rows: list[float] = []
    for k in range(STEPS):
        for signal in plant.inputs:
            on = (k // 15) % 2 == 1
            plant.set_input(signal.name, float(on) if signal.name != "drive.tau" else 2.0 * math.sin(0.1 * k))
        if saved_every and k % saved_every == 0:
            plant.restore(plant.save())
        plant.step_to((k + 1) * STEP)
        rows += [plant.output(name) for name in names]
    found = plant.diagnostics
    share = found["solver.traced_evaluations"] / found["solver.evaluations"]
    return rows, [text for _, text in plant.events], share


@pytest.mark.parametrize("integrator", ["auto", "erk", "rk4", "dirk"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("at", ["first", "second", "linkage"])
def test_laws_along_joints_move_alike(at: str, law: str, integrator: str) -> None:
    source = (
        linkage(LAWS[law]) if at == "linkage" else two_pendulums({"first": "A", "second": "B"}[at], LAWS[law])
    )
    expected, events, none = run(source, "general", integrator)
    found, also, share = run(source, "traced", integrator)
    assert none == 0
    assert share > LEAST_SHARE.get(law, 0.2)
    assert also == events
    assert found == pytest.approx(expected, abs=CLOSE, rel=CLOSE)


@pytest.mark.parametrize("law", LAWS)
def test_saved_and_restored_runs_have_the_same_bits(law: str) -> None:
    source = two_pendulums("B", LAWS[law])
    assert run(source, "traced", "erk", saved_every=7) == run(source, "traced", "erk")
