# SPDX-License-Identifier: BSD-3-Clause
"""Recursive Jacobians of the residuals, against forward-mode automatic differentiation with dual numbers."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
import warned
from mechanisms import (
    GRAVITY,
    Array,
    Scene,
    body,
    frame,
    joint,
    scene,
)
from mechanisms import rotation as turned
from models.derivative_cases import CASES
from models.reducible import ball_four_bar, platform_on_balls, two_mechanisms
from models.rods import hung_plank
from models.sleighs import chaplygin_sleigh, on_a_turntable
from models.vehicles import trailer, tricycle, two_wheeled_cart

import gelenk
from gelenk.chart import mechanisms

KINDS = ("revolute", "prismatic", "cylindrical", "universal", "spherical", "planar", "free")


def any_frame(rng: np.random.Generator, name: str) -> Scene:
    return frame(name, rng.normal(size=3), turned(rng.normal(size=3), rng.uniform(-2, 2)))


def random_tree(seed: int) -> Scene:
    """A branched tree with joints of all types, in both directions, and with springs and wrenches."""
    rng = np.random.default_rng(seed)
    bodies: Scene = {}
    joints: Scene = {}
    names = ["ground"]
    for i in range(9):
        name = f"b{i}"
        R = turned(rng.normal(size=3), rng.uniform(-2, 2))
        inertia = R @ np.diag(rng.uniform(1.0, 1.6, size=3)) @ R.T
        moments = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
        bodies[name] = body(rng.uniform(0.5, 2), 0.3 * rng.normal(size=3), moments)
        kind = KINDS[int(rng.integers(len(KINDS)))]
        inner = names[int(rng.integers(len(names)))] if i > 2 else names[-1]
        ends = [any_frame(rng, inner), any_frame(rng, name)]
        joints[f"j{i}"] = joint(kind, *(ends if rng.random() < 0.5 else ends[::-1]))
        names.append(name)
    forces: Scene = {
        "tie": {
            "type": "spring_damper",
            "from": frame("b7", rng.normal(size=3)),
            "to": frame("b8", rng.normal(size=3)),
            "stiffness": 30.0,
            "damping": 2.0,
            "length": 0.4,
        },
        "hang": {
            "type": "spring_damper",
            "from": frame("ground", rng.normal(size=3)),
            "to": frame("b5", rng.normal(size=3)),
            "stiffness": 10.0,
            "damping": 1.0,
            "length": 0.2,
        },
        "blow": {"type": "wrench", **any_frame(rng, "b4"), "force": [1.0, -2.0, 3.0], "input": True},
        "jet": {
            "type": "wrench",
            **any_frame(rng, "b6"),
            "torque": [1.0, 0.5, 2.0],
            "frame": "body",
            "input": True,
        },
    }
    return scene(bodies, joints, gravity=[1.0, 2.0, -GRAVITY], forces=forces)


OTHERS: dict[str, Callable[[], Scene]] = {
    **{name: partial(mechanisms.shipped, name) for name in ("andrews", "bicycle", "balancing_robot")},
    "Chaplygin's sleigh": lambda: chaplygin_sleigh(1.0, 2.0),
    "on a turntable": lambda: on_a_turntable(1.0, True),
    "cart": lambda: two_wheeled_cart(1.0, 2.0),
    "trailer": lambda: trailer(0.3, True),
    "tricycle": tricycle,
    "plank on rods": lambda: hung_plank(3),
    "balls in a loop": ball_four_bar,
    "platform on balls": platform_on_balls,
    "two mechanisms": two_mechanisms,
    **{f"tree {seed}": partial(random_tree, seed) for seed in range(6)},
}


def jacobians(plant: gelenk.Simulation, island: int, x: Array, by_duals: bool) -> list[Array]:
    return [np.array(part) for part in plant._core._residual_jacobians(island, x.tolist(), by_duals)]


@warned.PRESSED
@pytest.mark.parametrize("name", [*CASES, *OTHERS])
def test_recursion_and_dual_numbers_agree(name: str) -> None:
    """At states that do not satisfy the loops, for any norm of quaternions, accelerations and multipliers.

    1e-12 of the largest entry: sums of some hundred terms, each exact to 1e-16; measured 2e-14.
    """
    plant = gelenk.Simulation(CASES[name].make() if name in CASES else OTHERS[name]())
    plant.initialize()
    rng = np.random.default_rng(5)
    for signal in plant.inputs:
        plant.set_input(signal.name, rng.normal())
    for island in range(plant.size.islands):
        for _ in range(3):
            x = rng.normal(
                size=300
            )  # as many as coordinates, velocities, accelerations, multipliers, or more
            found, expected = (jacobians(plant, island, x, by_duals) for by_duals in (False, True))
            for matrix, truth in zip(found, expected, strict=True):
                # Where forces cancel, their rounding errors remain.
                largest = max(1.0, np.abs(truth).max(initial=0.0))
                assert np.abs(matrix - truth).max(initial=0.0) < 1e-12 * largest
