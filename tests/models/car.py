# SPDX-License-Identifier: BSD-3-Clause
"""The car of the gallery: variants of its scene, and what follows from its numbers in closed form."""

from __future__ import annotations

from math import atan, sin
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mechanisms import Array, Scene
from scipy.optimize import brentq

from models.tires import SingleTrack

FILE = Path(__file__).resolve().parents[2] / "docs" / "gallery" / "car" / "scene.yaml"
G = 9.81  # m/s2
CORNERS = ("fl", "fr", "rl", "rr")
HUBS = tuple(f"hub_{corner}" for corner in CORNERS)
BRAKES = tuple(f"{hub}.friction.engagement" for hub in HUBS)
ARMS = ("lower_fl", "lower_fr", "pivot_rl", "pivot_rr")
HEIGHT = 0.3  # m, of the hubs in the position of construction


def car(speed: float = 15.0) -> Scene:
    """Return the scene of the gallery, rolling at a speed [m/s]."""
    scene: Scene = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    scene["joints"]["ride"]["start"]["v_x"] = speed
    for hub in HUBS:
        scene["joints"][hub]["start"]["w"] = speed / HEIGHT
    return scene


def without_drag(scene: Scene) -> Scene:
    del scene["forces"]["air"]
    return scene


def steered(scene: Scene) -> Scene:
    """Return the car with a rack that follows an input, steer.s_ref [m], instead of a torque."""
    del scene["motors"]["column"], scene["joints"]["rack"]["start"]
    scene["constraints"]["steer"] = {"type": "motion", "joint": "rack", "input": "position"}
    return scene


def welded(scene: Scene, *names: str) -> Scene:
    for name in names:
        joint = scene["joints"][name]
        scene["joints"][name] = {"type": "weld"} | {key: joint[key] for key in ("parent", "child", "at")}
    return scene


def rigid(scene: Scene) -> Scene:
    """Return the car without suspension on its tires, level and at its height: it moves in the plane."""
    for side in ("l", "r"):
        del scene["constraints"][f"drive_{side}"]["carrier"]
    return welded(scene, "heave", "pitch", "roll", *ARMS)


def places(scene: Scene) -> dict[str, tuple[float, Array]]:
    """Return masses [kg] and centers of mass [m] in the position of construction; no body is turned."""
    return {
        name: (body["mass"], np.array(body["pose"]["position"]) + body.get("com", (0, 0, 0)))
        for name, body in scene["bodies"].items()
    }


def center(scene: Scene) -> Array:
    masses, points = zip(*places(scene).values(), strict=True)
    out: Array = np.average(points, axis=0, weights=masses)
    return out


def mass(scene: Scene) -> float:
    return sum(m for m, _ in places(scene).values())


def yaw_moment(scene: Scene) -> float:
    """Return the moment of inertia about the vertical through the center of mass [kg m2]."""
    about = center(scene)[:2]
    own = sum(body["inertia"][2] for body in scene["bodies"].values() if "inertia" in body)
    return float(own + sum(m * ((p[:2] - about) @ (p[:2] - about)) for m, p in places(scene).values()))


def hub(scene: Scene, corner: str) -> Array:
    return np.array(scene["joints"][f"hub_{corner}"]["at"]["position"])


def built_load(scene: Scene, corner: str) -> float:
    """Return the load of a tire in the position of construction [N]."""
    tire = scene["forces"][f"tire_{corner}"]
    return float(tire["stiffness"] * (tire["radius"] - hub(scene, corner)[2]))


def axle_loads(scene: Scene, deceleration: float = 0.0, height: float | None = None) -> tuple[float, float]:
    """Return the loads of both axles from moments about the points of contact [N]."""
    front, rear = hub(scene, "fl")[0], hub(scene, "rl")[0]
    x, _, z = center(scene)
    z = z if height is None else height
    m = mass(scene)
    ahead = m * (G * (x - rear) + deceleration * z) / (front - rear)
    return ahead, m * G - ahead


def single_track(scene: Scene, speed: float, loads: tuple[float, float]) -> SingleTrack:
    """Return the single-track model, from the loads of the axles [N]."""
    x = center(scene)[0]
    stiffness = [scene["forces"][f"tire_{corner}"]["cornering_stiffness"] for corner in ("fl", "rl")]
    return SingleTrack(
        mass(scene),
        yaw_moment(scene),
        hub(scene, "fl")[0] - x,
        x - hub(scene, "rl")[0],
        stiffness[0] * loads[0],
        stiffness[1] * loads[1],
        speed,
    )


def steering_per_rack(scene: Scene, corner: str = "fl") -> float:
    """Return the angle of a front wheel's heading per travel of the rack [rad/m].

    The knuckle turns about the line through its ball joints; the length of the tie rod remains.
    """
    ball, top, inner, outer, rack = (
        np.array(scene["joints"][f"{name}_{corner}"]["at"]["position"]) if name else np.zeros(3)
        for name in ("ball", "rear_end", "tie", "tie_end", "")
    )
    rack = np.array(scene["joints"]["rack"]["axis"], float)
    kingpin = (top - ball) / np.linalg.norm(top - ball)
    rod = outer - inner
    turn = (rod @ rack) / (rod @ np.cross(kingpin, outer - ball))
    # The wheel's axis y turns with a velocity kingpin x y: the heading, with the vertical component.
    return float(turn * kingpin[2])


def lateral_curve(scene: Scene, corner: str, slip: float) -> float:
    """Return the lateral force per load, opposite to the tangent of the slip angle."""
    tire = scene["forces"][f"tire_{corner}"]
    mu, C = tire["friction_lat"], 1.3
    return float(mu * sin(C * atan(tire["cornering_stiffness"] * slip / (mu * C))))


def sliding_friction(scene: Scene) -> float:
    """Return the longitudinal force per load of a locked wheel: the Magic Formula at the slip -1."""
    tire = scene["forces"]["tire_fl"]
    mu, C = tire["friction_long"], 1.65
    return float(mu * sin(C * atan(tire["slip_stiffness"] / (mu * C))))


def slip_for(scene: Scene, corner: str, lateral: float) -> float:
    """Return the tangent of the slip angle at which a tire has the lateral force per load."""
    return float(brentq(lambda slip: lateral_curve(scene, corner, slip) - lateral, 0, 0.2, xtol=1e-15))


def set_bump(scene: Scene, **bump: Any) -> Scene:
    for corner in CORNERS:
        scene["forces"][f"tire_{corner}"] |= bump
    return scene
