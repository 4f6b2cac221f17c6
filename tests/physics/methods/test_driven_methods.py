# SPDX-License-Identifier: BSD-3-Clause
"""Every formulation with every integrator, on a four-bar with a driven crank and on a geared one."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from looped import looped
from mechanisms import GRAVITY, Scene, body, frame, joint
from models.driven import Array, Law, polynomial, sine
from models.geared_five_bar import five_bar, five_bar_bodies
from models.one_dof import Jet, OneDofMechanism
from scipy.integrate import solve_ivp

import gelenk
from physics.constraints.test_driven_loops import LINKS, START, driven

# On the rocker: kg, kg m2 about the center of mass, m to it, position of the pivot on the rocker in m.
BOB, BOB_MOMENT, REACH, PIVOT = 0.3, 0.001, 0.1, (0.7, 0.1)
RATIO, OFFSET, CRANK_START = -2.0, 2.0, 1.9
MOTIONS: dict[str, tuple[dict[str, Any], Law]] = {
    "position": (
        {"polynomial": [START, 3.0], "sine": {"amplitude": 0.2, "frequency": 1.5}},
        lambda t: [a + b for a, b in zip(polynomial([START, 3.0])(t), sine(0.2, 1.5)(t), strict=True)],
    ),
    "speed": ({"speed": 3.0}, polynomial([START, 3.0])),
}


def with_bob(kind: str) -> Scene:
    """A four-bar driven at its crank with a bob (pendulum) on its rocker."""
    out = driven(**MOTIONS[kind][0])
    out["sensors"] = {}
    out["joints"]["A"]["start"] = {"phi": START, "fixed": ["phi"]}
    out["bodies"]["bob"] = body(BOB, (REACH, 0, 0), (BOB_MOMENT, BOB_MOMENT, BOB_MOMENT))
    start = {"phi": -1.0, "w": 0.0, "fixed": True}
    out["joints"]["swings"] = joint(
        "revolute", frame("rocker", (*PIVOT, 0)), frame("bob"), axis=[0, 0, 1], start=start
    )
    return out


@cache
def bob_reference(kind: str) -> float:
    """The angle of the bob relative to the rocker after 1 s,
    by SciPy with the closed-form path of the pivot.
    """
    law = MOTIONS[kind][1]

    def rocker(t: float) -> tuple[float, float, float]:
        phi, w, a = law(t)[:3]
        psi = LINKS.angles(Jet(phi, 1.0))[1]
        return psi.x, psi.d * w, psi.dd * w * w + psi.d * a

    def rates(t: float, x: Array) -> list[float]:
        psi, w, a = rocker(t)
        arm = np.array([[math.cos(psi), -math.sin(psi)], [math.sin(psi), math.cos(psi)]]) @ PIVOT
        ax, ay = a * np.array([-arm[1], arm[0]]) - w * w * arm + [0, GRAVITY]
        moment = BOB * REACH * (ax * math.sin(x[0]) - ay * math.cos(x[0]))
        return [x[1], moment / (BOB_MOMENT + BOB * REACH**2)]

    psi, w, _ = rocker(0.0)
    found = solve_ivp(rates, (0, 1), [psi - 1.0, w], "DOP853", rtol=1e-12, atol=1e-13)
    return float(found.y[0, -1] - rocker(1.0)[0])


@cache
def geared_reference() -> float:
    bodies = five_bar_bodies(RATIO, OFFSET)
    phi, _ = OneDofMechanism(bodies, (0, -GRAVITY, 0)).motion(CRANK_START, 0.0, np.array([0.0, 1.0]))
    return float(phi[-1])


def error(plant: str, formulation: str, integrator: str) -> float:
    """Error of the independent angle after 1 s, rad."""
    geared = plant == "geared"
    source = five_bar(CRANK_START, RATIO, OFFSET) if geared else with_bob(plant)
    source["solver"] = {"formulation": formulation, "integrator": integrator, "step": 1e-3}
    simulation = gelenk.Simulation(gelenk.load(source))
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(1.0)
    found = simulation.output("A.phi" if geared else "swings.phi")
    return abs(found - (geared_reference() if geared else bob_reference(plant)))


ADAPTIVE = ("auto", "erk", "ida", "cvode", "cvode-adams", "dirk")
SECOND_ORDER = ("generalized-alpha", "hht", "newmark")
ALTERNATIVES = ("baumgarte", "udwadia-kalaba", "penalty", "augmented-lagrangian", "independent")
PAIRS = [
    *((f, i) for f in ("projection", *ALTERNATIVES) for i in (*ADAPTIVE, "rk4", "euler", *SECOND_ORDER)),
    *((f, i) for f in ("index3", "stabilized-index2") for i in ("auto", "ida")),
    *(("index3", i) for i in SECOND_ORDER),
]
# At a tolerance of 1e-8 errors of 2e-8 are observed, with penalties 1e-7; with steps of 1 ms, 6e-2 for order
# 1 and 2e-4 for order 2.
BOUNDS = {"euler": 0.15, **dict.fromkeys(SECOND_ORDER, 5e-4)}


@pytest.mark.parametrize("plant", ["position", "speed", "geared"])
@looped(("formulation", "integrator"), PAIRS)
def test_all_methods_give_the_same_result(plant: str, formulation: str, integrator: str) -> None:
    if (plant, formulation) == ("speed", "independent"):
        return  # refused: below
    bound = BOUNDS.get(integrator, 1e-5 if formulation == "index3" else 3e-7)
    assert error(plant, formulation, integrator) < bound


def test_formulation_without_velocity_constraints_refuses_them() -> None:
    with pytest.raises(gelenk.SceneError) as refused:
        error("speed", "independent", "auto")
    assert str(refused.value) == (
        "scene: solver.formulation: found 'independent' with constraints.drive, which constrains "
        "velocities but no positions, expected another formulation, such as projection"
    )
