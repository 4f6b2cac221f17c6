# SPDX-License-Identifier: BSD-3-Clause
"""Random scenes of bodies that touch, ordinary and extreme ones."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np

SceneData = dict[str, Any]
Generator = np.random.Generator


@dataclass(frozen=True)
class RandomScene:
    """A scene whose bodies touch.

    Args:
        scene: for `gelenk.simulate`.
        length: size of its bodies [m].
        step: of time stepping [s].
        passive: whether nothing but gravity does work on it.
    """

    scene: SceneData
    length: float
    step: float
    passive: bool


def _one_of(rng: Generator, *values: Any) -> Any:
    return values[int(rng.integers(len(values)))]


def _direction(rng: Generator) -> np.ndarray:
    out = rng.normal(size=3)
    return np.asarray(out / np.linalg.norm(out))


def _shape(rng: Generator, size: float) -> SceneData:
    """A shape of about this size [m], sometimes a thousand times longer than thick."""
    a, b, c = size * rng.uniform(0.3, 1, 3)
    if rng.random() < 0.15:
        c *= _one_of(rng, 1e-3, 1e-2, 10)
    kind = int(rng.integers(5))
    if kind == 0:
        return {"sphere": a / 2}
    if kind == 1:
        return {"box": [a, b, c] if rng.random() < 0.7 else [a, a, a]}
    if kind == 2:
        return {"cylinder": {"radius": a / 2, "length": c}}
    if kind == 3:
        return {"capsule": {"radius": a / 2, "length": c}}
    corners = [[0, 0, 0], [a, 0, 0], [0, b, 0], [0, 0, c]] if rng.random() < 0.3 else None
    return {"hull": corners or (a * rng.normal(size=(int(rng.integers(4, 24)), 3)) / 2).tolist()}


def _law(rng: Generator, length: float) -> SceneData:
    law: SceneData = {"friction": _one_of(rng, 0.0, 0.0, 0.3, 0.6, 1.0, 1e3, 1e8)}
    if rng.random() < 0.2:
        law["static"] = 1.5 * law["friction"] + 0.1
    if rng.random() < 0.3:
        law["rolling"] = length * _one_of(rng, 1e-3, 0.1, 10)
    if rng.random() < 0.3:
        law["spinning"] = length * _one_of(rng, 1e-3, 0.1, 10)
    return law


def _body(rng: Generator, length: float) -> SceneData:
    shapes = {}
    for k in range(1 if rng.random() < 0.8 else 2):
        shape = {**_shape(rng, length), "surface": _one_of(rng, "wood", "steel")}
        if k or rng.random() < 0.2:
            shape["position"] = (length * rng.normal(size=3) / 2).tolist()
            shape["rotation"] = {"axis": _direction(rng).tolist(), "angle": rng.uniform(0, pi)}
        shapes[f"s{k}"] = shape
    if rng.random() < 0.6:
        return {"mass": {"density": float(10 ** rng.uniform(0, 4))}, "shapes": shapes}
    mass = 1e3 * length**3 * 10 ** rng.uniform(-1, 1)
    moment = mass * length * length * 10 ** rng.uniform(-3, 0)
    return {"mass": mass, "inertia": [moment, moment, moment * rng.uniform(0.1, 1.9)], "shapes": shapes}


def _start(rng: Generator, length: float, i: int, way: int, speed: float) -> SceneData:
    """Where a free body starts: at random, on others, or at the place of all."""
    turn = _direction(rng) * sqrt(1 - (w := rng.uniform(-1, 1)) ** 2)
    out: SceneData = {"Q": [*turn.tolist(), w], "fixed": True}
    if way == 0:
        out["r"] = (length * rng.uniform(-1, 1, 3) + [0, 0, length]).tolist()
    elif way == 1:
        out |= {"r": [0, 0, length * (i + 0.5)], "Q": [0, 0, 0, 1]}
    elif way == 2:
        out |= {"r": [0, 0, 0], "Q": [0, 0, 0, 1]}
    else:
        out["r"] = (0.2 * length * rng.normal(size=3)).tolist()
    if rng.random() < 0.7:
        out["v"] = (speed * rng.normal(size=3)).tolist()
        out["w"] = (speed / length * rng.normal(size=3)).tolist()
    return out


def _contacts(rng: Generator, scene: SceneData, length: float) -> SceneData:
    """Laws between all surfaces of which two shapes can touch; the first body always touches the ground."""
    scene["bodies"]["b0"]["shapes"]["s0"]["surface"] = "wood"
    surfaces = {
        name: {s["surface"] for s in body["shapes"].values()} for name, body in scene["bodies"].items()
    }
    surfaces["ground"] = {"stone"}
    joined = [{_body_of(j["parent"]), j["child"]} for j in scene["joints"].values() if j["type"] != "free"]
    out: SceneData = {}
    for pair in (
        ["wood", "stone"],
        ["wood", "wood"],
        ["steel", "stone"],
        ["wood", "steel"],
        ["steel", "steel"],
    ):
        law = _law(rng, length)
        if any(
            pair[0] in surfaces[a] and pair[1] in surfaces[b]
            for a in surfaces
            for b in surfaces
            if a != b and ({a, b} not in joined or "ground" in (a, b))
        ):
            out[f"c{len(out)}"] = {"between": pair, **law}
    return out


def _body_of(frame: str | SceneData) -> str:
    return frame if isinstance(frame, str) else str(frame["body"])


def random_scene(seed: int) -> RandomScene:
    """Return the scene of this number; the same one each time."""
    rng = np.random.default_rng(seed)
    length = float(_one_of(rng, 1.0, 1.0, 0.1, 10 ** rng.uniform(-6, 6)))
    g = float(_one_of(rng, 9.81, 9.81, 9.81, 0.0))
    rate = sqrt((g or 9.81) / length)
    step = float(_one_of(rng, 1e-3, 1e-2, 0.05)) / rate
    way = int(rng.integers(4))
    count = int(rng.integers(1, 6))
    scene: SceneData = {"gelenk": 1, "gravity": [0, 0, -g], "bodies": {}, "joints": {}}
    for i in range(count):
        mixed = 10 ** rng.uniform(-3, 3) if rng.random() < 0.1 else 1.0
        scene["bodies"][f"b{i}"] = _body(rng, length * mixed)
        joint: SceneData = {"type": "free", "parent": "ground", "child": f"b{i}"}
        if rng.random() < 0.3:
            frame = {
                "body": f"b{i - 1}" if i else "ground",
                "position": (length * rng.normal(size=3)).tolist(),
            }
            joint |= {"type": _one_of(rng, "revolute", "spherical", "prismatic"), "parent": frame}
            if joint["type"] != "spherical":
                joint["axis"] = _direction(rng).tolist()
            scene["joints"][f"j{i}"] = joint
            continue
        speed = float(_one_of(rng, 0.0, 1.0, 1.0, 30.0)) * rate * length
        scene["joints"][f"j{i}"] = joint | {"start": _start(rng, length, i, way, speed)}
    ground: SceneData = {"plane": [0, 0, 1], "surface": "stone"}
    if rng.random() < 0.3:
        ground = {"box": [5 * length] * 3, "position": [0, 0, -2.5 * length], "surface": "stone"}
    scene["ground"] = {"shapes": {"floor": ground}}
    scene["contacts"] = _contacts(rng, scene, length)
    passive = rng.random() < 0.7
    if not passive:
        for law in scene["contacts"].values():
            law["restitution"] = _one_of(rng, 0.0, 0.3, 1.0)
            if rng.random() < 0.3:
                law["velocity"] = (length * rate * rng.normal(size=3)).tolist()
    scene["experiment"] = {"step": step, "stop": 1000 * step}
    scene["solver"] = {"integrator": "moreau-jean"}
    return RandomScene(scene, length, step, passive)
