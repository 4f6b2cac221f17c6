# SPDX-License-Identifier: BSD-3-Clause
"""Racks that lose power by its direction: closed forms, and the same gear on a wheel in place of the rack."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Scene, body, frame, joint, scene
from models.running import assert_close

import gelenk

RADIUS, INERTIA, MASS = 0.05, 0.02, 4.0  # m, kg m2, kg
INTEGRATORS = ("erk", "cvode", "cvode-adams", "ida", "dirk")


def lift(w: float = 0.0, *, gear: bool = False, order: int = 1, **losses: float) -> Scene:
    """A pinion with a motor, and a load on the rack, or on a wheel of the same inertia reduced by 1 m.

    order: -1 declares the load first.
    """
    start = {"fixed": True}
    pinion = joint(
        "revolute",
        frame("ground"),
        frame("wheel"),
        friction={"coulomb": 0.0},
        start={"phi": 0, "w": w} | start,
    )
    name, kind = ("load", "revolute") if gear else ("load", "prismatic")
    position, speed = ("phi", "w") if gear else ("s", "v")
    load = joint(
        kind, frame("ground"), frame("load"), axis=[0, 0, 1], start={position: 0.0, speed: RADIUS * w} | start
    )
    mesh: dict[str, Any] = (
        {"type": "gear", "joint": "pinion", "with": "load", "ratio": 1 / RADIUS}
        if gear
        else {"type": "rack", "rack": "load", "pinion": "pinion", "radius": RADIUS}
    )
    joints = {"pinion": pinion, name: load}
    return scene(
        {"wheel": body(1, inertia=(0, 0, INERTIA)), "load": body(MASS, inertia=(0, 0, MASS))},
        dict(list(joints.items())[::order]),
        gravity=[0, 0, 0],
        constraints={"mesh": {**mesh, **losses}},
        motors={"drive": {"joint": "pinion"}, "weight": {"joint": "load"}},
        sensors={"power": {"type": "power", "joint": "pinion"}},
    )


def started(
    source: Scene, drive: float, weight: float, tolerance: float = 1e-9, **solver: Any
) -> gelenk.Simulation:
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": solver} if solver else source))
    simulation.set_input("drive.tau", drive)
    simulation.set_input("weight.tau" if "weight.tau" in inputs(simulation) else "weight.f", weight)
    simulation.initialize(0.0, tolerance)
    return simulation


def inputs(simulation: gelenk.Simulation) -> list[str]:
    return [str(signal.name) for signal in simulation.inputs]


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(("drive", "weight"), [(12.0, -100.0), (-1.0, 100.0), (0.5, -100.0), (3.0, 100.0)])
@pytest.mark.parametrize("w", [4.0, -4.0])
def test_power_is_lost_by_its_direction(w: float, drive: float, weight: float, order: int) -> None:
    """Of what enters the mesh, 0.8 leaves it if the pinion drives, 0.7 if the rack does."""
    plant = started(lift(w, order=order, efficiency=0.8, backdriving=0.7), drive, weight)
    from_pinion = (drive - INERTIA * plant.output("pinion.a")) * w
    from_rack = (weight - MASS * plant.output("load.a")) * RADIUS * w
    assert from_pinion * from_rack < 0
    if from_pinion > 0:
        assert -from_rack == pytest.approx(0.8 * from_pinion, rel=1e-12)
    else:
        assert -from_pinion == pytest.approx(0.7 * from_rack, rel=1e-12)
    lost = -plant.output("pinion.friction.tau") * w
    assert lost == pytest.approx(from_pinion + from_rack, rel=1e-12)
    assert plant.output("mesh.f") * RADIUS * w == pytest.approx(-from_rack, rel=1e-12)
    # What the motor supplies, less the loss and what goes through the mesh, accelerates the pinion.
    assert plant.output("power.total") == pytest.approx(drive * w - lost + from_rack, rel=1e-12)


def test_a_rack_holds_a_load_between_its_limits() -> None:
    """100 N are 5 N m on the pinion: 10 N m raise them, and 2.5 N m hold them."""
    for drive, moves in ((10.000001, 1), (9.999999, 0), (2.500001, 0), (2.499999, -1)):
        plant = started(lift(efficiency=0.5, backdriving=0.5), drive, -100.0)
        plant.step_to(0.1)
        assert np.sign(plant.output("pinion.w")) == moves
        assert plant.output("pinion.friction.mode") == moves
        # The load follows the pinion by its constraint equation, within rounding.
        assert (abs(plant.output("load.v")) < 1e-15) == (moves == 0)


def test_a_self_locking_rack_is_not_driven_by_its_load() -> None:
    for weight in (-1e-3, -100.0, -1e6, 0.0, 100.0):
        plant = started(lift(efficiency=0.4), 0.0, weight)
        plant.step_to(0.5)
        assert plant.output("pinion.phi") == plant.output("pinion.w") == 0
        assert abs(plant.output("load.s")) < 1e-15
    # The motor has to push the load down: backdriving is 2 - 1 / 0.4 = -0.5.
    for drive, moves in ((-2.499999, 0), (-2.500001, -1)):
        plant = started(lift(efficiency=0.4), drive, -100.0)
        plant.step_to(0.1)
        assert np.sign(plant.output("pinion.w")) == moves


@pytest.mark.filterwarnings("ignore:solver.tolerance")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_rack_raises_and_lowers_its_load(integrator: str, tolerance: float) -> None:
    """Constant accelerations until the pinion stops: closed form with three events."""
    plant = started(lift(efficiency=0.8, backdriving=0.7), 10.0, -100.0, tolerance, integrator=integrator)
    raising = 1 / 0.8  # the pinion drives: its torque counts 0.8
    a = (10.0 - raising * 5.0) / (INERTIA + raising * MASS * RADIUS**2)
    plant.step_to(1.0)
    assert_close(
        "w", plant.output("pinion.w"), a, 100 * tolerance * a, "100 times the tolerance of the speed"
    )
    plant.set_input("drive.tau", 0.0)
    slowing = (-raising * 5.0) / (INERTIA + raising * MASS * RADIUS**2)
    # Here the load, which is retarded by its weight, drives the pinion if its force on the mesh is positive.
    mesh = -100.0 - MASS * RADIUS * slowing
    if mesh > 0:
        slowing = (-0.7 * 5.0) / (INERTIA + 0.7 * MASS * RADIUS**2)
        assert -100.0 - MASS * RADIUS * slowing > 0
    stop = -a / slowing
    top = a / 2 + a * stop / 2
    falling = (-0.7 * 5.0) / (INERTIA + 0.7 * MASS * RADIUS**2)
    end = 1.0 + stop + 0.5
    plant.step_to(end)
    scale = max(a, top, abs(falling))
    assert_close(
        "w", plant.output("pinion.w"), 0.5 * falling, 100 * tolerance * scale, "100 times the tolerance"
    )
    phi = top + falling / 8
    assert_close("phi", plant.output("pinion.phi"), phi, 100 * tolerance * scale, "100 times the tolerance")
    assert_close(
        "s", plant.output("load.s"), RADIUS * phi, 100 * tolerance * scale, "100 times the tolerance"
    )
    assert plant.diagnostic("solver.events") == 1


@warned.TIGHT
@pytest.mark.parametrize("integrator", ["erk", "ida"])
def test_a_rack_is_a_gear_on_a_wheel(integrator: str) -> None:
    """Both have the same equations, so that runs agree but for the units of their coordinates."""
    ends = []
    for gear in (False, True):
        plant = started(
            lift(3.0, gear=gear, efficiency=0.75, backdriving=0.6), 8.0, -100.0, 1e-10, integrator=integrator
        )
        names = inputs(plant)
        for k, (drive, weight) in enumerate([(8, -100), (0, -100), (3, 50), (0, 0), (-6, -50)]):
            plant.set_input("drive.tau", float(drive))
            plant.set_input(next(name for name in names if name.startswith("weight")), float(weight))
            plant.step_to(0.2 * (k + 1))
        ends.append(
            [plant.output("pinion.phi"), plant.output("pinion.w"), plant.output("pinion.friction.tau")]
        )
    assert_close("ends", ends[0], np.array(ends[1]), 1e-8, "100 times the tolerance")


@pytest.mark.parametrize(("drive", "weight"), [(12.0, -100.0), (-1.0, 100.0)])
@pytest.mark.parametrize("w", [3.0, -3.0])
def test_linear_models_of_racks_with_losses(w: float, drive: float, weight: float) -> None:
    source = gelenk.load(lift(w, efficiency=0.8, backdriving=0.7))
    given = {"drive.tau": drive, "weight.f": weight}
    found = gelenk.linear.linear_model(source, input_values=given)
    row = found.states.index("pinion.w" if "pinion.w" in found.states else "load.v")
    name = "pinion.a" if "pinion.w" in found.states else "load.a"
    h = 1e-3  # accelerations are piecewise linear in forces
    for k, of in enumerate(given):
        a = [
            started(
                lift(w, efficiency=0.8, backdriving=0.7),
                drive + (sign * h if of == "drive.tau" else 0),
                weight + (sign * h if of == "weight.f" else 0),
            ).output(name)
            for sign in (1, -1)
        ]
        assert_close("B", found.B[row, k], (a[0] - a[1]) / (2 * h), 1e-10, "rounding over h")
    assert_close("A", found.A[row], np.zeros(found.A.shape[1]), 1e-12, "no dependence on speed")


def test_a_rack_with_losses_needs_friction_on_its_pinion() -> None:
    source = lift(efficiency=0.8)
    del source["joints"]["pinion"]["friction"]
    with pytest.raises(gelenk.SceneError, match=r"expected joints\.pinion\.friction, to which the losses"):
        gelenk.load(source)
