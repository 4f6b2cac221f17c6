# SPDX-License-Identifier: BSD-3-Clause
"""Located contacts of mechanisms with loops: a plate on two cranks, and a Stewart platform."""

from math import asin, cos, sin

import numpy as np
import pytest
import warned
from models.touching import SceneData

import gelenk

from .test_ball_on_a_platform import HEIGHT, RADIUS, TOP, G, with_ball

CRANK = 0.3  # m
BALL = 0.05  # m
HALF_PLATE = 0.01  # m


def carried(rate: float, phase: float, friction: float, integrator: str) -> SceneData:
    """A ball on a plate that two equal cranks carry around with this rate [rad/s], from this angle [rad] on.

    The plate does not turn. The loop is closed by a revolute joint, whose axis is parallel to the others.
    """
    v = CRANK * rate * np.array([-sin(phase), 0, cos(phase)])
    middle = CRANK * np.array([cos(phase), 0, sin(phase)]) + [0.5, 0, HALF_PLATE + BALL]
    rod = {"mass": 1.0, "com": [CRANK / 2, 0, 0], "inertia": [0.001, 0.01, 0.01]}
    top = {"box": [2, 1, 2 * HALF_PLATE], "position": [0.5, 0, 0], "surface": "plate"}
    end = {"position": [CRANK, 0, 0]}
    at_right = {"position": [1, 0, 0]}

    def turn(parent: SceneData, child: SceneData, phi: float) -> SceneData:
        start = {"phi": phi}
        return {"type": "revolute", "axis": [0, -1, 0], "parent": parent, "child": child, "start": start}

    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "left": rod,
            "right": rod,
            "plate": {
                "mass": 2.0,
                "com": [0.5, 0, 0],
                "inertia": [0.1, 0.2, 0.3],
                "shapes": {"top": top},
            },
            "ball": {
                "mass": 0.5,
                "inertia": [0.4 * 0.5 * BALL**2] * 3,
                "shapes": {"s": {"sphere": BALL, "surface": "ball"}},
            },
        },
        "joints": {
            "A": turn({"body": "ground"}, {"body": "left"}, phase),
            "B": turn({"body": "ground"} | at_right, {"body": "right"}, phase),
            "C": turn({"body": "left"} | end, {"body": "plate"}, -phase),
            "D": turn({"body": "right"} | end, {"body": "plate"} | at_right, -phase),
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "ball",
                "start": {"r": middle.tolist(), "v": v.tolist(), "fixed": True},
            },
        },
        "constraints": {"drive": {"type": "motion", "joint": "A", "polynomial": [phase, rate]}},
        "contacts": {"rest": {"between": ["ball", "plate"], "friction": friction}},
        "solver": {"integrator": integrator},
    }


@warned.TIGHT
@pytest.mark.parametrize("integrator", ["erk", "cvode", "dirk"])
def test_a_ball_leaves_a_plate_that_is_carried_around(integrator: str) -> None:
    """It leaves where the plate falls with the acceleration of gravity: r w2 sin(phi) = g."""
    rate, phase = 7.0, 0.3
    scene = carried(rate, phase, 0, integrator)
    run = gelenk.simulate(scene, stop=0.25, step=0.01, tolerance=1e-10)
    exact = (asin(G / (CRANK * rate**2)) - phase) / rate
    leaving = [t for t, text in run.events if text == "rest: ball leaves plate"]
    assert leaving == pytest.approx([exact], abs=1e-9)
    carried_up = run["J.r[3]"][run.time < exact]
    angle = phase + rate * run.time[run.time < exact]
    assert np.abs(carried_up - CRANK * np.sin(angle) - HALF_PLATE - BALL).max() <= 1e-9


def test_a_ball_rolls_on_a_plate_that_is_carried_around() -> None:
    """Without slip, the ball has 2/7 of the acceleration of the plate along it."""
    rate, phase = 3.0, 0.5
    scene = carried(rate, phase, 2.0, "erk")
    run = gelenk.simulate(
        scene, stop=0.6, step=0.05, tolerance=1e-10, outputs=["J.*", "rest.mode", "rest.f*"]
    )
    angle = phase + rate * run.time
    v = -CRANK * rate * sin(phase)
    way = CRANK * (np.cos(angle) - cos(phase))
    exact = CRANK * cos(phase) + 0.5 + v * run.time + 2 / 7 * (way - v * run.time)
    assert np.abs(run["J.r[1]"] - exact).max() <= 1e-8
    assert set(run["rest.mode"]) == {1}
    normal = 0.5 * (G - CRANK * rate**2 * np.sin(angle))
    assert np.abs(run["rest.f[3]"] - normal).max() <= 1e-7


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_a_ball_lands_on_a_stewart_platform_rolls_and_leaves(tolerance: float) -> None:
    """The platform, on its springs, has five loops; erk and cvode agree, and the loops remain closed."""
    names = ["roll.mode", "roll.gap", "constraints.position", *(f"J.r[{k}]" for k in (1, 2, 3))]
    forces = {"drive1.f": 600.0, "drive2.f": 600.0, "drive4.f": -600.0, "drive5.f": -600.0}
    runs = []
    for integrator in ("erk", "cvode"):
        scene = with_ball({"r": [0.3, 0, HEIGHT + TOP + RADIUS + 0.02]}, 0.5)
        scene["solver"] = {"integrator": integrator}
        runs.append(
            gelenk.simulate(scene, stop=1, step=0.02, outputs=names, inputs=forces, tolerance=tolerance)
        )
    for run in runs:
        assert 0 in run["roll.mode"]
        assert 1 in run["roll.mode"]
        assert run["roll.gap"].min() >= -1e-12
        assert run["constraints.position"].max() <= 1e-12
    for k in (1, 2, 3):
        assert np.abs(runs[0][f"J.r[{k}]"] - runs[1][f"J.r[{k}]"]).max() <= 1000 * tolerance
