# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms in which many limits and joints with dry friction are struck together."""

from __future__ import annotations

from typing import Any

from mechanisms import GRAVITY, Scene, body, frame, joint, scene


def bouncing_slider() -> Scene:
    """An arm that falls on its inelastic limit, with a slider that bounces on a limit of its own."""
    start = {"fixed": True}
    limits = {
        "j0": {"lower": 0.31, "upper": 0.88, "restitution": 0},
        "j1": {"lower": 0.138, "upper": 0.504, "restitution": 0.3},
    }
    return scene(
        {
            "b0": {"mass": 2.308, "com": [0.269, 0, 0], "inertia": [0.03798, 0.0422, 0.0422]},
            "b1": {"mass": 1.305, "com": [0.12, 0, 0], "inertia": [0.08541, 0.0949, 0.0949]},
        },
        {
            "j0": joint(
                "revolute",
                frame("ground"),
                frame("b0"),
                axis=[0, 1, 0],
                limit=limits["j0"],
                start={"phi": 0.678, "w": -1.06, **start},
            ),
            "j1": joint(
                "prismatic",
                frame("b0", (0.365, 0, 0)),
                frame("b1"),
                limit=limits["j1"],
                start={"s": 0.191, "v": -0.88, **start},
            ),
        },
        gravity=[0, 0, -GRAVITY],
    )


def with_unreachable_floor(source: Scene, on: str) -> Scene:
    """The same with a ball at this body and a floor 5 m below."""
    source["bodies"][on]["shapes"] = {"ball": {"sphere": 0.02, "surface": "wood"}}
    source["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "position": [0, 0, -5], "surface": "stone"}}}
    source["contacts"] = {"k": {"between": ["wood", "stone"], "friction": 0.2, "adjacent": True}}
    return source


def stopped_carriage(slip: float, mass: float = 0.3, carriage: float = 0.7, v: float = 1e-3) -> Scene:
    """A carriage with dry friction, along which a block slides onto an inelastic limit; no gravity.

    Both go on together and stop after this way `slip`: (m + M) V^2 / (2 F) with V = m v / (m + M).
    """
    together = mass * v / (mass + carriage)
    friction = (mass + carriage) * together**2 / (2 * slip)
    return scene(
        {"carriage": body(carriage), "block": body(mass)},
        {
            "A": joint(
                "prismatic",
                frame("ground"),
                frame("carriage"),
                axis=[1, 0, 0],
                friction={"coulomb": friction},
            ),
            "B": joint(
                "prismatic",
                frame("carriage"),
                frame("block"),
                axis=[1, 0, 0],
                limit={"upper": 0.1 * v},
                start={"s": 0.0, "v": v, "fixed": True},
            ),
        },
    )


def hand(fingers: int) -> Scene:
    """A light hand on a carriage with six degrees of freedom and dry friction.

    Its fingers, of two links each, start at inelastic limits.
    """
    bodies: dict[str, Any] = {
        "palm": {"mass": 0.19, "com": [0.05, 0, 0.001], "inertia": [9e-5, 9e-5, 1.6e-4]},
        "w": {"mass": 5e-4, "inertia": [3e-8, 3e-8, 3e-9]},
    }
    joints: Scene = {}
    parent = "ground"
    axes = ([1, 0, 0], [0, 1, 0], [0, 0, 1])
    for i in range(6):
        bodies[f"c{i}"] = {"mass": 0.065, "inertia": [4e-5, 4e-5, 3e-5]} if i == 5 else {"mass": 0}
        joints[f"carry{i}"] = joint(
            "prismatic" if i < 3 else "revolute",
            frame(parent),
            frame(f"c{i}"),
            axis=axes[i % 3],
            damping=10.0,
            friction={"coulomb": 10.0},
            limit={"lower": -20, "upper": 20},
        )
        parent = f"c{i}"

    def hinge(at: Any, child: str, axis: list[float], lower: float, upper: float) -> Any:
        return joint("revolute", at, frame(child), axis=axis, limit={"lower": lower, "upper": upper})

    joints["pitch"] = hinge(frame("c5", (0.03, 0, 0)), "w", [0, 1, 0], -0.39, 0.39)
    joints["yaw"] = hinge(frame("w", (0.01, 0, 0)), "palm", [0, 0, 1], -0.44, 0.44)
    for k in range(fingers):
        side = 1 if k % 2 else -1
        bodies[f"p{k}"] = {"mass": 0.007, "com": [0.015, 0.002, 0], "inertia": [4e-7, 8e-7, 8e-7]}
        bodies[f"q{k}"] = {"mass": 0.0042, "com": [0.02, 0.003, 0], "inertia": [2e-7, 6.4e-7, 6.4e-7]}
        at = frame("palm", (0.1, -0.03 + 0.02 * k, 0))
        joints[f"m{k}"] = hinge(at, f"p{k}", [0, side, 0.1], -1.34, 0.0)
        joints[f"i{k}"] = hinge(frame(f"p{k}", (0.03, 0, 0)), f"q{k}", [0, side, 0], -1.59, 0.045)
    return scene(bodies, joints, gravity=[0, 0, -GRAVITY])
