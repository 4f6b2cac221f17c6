# SPDX-License-Identifier: BSD-3-Clause
"""A block that begins to slide from rest, in a direction that turns as it slides."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gelenk

G, MASS, FRICTION, STATIC = 9.81, 0.7, 0.3, 0.4  # m/s2, kg
PULL, RISE = 1.0, 40.0  # N, N/s: of the force along x
STIFFNESS, REACH = 90.0, 0.01  # N/m, m: of a spring along y
STOP = 0.1  # s


def block(integrator: str) -> dict[str, Any]:
    """A block that slides and does not turn, on the ground, with a motor along x and a spring along y."""
    shape = {"box": [0.1, 0.1, 0.1], "surface": "block"}
    joints: dict[str, Any] = {
        "x": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "a"},
        "y": {
            "type": "prismatic", "axis": [0, 1, 0], "parent": "a", "child": "b",
            "stiffness": STIFFNESS, "spring_reference": REACH,
        },
        "z": {"type": "prismatic", "axis": [0, 0, 1], "parent": "b", "child": "block"},
    }  # fmt: skip
    for name, of in joints.items():
        of["start"] = {"s": 0.05 if name == "z" else 0.0, "v": 0.0, "fixed": True}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {"a": {"mass": 0}, "b": {"mass": 0}, "block": {"mass": MASS, "shapes": {"box": shape}}},
        "joints": joints,
        "motors": {"pull": {"joint": "x"}},
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {"k": {"between": ["block", "floor"], "friction": FRICTION, "static": STATIC}},
        "solver": {"integrator": integrator},
    }


def reference() -> tuple[float, float]:
    """vx, vy at the end; it begins to slide in the direction of the force that exceeds friction."""
    limit = FRICTION * MASS * G
    begin = (np.sqrt((STATIC * MASS * G) ** 2 - (STIFFNESS * REACH) ** 2) - PULL) / RISE

    def rates(t: float, y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        force, v = np.array([PULL + RISE * t, STIFFNESS * (REACH - y[1])]), y[2:]
        along = v if np.any(v) else force
        return np.concatenate([v, (force - limit * along / np.linalg.norm(along)) / MASS])

    out = solve_ivp(rates, (begin, STOP), np.zeros(4), method="DOP853", rtol=1e-12, atol=1e-15)
    return float(out.y[2, -1]), float(out.y[3, -1])


@pytest.mark.parametrize("step", [0.1, 0.05, 0.01, 1e-3])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida"])
def test_direction_turns_from_the_first_step(integrator: str, step: float) -> None:
    """Dirk left it as it was in the first step, with an error of the order of the step's square."""
    plant = gelenk.Simulation(block(integrator))
    plant.initialize(0.0, 1e-9)
    force = next(of.name for of in plant.inputs)
    for k in range(round(STOP / step)):
        plant.set_input(force, PULL + RISE * k * step)
        plant.set_input_derivative(force, 1, RISE)
        plant.step_to((k + 1) * step)
    expected = reference()
    assert plant.output("x.v") == pytest.approx(expected[0], abs=1e-7)
    assert plant.output("y.v") == pytest.approx(expected[1], abs=1e-7)
