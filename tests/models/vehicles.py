# SPDX-License-Identifier: BSD-3-Clause
"""Wheeled vehicles: a cart with two driven wheels, a rigid four-wheeled cart, a tractor with its trailer."""

from __future__ import annotations

from typing import Any

import numpy as np
from mechanisms import (
    GRAVITY,
    Array,
    Numbers,
    Scene,
    body,
    frame,
    frame_sensor,
    joint,
    matrix,
    numbers,
    scene,
)

ABOUT_Y = {"axis": [0, 1, 0]}

# A cart with two wheels: kg, kg m2 about the vertical, m from the axle to its center of mass.
CART, CART_MOMENT, AHEAD = 12.0, 0.5, 0.15
WHEEL, ROLLING, DIAMETRAL = 0.8, 0.006, 0.0032  # kg, kg m2
RADIUS, HALF_TRACK = 0.1, 0.25  # m


def wheel_body() -> dict[str, Any]:
    return body(WHEEL, (0, 0, 0), (DIAMETRAL, ROLLING, DIAMETRAL))


def tyre(name: str, **on: Any) -> dict[str, Any]:
    return {"type": "rolling", "body": name, "radius": RADIUS, **on}


def two_wheeled_cart(u: float, w: float) -> Scene:
    """Two motors; massless casters (a planar joint) keep it level. Moves forward at u, turns at w."""
    places = {"left": (0, HALF_TRACK, 0), "right": (0, -HALF_TRACK, 0)}
    values = {"s_x": 0.0, "s_y": 0.0, "phi": 0.0, "v_x": u, "w": w}
    start = {**values, "fixed": list(values)}
    return scene(
        {
            "cart": body(CART, (AHEAD, 0, 0), (0.3, 0.3, CART_MOMENT)),
            "left": wheel_body(),
            "right": wheel_body(),
        },
        {"castors": joint("planar", frame("ground", (0, 0, RADIUS)), frame("cart"), start=start)}
        | {name: joint("revolute", frame("cart", at), frame(name), **ABOUT_Y) for name, at in places.items()},
        name="Cart",
        gravity=[0, 0, -GRAVITY],
        constraints={f"{name}_tyre": tyre(name) for name in places},
        motors={f"{name}_motor": {"joint": name} for name in places},
        experiment={"stop": 4, "step": 0.01, "tolerance": 1e-11},
    )


def two_wheeled_rates(u: float, w: float, left: float, right: float) -> tuple[float, float]:
    """du/dt, dw/dt under torques of the motors [N m]; Newton-Euler in the plane, wheels at r and +-b."""
    mass = CART + 2 * WHEEL + 2 * ROLLING / RADIUS**2
    moment = CART_MOMENT + CART * AHEAD**2
    moment += 2 * (DIAMETRAL + (WHEEL + ROLLING / RADIUS**2) * HALF_TRACK**2)
    du = (CART * AHEAD * w**2 + (left + right) / RADIUS) / mass
    dw = (-CART * AHEAD * u * w + (right - left) * HALF_TRACK / RADIUS) / moment
    return du, dw


# A rigid cart on four wheels: kg, kg m2, m; positions of the wheels; its center of mass is off-center.
DECK, DECK_COM = 20.0, (0.12, 0.05, 0.3)
CORNERS = {"a": (0.4, 0.3, 0.0), "b": (0.4, -0.3, 0.0), "c": (-0.4, 0.3, 0.0), "d": (-0.4, -0.3, 0.0)}


def four_wheeled_cart(R: Array, p: Numbers = (0, 0, 0), v: float = 0.0) -> Scene:
    """Supported by its wheels alone, which roll on the plane z = 0 of the frame R at p, along its x at v."""
    at = np.asarray(p) + R @ [0, 0, RADIUS]
    start = {
        "r": numbers(at),
        "rotation": matrix(R),
        "v": numbers(R @ [v, 0, 0]),
        "w": [0, 0, 0],
        "fixed": True,
    }
    plane = {"on": frame("ground", p, R)}
    return scene(
        {"deck": body(DECK, DECK_COM, (0.8, 1.1, 1.4))} | {name: wheel_body() for name in CORNERS},
        {"flight": joint("free", frame("ground"), frame("deck"), start=start)}
        | {
            name: joint("revolute", frame("deck", at), frame(name), **ABOUT_Y) for name, at in CORNERS.items()
        },
        name="Deck",
        gravity=[0, 0, -GRAVITY],
        constraints={f"{name}_tyre": tyre(name, **plane) for name in CORNERS},
        sensors={"deck_at": frame_sensor("deck")},
        experiment={"stop": 2, "step": 0.01, "tolerance": 1e-10},
    )


LENGTH, SPEED = 1.4, 0.8  # m from hitch to axle of the trailer, m/s of the tractor


def trailer(angle: float, wheels: bool) -> Scene:
    """Towed along x at constant speed, initially at `angle` to it; its axle is a blade, or two wheels."""
    out = scene(
        {"tractor": body(30.0), "trailer": body(8.0, (-0.9 * LENGTH, 0, 0), (0.4, 0.9, 0.9))},
        {
            "road": joint("prismatic", frame("ground", (0, 0, RADIUS)), frame("tractor"), axis=[1, 0, 0]),
            "hitch": joint(
                "revolute", frame("tractor"), frame("trailer"), axis=[0, 0, 1],
                start={"phi": angle, "fixed": ["phi"]},
            ),
        },
        name="Trailer",
        gravity=[0, 0, -GRAVITY],
        constraints={"engine": {"type": "motion", "joint": "road", "polynomial": [0.0, SPEED]}},
    )  # fmt: skip
    if not wheels:
        axle = {"type": "knife_edge", "body": "trailer", "position": [-LENGTH, 0, 0]}
        out["constraints"]["axle"] = axle
        return out
    for name, side in (("left", HALF_TRACK), ("right", -HALF_TRACK)):
        out["bodies"][name] = wheel_body()
        out["joints"][name] = joint("revolute", frame("trailer", (-LENGTH, side, 0)), frame(name), **ABOUT_Y)
        out["constraints"][f"{name}_tyre"] = tyre(name)
    return out


BASE = 1.1  # m, from the rear axle of the tricycle to its front wheel


def tricycle() -> Scene:
    """The front wheel is driven at 8 rad/s and steered by a sine; the wheels alone support the tricycle."""
    corners = {"left": (0, HALF_TRACK, 0), "right": (0, -HALF_TRACK, 0)}
    start = {"r": [0, 0, RADIUS], "Q": [0, 0, 0, 1], "fixed": True}
    return scene(
        {"frame": body(25.0, (0.4, 0, 0.2), (0.6, 1.2, 1.5)), "fork": body(1.0, inertia=(0.01, 0.01, 0.01))}
        | {name: wheel_body() for name in ("front", *corners)},
        {
            "flight": joint("free", frame("ground"), frame("frame"), start=start),
            "steer": joint("revolute", frame("frame", (BASE, 0, 0)), frame("fork"), axis=[0, 0, 1]),
            "front_hub": joint("revolute", frame("fork"), frame("front"), **ABOUT_Y),
        }
        | {
            name: joint("revolute", frame("frame", at), frame(name), **ABOUT_Y)
            for name, at in corners.items()
        },
        name="Tricycle",
        gravity=[0, 0, -GRAVITY],
        constraints={
            "bars": {"type": "motion", "joint": "steer", "sine": {"amplitude": 0.5, "frequency": 0.3}},
            "pedals": {"type": "motion", "joint": "front_hub", "polynomial": [0.0, 8.0]},
        }
        | {f"{name}_tyre": tyre(name) for name in ("front", *corners)},
    )
