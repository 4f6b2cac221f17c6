# SPDX-License-Identifier: BSD-3-Clause
"""Where joints and contacts hold the same thing, reported forces balance the loads and obey all laws.

An arm rests with its tip on a plate, and its joint does not move either. How they share the weight is not
determined, but friction exerts no more than it can, and limits, one-way clutches and contacts only push.
"""

from __future__ import annotations

import math
from typing import Any

import pytest

import gelenk

EVENTS = ["auto", "erk", "cvode", "ida", "dirk"]
MASS, LENGTH, RADIUS, G = 2.0, 0.5, 0.02, 9.81
WEIGHT = MASS * G * LENGTH / 2  # N m
COULOMB = 0.3  # N m

# What holds the joint; the torque along phi that it can exert, which the weight turns in positive direction.
HELD: dict[str, tuple[dict[str, Any], float, float]] = {
    "friction": ({"friction": {"coulomb": COULOMB}}, -COULOMB, COULOMB),
    "a limit that would have to pull": ({"limit": {"lower": 0.0}}, 0.0, float("inf")),
    "a one-way clutch": ({"one_way": {"free": "positive"}}, 0.0, float("inf")),
    "a limit and friction": (
        {"limit": {"lower": 0.0}, "friction": {"coulomb": COULOMB}},
        -COULOMB,
        float("inf"),
    ),
}


def arm(joint: dict[str, Any], integrator: str, friction: float = 0.0) -> dict[str, Any]:
    return {
        "gelenk": 1,
        "gravity": [0, 0, -G],
        "bodies": {
            "arm": {
                "mass": MASS,
                "com": [LENGTH / 2, 0, 0],
                "inertia": [0.01] * 3,
                "shapes": {"tip": {"sphere": RADIUS, "position": [LENGTH, 0, 0], "surface": "steel"}},
            }
        },
        "joints": {
            "A": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": {"body": "ground", "position": [0, 0, RADIUS]},
                "child": "arm",
                "start": {"phi": 0, "w": 0, "fixed": True},
                **joint,
            }
        },
        "motors": {"motor": {"joint": "A"}},
        "sensors": {"reaction": {"type": "reaction", "joint": "A"}},
        "ground": {"shapes": {"plate": {"plane": [0, 0, 1], "surface": "plate"}}},
        "contacts": {"rest": {"between": ["steel", "plate"], "friction": friction}},
        "solver": {"integrator": integrator},
    }


@pytest.mark.parametrize("integrator", EVENTS)
@pytest.mark.parametrize("held", HELD)
def test_forces_balance_within_the_laws(held: str, integrator: str) -> None:
    joint, least, most = HELD[held]
    plant = gelenk.Simulation(arm(joint, integrator))
    plant.initialize()
    laws = [f"A.{law}.tau" for law in joint]
    for torque in (0.0, 1.0, -2.0):
        plant.set_input("motor.tau", torque)
        plant.step_to(plant.time + 0.01)
        assert plant.output("A.phi") == pytest.approx(0, abs=1e-12)
        exerted = sum(plant.values(laws))
        normal = plant.output("rest.f[3]")
        assert WEIGHT + torque + exerted - LENGTH * normal == pytest.approx(0, abs=1e-9)
        assert least - 1e-9 <= exerted <= most + 1e-9
        assert normal >= 0
        reaction = plant.output("reaction.f[3]")
        assert reaction == pytest.approx(MASS * G - normal, abs=1e-9)


@pytest.mark.parametrize("integrator", EVENTS)
def test_the_contact_opens_where_friction_alone_cannot_hold_the_arm(integrator: str) -> None:
    """A torque lifts the arm: first by its weight, which needs no force; then by more than friction holds."""
    plant = gelenk.Simulation(arm(HELD["friction"][0], integrator, friction=0.5))
    plant.initialize()
    plant.set_input("motor.tau", -WEIGHT)
    plant.step_to(0.01)
    assert abs(plant.output("A.friction.tau")) <= COULOMB
    assert plant.output("rest.f[3]") >= 0
    plant.set_input("motor.tau", -WEIGHT - 1.2 * COULOMB)
    plant.step_to(0.02)
    acceleration = -0.2 * COULOMB / (0.01 + MASS * LENGTH**2 / 4)
    assert plant.output("A.w") == pytest.approx(0.01 * acceleration, rel=1e-6)
    assert plant.output("A.friction.tau") == pytest.approx(COULOMB)


@pytest.mark.parametrize("integrator", EVENTS)
@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5, 2.0])
def test_the_tip_of_a_pendulum_stays_where_it_falls(integrator: str, friction: float) -> None:
    """The arm of a pendulum falls onto a plate, steeply: its joint and the contact hold it, by any friction.

    Its tip could move in one direction only, in which the normal force alone keeps it. That the force of
    least norm is outside the friction cone changes nothing: the contact has redundant forces, although
    nothing else holds.
    """
    height = 0.19
    scene = arm({}, integrator, friction)
    scene["joints"]["A"]["parent"]["position"] = [0, 0, height]
    scene["solver"]["max_evaluations"] = 2000
    plant = gelenk.Simulation(scene)
    plant.initialize(0.0, 1e-6)
    for k in range(60):
        plant.step_to((k + 1) * 0.01)
    phi, w, f_x, f_z, mode = plant.values(["A.phi", "A.w", "rest.f[1]", "rest.f[3]", "rest.mode"])
    assert phi == pytest.approx(math.asin((height - RADIUS) / LENGTH), abs=1e-9)
    assert w == pytest.approx(0, abs=1e-12)
    assert mode == (1 if friction > 0 else 2)
    moment = LENGTH * (f_z * math.cos(phi) + f_x * math.sin(phi))
    # The tip is a ball, whose lowest point touches.
    moment += RADIUS * f_x
    assert moment == pytest.approx(WEIGHT * math.cos(phi), rel=1e-9)
    assert f_z > 0
    assert abs(f_x) <= friction * f_z * (1 + 1e-6)
    assert 0 <= plant.diagnostic("solver.law_excess") < 1
