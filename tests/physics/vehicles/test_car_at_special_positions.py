# SPDX-License-Identifier: BSD-3-Clause
"""The car at rest, with locked wheels, exactly straight ahead, at full lock."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from mechanisms import Scene
from models.car import BRAKES, CORNERS, HEIGHT, G, car, mass, set_bump, sliding_friction, without_drag

import gelenk


def level(speed: float) -> Scene:
    return set_bump(without_drag(car(speed)), bump_height=0.0)


@pytest.mark.parametrize("brake", [0.0, 1.0])
def test_a_parked_car_remains_where_it_is(brake: float) -> None:
    """With locked wheels, tension between the axles relaxes by the creep of the tires, within a minute."""
    run = gelenk.simulate(level(0.0), stop=5, step=0.05, tolerance=1e-8, inputs=dict.fromkeys(BRAKES, brake))
    assert np.abs(run["ride.s_x"]).max() <= 1e-3  # m: it settles on its springs by 0.1 mm
    for name in ("ride.v_x", "ride.v_y", "ride.w", "heave.v", "pitch.w", "roll.w"):
        assert abs(run[name][-1]) <= (1e-5 if brake else 1e-6)
    for name in ("ride.s_y", "ride.phi", "roll.phi"):
        assert np.abs(run[name]).max() <= 1e-10
    loads = [run[f"tire_{corner}.f_n"][-1] for corner in CORNERS]
    assert sum(loads) == pytest.approx(mass(level(0.0)) * G, rel=1e-6)


def test_a_parked_car_creeps_down_an_incline_as_documented() -> None:
    """With locked wheels, v = F (v0 + v^2/v0)/(2 K N) of all four tires together."""
    scene = level(0.0)
    scene["gravity"] = [0.5, 0, -9.8]
    run = gelenk.simulate(scene, stop=20, step=0.05, tolerance=1e-8, inputs=dict.fromkeys(BRAKES, 1.0))
    v0, K = 0.1, scene["forces"]["tire_fl"]["slip_stiffness"]
    c = 0.5 / (2 * K * 9.8)
    v = (1 - sqrt(1 - 4 * c**2)) / (2 * c) * v0
    # The Magic Formula is below its tangent by terms of second order, (K kappa/2)^2 = 7e-4.
    assert run["ride.v_x"][-1] == pytest.approx(v, rel=2e-3)
    assert abs(run["ride.v_y"][-1]) <= 1e-9
    assert [run[f"hub_{corner}.w"][-1] for corner in CORNERS] == [0] * 4


def test_braking_to_standstill_ends_at_rest() -> None:
    """From 10 m/s in v^2/(2 mu g), but for the wheels before they lock and the last tenth of a m/s: 5 %."""
    scene = level(10.0)
    run = gelenk.simulate(scene, stop=20, step=0.01, tolerance=1e-7, inputs=dict.fromkeys(BRAKES, 1.0))
    way = 10.0**2 / (2 * sliding_friction(scene) * G)
    assert run["ride.s_x"][-1] == pytest.approx(way, rel=5e-2)
    assert np.ptp(run["ride.s_x"][run.time > 19.5]) <= 1e-6
    assert run["ride.v_x"].min() >= -0.1  # it rocks back on its springs
    assert abs(run["ride.v_x"][-1]) <= 1e-6
    assert np.isfinite(run["ride.a_x"]).all()


@pytest.mark.parametrize("speed", [0.05, 1.0, 20.0])
def test_a_start_with_locked_wheels(speed: float) -> None:
    scene = level(speed)
    for corner in CORNERS:
        scene["joints"][f"hub_{corner}"]["start"]["w"] = 0
    run = gelenk.simulate(scene, stop=4, step=0.02, tolerance=1e-7, inputs=dict.fromkeys(BRAKES, 1.0))
    for corner in CORNERS:
        assert not run[f"hub_{corner}.w"].any()
    expected = max(speed - 4 * sliding_friction(scene) * G, 0)
    assert run["ride.v_x"][-1] == pytest.approx(expected, abs=0.02 * speed)


def test_a_start_from_rest_accelerates_by_the_torque() -> None:
    """T i/r = (m + sum I/r^2) a, where the differential and the rotor turn with the rear wheels."""
    scene = level(0.0)
    engine = scene["motors"]["engine"]
    torque = 50.0
    run = gelenk.simulate(scene, stop=3, step=0.02, tolerance=1e-8, inputs={"engine.tau": torque})
    spin = 4 * 1.1 + 2 * 0.002 + 0.04 + engine["gear_ratio"] ** 2 * engine["rotor_inertia"]
    a = torque * engine["gear_ratio"] / HEIGHT / (mass(scene) + spin / HEIGHT**2)
    found = (run["ride.v_x"][-1] - run["ride.v_x"][50]) / 2
    # The radius at which the rear wheels roll decreases as they are loaded, by 1 %.
    assert found == pytest.approx(a, rel=2e-2)
    assert np.abs(run["ride.s_y"]).max() <= 1e-9


def test_straight_ahead_nothing_turns_to_either_side() -> None:
    """Over the bump, driven and braked: the symmetric car stays on its line to rounding."""
    scene = car(15.0)
    inputs = {"engine.tau": 80.0} | {name: lambda t: 0.3 if t > 1 else 0.0 for name in BRAKES}
    run = gelenk.simulate(scene, stop=2, step=0.01, tolerance=1e-8, inputs=inputs)
    for name in ("ride.s_y", "ride.phi", "roll.phi", "rack.s"):
        assert np.abs(run[name]).max() <= 1e-9, name
    assert run["pitch.phi"].max() > 0.01


def test_left_and_right_are_mirror_images() -> None:
    runs = [
        gelenk.simulate(level(15.0), stop=2, step=0.05, tolerance=1e-9, inputs={"column.tau": torque})
        for torque in (4.0, -4.0)
    ]
    assert abs(runs[0]["ride.phi"][-1]) > 0.1
    for name, sign in (("ride.s_x", 1), ("ride.s_y", -1), ("ride.phi", -1), ("roll.phi", -1), ("heave.s", 1)):
        np.testing.assert_allclose(runs[1][name], sign * runs[0][name], atol=1e-6)
    np.testing.assert_allclose(runs[1]["tire_fl.f_n"], runs[0]["tire_fr.f_n"], rtol=1e-5)


@pytest.mark.parametrize("speed", [0.0, 3.0, 15.0])
def test_full_lock(speed: float) -> None:
    """The rack rests on its stop; the car circles to the left, and its loops remain closed."""
    plant = gelenk.Simulation(gelenk.load(level(speed)))
    plant.initialize()
    plant.set_input("column.tau", 60.0)
    closed = 0.0
    for k in range(400):
        plant.step_to(0.01 * (k + 1))
        closed = max(closed, plant.diagnostics["constraints.position"])
    # The forces of the tires move it by millimeters, to either side.
    assert plant.output("rack.s") == pytest.approx(0.07 + 60 / 0.008 / 500e3, abs=5e-3)
    assert closed <= 1e-12
    assert all(np.isfinite(value) for value in plant.values())
    if speed:
        assert plant.output("ride.phi") > 0.5
    else:
        assert abs(plant.output("ride.phi")) < 0.05
