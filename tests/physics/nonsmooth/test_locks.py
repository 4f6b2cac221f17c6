# SPDX-License-Identifier: BSD-3-Clause
"""Locks of joints, engaged and released by an input: docking, against closed forms of the plastic impact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Array, matrix, placed, rotation
from models.locks import (
    CAPSULE,
    ENGAGEMENT,
    HATCH,
    LOCK,
    PORT,
    STATION,
    TURN,
    docking,
    matrix_of,
    momentum,
    started,
    stuck_together,
    vector,
)
from models.running import assert_close

import gelenk

# Momenta are sums of some 50 products of numbers about 1.
ROUNDING = 1e-14
INTEGRATORS = ("erk", "dirk", "cvode", "ida", "rk4")
STEP = {"rk4": {"step": 1e-3}, "moreau-jean": {"step": 1e-3}}


def engage(simulation: gelenk.Simulation, value: float = 1.0) -> None:
    """Set the input, and let the impact happen in a step of 1 ns."""
    simulation.set_input(ENGAGEMENT, value)
    simulation.step_to(simulation.time + 1e-9)


@warned.TIGHT
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_two_bodies_dock_and_are_released(integrator: str) -> None:
    """Momenta remain, the energy becomes that of one body with them; then both turn and drift as one."""
    plant = started(docking(LOCK), integrator, **STEP.get(integrator, {}))
    plant.step_to(0.7)
    P, H, T = momentum(plant)
    expected = stuck_together(plant)
    assert expected < 0.8 * T  # an impact, not an encounter
    engage(plant)
    P1, H1, T1 = momentum(plant)
    assert_close("linear momentum", P1, P, ROUNDING, "rounding")
    assert_close("angular momentum", H1, H, 1e-8, "1 ns in which bodies move")
    assert_close("energy", T1, expected, 10 * ROUNDING, "rounding")
    pose = vector(plant, "port.r"), vector(plant, "port.Q", 4)
    plant.step_to(1.5)
    assert np.all(vector(plant, "port.v") == 0)
    assert np.all(vector(plant, "port.w") == 0)
    assert np.all(vector(plant, "port.r") == pose[0])
    assert np.all(vector(plant, "port.Q", 4) == pose[1])
    assert plant.output("port.lock.mode") == 1
    P2, H2, T2 = momentum(plant)
    for what, found, was in (("P", P2, P), ("H", H2, H), ("T", T2, T1)):
        assert_close(what, found, was, 1e-9, "10 times the tolerance")
    engage(plant, 0.0)
    assert plant.output("port.lock.mode") == 0
    assert_close("energy", momentum(plant)[2], T2, 10 * ROUNDING, "nothing is lost")
    free = [vector(plant, "station.v"), vector(plant, "capsule.v")]
    plant.step_to(2.5)
    for name, v in zip(("station", "capsule"), free, strict=True):
        assert_close(name, vector(plant, f"{name}.v"), v, 1e-9, "10 times the tolerance")
    assert plant.diagnostics["solver.events"] == 2
    assert plant.diagnostics["solver.impacts"] == 1


def test_the_loss_is_that_of_the_impact_law() -> None:
    """1/2 v W^-1 v, with the velocities v of the joint before, and W per impulse along them."""
    plant = started(docking(LOCK), "erk", 1e-12)
    plant.step_to(0.7)
    _, _, T = momentum(plant)
    v = np.concatenate([vector(plant, "port.v"), vector(plant, "port.w")])
    engage(plant)
    lost = T - momentum(plant)[2]
    W = response(plant)
    assert_close("loss", lost, v @ np.linalg.solve(W, v) / 2, 1e-8, "1 ns in which bodies move")


def response(plant: gelenk.Simulation) -> Array:
    """Velocities of the joint per impulses along them, from the Newton-Euler equations of both bodies."""
    R_s = matrix_of(vector(plant, "station.Q", 4))
    R_c = matrix_of(vector(plant, "capsule.Q", 4))
    M = R_c @ TURN  # axes of the frame M on the capsule
    p = np.array(HATCH) @ R_c.T + vector(plant, "capsule.r")  # origin of M in the world
    columns = []
    for k in range(6):
        f = R_s[:, k] if k < 3 else np.zeros(3)  # on the capsule at p, along F's axes
        n = M[:, k - 3] if k >= 3 else np.zeros(3)
        v, w = {}, {}
        for name, (mass, moments), R, side in (
            ("station", STATION, R_s, -1),
            ("capsule", CAPSULE, R_c, 1),
        ):
            arm = p - vector(plant, f"{name}.r")
            v[name] = side * f / mass
            w[name] = R @ (R.T @ (side * (n + np.cross(arm, f))) / np.array(moments))
        at = {name: v[name] + np.cross(w[name], p - vector(plant, f"{name}.r")) for name in v}
        columns.append(
            np.concatenate([R_s.T @ (at["capsule"] - at["station"]), M.T @ (w["capsule"] - w["station"])])
        )
    return np.array(columns).T


def test_docked_bodies_move_as_welded_ones() -> None:
    """A scene with a weld at the pose in which they docked, started with their velocities."""
    plant = started(docking(LOCK), "erk", 1e-12)
    plant.step_to(0.7)
    engage(plant)
    welded = docking(kind="weld")
    port = welded["joints"]["port"]
    port["parent"] = {
        "body": "station",
        "position": list(np.array(PORT) + vector(plant, "port.r")),
        "rotation": matrix(matrix_of(vector(plant, "port.Q", 4))),
    }
    start = {k: list(vector(plant, f"orbit.{k}", n)) for k, n in (("r", 3), ("Q", 4), ("v", 3), ("w", 3))}
    welded["joints"]["orbit"]["start"] = {**start, "fixed": True}
    reference = started(welded, "erk", 1e-12)
    reference.step_to(1.0)
    plant.step_to(plant.time + 1.0)
    for name in ("station", "capsule"):
        for k, n in (("r", 3), ("v", 3), ("w", 3)):
            assert_close(
                f"{name}.{k}",
                vector(plant, f"{name}.{k}", n),
                vector(reference, f"{name}.{k}", n),
                1e-10,
                "both",
            )
    assert_close(
        "force", vector(plant, "port.lock.f"), vector(plant, "transmitted.f"), 1e-13, "the same force"
    )


@pytest.mark.parametrize("value", [0.5, -3.0, 0.49999])
def test_an_input_up_to_one_half_releases(value: float) -> None:
    plant = started(docking(LOCK))
    plant.set_input(ENGAGEMENT, value)
    plant.step_to(0.1)
    assert plant.output("port.lock.mode") == 0
    assert plant.diagnostics["solver.events"] == 0


def test_turned_in_space_and_later_in_time() -> None:
    """All outputs of the joint are the same."""
    ends = []
    for source, begin in (
        (docking(LOCK), 0.0),
        (placed(docking(LOCK), rotation((1, 2, 3), 0.8), (0.4, -1, 2)), 0.0),
        (docking(LOCK), 17.0),
    ):
        plant = gelenk.Simulation({**source, "solver": {"integrator": "erk"}})
        plant.initialize(begin, 1e-11)
        plant.step_to(begin + 0.5)
        plant.set_input(ENGAGEMENT, 1.0)
        plant.step_to(begin + 1.0)
        forces = [vector(plant, "port.lock.f"), vector(plant, "port.lock.tau")]
        plant.set_input(ENGAGEMENT, 0.0)
        plant.step_to(begin + 1.5)
        ends.append(np.concatenate([*forces, vector(plant, "port.r"), vector(plant, "port.w")]))
    assert_close("turned", ends[1], ends[0], 1e-9, "100 times the tolerance")
    assert_close("later", ends[2], ends[0], 1e-9, "100 times the tolerance")


def test_time_steps_with_impulses_dock_them_too() -> None:
    """Of first order in the step in which velocities jump."""
    ends = []
    for integrator, h in (("erk", 0.0), ("moreau-jean", 2e-3), ("moreau-jean", 1e-3)):
        plant = started(docking(LOCK), integrator, 1e-10, **({"step": h} if h else {}))
        plant.step_to(0.5)
        plant.set_input(ENGAGEMENT, 1.0)
        plant.step_to(1.0)
        assert plant.output("port.lock.mode") == 1
        forces = vector(plant, "port.lock.f")
        plant.set_input(ENGAGEMENT, 0.0)
        plant.step_to(1.2)
        assert plant.output("port.lock.mode") == 0
        ends.append(np.concatenate([vector(plant, "port.r"), vector(plant, "port.v"), forces]))
    errors = [float(np.abs(end - ends[0]).max()) for end in ends[1:]]
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.3)


@pytest.mark.parametrize("integrator", [*INTEGRATORS, "moreau-jean"])
@pytest.mark.parametrize("engaged", [0.0, 1.0])
def test_restored_in_both_conditions_to_the_bit(integrator: str, engaged: float) -> None:
    plant = started(docking(LOCK), integrator, 1e-8, **STEP.get(integrator, {}))
    plant.step_to(0.3)
    plant.set_input(ENGAGEMENT, engaged)
    plant.step_to(0.5)
    saved = plant.save()
    ends = []
    for goes_on in (True, False, False):
        if not goes_on:
            plant.restore(saved)
        plant.step_to(0.6)
        plant.set_input(ENGAGEMENT, 1 - engaged)
        plant.step_to(0.9)
        ends.append(plant.values())
    np.testing.assert_array_equal(ends[1], ends[0])
    np.testing.assert_array_equal(ends[2], ends[0])


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "ida", "moreau-jean"])
@pytest.mark.parametrize("of_ball", [True, False])
def test_beside_friction_about_any_axis_or_in_any_direction(integrator: str, of_ball: bool) -> None:
    """The lock stops what slips, and friction holds what it releases: a puck on a slope of half of it."""
    friction: dict[str, Any] = {"coulomb": 0.2} if of_ball else {"translation": {"coulomb": 0.2}}
    start = {"w": [0.6, 0, 0.8]} if of_ball else {"v_x": 0.6, "v_y": 0.8}
    speeds = ["J.w[1]", "J.w[3]"] if of_ball else ["J.v_x", "J.v_y"]
    plant = gelenk.Simulation(
        {
            "gelenk": 1,
            "gravity": [0, 0, 0] if of_ball else [0.1, 0, 0],
            "bodies": {"b": {"mass": 1.0, "inertia": [0.4] * 3}},
            "joints": {
                "J": {
                    "type": "spherical" if of_ball else "planar",
                    "parent": "ground",
                    "child": "b",
                    "start": start | {"fixed": True},
                    "friction": friction,
                    "lock": {"input": "engagement"},
                }
            },
            "solver": {"integrator": integrator, "step": 1e-3},
        }
    )
    plant.initialize(0, 1e-9)
    plant.step_to(0.5)
    assert np.linalg.norm(plant.values(speeds)) > 0.5
    slipping = plant.values(speeds)
    saved = plant.save()
    for engaged, end in ((1.0, 1.0), (0.0, 2.0)):
        plant.set_input("J.lock.engagement", engaged)
        plant.step_to(end)
        assert plant.values(speeds) == pytest.approx([0, 0], abs=1e-12)
        assert plant.values(["J.lock.mode"]) == [engaged]
    plant.restore(saved)
    assert plant.values(speeds).tolist() == slipping.tolist()
