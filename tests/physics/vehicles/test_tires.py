# SPDX-License-Identifier: BSD-3-Clause
"""Tires that slip, against the Magic Formula, the single-track model and independent integration."""

from __future__ import annotations

from math import atan, cos, pi, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import Array
from models.running import assert_restored_run_continues
from models.tires import LAT, LOAD, LONG, RADIUS, SingleTrack, magic, rig, two_wheels
from scipy.integrate import solve_ivp

import gelenk

ROUNDING = 1e-13


def read(scene: dict[str, Any]) -> dict[str, float]:
    """Return the outputs of the tire at the start."""
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize()
    names = ("f_n", "f_long", "f_lat", "slip", "slip_angle", "tau")
    return {name: plant.output(f"tire.{name}") for name in names}


@pytest.mark.parametrize("slip", [-1.0, -0.3, -0.05, 1e-4, 0.02, 0.1, 0.4, 3.0])
def test_longitudinal_force_is_the_magic_formula(slip: float) -> None:
    V = 20.0
    found = read(rig((V, 0.0), V * (1 + slip) / RADIUS))
    assert found["slip"] == pytest.approx(slip, abs=ROUNDING)
    assert found["f_long"] == pytest.approx(LOAD * magic(slip, *LONG), rel=10 * ROUNDING)
    assert found["f_lat"] == 0
    assert found["f_n"] == LOAD
    assert found["tau"] == pytest.approx(-RADIUS * found["f_long"], rel=10 * ROUNDING)


@pytest.mark.parametrize("side", [-30.0, -2.0, -0.1, 1e-3, 0.5, 4.0])
@pytest.mark.parametrize("V", [20.0, -20.0])
def test_lateral_force_is_the_magic_formula(side: float, V: float) -> None:
    """Of the tangent of the slip angle; backwards, too."""
    found = read(rig((V, side), V / RADIUS))
    assert found["slip_angle"] == pytest.approx(atan(side / abs(V)), abs=ROUNDING)
    assert found["f_lat"] == pytest.approx(-LOAD * magic(side / abs(V), *LAT), rel=10 * ROUNDING)
    assert abs(found["f_long"]) <= 1e-9  # rounding of the spin


# Coefficients B, C, D, E for dry and wet tarmac, snow and ice, as widely published (for
# example by The MathWorks: Tire-Road Interaction, Magic Formula).
ROADS = {
    "dry": (10.0, 1.9, 1.0, 0.97),
    "wet": (12.0, 2.3, 0.82, 1.0),
    "snow": (5.0, 2.0, 0.3, 1.0),
    "ice": (4.0, 2.0, 0.1, 1.0),
}


@pytest.mark.parametrize("road", ROADS)
def test_curves_have_the_shape_of_their_coefficients(road: str) -> None:
    """The slope is B C D at the origin, D is the peak, where eq. 4.9 says."""
    B, C, D, E = ROADS[road]
    change = {"slip_stiffness": B * C * D, "friction_long": D, "shape_long": C, "curvature_long": E}

    def force(slip: float) -> float:
        return read(rig((20.0, 0.0), 20.0 * (1 + slip) / RADIUS, **change))["f_long"] / LOAD

    assert force(1e-7) / 1e-7 == pytest.approx(B * C * D, rel=1e-6)
    slips = np.linspace(0.01, 1, 100)
    forces = np.array([force(s) for s in slips])
    assert forces == pytest.approx(magic(slips, B, C, D, E), rel=1e-12)
    peak = forces.max()
    assert D * 0.99 < peak <= D * (1 + ROUNDING)
    # The peak is where B x - E (B x - atan B x) = tan(pi / (2 C)) (eq. 4.9).
    x = slips[forces.argmax()]
    beside = [B * s - E * (B * s - atan(B * s)) for s in (x - 0.01, x + 0.01)]
    assert beside[0] < np.tan(pi / (2 * C)) < beside[1]


@pytest.mark.parametrize("angle", [0.3, 1.2, 2.5, -2.0])
@pytest.mark.parametrize("size", [0.01, 0.1, 0.6])
def test_combined_slip_of_an_isotropic_tire_is_opposite_to_the_slip(angle: float, size: float) -> None:
    """With equal coefficients the force has the size of the pure one, against the sliding velocity."""
    B, C, mu, E = LONG
    V, slip, side = 15.0, size * cos(angle), size * sin(angle)
    change = {
        "cornering_stiffness": B * C * mu, "friction_lat": mu, "shape_lat": C, "curvature_lat": E
    }  # fmt: skip
    found = read(rig((V, side * V), V * (1 + slip) / RADIUS, **change))
    size_of_force = LOAD * magic(size, *LONG)
    assert found["f_long"] == pytest.approx(size_of_force * cos(angle), rel=1e-11)
    assert found["f_lat"] == pytest.approx(-size_of_force * sin(angle), rel=1e-11)


def test_combined_slip_by_the_similarity_method() -> None:
    """Slips times stiffness over friction add as vectors; each component follows its own curve."""
    V, slip, side = 15.0, 0.06, -0.09
    found = read(rig((V, side * V), V * (1 + slip) / RADIUS))
    e = np.array([LONG[0] * LONG[1] * slip, -LAT[0] * LAT[1] * side])
    size = np.hypot(*e)
    exact = [
        LOAD * e[i] / size * magic(size / (c[0] * c[1]), *c) for i, c in enumerate((LONG, LAT))
    ]  # fmt: skip
    assert [found["f_long"], found["f_lat"]] == pytest.approx(exact, rel=1e-12)


def test_a_linear_tire_is_the_limit_of_small_slips() -> None:
    V, slip, side = 15.0, 1e-6, 2e-6
    linear = {"friction_long": None, "friction_lat": None}
    scene = rig((V, side * V), V * (1 + slip) / RADIUS)
    limited = read(scene)
    for name in linear:
        del scene["forces"]["tire"][name]
    found = read(scene)
    for name in ("f_long", "f_lat"):
        assert found[name] == pytest.approx(limited[name], rel=1e-9)  # terms of third order: (20 slip)^2


def test_one_coefficient_of_friction_is_refused() -> None:
    scene = rig((1, 0), 1)
    del scene["forces"]["tire"]["friction_lat"]
    with pytest.raises(
        gelenk.SceneError, match=r"tire\.friction_lat: found nothing, expected a number, since"
    ):
        gelenk.load(scene)
    with pytest.raises(gelenk.SceneError, match=r"curvature_lat: found 1\.5, expected at most 1"):
        gelenk.load(rig((1, 0), 1, curvature_lat=1.5))


@pytest.mark.parametrize("V", [0.0, 0.05, 0.1, 0.1 + 1e-12, -0.07])
def test_at_standstill_slip_is_relative_to_a_mean_speed(V: float) -> None:
    """V is replaced by (v0 + V^2/v0)/2 below v0 = 0.1 m/s, and continues from there."""
    spin = V / RADIUS + 0.01
    found = read(rig((V, 0.0), spin))
    v0 = 0.1
    of = abs(V) if abs(V) >= v0 else (v0 + V**2 / v0) / 2
    assert found["slip"] == pytest.approx((spin * RADIUS - V) / of, rel=1e-10)


@warned.GYRATION
def test_a_parked_wheel_creeps_as_documented() -> None:
    """Pushed by F, a locked wheel slides at the root of v = F (v0 + v^2/v0)/(2 K N)."""
    force, K, v0 = LOAD / 10, 20.0, 0.1
    scene = rig((0.0, 0.0), 0.0, slip_stiffness=K, damping=0.0)
    for name in ("friction_long", "friction_lat"):
        del scene["forces"]["tire"][name]
    scene["bodies"]["carriage"]["mass"] = 280.0
    scene["joints"]["hub"]["type"] = "weld"
    del scene["joints"]["hub"]["start"], scene["joints"]["hub"]["axis"]
    scene["forces"]["push"] = {"type": "wrench", "body": "carriage", "force": [force, 0, 0], "frame": "world"}
    run = gelenk.simulate(scene, stop=10, step=1, tolerance=1e-10)
    c = force / (2 * K * LOAD)
    v = (1 - sqrt(1 - 4 * c**2)) / (2 * c) * v0
    assert run["road.v_x"][-1] == pytest.approx(v, rel=1e-9)
    assert v == pytest.approx(0.25e-3, rel=1e-4)  # m/s: the number in the documentation


def quarter_car() -> dict[str, Any]:
    """A wheel under a load that slides along x only, with a torque on the hub, from 25 m/s."""
    V = 25.0
    scene = rig((V, 0.0), V / RADIUS)
    scene["bodies"]["carriage"] = {"mass": 290.0}
    start = {"s": 0, "v": V, "fixed": True}
    scene["joints"]["road"] = {
        "type": "prismatic", "axis": [1, 0, 0], "parent": {"body": "ground", "position": [0, 0, RADIUS]},
        "child": "carriage", "start": start,
    }  # fmt: skip
    scene["joints"]["hub"]["friction"] = {"coulomb": 1500, "input": "engagement"}
    return scene


def braking(times: Array) -> tuple[Array, list[float]]:
    """Independent: m dv/dt = F, I dw/dt = -r F - T; the wheel locks at w = 0 and is released after 1 s."""
    m, moment, torque = 310.0, 1.0, 1500.0

    def force(v: float, w: float) -> float:
        return LOAD * float(magic((w * RADIUS - v) / v, *LONG))

    def rates(_: float, y: Array, mode: str) -> Array:
        F = force(y[1], y[2])
        spin = 0.0 if mode == "locked" else (-RADIUS * F - (torque if mode == "brakes" else 0.0)) / moment
        return np.array([y[1], F / m, spin])

    def locks(_: float, y: Array, _mode: str) -> float:
        return float(y[2])

    locks.terminal = True  # type: ignore[attr-defined]
    y, t, rows, locked = np.array([0, 25.0, 25.0 / RADIUS]), 0.0, [], []
    for mode, until in (("brakes", 1.0), ("locked", 1.0), ("rolls", times[-1])):
        found = solve_ivp(
            rates, (t, until), y, args=(mode,), method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True,
            events=locks if mode == "brakes" else None,
        )  # fmt: skip
        rows += [found.sol(at) for at in times if t <= at < found.t[-1]]
        t, y = float(found.t[-1]), found.y[:, -1]
        if mode == "brakes":
            locked.append(t)
            y[2] = 0.0
    return np.array([*rows, y]), locked


BRAKE = {"hub.friction.engagement": lambda t: 1.0 if t < 1 - 1e-9 else 0.0}


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_braking_to_lock_and_release(tolerance: float) -> None:
    times = np.linspace(0, 2, 21)
    exact, (locked,) = braking(times)
    run = gelenk.simulate(
        quarter_car(),
        stop=2,
        step=0.1,
        tolerance=tolerance,
        integrator="erk",
        inputs=BRAKE,
        outputs=["road.s", "road.v", "hub.w", "energy.kinetic"],
    )
    assert min(abs(t - locked) for t, _ in run.events) <= 100 * tolerance
    for name, column, scale in (("road.s", 0, 50), ("road.v", 1, 25), ("hub.w", 2, 80)):
        assert np.abs(run[name] - exact[:, column]).max() <= 100 * tolerance * scale
    assert (np.diff(run["energy.kinetic"]) <= 100 * tolerance * run["energy.kinetic"][0]).all()


@pytest.mark.parametrize("time", [0.02, 0.5, 1.05])
def test_a_run_restored_while_it_brakes_continues_with_the_same_bits(time: float) -> None:
    assert_restored_run_continues(quarter_car(), time, [0.1, 0.4])


TRACK = SingleTrack(1500.0, 2500.0, 1.2, 1.4, 90e3, 110e3, 20.0)


@pytest.mark.parametrize("speed", [5.0, 20.0, 60.0])
def test_linear_model_is_the_single_track_model(speed: float) -> None:
    """To rounding: derivatives of the slip forces are exact."""
    track = SingleTrack(1500.0, 2500.0, 1.2, 1.4, 90e3, 110e3, speed)
    model = gelenk.linear.linear_model(two_wheels(track), states=["road.phi", "road.v_y", "road.w"])
    A, _ = track.matrices()
    # The velocity v_y of the joint is along the axes of the road: the lateral one is v_y - V phi.
    found = np.asarray(model.A)
    assert found[0] == pytest.approx([0, 0, 1], abs=1e-12)
    assert found[1] == pytest.approx([-speed * A[0, 0], A[0, 0], A[0, 1] + speed], rel=1e-10, abs=1e-10)
    assert found[2] == pytest.approx([-speed * A[1, 0], A[1, 0], A[1, 1]], rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("front", [90e3, 130e3])
def test_steady_cornering_has_the_closed_form(front: float) -> None:
    """At 1 mrad of steering: yaw rate and sideslip, under- and oversteering, up to terms of second order."""
    track = SingleTrack(1500.0, 2500.0, 1.2, 1.4, front, 110e3, 12.0)
    delta = 1e-3
    run = gelenk.simulate(
        two_wheels(track, delta), stop=6, step=0.01, tolerance=1e-10, inputs={"bars.phi_ref": delta}
    )
    assert run["road.w"][-1] == pytest.approx(track.yaw_gain() * delta, rel=1e-4)
    phi = run["road.phi"][-1]
    lateral = run["road.v_y"][-1] * cos(phi) - run["road.v_x"][-1] * sin(phi)
    assert lateral / track.speed == pytest.approx(track.sideslip_gain() * delta, rel=1e-3)
    assert (track.understeer() > 0) == (front * track.to_front < track.rear * track.to_rear)


def test_a_tire_on_its_spring_keeps_its_energy_over_a_bump() -> None:
    """Without slip stiffness and damping the normal force is conservative, along the slope of the bump."""
    bump = {"bump_position": 3.0, "bump_length": 0.3, "bump_height": 0.05}
    law = {"load": 0.0, "stiffness": 2e5, "slip_stiffness": 0, "cornering_stiffness": 0}
    scene = rig((10.0, 0.0), 10 / RADIUS, **law, **bump)
    start = {"r": [0, 0, RADIUS - 0.002], "v": [10, 1, 0], "w": [0.1, 30, 0.2], "Q": [0.1, 0, 0, 1]}
    scene["bodies"] = {"wheel": scene["bodies"]["wheel"]}
    free = {"type": "free", "parent": "ground", "child": "wheel"}
    scene["joints"] = {"J": {**free, "start": {**start, "fixed": True}}}
    run = gelenk.simulate(
        scene, stop=1, step=0.001, tolerance=1e-10, integrator="erk", outputs=["tire.f_n", "energy.total"]
    )
    assert run["tire.f_n"].max() > 500  # it meets the bump
    assert run["tire.f_n"].min() == 0  # and leaves the road
    assert np.ptp(run["energy.total"]) <= 1e-7 * run["energy.total"][0]


def test_relaxation_by_the_carcass() -> None:
    """The tread on a spring k: the force after a step of the lateral velocity has a closed form.

    The tread of mass m is pushed by the carcass and by the tire, c = N C/V:
        m x'' + c (x' + v) + k x = 0,
    in which the force k x follows 1 - exp(-V t/sigma), sigma = N C/k, after its fast mode of c/m.
    """
    V, side, k, m, C = 20.0, 0.1, 1.2e5, 2.0, 14.0
    scene = rig((V, 0.0), V / RADIUS, slip_stiffness=0.0, cornering_stiffness=C)
    del scene["forces"]["tire"]["friction_long"], scene["forces"]["tire"]["friction_lat"]
    scene["bodies"]["tread"] = {"mass": m, "inertia": [0.1, 0.1, 0.1]}
    scene["joints"]["carcass"] = {
        "type": "prismatic", "axis": [0, 1, 0], "parent": "wheel", "child": "tread", "stiffness": k,
        "start": {"s": 0, "v": -side, "fixed": True},
    }  # fmt: skip
    scene["joints"]["road"]["start"]["v_y"] = side
    scene["bodies"]["carriage"]["mass"] = 1e12
    scene["forces"]["tire"]["body"] = "tread"
    run = gelenk.simulate(scene, stop=0.2, step=0.002, tolerance=1e-10)
    c = LOAD * C / V
    slow, fast = np.sort(np.abs(np.roots([m, c, k])))
    # x = -(c v/k) + a exp(-slow t) + b exp(-fast t), x(0) = 0, x'(0) = -v
    end = -c * side / k
    a, b = np.linalg.solve([[1, 1], [-slow, -fast]], [-end, -side])
    x = end + a * np.exp(-slow * run.time) + b * np.exp(-fast * run.time)
    assert np.abs(run["carcass.s"] - x).max() <= 1e-8
    assert V / slow == pytest.approx(LOAD * C / k, rel=0.1)  # the relaxation length


def test_coefficients_are_parameters_of_the_fmu(tmp_path: Path) -> None:
    """Set before the start, friction limits the force at a large slip."""
    scene = {**rig((20.0, 0.0), 70.0), "parameters": ["tire.friction_long"]}
    fmu = gelenk.export_fmu(scene, tmp_path / "Rig.fmu")
    forces = [
        gelenk.simulate(fmu, stop=0.01, step=0.01, parameters={"tire.friction_long": mu})["tire.f_long"][0]
        for mu in (1.1, 0.3)
    ]
    slip = 70 * RADIUS / 20 - 1
    K = LONG[0] * LONG[1] * LONG[2]
    exact = [LOAD * magic(slip, K / (LONG[1] * mu), LONG[1], mu, LONG[3]) for mu in (1.1, 0.3)]
    assert forces == pytest.approx(exact, rel=1e-9)


def test_the_camber_of_a_wheel_moves_its_contact_point() -> None:
    """The torque about its axis remains -r F, at h/sin of the camber below its center."""
    angle = 0.2
    scene = rig((20.0, 0.0), 20.0 * 1.05 / RADIUS)
    scene["forces"]["tire"]["axis"] = [0, cos(angle), sin(angle)]
    scene["joints"]["hub"]["axis"] = [0, cos(angle), sin(angle)]
    found = read(scene)
    assert found["tau"] == pytest.approx(-RADIUS / cos(angle) * found["f_long"], rel=1e-12)
