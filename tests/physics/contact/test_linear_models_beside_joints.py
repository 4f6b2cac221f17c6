# SPDX-License-Identifier: BSD-3-Clause
"""Linear models of closed contacts beside what joints hold, couple or carry; and in FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.linear import LinearModel, linear_model

GRAVITY = [0, 0, -9.81]
BALL: dict[str, Any] = {
    "mass": 2,
    "inertia": [0.012] * 3,
    "shapes": {"skin": {"sphere": 0.1, "surface": "skin"}},
}
FLOOR: dict[str, Any] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}}


def free(**start: Any) -> dict[str, Any]:
    return {"type": "free", "parent": "ground", "child": "body", "start": {**start, "fixed": True}}


def on_the_floor(body: dict[str, Any], friction: float = 0.4, **start: Any) -> dict[str, Any]:
    return {
        "gelenk": 1,
        "gravity": GRAVITY,
        "bodies": {"body": body},
        "ground": FLOOR,
        "joints": {"J": free(**start)},
        "contacts": {"c": {"between": ["skin", "floor"], "friction": friction}},
    }


def entry(matrix: np.ndarray, model: LinearModel, output: str, of: str) -> float:
    known = model.inputs if of in model.inputs else model.states
    return float(matrix[model.outputs.index(output), known.index(of)])


def test_a_rail_that_bearing_friction_holds_shows_all_that_it_holds_once() -> None:
    """A ball that rolls on a cart pushes it by I / (I + m r^2) of what pushes the ball."""
    plate = {"plate": {"box": [1, 1, 0.1], "surface": "plate"}}
    friction = {"coulomb": 5, "bearing": {"coefficient": 0.1}}
    source = {
        "gelenk": 1,
        "gravity": GRAVITY,
        "bodies": {"cart": {"mass": 3, "inertia": [0.1] * 3, "shapes": plate}, "body": BALL},
        "joints": {
            "rail": {
                "type": "prismatic",
                "axis": [1, 0, 0],
                "parent": "ground",
                "child": "cart",
                "friction": friction,
            },
            "J": free(r=[0, 0, 0.15]),
        },
        "forces": {"push": {"type": "wrench", "body": "body", "input": True}},
        "contacts": {"c": {"between": ["skin", "plate"], "friction": 0.6}},
    }
    model = linear_model(gelenk.load(source), input_values={"push.f[1]": 1.0})
    share = 0.012 / (0.012 + 2 * 0.1**2)
    assert entry(model.D, model, "rail.friction.f", "push.f[1]") == pytest.approx(-share, abs=1e-12)


def test_the_torque_of_a_gear_between_wheels_that_stick_is_not_determined() -> None:
    """Both wheels roll alike without the gear, so that it may transmit anything. The motion is the same."""

    def cart(**constraints: Any) -> dict[str, Any]:
        wheel = {"mass": 0.5, "inertia": [2e-3] * 3, "shapes": {"tire": {"sphere": 0.1, "surface": "skin"}}}

        def joint(kind: str, axis: list[float], parent: Any, child: str, **start: Any) -> dict[str, Any]:
            return {"type": kind, "axis": axis, "parent": parent, "child": child, "start": start}

        x, y, z = [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]
        return {
            "gelenk": 1,
            "gravity": GRAVITY,
            "bodies": {"slide": {"mass": 0}, "cart": {"mass": 3}, "front": wheel, "rear": wheel},
            "ground": FLOOR,
            "joints": {
                "X": joint("prismatic", x, "ground", "slide", s=0, v=0, fixed=True),
                "Z": joint("prismatic", z, "slide", "cart", s=0.1, fixed=True),
                "F": joint(
                    "revolute", y, {"body": "cart", "position": [0.2, 0, 0]}, "front", phi=0, fixed=True
                ),
                "R": joint("revolute", y, {"body": "cart", "position": [-0.2, 0, 0]}, "rear", phi=0),
            },
            "constraints": constraints,
            "motors": {"drive": {"joint": "F"}},
            "contacts": {"c": {"between": ["skin", "floor"], "friction": 0.9}},
        }

    geared = linear_model(gelenk.load(cart(mesh={"type": "gear", "joint": "F", "with": "R", "ratio": 1})))
    assert "mesh.tau" not in geared.outputs
    moved = 3 + 2 * 0.5 + 2 * 2e-3 / 0.1**2  # kg
    for model in (geared, linear_model(gelenk.load(cart()))):
        assert entry(model.D, model, "X.a", "drive.tau") == pytest.approx(1 / 0.1 / moved, rel=1e-12)


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_the_gap_of_a_contact_that_opens_follows_the_body(speed: float) -> None:
    """It is 0 at first; that of a contact that remains closed does not change."""
    model = linear_model(gelenk.load(on_the_floor(BALL, r=[0, 0, 0.1], v=[0, 0, speed])))
    gap = model.C[model.outputs.index("c.gap")]
    if speed == 0:
        assert not gap.any()
        return
    assert len(model.states) == 12
    assert gap == pytest.approx(np.eye(12)[model.states.index("J.r[3]")], abs=1e-12)


BOX: dict[str, Any] = {
    "mass": 2,
    "inertia": [0.03, 0.04, 0.05],
    "shapes": {"skin": {"box": [0.4, 0.3, 0.2], "surface": "skin"}},
}
LYING: dict[str, Any] = {
    "mass": 2,
    "inertia": [0.01, 0.03, 0.03],
    "shapes": {
        "skin": {
            "capsule": {"radius": 0.1, "length": 0.4},
            "rotation": {"axis": [0, 1, 0], "angle": np.pi / 2},
            "surface": "skin",
        }
    },
}


@pytest.mark.parametrize(
    ("source", "states"),
    [
        (on_the_floor(BOX, r=[0, 0, 0.1], v=[0.5, 0, 0]), 6),  # it slides and turns on its face
        (on_the_floor(LYING, r=[0, 0, 0.1], v=[0, 0.5, 0], w=[-5, 0, 0]), 5),  # it rolls on two points
    ],
    ids=["sliding", "rolling"],
)
@pytest.mark.parametrize("outputs", [None, ["J.r[1]", "c.f[1]"]])
def test_an_fmu_has_the_model_of_its_scene(
    source: dict[str, Any], states: int, outputs: list[str] | None, tmp_path: Path
) -> None:
    """Also where its states are no outputs, and where what rolls moves with its heading only."""
    listed = source if outputs is None else {**source, "outputs": outputs}
    of_scene = linear_model(gelenk.load(source))
    of_fmu = linear_model(gelenk.export_fmu(listed, tmp_path / "x.fmu"))
    assert len(of_scene.states) == states
    assert of_fmu.states == of_scene.states
    np.testing.assert_allclose(of_fmu.A, of_scene.A, atol=1e-12)
