# SPDX-License-Identifier: BSD-3-Clause
"""A mass on a spring and a damper, the other end of which is driven by an input, and its motion."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mechanisms import Scene, body, frame, joint, scene
from scipy.integrate import solve_ivp

import gelenk

MASS, STIFFNESS, DAMPING = 2.0, 50.0, 8.0  # kg, N/m, N s/m
TOLERANCE = 1e-10
END = 0.6  # s

type Motion = Callable[[float], float]


def driven_mass(integrator: str = "auto", **motion: Any) -> Scene:
    """A mass on a spring and a damper, the other end of which is driven."""
    out = scene(
        {"end": body(1.0), "load": body(MASS)},
        {
            "x": joint("prismatic", frame("ground"), frame("end"), axis=[1, 0, 0]),
            "y": joint(
                "prismatic", frame("end"), frame("load"), axis=[1, 0, 0], stiffness=STIFFNESS, damping=DAMPING
            ),
        },
    )
    out["constraints"] = {"pos": {"type": "motion", "joint": "x", "input": "position"} | motion}
    out["solver"] = {"integrator": integrator, "step": 1e-3}
    return out


def start_of(source: Scene, name: str = "pos.s_ref", value: float = 0.0) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(source))
    plant.set_input(name, value)
    plant.initialize(0.0, TOLERANCE)
    return plant


def follow(plant: gelenk.Simulation, times: Sequence[float], motion: Motion, name: str = "pos.s_ref") -> None:
    for t, later in itertools.pairwise(times):
        plant.set_input(name, motion(t))
        plant.step_to(later)


def swing(t: float) -> float:
    return 0.3 * math.sin(4.0 * t + 0.4)


def swing_rate(t: float) -> float:
    return 1.2 * math.cos(4.0 * t + 0.4)


def place_of_mass(motion: Motion, rate: Motion) -> float:
    """Of the mass at END, by its equation of motion; it starts with the velocity of the driven end."""
    found = solve_ivp(
        lambda t, z: [z[1], (STIFFNESS * (motion(t) - z[0]) + DAMPING * (rate(t) - z[1])) / MASS],
        (0.0, END), [motion(0.0), rate(0.0)], rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    return float(found.y[0, -1])


def equal_steps(h: float) -> list[float]:
    return [k * h for k in range(round(END / h) + 1)]


def unequal_steps(h: float) -> list[float]:
    """Times of which each step is up to ten times as long as the one before it, or as short."""
    factors = 10.0 ** np.random.default_rng(5).uniform(-0.5, 0.5, round(END / h))
    return [0.0, *(END * np.cumsum(factors) / factors.sum()).tolist()]
