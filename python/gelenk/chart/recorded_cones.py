# SPDX-License-Identifier: BSD-3-Clause
"""Cone problems recorded from simulations: heaps of spheres, walls of boxes, boxes on a linkage."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import gelenk
from gelenk import _core

PER_SCENE = 4  # problems of each scene, evenly distributed over its recorded interval


@dataclass(frozen=True)
class RecordedScene:
    """A scene and the interval of time from which its problems are taken [s]."""

    kind: str
    scene: dict[str, Any]
    start: float
    stop: float


def spheres(count: int) -> dict[str, Any]:
    """Return a scene of spheres that fall from a lattice into an open box of five half-spaces."""
    radius, side = 0.05, round(count ** (1 / 3))
    half = 1.1 * radius * side
    places = np.array([(k % side, k // side % side, k // side**2) for k in range(count)], float)
    places = (places + 0.5) * 2.2 * radius - [half, half, 0]
    places += np.random.default_rng(1).uniform(-0.08, 0.08, (count, 3)) * radius
    planes: list[Any] = [([0, 0, 1], [0, 0, 0])]
    for side in (-1, 1):
        planes += [([-side, 0, 0], [side * half, 0, 0]), ([0, -side, 0], [0, side * half, 0])]
    body = {"mass": {"density": 2500}, "shapes": {"skin": {"sphere": radius, "surface": "stone"}}}
    return _scene([body] * count, places.tolist(), planes)


def wall(columns: int, rows: int) -> dict[str, Any]:
    """Return a scene of a wall in running bond, hit by a sphere."""
    length, depth, height = 0.2, 0.1, 0.1
    shapes = {"hull": {"box": [length, depth, height], "surface": "stone"}}
    bodies, places = [], []
    for row in range(rows):
        shift = 0.25 if row % 2 else -0.25
        for column in range(columns):
            bodies.append({"mass": {"density": 2000}, "shapes": shapes})
            places.append([(column + shift) * length, 0.0, (row + 0.5) * height])
    ball = {"mass": {"density": 7800}, "shapes": {"skin": {"sphere": 0.06, "surface": "stone"}}}
    scene = _scene([*bodies, ball], [*places, [0.3, -0.2, 0.7 * rows * height]], [([0, 0, 1], [0, 0, 0])])
    scene["joints"][f"j{len(bodies)}"]["start"]["v"] = [0, 4, 0]
    return scene


def carried(count: int) -> dict[str, Any]:
    """Return a scene of boxes that slide on the coupler of a swinging parallelogram linkage."""
    arm, width = 0.5, 0.3 * count
    boxes = [
        {"mass": {"density": 500}, "shapes": {"hull": {"box": [0.2, 0.2, 0.2], "surface": "stone"}}}
        for _ in range(count)
    ]
    # The coupler starts 0.3 rad off the lowest position; the boxes are on top of it.
    x, z = arm * np.sin(0.3), 1.0 - arm * np.cos(0.3)
    places = [[float(x) + 0.3 * (k + 0.5 - count / 2), 0.0, float(z) + 0.125] for k in range(count)]
    scene = _scene(boxes, places, [])
    link = {"mass": 1, "com": [0, 0, -arm / 2], "inertia": [0.02, 0.02, 0.001]}
    scene["bodies"] |= {
        "left": link,
        "right": link,
        "tray": {"mass": 3, "inertia": [0.1, 0.1, 0.1],
                 "shapes": {"board": {"box": [width, 0.4, 0.05], "surface": "stone"}}},
    }  # fmt: skip
    axis = [0, -1, 0]
    for name, side in (("left", -1), ("right", 1)):
        pivot = {"body": "ground", "position": [side * width / 2, 0, 1]}
        end = {"body": name, "position": [0, 0, -arm]}
        on_tray = {"body": "tray", "position": [side * width / 2, 0, 0]}
        start = {"phi": 0.3, "fixed": True} if side < 0 else {"phi": 0.3}
        scene["joints"][f"{name}_pivot"] = {
            "type": "revolute", "axis": axis, "parent": pivot, "child": name, "start": start,
        }  # fmt: skip
        scene["joints"][f"{name}_end"] = {
            "type": "revolute", "axis": axis, "parent": end, "child": on_tray, "start": {"phi": -0.3},
        }  # fmt: skip
    return scene


def _scene(bodies: list[dict[str, Any]], places: list[list[float]], planes: list[Any]) -> dict[str, Any]:
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {f"b{k}": body for k, body in enumerate(bodies)},
        "ground": {
            "shapes": {
                f"plane{k}": {"plane": normal, "position": point, "surface": "stone"}
                for k, (normal, point) in enumerate(planes)
            }
        },
        "joints": {
            f"j{k}": {
                "type": "free",
                "parent": "ground",
                "child": f"b{k}",
                "start": {"r": place, "fixed": True},
            }
            for k, place in enumerate(places)
        },
        "contacts": {"touch": {"between": ["stone", "stone"], "friction": 0.4}},
        "solver": {"integrator": "moreau-jean", "step": 1e-3},
    }


def recorded_scenes() -> list[RecordedScene]:
    """Return the scenes whose problems are recorded."""
    return [
        RecordedScene("spheres", spheres(27), 0.1, 0.4),
        RecordedScene("spheres", spheres(64), 0.1, 0.4),
        RecordedScene("boxes", wall(3, 4), 0.0, 0.1),
        RecordedScene("boxes", wall(4, 7), 0.0, 0.1),
        RecordedScene("loops", carried(1), 0.0, 0.4),
        RecordedScene("loops", carried(4), 0.0, 0.4),
    ]


def record(
    scenes: Sequence[RecordedScene], progress: Callable[[str, float], None] | None = None
) -> Iterator[tuple[str, _core.ConeProblem]]:
    """Run scenes; yields PER_SCENE problems of each, with its kind, the first of each step that is chosen."""
    for k, one in enumerate(scenes):
        if progress is not None:
            progress("recording cone problems", k / len(scenes))
        plant = gelenk.Simulation(gelenk.load(one.scene))
        plant.initialize()
        if one.start > 0:
            plant.step_to(one.start)
        for stop in np.linspace(one.start, one.stop, PER_SCENE + 1)[1:]:
            plant.step_to(float(stop) - 1e-3)
            problems = plant._core._record_cone_problems(float(stop))
            yield one.kind, problems[0]
