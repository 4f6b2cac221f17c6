# SPDX-License-Identifier: BSD-3-Clause
"""Friction of guides and bearings that carry what contacts put on them: closed forms, all integrators."""

from __future__ import annotations

from typing import Any

import pytest
from models.laws_that_meet import ALONG, guided
from models.registered_laws import INTEGRATORS

import gelenk

G = 9.81  # m/s2
CART, BOX = 2.0, 1.0  # kg
BETWEEN, GUIDE, AT_REST = 0.4, 0.2, 0.25  # coefficients of friction
TIME, STEP = 0.2, 1e-3  # s


def box_on_a_cart(integrator: str, gravity: float = G) -> dict[str, Any]:
    """A cart in a guide, with friction in proportion to its load; a box stands on it."""
    guide = {"coulomb": 0.0, "bearing": {"coefficient": GUIDE, "static": AT_REST}}
    top = {"box": [4, 1, 0.2], "surface": "steel"}
    hull = {"box": [0.2, 0.2, 0.2], "surface": "wood"}
    start = {"r": [0, 0, 0.2], "fixed": True}
    return {
        "gelenk": 1,
        "gravity": [0, 0, -gravity],
        "bodies": {
            "cart": {"mass": CART, "inertia": [1, 1, 1], "shapes": {"top": top}},
            "box": {"mass": BOX, "inertia": [0.1, 0.1, 0.1], "shapes": {"hull": hull}},
        },
        "joints": {
            "P": guided("cart", ALONG, start={"v": 0.0}, friction=guide),
            "J": {"type": "free", "parent": "ground", "child": "box", "start": start},
        },
        "contacts": {"top": {"between": ["steel", "wood"], "friction": BETWEEN}},
        "motors": {"push": {"joint": "P"}},
        "solver": {"integrator": integrator, "step": STEP},
    }


def pushed(integrator: str, force: float, gravity: float = G) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(box_on_a_cart(integrator, gravity)))
    plant.set_input("push.f", force)
    plant.initialize(tolerance=1e-9)
    plant.step_to(TIME)
    return plant


# N: held by the guide; both move as one; the box slides.
@pytest.mark.parametrize("force", [0.99 * AT_REST * 3 * G, 1.01 * AT_REST * 3 * G, 16.0, 30.0])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_guide_carries_what_stands_on_its_cart(integrator: str, force: float) -> None:
    plant = pushed(integrator, force)
    load = (CART + BOX) * G
    cart = box = 0.0
    if force > AT_REST * load:
        cart = box = (force - GUIDE * load) / (CART + BOX)
        if box > BETWEEN * G:
            box = BETWEEN * G
            cart = (force - BETWEEN * BOX * G - GUIDE * load) / CART
    # Constant accelerations, which all methods integrate exactly but for their tolerance; in the time step
    # in which the cart breaks away, it still has static friction.
    error = 1e-7
    if integrator == "moreau-jean":
        error += (AT_REST - GUIDE) * load / CART * STEP
    assert plant.output("P.v") == pytest.approx(cart * TIME, abs=error)
    assert plant.output("J.v[1]") == pytest.approx(box * TIME, abs=error)
    friction = -GUIDE * load if cart > 0 else -force
    assert plant.output("P.friction.f") == pytest.approx(friction, rel=1e-7)
    assert plant.output("P.friction.mode") == (1 if cart > 0 else 0)
    assert plant.output("top.f[3]") == pytest.approx(-BOX * G, rel=1e-7)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_box_without_weight_is_not_dragged_along(integrator: str) -> None:
    """It touches without a force, so that there is no friction: it stays where it is."""
    plant = pushed(integrator, 5.0, gravity=0.0)
    assert plant.output("P.v") == pytest.approx(5.0 / CART * TIME, rel=1e-7)
    assert plant.output("J.v[1]") == pytest.approx(0.0, abs=1e-12)
    assert plant.output("J.v[3]") == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_belt_that_is_started_slips_below_a_box(integrator: str) -> None:
    """Friction takes the box along, v = mu g t; it is not moved at once."""
    belt = box_on_a_cart(integrator)
    belt["joints"]["P"]["friction"] = {"coulomb": 100.0}  # N: holds the cart
    belt["parameters"] = ["top.velocity[1]"]
    source = gelenk.load(belt)
    plant = gelenk.Simulation(source)
    plant.initialize(tolerance=1e-9)
    plant.step_to(0.05)
    plant._core.tune(source.with_parameters({"top.velocity[1]": 2.0})._core)
    plant.step_to(0.05 + TIME)
    assert abs(plant.output("J.v[1]")) == pytest.approx(BETWEEN * G * TIME, rel=1e-6)
    assert plant.output("top.mode") == 2


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_platform_whose_speed_jumps_slips_below_a_box(integrator: str) -> None:
    """As a belt that is started: the impact that changes its speed has no normal impulse on the box."""
    moved = box_on_a_cart(integrator)
    del moved["joints"]["P"]["friction"], moved["joints"]["P"]["start"], moved["motors"]
    moved["constraints"] = {"drive": {"type": "motion", "joint": "P", "input": "speed"}}
    plant = gelenk.Simulation(gelenk.load(moved))
    plant.initialize(tolerance=1e-9)
    plant.step_to(0.05)
    plant.set_input("drive.v_ref", 1.5)
    plant.step_to(0.05 + TIME)
    assert plant.output("P.v") == pytest.approx(1.5, abs=1e-12)
    assert plant.output("J.v[1]") == pytest.approx(BETWEEN * G * TIME, rel=1e-6)
    assert plant.output("top.mode") == 2
