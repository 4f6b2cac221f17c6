# SPDX-License-Identifier: BSD-3-Clause
"""What contacts hold entirely is at rest exactly; what they carry along is not."""

from __future__ import annotations

from math import atan, radians
from typing import Any

import numpy as np
import pytest
from models.contact_law_cases import PUSH
from models.touching import SceneData, box_on_a_cart, inertia_of_box, on_plane

import gelenk

G = 9.81  # m/s2
EDGE, MASS, FRICTION = 0.2, 2.0, 0.5
INTEGRATORS = ["rk4", "auto", "erk", "cvode", "dirk"]


def cube(integrator: str, **fields: Any) -> SceneData:
    start = {"r": [0, 0, EDGE / 2]} | fields.pop("start", {})
    law = {"friction": FRICTION} | fields.pop("law", {})
    source = on_plane({"box": [EDGE] * 3}, MASS, inertia_of_box(MASS, [EDGE] * 3), start, law, **fields)
    source["forces"] = {"push": PUSH}
    source["solver"] = {"integrator": integrator, "step": 1e-3}
    return source


def speeds(plant: gelenk.Simulation, joint: str = "J") -> np.ndarray[Any, Any]:
    return plant.values([f"{joint}.{q}[{k}]" for q in "vw" for k in (1, 2, 3)])


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("angle", [0.0, 20.0])
def test_a_cube_at_rest_does_not_move_at_all(integrator: str, angle: float) -> None:
    """Also on a slope; with forces that change, and with other inputs in each step."""
    slope = radians(angle)
    normal = (-np.sin(slope), 0.0, np.cos(slope))
    start = {
        "r": [EDGE / 2 * x for x in normal],
        "Q": [0, -np.sin(slope / 2), 0, np.cos(slope / 2)],
    }
    plant = gelenk.Simulation(cube(integrator, normal=normal, start=start))
    plant.initialize()
    plant.step_to(0.05)
    at = plant.values([f"J.r[{k}]" for k in (1, 2, 3)])
    for k in range(1, 40):
        plant.set_input("push.f[1]", 0.5 * np.sin(k))
        plant.step_to(0.05 + 0.01 * k)
        assert not speeds(plant).any()
        assert (plant.values([f"J.r[{k}]" for k in (1, 2, 3)]) == at).all()
        assert plant.output("floor.f[1]") == pytest.approx(-0.5 * np.sin(k), abs=1e-10)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_it_slides_from_where_the_force_exceeds_friction(integrator: str) -> None:
    """Pushed with just less than friction holds, then 1 N more, then not: it stops and is at rest again."""
    source = cube(integrator)
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, 1e-9)
    limit = FRICTION * MASS * G
    assert 9.0 < limit < 10.0
    plant.set_input("push.f[1]", limit * (1 - 1e-9))
    plant.step_to(0.1)
    assert not speeds(plant).any()
    plant.set_input("push.f[1]", limit + 1.0)
    plant.step_to(0.2)
    assert plant.output("J.v[1]") == pytest.approx(0.1 * 1.0 / MASS, abs=1e-8)
    plant.set_input("push.f[1]", 0.0)
    plant.step_to(0.4)
    assert not speeds(plant).any()
    slid = 0.1**2 / 2 / MASS
    assert plant.output("J.r[1]") == pytest.approx(slid + (0.1 / MASS) ** 2 / (2 * FRICTION * G), abs=1e-8)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_what_a_cart_carries_moves_with_it(integrator: str) -> None:
    source = box_on_a_cart()
    source["solver"] = {"integrator": integrator}
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, 1e-9)
    plant.set_input("drive.f", 1.5)
    plant.step_to(0.5)
    exact = 1.5 * (1 - np.exp(-0.5 / 1.5))  # 1 N s/m of damping, 1.5 kg
    assert plant.output("P.v") == pytest.approx(exact, abs=1e-7)
    assert speeds(plant) == pytest.approx([exact, 0, 0, 0, 0, 0], abs=1e-7)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_belt_carries_along(integrator: str) -> None:
    source = cube(integrator, law={"velocity": [0.3, 0, 0]}, start={"v": [0.3, 0, 0]})
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, 1e-9)
    plant.step_to(0.5)
    assert speeds(plant) == pytest.approx([0.3, 0, 0, 0, 0, 0], abs=1e-9)
    assert plant.output("J.r[1]") == pytest.approx(0.15, abs=1e-8)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_prescribed_motion_carries_along(integrator: str) -> None:
    source = box_on_a_cart()
    del source["motors"]
    source["constraints"] = {
        "move": {"type": "motion", "joint": "P", "sine": {"amplitude": 0.05, "frequency": 1.0}}
    }
    source["solver"] = {"integrator": integrator}
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, 1e-9)
    plant.step_to(0.3)
    assert plant.output("J.v[1]") == pytest.approx(plant.output("P.v"), abs=1e-9)
    assert abs(plant.output("P.v")) > 0.01


@pytest.mark.parametrize("integrator", ["rk4", "auto"])
def test_restored_at_rest_it_continues_to_the_bit(integrator: str) -> None:
    def continued(plant: gelenk.Simulation) -> np.ndarray[Any, Any]:
        rows = []
        for k in range(1, 20):
            plant.set_input("push.f[1]", 12.0 if k % 5 == 0 else 1.0)
            plant.step_to(0.1 + 0.005 * k)
            rows.append(plant.values())
        return np.array(rows)

    plant = gelenk.Simulation(cube(integrator))
    plant.initialize()
    plant.step_to(0.1)
    saved = plant.save()
    first = continued(plant)
    plant.restore(saved)
    assert (continued(plant) == first).all()
    other = gelenk.Simulation(cube(integrator))
    other.initialize()
    other.restore(saved)
    assert (continued(other) == first).all()


def test_the_angle_at_which_it_slides() -> None:
    """On either side of the angle of friction."""
    for factor, rests in ((1 - 1e-9, True), (1 + 1e-9, False)):
        slope = atan(FRICTION) * factor
        normal = (-np.sin(slope), 0.0, np.cos(slope))
        start = {"r": [EDGE / 2 * x for x in normal], "Q": [0, -np.sin(slope / 2), 0, np.cos(slope / 2)]}
        plant = gelenk.Simulation(cube("auto", normal=normal, start=start))
        plant.initialize()
        plant.step_to(0.1)
        assert speeds(plant).any() != rests
