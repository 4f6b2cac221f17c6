# SPDX-License-Identifier: BSD-3-Clause
"""Linear models with closed contacts against central differences of runs that begin at displaced states.

A run that begins at displaced states shows all outputs there: accelerations, contact forces and reactions of
joints. States are displaced along those of the model, so that gaps close to second order: 1e-12 m.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from models.standing import TURNED, G, free_body
from scipy.spatial.transform import Rotation

import gelenk
from gelenk.model.values import start_parameter
from gelenk.simulation.scene_plant import ScenePlant

STEP = 1e-6  # of states and inputs: differences have errors of 1e-10 by rounding
CLOSE = 1e-6  # of the largest derivative of an output

TILTED = Rotation.from_euler("xyz", [0.4, 0.3, 0.2])
ACROSS = {"rotation": {"axis": [1, 0, 0], "angle": np.pi / 2}}


def values_at(source: gelenk.Scene, starts: dict[str, float], inputs: dict[str, float]) -> dict[str, float]:
    plant = ScenePlant(source)
    try:
        plant.set_parameters(starts)
        plant.start(None, inputs)
        return dict(plant.values)
    finally:
        plant.close()


def assert_model_is_that_of_runs(source: dict[str, Any]) -> gelenk.linear.LinearModel:
    scene = gelenk.load(source)
    model = gelenk.linear.linear_model(scene)
    plant = ScenePlant(scene)
    plant.start(None, {})
    known, values = set(plant.parameters), dict(plant.values)
    plant.close()
    outputs = [name for name in model.outputs if not name.startswith("solver.")]
    rows = [model.outputs.index(name) for name in outputs]
    with_starts = {
        name: model.C[model.outputs.index(name)] for name in outputs if start_parameter(name) in known
    }
    zero = dict.fromkeys(model.inputs, 0.0)

    def difference(starts: dict[str, float], inputs: dict[str, float]) -> Array:
        ends = []
        for sign in (1, -1):
            at = {start_parameter(n): values[n] + sign * STEP * x for n, x in starts.items()}
            there = values_at(scene, at, zero | {n: sign * STEP * x for n, x in inputs.items()})
            ends.append([there[name] for name in outputs])
        difference: Array = (np.array(ends[0]) - np.array(ends[1])) / (2 * STEP)
        return difference

    by_states = [
        difference({n: row[k] for n, row in with_starts.items()}, {}) for k in range(len(model.states))
    ]
    by_inputs = [difference({}, {name: 1.0}) for name in model.inputs]
    found = np.hstack([model.C[rows], model.D[rows]])
    expected = np.array([*by_states, *by_inputs]).reshape(len(by_states) + len(by_inputs), len(outputs)).T
    size = np.maximum(1, np.abs(expected).max(axis=1, keepdims=True))
    error = np.abs(found - expected) / size
    worst = np.unravel_index(int(np.argmax(error)), error.shape)
    names = [*model.states, *model.inputs]
    assert error[worst] <= CLOSE, (
        f"{outputs[worst[0]]} by {names[worst[1]]}: {found[worst]}, by differences {expected[worst]}"
    )
    return model


def ball(**given: Any) -> dict[str, Any]:
    arguments: dict[str, Any] = {"at": [0, 0, 0.1], "friction": 0.6} | given
    return free_body({"sphere": 0.1}, 2.0, [0.02, 0.012, 0.016], **arguments)


def on_a_ball(angle: float, **given: Any) -> dict[str, Any]:
    at = 0.45 * np.array([np.sin(angle), 0, np.cos(angle)])
    return ball(at=at.tolist(), on={"ball": {"sphere": 0.35}}, **given)


def leaning_wheel(crown: float, lean: float, **given: Any) -> dict[str, Any]:
    height = (0.3 - crown) * np.cos(lean) + crown
    own = Rotation.from_euler("x", lean)
    shape = {"wheel": {"radius": 0.3, "crown": crown}, **ACROSS}
    return free_body(shape, 2.0, [0.05, 0.09, 0.05], [0, 0, height], own=own, **given)


def box(own: Rotation, **given: Any) -> dict[str, Any]:
    size = np.array([0.3, 0.2, 0.4])
    height = (np.abs(own.as_matrix()[2]) * size / 2).sum()
    arguments = {"friction": 0.5} | given
    return free_body({"box": size.tolist()}, 2.0, [0.03, 0.04, 0.02], [0, 0, height], own=own, **arguments)


def ball_on_a_cart(**joint: Any) -> dict[str, Any]:
    """A ball on a cart that a motor moves, with whatever its joint has."""
    source = ball(at=[0.05, 0.02, 0.15])
    source["bodies"]["cart"] = {
        "mass": 3.0, "inertia": [0.1] * 3, "shapes": {"plate": {"box": [1, 1, 0.1], "surface": "floor"}}
    }  # fmt: skip
    del source["ground"]
    source["joints"]["rail"] = {
        "type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "cart", "stiffness": 20.0,
        **joint,
    }  # fmt: skip
    source["motors"] = {"drive": {"joint": "rail"}}
    return source


def crossed_capsules(**given: Any) -> dict[str, Any]:
    other = {"capsule": {"radius": 0.08, "length": 2.0}, "rotation": {"axis": [1, 0, 0], "angle": np.pi / 2}}
    shape = {"capsule": {"radius": 0.1, "length": 1.0}, "rotation": {"axis": [0, 1, 0], "angle": np.pi / 2}}
    return free_body(shape, 2.0, [0.02, 0.16, 0.16], [0, 0, 0.18], on={"rail": other}, **given)


def crossed_edges(**given: Any) -> dict[str, Any]:
    """A box on an edge along x, on the edge along y of a fixed box; both are turned by 45 degrees."""
    up = {"box": [0.3, 1.0, 0.3], "turn": Rotation.from_euler("y", np.pi / 4)}
    own = Rotation.from_euler("x", np.pi / 4)
    height = 0.3 / np.sqrt(2) + 0.2 / np.sqrt(2)
    return free_body(
        {"box": [1.0, 0.2, 0.2]},
        2.0,
        [0.02, 0.16, 0.17],
        [0.02, 0.03, height],
        own=own,
        on={"rail": up},
        **given,
    )


def lying(shape: dict[str, Any], **given: Any) -> dict[str, Any]:
    """A cylinder or a capsule on its side, which rolls along x or slides."""
    return free_body({**shape, **ACROSS}, 2.0, [0.05, 0.009, 0.05], [0, 0, 0.1], **given)


LEVEL = Rotation.identity()
GUIDE = {"coulomb": 0, "bearing": {"coefficient": 0.2}}
SCENES = {
    "ball rolls on a ball": on_a_ball(0.1),
    "ball rolls on a ball, turned": on_a_ball(0.1, turn=TURNED),
    "ball slides on a ball": on_a_ball(0.2, v=[0.3 * np.cos(0.2), 0.4, -0.3 * np.sin(0.2)], friction=0.3),
    "ball without friction": on_a_ball(0.2, friction=0.0),
    "ball slides and spins": ball(v=[0.7, 0.2, 0], w=[1, -4, 3]),
    "ball spins against friction": ball(
        w=[0, 0, 3.0], friction={"friction": 0.5, "spinning": 0.004, "rolling": 0.002}
    ),
    "roly-poly at speed": ball(com=[0.01, 0, -0.03], v=[0.2, 0, 0], w=[0, 2.0, 0.5]),
    "wheel rolls upright": leaning_wheel(0.0, 0.0, v=[1.2, 0, 0], w=[0, 4.0, 0]),
    "crowned wheel leans at rest": leaning_wheel(0.05, 0.2),
    "leaning wheel slides": leaning_wheel(0.0, 0.3, v=[1.0, 0, 0], w=[0, 1.0, 0], friction=0.4),
    "box slides flat": box(LEVEL, v=[0.5, 0.3, 0]),
    "box slides flat, turned": box(LEVEL, v=[0.5, 0.3, 0], turn=TURNED),
    "box slides without friction": box(LEVEL, v=[0.5, 0.3, 0], friction=0.0),
    "box turns about a corner that sticks": box(TILTED),
    "box slides on a corner": box(TILTED, v=[0.4, 0, 0], friction=0.2),
    "box slides on a corner, turned": box(TILTED, v=[0.4, 0, 0], friction=0.2, turn=TURNED),
    "ball on a belt": ball(friction={"friction": 0.3, "velocity": [0.5, 0, 0]}),
    "ball rolls on a cart": ball_on_a_cart(),
    "ball rolls on a cart that friction holds": ball_on_a_cart(friction={"coulomb": 5.0}),
    "ball rolls on a cart that slips": ball_on_a_cart(
        friction={"coulomb": 0.5}, start={"v": 0.3, "fixed": True}
    ),
    "ball on a cart at its limit": ball_on_a_cart(limit={"lower": 0.0}),
    "ball rolls on a cart in a guide": ball_on_a_cart(friction=GUIDE, start={"v": 0.3, "fixed": True}),
    "box across an edge": crossed_edges(),
    "box slides across an edge": crossed_edges(v=[0.2, 0.3, 0], friction=0.3),
    "capsule rolls": lying({"capsule": {"radius": 0.1, "length": 0.6}}, v=[0.5, 0, 0], w=[0, 5.0, 0]),
    "cylinder rolls": lying({"cylinder": {"radius": 0.1, "length": 0.6}}, v=[0.5, 0, 0], w=[0, 5.0, 0]),
    "cylinder slides": lying({"cylinder": {"radius": 0.1, "length": 0.6}}, v=[0.5, 0.2, 0], friction=0.2),
    "capsules across": crossed_capsules(),
    "capsules slide across": crossed_capsules(v=[0.3, 0.2, 0], friction=0.3),
}


@pytest.mark.parametrize("scene", SCENES)
def test_linear_models_are_those_of_runs(scene: str) -> None:
    source = SCENES[scene]
    if scene == "ball on a cart at its limit":  # pushed against it
        source = {**source, "gravity": [-0.5, 0, -G]}
    assert_model_is_that_of_runs(source)


def test_open_gaps_have_derivatives() -> None:
    """A ball above a plane and beside a box: the gaps follow the nearest points."""
    source = ball(at=[0.3, 0.1, 0.4], gravity=(0, 0, 0))
    source["ground"]["shapes"]["post"] = {"box": [0.1, 0.1, 2.0], "surface": "post"}
    source["contacts"]["beside"] = {"between": ["wood", "post"]}
    model = assert_model_is_that_of_runs(source)
    row = model.C[model.outputs.index("beside.gap")]
    at = model.states.index("J.r[1]")
    assert row[at] == pytest.approx(0.25 / np.hypot(0.25, 0.05), rel=1e-9)
    assert model.C[model.outputs.index("floor.gap"), model.states.index("J.r[3]")] == pytest.approx(
        1, rel=1e-12
    )
