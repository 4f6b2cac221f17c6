# SPDX-License-Identifier: BSD-3-Clause
"""Where a joint and a contact hold the same motion, forces are redundant, but friction follows from them.

A carriage slides along x against friction; on it, a guide slanted by (0.6, 0, 0.8), on which a ball touches
the ground. The ball cannot sink into the ground; what keeps it from rising, or holds it as well, is a limit,
a one-way clutch or friction of the guide. With the force f along the guide and the normal force N,

    (M + m) x'' = -d (F + mu N),   0.6 m x'' = f - 0.8 m g + (0.8 - 0.6 d mu) N,

where d is the direction of the motion, if the ball stays on the ground.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk

G = 9.81  # m/s2
CARRIAGE, BALL = 1.0, 1.25  # kg
FRICTION = 5.9  # N: of the carriage
COEFFICIENT = 0.3  # of the ground


def scene(speed: float, guide: dict[str, Any], height: float = 0.0) -> dict[str, Any]:
    """Describe it.

    Args:
        speed: of the carriage [m/s].
        guide: fields of the joint between the carriage and the ball.
        height: of the ball above the ground [m].
    """
    place = {"body": "ground", "position": [0, 0, 0.02 + height]}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "carriage": {"mass": CARRIAGE},
            "ball": {"mass": BALL, "shapes": {"s": {"sphere": 0.02, "surface": "ball"}}},
        },
        "joints": {
            "x": {
                "type": "prismatic", "axis": [1, 0, 0], "parent": place, "child": "carriage",
                "start": {"s": 0.0, "v": speed, "fixed": True}, "friction": {"coulomb": FRICTION},
            },
            "u": {
                "type": "prismatic", "axis": [0.6, 0, 0.8], "parent": "carriage", "child": "ball",
                "start": {"s": 0.0, "v": 0.0, "fixed": True}, **guide,
            },
        },
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {"k": {"between": ["ball", "floor"], "friction": COEFFICIENT}},
    }  # fmt: skip


def motion(direction: int, f: float) -> tuple[float, float]:
    """Acceleration of the carriage [m/s2] and normal force [N], if the ball stays on the ground."""
    A = [[CARRIAGE + BALL, direction * COEFFICIENT], [0.6 * BALL, -0.8 + 0.6 * direction * COEFFICIENT]]
    acceleration, normal = np.linalg.solve(A, [-direction * FRICTION, f - 0.8 * BALL * G])
    return float(acceleration), float(normal)


INTEGRATORS = ["auto", "erk", "cvode", "ida"]
# Where the guide holds the ball back, it cannot hold it up. Its largest force along the guide [N] follows.
TOO_WEAK: dict[str, tuple[dict[str, Any], float]] = {
    "limit": ({"limit": {"upper": 0.0}}, 0.0),
    "clutch": ({"one_way": {"free": "negative"}}, 0.0),
    "friction": ({"friction": {"coulomb": 2.0}}, 2.0),
    "friction and limit": ({"friction": {"coulomb": 2.0}, "limit": {"upper": 0.0}}, 2.0),
}
STRONG: dict[str, dict[str, Any]] = {
    "limit": {"limit": {"lower": 0.0}},
    "clutch": {"one_way": {"free": "positive"}},
    "friction": {"friction": {"coulomb": 20.0}},
}


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("direction", [-1, 1])
@pytest.mark.parametrize("guide", TOO_WEAK)
def test_what_cannot_hold_alone_rests_on_the_contact(guide: str, direction: int, integrator: str) -> None:
    fields, force = TOO_WEAK[guide]
    result = gelenk.simulate(scene(0.5 * direction, fields), stop=0.02, step=0.002, integrator=integrator)
    acceleration, normal = motion(direction, force)
    assert result["x.v"][-1] == pytest.approx(0.5 * direction + 0.02 * acceleration, abs=1e-8)
    assert result["k.f[3]"] == pytest.approx(np.full(len(result), normal), rel=1e-9)
    assert np.abs(result["u.s"]).max() < 1e-12


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("direction", [-1, 1])
@pytest.mark.parametrize("guide", STRONG)
def test_forces_agree_with_the_motion(guide: str, direction: int, integrator: str) -> None:
    """Any part of the weight may rest on the ground: what is reported must decelerate the carriage."""
    result = gelenk.simulate(
        scene(0.5 * direction, STRONG[guide]), stop=0.02, step=0.002, integrator=integrator
    )
    friction = -direction * FRICTION + result["k.f[1]"]
    assert result["k.f[1]"] == pytest.approx(-direction * COEFFICIENT * result["k.f[3]"], abs=1e-9)
    assert result["x.a"] == pytest.approx(friction / (CARRIAGE + BALL), rel=1e-9)
    assert (result["k.f[3]"] >= 0).all()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_load_goes_to_the_contact_after_an_impact(integrator: str) -> None:
    described = scene(0.0, {"one_way": {"free": "negative"}}, height=0.017201514768913503)
    described["joints"]["u"]["start"]["v"] = -2.952088346940575
    result = gelenk.simulate(described, stop=0.02, step=0.001, integrator=integrator)
    acceleration, normal = motion(-1, 0.0)
    after = result["time"] > 0.008
    speeds = np.diff(result["x.v"][after]) / 0.001
    assert speeds == pytest.approx(np.full(len(speeds), acceleration), rel=1e-6)
    assert result["k.f[3]"][after] == pytest.approx(np.full(after.sum(), normal), rel=1e-9)
