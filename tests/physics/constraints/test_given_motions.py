# SPDX-License-Identifier: BSD-3-Clause
"""Prescribed motions of every kind, on every joint coordinate, against Pinocchio's dynamics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from models.driven import Array, Law, follow, polynomial, run, sine
from models.hybrid import STEPS, Chain
from models.running import assert_close
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline

import gelenk

TIMES: Array = np.linspace(0, 1, 51)
TOLERANCE = 1e-11
COEFFICIENTS = [0.1, 0.2, -0.3, 0.15]
SINE = {"amplitude": 0.3, "frequency": 0.9, "phase": 0.4}
# Error of coordinates, velocities, accelerations and forces of up to 20 at this tolerance; measured: 3e-10.
BOUND = 1e-9


def both(t: float) -> list[float]:
    parts = (sine(0.3, 0.9, 0.4)(t), polynomial(COEFFICIENTS)(t))
    return [a + b for a, b in zip(*parts, strict=True)]


LAWS: dict[str, tuple[dict[str, Any], Law]] = {
    "both": ({"polynomial": COEFFICIENTS, "sine": SINE}, both),
    "polynomial": ({"polynomial": COEFFICIENTS}, polynomial(COEFFICIENTS)),
    "sine": ({"sine": SINE}, sine(0.3, 0.9, 0.4)),
    "sine of phase 0": ({"sine": {"amplitude": 0.3, "frequency": 0.9}}, sine(0.3, 0.9)),
    "standing": ({"polynomial": [0.25]}, polynomial([0.25])),
    "standing sine": ({"sine": {"amplitude": 0.5, "frequency": 0, "phase": 1}}, sine(0.5, 0.0, 1.0)),
}
CASES = [
    (kind, step[0], backwards)
    for kind, steps in STEPS.items()
    for step in steps
    for backwards in (False, True)
]


def rest(chain: Chain) -> dict[str, Any] | None:
    """Start values of the joint's other coordinates and velocities: zero."""
    names = [name for k, s in enumerate(chain.steps) for name in s[:2] if k != chain.driven]
    return {**dict.fromkeys(names, 0.0), "fixed": names} if names else None


def compare(found: dict[str, Array], truth: dict[str, Array], bound: float, why: str) -> None:
    for name, expected in truth.items():
        assert_close(name, found[name], expected, bound, why)


@pytest.mark.parametrize(("kind", "coordinate", "backwards"), CASES)
def test_each_coordinate_of_each_joint_follows_its_motion_and_outputs_its_force(
    kind: str, coordinate: str, backwards: bool
) -> None:
    chain = Chain(kind, coordinate, backwards)
    motion, law = LAWS["both"]
    found = run(chain.scene(motion, rest(chain)), TIMES, TOLERANCE)
    compare(found, chain.motion(law, TIMES), BOUND, "see above")


@pytest.mark.parametrize("name", [name for name in LAWS if name != "both"])
def test_each_kind_of_motion(name: str) -> None:
    chain = Chain("revolute", "phi")
    motion, law = LAWS[name]
    compare(run(chain.scene(motion), TIMES, TOLERANCE), chain.motion(law, TIMES), BOUND, "see above")


def test_constant_speed_begins_at_the_start_value_of_the_coordinate() -> None:
    chain = Chain("revolute", "phi")
    start: dict[str, Any] = {"phi": 0.35, "fixed": ["phi"]}
    found = run(chain.scene({"speed": -1.4}, start), TIMES, TOLERANCE)
    compare(found, chain.motion(polynomial([0.35, -1.4]), TIMES), BOUND, "see above")


def test_two_coordinates_of_a_joint_at_once() -> None:
    """A slider that is also rotated at constant speed moves like a screw."""
    chain = Chain("cylindrical", "s")
    scene = chain.scene({"polynomial": [0.0, 0.05]}, {"phi": 0.0, "fixed": False})
    scene["constraints"]["turn"] = {"type": "motion", "joint": "J", "coordinate": "phi", "speed": 2.0}
    found = run(scene, TIMES, TOLERANCE)
    assert_close("J.s", found["J.s"], found["J.phi"] * 0.025, 1e-13, "rounding")
    assert_close("J.w", found["J.w"], 2.0, 1e-13, "rounding")
    assert set(found) >= {"drive.f", "turn.tau"}


@pytest.mark.parametrize(("kind", "coordinate"), [("revolute", "phi"), ("cylindrical", "s")])
def test_work_of_the_drive_is_the_change_of_energy(kind: str, coordinate: str) -> None:
    """By Simpson's rule over steps of 1 ms. Springs store energy; the losses of dampers are subtracted."""
    chain = Chain(kind, coordinate)
    times = np.linspace(0, 1, 1001)
    found = run(chain.scene(LAWS["both"][0], rest(chain)), times, TOLERANCE)
    power = found[chain.force_name] * found[chain.speeds[chain.driven]]
    loss = sum(c * found[v] ** 2 for c, v in zip(chain.damping, chain.speeds, strict=True))
    gained = found["meter.total"][-1] - found["meter.total"][0]
    assert abs(gained) > 0.1
    assert_close(
        "energy", simpson(power - loss, times), gained, 1e-9, "errors of the rule, 2e-10, and the run"
    )


KNOTS: Array = np.array([0.0, 0.11, 0.2, 0.37, 0.5, 0.58, 0.7])
HEIGHTS: Array = np.array([0.2, 0.31, 0.12, -0.1, 0.05, 0.15, 0.02])


def natural() -> Law:
    """SciPy's natural spline, continued by straight lines."""
    spline = CubicSpline(KNOTS, HEIGHTS, bc_type="natural")

    def law(t: float) -> list[float]:
        inside = min(max(t, KNOTS[0]), KNOTS[-1])
        speed = float(spline(inside, 1))
        return [
            float(spline(inside)) + (t - inside) * speed,
            speed,
            float(spline(t, 2)) if t == inside else 0,
        ]

    return law


def periodic() -> Law:
    values = [*HEIGHTS[:-1], HEIGHTS[0]]
    spline = CubicSpline(KNOTS, values, bc_type="periodic")
    return lambda t: [float(spline(t % KNOTS[-1], k)) for k in range(3)]


@pytest.mark.parametrize("repeats", [False, True])
def test_tables_are_interpolated_by_splines(repeats: bool) -> None:
    """Natural and periodic splines; the run begins before the table and ends long after it."""
    chain = Chain("revolute", "phi")
    values = [*HEIGHTS[:-1], HEIGHTS[0]] if repeats else HEIGHTS
    table = {"time": KNOTS.tolist(), "value": [float(x) for x in values], "periodic": repeats}
    times = np.linspace(-0.5, 2, 126) if repeats else np.linspace(-0.5, 1.2, 86)
    law = periodic() if repeats else natural()
    found = run(chain.scene({"table": table}), times, 1e-10)
    for k, name in enumerate(("J.phi", "J.w", "J.a")):
        assert_close(name, found[name], [law(float(t))[k] for t in times], 1e-11, "of 20, rounding")
    kinks = [t + n * KNOTS[-1] for n in range(-1, 4) for t in KNOTS[:-1]] if repeats else KNOTS.tolist()
    compare(found, chain.motion(law, times, kinks), BOUND, "see above")


def test_a_table_of_two_points_is_a_straight_line() -> None:
    chain = Chain("revolute", "phi")
    found = run(chain.scene({"table": {"time": [0.2, 0.6], "value": [0.1, 0.5]}}), TIMES, TOLERANCE)
    compare(found, chain.motion(polynomial([-0.1, 1.0]), TIMES), BOUND, "see above")


@pytest.mark.parametrize("kind", ["position", "speed"])
def test_inputs_of_five_derivatives_are_polynomials_of_order_five(kind: str) -> None:
    """Such a motion is exact for steps of any length."""
    chain = Chain("revolute", "phi")
    coefficients = [0.1, 0.2, -0.3, 0.15, 0.4, -0.25]
    derived = 0 if kind == "position" else 1
    name = "drive.phi_ref" if kind == "position" else "drive.w_ref"
    start: dict[str, Any] | None = {"phi": 0.1, "fixed": ["phi"]} if kind == "speed" else None
    found = follow(
        chain.scene({"input": kind}, start), {name: polynomial(coefficients, derived)}, 5, 0.2, TOLERANCE
    )
    truth = chain.motion(polynomial(coefficients), np.linspace(0, 1, 6))
    compare(found, truth, BOUND, "see above")


@pytest.mark.parametrize("kind", ["position", "speed"])
@pytest.mark.parametrize("orders", [2, 3, 4, 5])
def test_order_of_the_error_follows_from_the_number_of_input_derivatives(kind: str, orders: int) -> None:
    """Errors of velocities are of order `orders` in the step, one order higher if speeds are prescribed."""
    chain = Chain("revolute", "phi")
    derived = 0 if kind == "position" else 1
    name = "drive.phi_ref" if kind == "position" else "drive.w_ref"
    start: dict[str, Any] | None = {"phi": 0.3 * math.sin(0.4), "fixed": ["phi"]} if kind == "speed" else None
    truth = chain.motion(sine(0.3, 1.5, 0.4), np.array([0.0, 1.0]))
    errors = []
    for steps in (40, 320):
        laws = {name: sine(0.3, 1.5, 0.4, derived)}
        found = follow(chain.scene({"input": kind}, start), laws, steps, 1 / steps, 1e-12, orders)
        errors.append(math.hypot(*(found[x][-1] - truth[x][-1] for x in ("H.phi", "H.w"))))
    # The two leading terms have opposite signs here, which reduces the observed order by up to 0.6.
    assert math.log2(errors[0] / errors[1]) / 3 > orders + derived - 0.7, errors


def test_start_follows_from_the_initial_inputs() -> None:
    """Inputs and their derivatives are set before initialization; those that are not set are 0."""
    chain = Chain("revolute", "phi")
    plant = gelenk.Simulation(gelenk.load(chain.scene({"input": "position"})))
    plant.set_input("drive.phi_ref", 0.8)
    plant.set_input_derivative("drive.phi_ref", 1, -0.3)
    plant.set_input_derivative("drive.phi_ref", 2, 5.0)
    plant.initialize()
    assert plant.values(["J.phi", "J.w", "J.a"]) == pytest.approx([0.8, -0.3, 5.0], abs=1e-12)
    other = gelenk.Simulation(gelenk.load(chain.scene({"input": "position"})))
    other.initialize()
    assert other.values(["J.phi", "J.w", "J.a"]) == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
