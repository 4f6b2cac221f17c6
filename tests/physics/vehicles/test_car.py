# SPDX-License-Identifier: BSD-3-Clause
"""The car of the gallery: loops, single-track model, cornering, braking and energy against closed forms."""

from __future__ import annotations

from math import atan, hypot
from typing import Any

import numpy as np
import pytest
from mechanisms import Array, Scene
from models.car import (
    BRAKES,
    CORNERS,
    HEIGHT,
    G,
    axle_loads,
    built_load,
    car,
    center,
    mass,
    rigid,
    set_bump,
    single_track,
    sliding_friction,
    slip_for,
    steered,
    steering_per_rack,
    without_drag,
)
from models.running import assert_restored_run_continues

import gelenk


def test_loops_remain_closed_over_a_bump_while_it_steers_and_brakes() -> None:
    plant = gelenk.Simulation(gelenk.load(car()))
    plant.initialize()
    closed, lifted = 0.0, False
    for k in range(300):
        plant.set_input("column.tau", 2.0 if k < 100 else -1.0)
        for brake in BRAKES:
            plant.set_input(brake, 1.0 if k > 150 else 0.0)
        plant.step_to(0.01 * (k + 1))
        closed = max(closed, plant.diagnostics["constraints.position"])
        lifted |= plant.output("tire_fl.f_n") == 0
    assert closed <= 1e-12  # m
    assert lifted


# --- the single-track model ---


def linear(scene: Scene, **options: Any) -> Any:
    return gelenk.linear.linear_model(gelenk.load(scene), **options)


@pytest.mark.parametrize("speed", [8.0, 20.0, 45.0])
def test_without_suspension_the_linear_model_is_the_single_track_model(speed: float) -> None:
    """To rounding: level, tires are loaded by their springs, and they have no longitudinal slip.

    With longitudinal slip, the spins of the wheels would take part in yawing.
    """
    scene = without_drag(steered(rigid(car(speed))))
    for corner in CORNERS:
        scene["forces"][f"tire_{corner}"]["slip_stiffness"] = 0.0
    loads = 2 * built_load(scene, "fl"), 2 * built_load(scene, "rl")
    track = single_track(scene, speed, loads)
    states = ["ride.phi", "ride.v_y", "ride.w"]
    model = linear(scene, states=states, inputs=["steer.s_ref"], outputs=["ride.w"])
    A, B = track.matrices()
    x = center(scene)[0]
    # The joint's point is ahead of the center of mass by -x: v_y = lateral velocity + V phi - x w.
    T = np.array([[1.0, 0, 0], [speed, 1, -x], [0, 0, 1]])  # of phi, lateral velocity, yaw rate
    exact = np.zeros((3, 3))
    exact[0, 2] = 1
    exact[1:, 1:] = A
    found = np.linalg.solve(T, np.asarray(model.A) @ T)
    np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-9)
    poles = np.sort_complex(np.linalg.eigvals(found[1:, 1:]))
    np.testing.assert_allclose(poles, np.sort_complex(np.linalg.eigvals(A)), rtol=1e-9)
    found_B = np.linalg.solve(T, np.asarray(model.B))[1:, 0] / steering_per_rack(scene)
    np.testing.assert_allclose(found_B, B, rtol=1e-9)
    gain = -np.linalg.solve(found[1:, 1:], found_B)[1]
    assert gain == pytest.approx(track.yaw_gain(), rel=1e-9)


def turned(scene: Scene, rack: float, ramp: float, stop: float) -> gelenk.Result:
    """Run with a travel of the rack [m] that it reaches after a time [s]."""
    steer = {"steer.s_ref": lambda t: rack * min(t / ramp, 1.0)}
    return gelenk.simulate(scene, stop=stop, step=0.05, tolerance=1e-8, inputs=steer)


@pytest.mark.parametrize("speed", [10.0, 25.0, 40.0])
def test_on_its_suspension_the_linear_model_turns_as_the_single_track_model(speed: float) -> None:
    """The steady yaw rate per rack, of the model with roll, suspension and spins; loads by moments.

    Rounded lengths of springs and tie rods change loads and steering by some 1e-4.
    """
    scene = set_bump(without_drag(steered(car(speed))), bump_height=0.0)
    model = linear(scene, inputs=["steer.s_ref"])
    # Where the car is, in which direction it heads and how its wheels are turned has no effect.
    idle = {"ride.s_x", "ride.s_y", "ride.phi", "ride.v_x"} | {f"hub_{corner}.phi" for corner in CORNERS}
    kept = [i for i, name in enumerate(model.states) if name not in idle]
    names = [model.states[i] for i in kept]
    A = np.array(model.A)[np.ix_(kept, kept)]
    A[names.index("ride.v_y"), names.index("ride.w")] -= speed  # in the axes of the car
    gain = -np.linalg.solve(A, np.array(model.B)[kept, 0])[names.index("ride.w")]
    track = single_track(scene, speed, axle_loads(scene))
    assert gain / steering_per_rack(scene) == pytest.approx(track.yaw_gain(), rel=1e-3)


def test_the_understeer_gradient_is_that_of_the_closed_form() -> None:
    """On its suspension, at 1 mrad of steering: yaw rates at two speeds, and the gradient from them.

    To first order the suspension does not steer as the car rolls, but for rounded lengths: within 1e-3.
    """
    delta, rates = 1e-3, {}
    for speed in (15.0, 30.0):
        scene = set_bump(without_drag(steered(car(speed))), bump_height=0.0)
        track = single_track(scene, speed, axle_loads(scene))
        run = turned(scene, delta / steering_per_rack(scene), 1.0, 6.0)
        rates[speed] = run["ride.w"][-1]
        assert rates[speed] == pytest.approx(track.yaw_gain() * delta, rel=1e-3)
    L = track.to_front + track.to_rear
    found = [(speed / (w / delta) - L) / speed**2 for speed, w in rates.items()]
    assert found == pytest.approx([track.understeer()] * 2, rel=2e-3)


@pytest.mark.parametrize("rack", [0.003, 0.006])
def test_steady_cornering_up_to_the_limit_of_the_tires(rack: float) -> None:
    """Delta = L/R + alpha_front - alpha_rear, with the slip angles from the Magic Formula.

    Each axle carries its part of the lateral force, in proportion to its load, so that the shift of
    loads to the outer wheels changes nothing. Neglected are terms of second order in the angles (of slip,
    roll and steering, up to 0.08 rad: 6e-3), by which headings and loads differ.
    """
    speed = 20.0
    scene = set_bump(without_drag(steered(car(speed))), bump_height=0.0)
    run = turned(scene, rack, 2.0, 8.0)
    w, V = run["ride.w"][-1], hypot(run["ride.v_x"][-1], run["ride.v_y"][-1])
    lateral = V * w / G
    slips = [atan(slip_for(scene, corner, lateral)) for corner in ("fl", "rl")]
    L = 2.7
    delta = steering_per_rack(scene) * rack
    assert L * w / V + slips[0] - slips[1] == pytest.approx(delta, rel=6e-3)


# --- braking ---


def braked(speed: float, spin: float | None = None) -> Scene:
    """Return the car with its brakes applied throughout, on a level road; spin: of the wheels [rad/s]."""
    scene = set_bump(without_drag(car(speed)), bump_height=0.0)
    for corner in CORNERS:
        joint = scene["joints"][f"hub_{corner}"]
        del joint["friction"]["input"]
        if spin is not None:
            joint["start"]["w"] = spin
    return scene


def current_center(plant: gelenk.Simulation, scene: Scene) -> Array:
    points, masses = [], []
    for name, body in scene["bodies"].items():
        R, r = plant.pose(name)
        points.append(r + R @ np.array(body.get("com", (0, 0, 0)), float))
        masses.append(body["mass"])
    out: Array = np.average(points, axis=0, weights=masses)
    return out


def test_locked_wheels_brake_with_the_friction_of_full_slip() -> None:
    """A = mu g with the Magic Formula at the slip -1; loads of the axles from moments about their contacts.

    The center of mass is that of the pose; 9 s after the start, pitching, exp(-1.5 t), has decayed to 1e-6.
    """
    scene = braked(65.0)
    plant = gelenk.Simulation(gelenk.load(scene).with_parameters({"solver.tolerance": 1e-9}))
    plant.initialize()
    for k in range(900):
        plant.step_to(0.01 * (k + 1))
    a = -plant.output("ride.a_x")
    assert a == pytest.approx(sliding_friction(scene) * G, rel=1e-5)
    for corner in CORNERS:
        assert plant.output(f"hub_{corner}.w") == 0
        assert plant.output(f"hub_{corner}.friction.mode") == 0
        assert plant.output(f"tire_{corner}.slip") == pytest.approx(-1, abs=1e-3)
    hubs = {corner: plant.pose(f"wheel_{corner}")[1][0] for corner in ("fl", "rl")}
    x, _, z = current_center(plant, scene)
    front = mass(scene) * (G * (x - hubs["rl"]) + a * z) / (hubs["fl"] - hubs["rl"])
    assert 2 * plant.output("tire_fl.f_n") == pytest.approx(front, rel=1e-4)
    assert 2 * plant.output("tire_rl.f_n") == pytest.approx(mass(scene) * G - front, rel=1e-4)
    assert front > 1.2 * axle_loads(scene)[0]


def test_released_wheels_roll_again() -> None:
    """After full braking for a second the wheels turn with the road, and the car goes on with its speed."""
    scene = set_bump(without_drag(car(30.0)), bump_height=0.0)
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    for brake in BRAKES:
        plant.set_input(brake, 1.0)
    plant.step_to(1.0)
    assert [plant.output(f"hub_{corner}.w") for corner in CORNERS] == [0] * 4
    for brake in BRAKES:
        plant.set_input(brake, 0.0)
    plant.step_to(1.5)
    v = plant.output("ride.v_x")
    plant.step_to(6.0)
    assert plant.output("ride.v_x") == pytest.approx(v, rel=1e-2)
    for corner in CORNERS:
        assert abs(plant.output(f"tire_{corner}.slip")) <= 1e-5
        assert plant.output(f"hub_{corner}.w") == pytest.approx(plant.output("ride.v_x") / HEIGHT, rel=1e-2)


@pytest.mark.parametrize("time", [0.05, 0.5, 1.2])
def test_a_run_restored_in_a_skid_continues_with_the_same_bits(time: float) -> None:
    scene = braked(25.0)
    scene["joints"]["ride"]["start"]["w"] = 1.5  # rad/s
    assert_restored_run_continues(gelenk.load(scene), time, [0.01, 0.05, 0.2])


# --- energy ---


def test_the_energy_of_a_coasting_car_is_lost_in_slip_dampers_and_air() -> None:
    """Over a bump, yawing: the losses are integrated by Simpson's rule from the forces and velocities."""
    scene = car(15.0)
    scene["joints"]["ride"]["start"] |= {"w": 0.4}
    sensors: dict[str, Any] = {"body": {"type": "frame", "body": "chassis"}}
    for corner in CORNERS:
        scene["forces"][f"tire_{corner}"] |= {"damping": 0.0, "bump_position": 4.0, "bump_height": 0.03}
        spring = scene["forces"][f"spring_{corner}"]
        sensors[f"length_{corner}"] = {"type": "distance", "from": spring["from"], "to": spring["to"]}
        sensors[f"on_{corner}"] = {"type": "frame", "body": f"wheel_{corner}"}
    scene["sensors"] = sensors
    plant = gelenk.Simulation(gelenk.load(scene).with_parameters({"solver.tolerance": 1e-9}))
    plant.initialize()

    def loss() -> float:
        speed = np.linalg.norm([plant.output(f"body.v[{i}]") for i in (1, 2, 3)])
        out = scene["forces"]["air"]["coefficient"] * speed**3
        out += scene["joints"]["column"]["damping"] * plant.output("column.w") ** 2
        for corner in CORNERS:
            out += scene["forces"][f"spring_{corner}"]["damping"] * plant.output(f"length_{corner}.v") ** 2
            axis = plant.pose(f"wheel_{corner}")[0][:, 1]
            heading = np.array([axis[1], -axis[0]]) / np.hypot(axis[0], axis[1])
            V = heading @ [plant.output(f"on_{corner}.v[{i}]") for i in (1, 2)]
            f_long, f_lat, slip, angle = (
                plant.output(f"tire_{corner}.{name}") for name in ("f_long", "f_lat", "slip", "slip_angle")
            )
            out += V * (f_long * slip - f_lat * np.tan(angle))
        return float(out)

    h, losses, energies = 5e-4, [loss()], [plant.diagnostics["energy.total"]]
    for k in range(1200):
        plant.step_to(h * (k + 1))
        losses.append(loss())
        energies.append(plant.diagnostics["energy.total"])
    P = np.array(losses)
    lost = h / 3 * (P[:-2:2] + 4 * P[1:-1:2] + P[2::2]).cumsum()
    found = energies[0] - np.array(energies)[2::2]
    assert found[-1] > 1000
    np.testing.assert_allclose(found, lost, atol=1e-5 * found[-1])


# --- cost ---


def evaluations(brakes: dict[str, float], rate: float = 0.0) -> float:
    """Return those of 100 steps of rk4; rate: of the first brake's engagement [1/s]."""
    scene = car() | {"solver": {"integrator": "rk4", "step": 1e-3}}
    plant = gelenk.Simulation(gelenk.load(scene))
    for brake, engagement in brakes.items():
        plant.set_input(brake, engagement)
    plant.initialize()
    before = plant.diagnostic("solver.evaluations")
    if rate:
        plant.set_input_derivative(BRAKES[0], 1, rate)
    plant.step_to(0.1)
    return plant.diagnostic("solver.evaluations") - before


def test_open_brakes_cost_nothing() -> None:
    """At the ends of a step, the rates of wheels' speeds are evaluated only for brakes that can stop them."""
    assert evaluations(dict.fromkeys(BRAKES, 0.0)) == 400
    assert evaluations({BRAKES[2]: 0.01}) >= 600
    assert evaluations({}, rate=0.01) >= 600  # a brake that begins to close in the step


@pytest.mark.parametrize("integrator", ["auto", "rk4", "cvode-adams"])
def test_a_brake_that_closes_from_zero_stops_its_wheel(integrator: str) -> None:
    """Its reversal is found, although rates were not evaluated while it was open."""
    hub, brake = "hub_fl", BRAKES[0]
    solver = {"integrator": integrator} | ({"step": 1e-3} if integrator == "rk4" else {})
    plant = gelenk.Simulation(gelenk.load(car(5.0) | {"solver": solver}))
    plant.initialize()
    plant.step_to(0.1)
    assert plant.output(f"{hub}.w") == pytest.approx(5.0 / HEIGHT, rel=0.05)
    plant.set_input_derivative(brake, 1, 5.0)
    plant.step_to(0.3)
    assert plant.output(f"{hub}.w") == 0
    assert plant.output(f"{hub}.phi") > 0
