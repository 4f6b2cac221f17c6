# SPDX-License-Identifier: BSD-3-Clause
"""A ball on the plate of a Stewart platform, a mechanism of five loops."""

from math import cos, radians, sin
from pathlib import Path

import numpy as np
import pytest
from models.touching import SceneData

import gelenk

G = 9.81  # m/s2
HEIGHT = 1.1  # m, of the platform's frame
TOP = 0.11  # m, of the plate above it
RADIUS = 0.05  # m
SCENE = Path(__file__).resolve().parents[3] / "scenes" / "stewart.yaml"
LEGS = range(1, 7)


def with_ball(start: dict[str, object], friction: float) -> SceneData:
    """The shipped platform with a plate of 1 m and a homogeneous ball."""
    scene = gelenk.load(SCENE).to_dict()
    scene["bodies"]["platform"]["shapes"] = {
        "plate": {"box": [1, 1, 0.02], "position": [0, 0, TOP - 0.01], "surface": "plate"}
    }
    scene["bodies"]["ball"] = {
        "mass": {"density": 1000},
        "shapes": {"hull": {"sphere": RADIUS, "surface": "ball"}},
    }
    scene["joints"]["J"] = {
        "type": "free",
        "parent": "ground",
        "child": "ball",
        "start": {**start, "fixed": True},
    }
    scene["contacts"] = {"roll": {"between": ["ball", "plate"], "friction": friction}}
    scene["experiment"] = {"step": 1e-3}
    scene.pop("solver", None)
    return scene


def leg_lengths(scene: SceneData, tilt: float) -> list[float]:
    """The coordinates of the legs with which the platform is turned about the y axis of its frame [m]."""
    turn = np.array([[cos(tilt), 0, sin(tilt)], [0, 1, 0], [-sin(tilt), 0, cos(tilt)]])
    center = np.array([0, 0, HEIGHT])
    out = []
    for i in LEGS:
        base, ball = (scene["joints"][f"{name}{i}"]["at"] for name in ("base", "ball"))
        _, pitch, yaw = base["rotation"]["rpy"]
        axis = np.array([cos(yaw) * sin(pitch), sin(yaw) * sin(pitch), cos(pitch)])
        from_base = np.array(ball["position"]) - base["position"]
        along = from_base @ axis
        aside = from_base @ from_base - along**2  # four digits: the ball is not quite on the axis
        now = center + turn @ (np.array(ball["position"]) - center) - base["position"]
        out.append(float(np.sqrt(now @ now - aside) - along))
    return out


@pytest.mark.parametrize("degrees", [2.0, 8.0])
def test_ball_rolls_down_a_tilted_plate(degrees: float) -> None:
    """The legs hold the plate at an angle a: a ball that rolls without slip has the acceleration 5/7 g sin a.

    Steps of order 2 follow a constant acceleration exactly; 1e-9 is that of the residuals over 500 steps.
    """
    import yaml

    tilt = radians(degrees)
    at = (TOP + RADIUS) * np.array([sin(tilt), 0, cos(tilt)]) + [0, 0, HEIGHT]
    scene = with_ball({"r": at.tolist()}, 0.5)
    written = yaml.safe_load(SCENE.read_text(encoding="utf-8"))
    for i, s in zip(LEGS, leg_lengths(written, tilt), strict=True):
        scene["constraints"] = scene.get("constraints", {}) | {
            f"hold{i}": {"type": "motion", "joint": f"leg{i}", "polynomial": [s]}
        }
        scene["joints"][f"leg{i}"].pop("start", None)
    names = [*(f"J.r[{k}]" for k in (1, 2, 3)), "J.w[2]", "roll.mode", "constraints.position", "roll.f[3]"]
    run = gelenk.simulate(scene, stop=0.5, step=0.01, outputs=names)
    moved = np.stack([run[f"J.r[{k}]"] for k in (1, 2, 3)], axis=1) - at
    a = 5 / 7 * G * sin(tilt)
    assert moved[-1] @ [cos(tilt), 0, -sin(tilt)] == pytest.approx(a / 2 * 0.25, abs=1e-9)
    assert moved[-1] @ [sin(tilt), 0, cos(tilt)] == pytest.approx(0, abs=1e-9)
    assert run["J.w[2]"][-1] == pytest.approx(a * 0.5 / RADIUS, abs=1e-7)
    assert set(run["roll.mode"][1:]) == {1}
    mass = 1000 * 4 / 3 * np.pi * RADIUS**3
    assert run["roll.f[3]"][-1] == pytest.approx(mass * (G - a * sin(tilt)), rel=1e-8)
    assert run["constraints.position"].max() <= 2e-13  # Newton's last step in the projection; mostly 1e-15


def test_loops_stay_closed_while_a_ball_lands_rolls_and_leaves() -> None:
    """On its springs, the platform sinks and tilts under the motors; the ball lands, rolls and falls off."""
    scene = with_ball({"r": [0.3, 0, HEIGHT + TOP + RADIUS + 0.02]}, 0.5)
    names = ["roll.mode", "roll.gap", "constraints.position", "J.r[1]", "J.r[3]"]
    forces = {"drive1.f": 600.0, "drive2.f": 600.0, "drive4.f": -600.0, "drive5.f": -600.0}
    run = gelenk.simulate(scene, stop=2, step=1e-3, outputs=names, inputs=forces)
    closed = run["roll.mode"] > 0
    assert not closed[0]
    assert closed.sum() > 100
    assert not closed[-10:].any()  # it has left
    assert run["J.r[3]"][-1] < 0.5
    assert run["constraints.position"].max() <= 2e-13  # Newton's last step in the projection; mostly 1e-15
