# SPDX-License-Identifier: BSD-3-Clause
"""Carts, a trailer and a balancing robot against closed forms and reduced equations; loads on wheels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mechanisms import GRAVITY, rotation
from models.running import assert_close, run
from models.vehicles import (
    BASE,
    CORNERS,
    DECK,
    DECK_COM,
    HALF_TRACK,
    LENGTH,
    RADIUS,
    ROLLING,
    SPEED,
    WHEEL,
    four_wheeled_cart,
    trailer,
    tricycle,
    two_wheeled_cart,
    two_wheeled_rates,
)
from scipy.integrate import solve_ivp

import gelenk

TIMES = np.linspace(0, 4, 81)


@pytest.mark.parametrize(("u", "w", "left", "right"), [(0.5, 2.0, 0.0, 0.0), (0.0, 0.0, 0.4, 0.55)])
def test_two_wheeled_cart(u: float, w: float, left: float, right: float) -> None:
    """With and without torques, against the equations of its two velocities."""
    inputs = {"left_motor.tau": left, "right_motor.tau": right}
    found = run(two_wheeled_cart(u, w), TIMES, tolerance=1e-11, inputs=inputs)

    def rates(_t: float, y: np.ndarray) -> list[float]:
        u, w, _x, _y, phi = y
        return [*two_wheeled_rates(u, w, left, right), u * np.cos(phi), u * np.sin(phi), w]

    y = solve_ivp(rates, (0, 4), [u, w, 0, 0, 0], "DOP853", TIMES, rtol=1e-12, atol=1e-13).y
    for name, value in zip(("castors.w", "castors.s_x", "castors.s_y", "castors.phi"), y[1:], strict=True):
        assert_close(name, found[name], value, 1e-8, "1000 rtol, up to 10 m and rad")
    for side, sign in (("left", -1), ("right", 1)):
        assert_close(side, found[f"{side}.w"], (y[0] + sign * HALF_TRACK * y[1]) / RADIUS, 1e-8, "1000 rtol")
    if not left:
        assert np.ptp(found["energy.total"]) < 1e-8 * abs(found["energy.total"][0])


def wheel_loads(slope: float) -> dict[str, float]:
    """Loads of the four wheels of the cart while it rolls down: those with the smallest sum of squares.

    Deck and wheels have the same acceleration; moments about y (positive: more load in front) are those of
    gravity, of inertia and of friction, which accelerates the wheels: J a / r^2 each.
    """
    total = DECK + 4 * WHEEL
    effective = total + 4 * ROLLING / RADIUS**2
    a = total * GRAVITY * np.sin(slope) / effective
    weight, pull = GRAVITY * np.cos(slope), GRAVITY * np.sin(slope)
    x, y, z = DECK_COM
    # Moments about the point on the ground below the middle of the wheels; inertial forces at the centers.
    height = z + RADIUS
    about_y = (
        DECK * (weight * x + (pull - a) * height) + 4 * WHEEL * (pull - a) * RADIUS - 4 * ROLLING * a / RADIUS
    )
    about_x = DECK * weight * y
    rows = np.array([[1, px, py] for px, py, _ in CORNERS.values()]).T
    loads = np.linalg.pinv(rows) @ [total * weight, about_y, about_x]
    others = {"acceleration": float(a), "turning": float(DECK * y * (pull - a))}
    return dict(zip(CORNERS, map(float, loads), strict=True)) | others


@pytest.mark.parametrize("slope", [0.0, 0.25])
def test_four_wheels_share_the_load(slope: float) -> None:
    """Twelve constraint equations of rank six. The cart rolls straight down at a constant acceleration."""
    R = rotation([0, 0, 1], 0.6) @ rotation([0, 1, 0], slope)
    p = np.array([0.3, 0.2, 1.0])
    found = run(four_wheeled_cart(R, p), np.linspace(0, 2, 21), tolerance=1e-10)
    expected = wheel_loads(slope)
    for name, place in CORNERS.items():
        assert_close(name, found[f"{name}_tyre.f_n"], expected[name], 1e-8, "rtol of 100 N")
        # The force at the deck's center of mass, which is not on the center line, has a yaw moment.
        aside = np.sign(place[0]) * expected["turning"] / (4 * abs(place[0]))
        assert_close(name, found[f"{name}_tyre.f_lat"], aside, 1e-8, "rtol of 100 N")
        friction = -ROLLING * expected["acceleration"] / RADIUS**2
        assert_close(name, found[f"{name}_tyre.f_long"], friction, 1e-8, "rtol of 100 N")
    way = (found.vector("deck_at.r") - p) @ R
    expected_way = expected["acceleration"] * found.time**2 / 2
    level = np.outer(np.ones(len(way)), [0, 0, RADIUS])
    assert_close("way", way, level + np.outer(expected_way, [1, 0, 0]), 1e-9, "10 rtol of 4 m")
    assert found["constraints.position"].max() < 1e-11


@pytest.mark.parametrize("wheels", [False, True])
@pytest.mark.parametrize("angle", [0.5, -2.8])
def test_trailer_aligns_with_the_tractor(angle: float, wheels: bool) -> None:
    """d(angle)/dt = -v/L sin(angle): tan(angle/2) decays as exp(-v t/L). A pushed trailer turns around."""
    times = np.linspace(0, 6, 61)
    found = run(trailer(angle, wheels), times, tolerance=1e-11)
    expected = 2 * np.arctan(np.tan(angle / 2) * np.exp(-SPEED * times / LENGTH))
    assert_close("angle", found["hitch.phi"], expected, 1e-9, "100 rtol")
    assert_close("tractor", found["road.s"], SPEED * times, 1e-12, "held")


READY = Path(__file__).parents[3] / "scenes"
LOADS = ["tyre_left.f_n", "tyre_right.f_n"]
ROBOT_MASS = 8 + 2 * 0.6


def test_each_wheel_of_the_robot_carries_half_of_its_weight() -> None:
    """The joints between ground and robot are constrained by the wheels only."""
    source = gelenk.load(READY / "balancing_robot.yaml").to_dict()
    found = run(source, [0.0])
    for name in LOADS:
        assert_close(name, found[name], ROBOT_MASS * GRAVITY / 2, 1e-10, "round-off of 100 N")


def test_normal_forces_of_the_robot_in_a_turn() -> None:
    """Upright at v on a circle: wheels balance the moments of m v w about the ground and of their spin."""
    v, w = 1.0, 1.5
    source = gelenk.load(READY / "balancing_robot.yaml").to_dict()
    for name, sign in (("hub_left", -1), ("hub_right", 1)):
        source["joints"][name]["start"]["w"] = (v + sign * 0.2 * w) / 0.1
        source["joints"][name]["damping"] = 0.0
    found = run(source, [0.0])
    # A left turn loads the right wheel: m v w h of chassis (0.4 m) and wheels (0.1 m), spins 2 J (v/r) w.
    moment = 8 * v * w * 0.4 + 2 * 0.6 * v * w * 0.1 + 2 * 0.003 * (v / 0.1) * w
    half = (found["tyre_right.f_n"] - found["tyre_left.f_n"]) / 2
    assert_close("difference", half * 0.4, moment, 1e-10, "round-off of 10 N m")
    total = found["tyre_right.f_n"] + found["tyre_left.f_n"]
    assert_close("sum", total, ROBOT_MASS * GRAVITY, 1e-10, "round-off of 100 N")
    aside = found["tyre_left.f_lat"] + found["tyre_right.f_lat"]
    assert_close("aside", aside, ROBOT_MASS * v * w, 1e-10, "round-off of 10 N")
    assert_close("shared", found["tyre_left.f_lat"], found["tyre_right.f_lat"], 1e-10, "least squares")


def test_tricycle_follows_the_kinematics_of_its_steering() -> None:
    """Yaw rate v sin(steer)/L, forward speed v cos(steer), v of the front wheel, independent of forces."""
    times = np.linspace(0, 5, 51)
    found = run(tricycle(), times, tolerance=1e-10)

    def rates(t: float, y: np.ndarray) -> list[float]:
        steer = 0.5 * np.sin(2 * np.pi * 0.3 * t)
        v = 8.0 * RADIUS
        return [v * np.sin(steer) / BASE, v * np.cos(steer) * np.cos(y[0]), v * np.cos(steer) * np.sin(y[0])]

    heading, x, y = solve_ivp(rates, (0, 5), [0, 0, 0], "DOP853", times, rtol=1e-12, atol=1e-13).y
    r = found.vector("flight.r")
    assert_close("x", r[:, 0], x, 1e-8, "100 rtol")
    assert_close("y", r[:, 1], y, 1e-8, "100 rtol")
    assert_close("height", r[:, 2], RADIUS, 1e-11, "projected")
    Q = found.vector("flight.Q")
    assert_close("heading", 2 * np.arctan2(Q[:, 2], Q[:, 3]), heading, 1e-8, "100 rtol")
    loads = sum(found[f"{name}_tyre.f_n"] for name in ("front", "left", "right"))
    assert_close(
        "load", loads, (25 + 1 + 3 * WHEEL) * GRAVITY, 1e-8, "round-off of 300 N, accelerations' 1e-10"
    )


def test_robot_is_in_equilibrium_on_a_slope() -> None:
    """The motors hold it with a torque of M g r sin(slope), and the chassis leans uphill to balance that."""
    slope = 0.12
    source = gelenk.load(READY / "balancing_robot.yaml").to_dict()
    hill = {"axis": [0, 1, 0], "angle": slope}  # x points downhill
    for tyre in source["constraints"].values():
        tyre["on"] = {"body": "ground", "rotation": hill}
    source["joints"]["ride"]["parent"] = {"body": "ground", "rotation": hill}
    motors = ["motor_left.tau", "motor_right.tau"]
    found = gelenk.equilibrium(source, solve_for=motors, hold={"ride.s_x": 0.0})
    needed = ROBOT_MASS * GRAVITY * 0.1 * np.sin(slope)  # N m
    for name in motors:
        assert_close(name, found.inputs[name], -needed / 2, 1e-8, "residual 1e-8 rad/s2 of 1 kg m2")
    lean = np.arcsin(needed / (8 * GRAVITY * 0.3))  # from the vertical; pitch is from the slope's normal
    assert_close("lean", found.values["pitch.phi"], -lean - slope, 1e-8, "residual")
    for name in LOADS:
        assert_close(name, found.values[name], ROBOT_MASS * GRAVITY * np.cos(slope) / 2, 1e-7, "residual")


def test_wheel_speeds_as_inputs_move_a_differential_drive_on_arcs() -> None:
    """At jumps of the wheel speeds, the velocity of the cart jumps."""
    source = two_wheeled_cart(0.0, 0.0)
    source["joints"]["castors"]["start"] = {"s_x": 0.0, "s_y": 0.0, "phi": 0.0, "fixed": True}
    del source["motors"]
    for name in ("left", "right"):
        source["constraints"][f"{name}_drive"] = {"type": "motion", "joint": name, "input": "speed"}
    plant = gelenk.Simulation(gelenk.load(source))
    x, y, phi = 0.0, 0.0, 0.0
    for leg, (left, right) in enumerate([(3.0, 5.0), (-1.0, 5.0), (2.0, 2.0)]):
        plant.set_input("left_drive.w_ref", left)
        plant.set_input("right_drive.w_ref", right)
        if leg == 0:
            plant.initialize(0.0, 1e-10)
        plant.step_to(1.0 * (leg + 1))
        v, w = RADIUS * (left + right) / 2, RADIUS * (right - left) / (2 * HALF_TRACK)
        x += v * (np.sin(phi + w) - np.sin(phi)) / w if w else v * np.cos(phi)
        y -= v * (np.cos(phi + w) - np.cos(phi)) / w if w else -v * np.sin(phi)
        phi += w
        for name, expected in (("s_x", x), ("s_y", y), ("phi", phi), ("w", w)):
            assert_close(name, plant.output(f"castors.{name}"), expected, 1e-8, "100 rtol")


def test_cart_with_wheels_locked_by_a_gear_does_not_turn() -> None:
    source = two_wheeled_cart(0.5, 0.0)
    source["constraints"]["lock"] = {"type": "gear", "joint": "left", "with": "right", "ratio": 1}
    found = run(source, np.linspace(0, 2, 21), inputs={"left_motor.tau": 0.3}, tolerance=1e-10)
    assert_close("turning", found["castors.w"], 0, 1e-11, "projected")
    du, _ = two_wheeled_rates(0.0, 0.0, 0.3, 0.0)
    assert_close("ahead", found["castors.v_x"], 0.5 + du * found.time, 1e-9, "10 rtol")
    source["joints"]["castors"]["start"]["w"] = 1.0
    with pytest.raises(gelenk.AssemblyError, match="fixed start velocities of castors contradict"):
        gelenk.Simulation(gelenk.load(source)).initialize()


@pytest.mark.parametrize("formulation", ["index3", "stabilized-index2"])
def test_formulations_that_require_independent_constraints_report_redundant_ones(formulation: str) -> None:
    """Both wheels of the axle constrain its lateral velocity."""
    source = two_wheeled_cart(0.5, 0.0) | {"solver": {"formulation": formulation}}
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    with pytest.raises(
        gelenk.StepError, match=r"constraint equations of rank 3, but .* requires independent ones"
    ):
        plant.step_to(0.1)
