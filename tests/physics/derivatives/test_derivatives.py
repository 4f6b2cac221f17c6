# SPDX-License-Identifier: BSD-3-Clause
"""Exact derivatives of outputs and of state derivatives by states and inputs, against finite differences of
independently assembled plants, and against closed forms.
"""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
import warned
from mechanisms import (
    GRAVITY,
    body,
    four_bar,
    frame,
    frame_sensor,
    joint,
    scene,
    with_sensors,
)
from models.derivative_cases import CASES, ENERGY, assert_relative, started
from models.differences import Array, Assembler, linearized, output_derivatives

import gelenk
from gelenk.chart import mechanisms


@warned.PRESSED
@pytest.mark.parametrize("name", CASES)
def test_derivatives_match_finite_differences_of_independently_assembled_plants(name: str) -> None:
    """1e-7 as documented; measured: at most 7e-9 (differences of fourth order over 1 ms: h^4 f5 / 30)."""
    case = CASES[name]
    source = case.make()
    plant = started(case, source)
    inputs = [s.name for s in plant.inputs]
    for t in case.times:
        plant.step_to(t)
        found = linearized(plant)
        assembler = Assembler(source, plant)
        assert_relative(f"values at {t} s", assembler.outputs({}), plant.values(), 1e-9)
        for matrix, names in ((found.C, found.states), (found.D, inputs)):
            for k, known in enumerate(names):
                assert_relative(f"by {known} at {t} s", matrix[:, k], assembler.column(known, 1e-3), 1e-7)


@warned.PRESSED
@pytest.mark.parametrize("name", CASES)
def test_derivatives_of_state_derivatives_are_those_of_the_outputs(name: str) -> None:
    """Velocities and accelerations are outputs; the rate of a quaternion, 1/2 Q (w, 0), is differentiated."""
    case = CASES[name]
    plant = started(case, case.make())
    plant.step_to(case.times[-1])
    found = linearized(plant)
    derivatives = [plant.outputs[i].derivative for i in plant._core._states()]
    values = plant.values()
    row = {name: k for k, name in enumerate(found.states)}
    for k, output in enumerate(derivatives):
        if output >= 0:
            assert np.array_equal(found.A[k], found.C[output])
            assert np.array_equal(found.B[k], found.D[output])
            assert found.xdot[k] == values[output]
            continue
        owner = found.states[k].partition(".")[0]
        turn = [row[f"{owner}.{x}[{i}]"] for x, n in (("Q", 4), ("w", 3)) for i in range(1, n + 1)]
        state = np.array([plant.output(found.states[i]) for i in turn])
        component = turn.index(k)
        assert found.xdot[k] == pytest.approx(quaternion_rate(state)[component], abs=1e-14)
        moved = found.C[[plant._output[found.states[i]] for i in turn]]  # derivatives of these seven
        for j in range(len(found.states)):
            step = 1e-20  # complex step: exact to rounding
            derivative = quaternion_rate(state + 1j * step * moved[:, j]).imag[component] / step
            assert found.A[k, j] == pytest.approx(derivative, abs=1e-13)
        assert not found.B[k].any()


def quaternion_rate(state: Array) -> Array:
    u, s, w = state[:3], state[3], state[4:]
    return 0.5 * np.array([*(s * w + np.cross(u, w)), -u @ w])


@pytest.mark.parametrize("name", ["gyroscope", "Stewart platform", "five-bar"])
def test_directional_derivative_is_the_combination_of_the_columns(name: str) -> None:
    case = CASES[name]
    plant = started(case, case.make())
    plant.step_to(case.times[-1])
    found = linearized(plant)
    rng = np.random.default_rng(3)
    dx, du = rng.normal(size=len(found.states)), rng.normal(size=len(plant.inputs))
    outputs, rates = plant._core._directional_derivative(list(dx), list(du))
    assert_relative("outputs", outputs, found.C @ dx + found.D @ du, 1e-12)
    assert_relative("rates", rates, found.A @ dx + found.B @ du, 1e-12)


def test_derivatives_by_a_quaternion_are_those_of_the_normalized_one() -> None:
    """A change along the quaternion has no effect; a change perpendicular to it has its full effect."""
    case = CASES["gyroscope"]
    plant = started(case, case.make())
    plant.step_to(0.4)
    found = linearized(plant)
    columns = [found.states.index(f"S.Q[{i}]") for i in (1, 2, 3, 4)]
    Q = np.array([plant.output(f"S.Q[{i}]") for i in (1, 2, 3, 4)])
    rows = [plant._output[f"S.Q[{i}]"] for i in (1, 2, 3, 4)]
    assert_relative("Q by Q", found.C[np.ix_(rows, columns)], np.eye(4) - np.outer(Q, Q), 1e-14)
    assert_relative("along Q", found.C[:, columns] @ Q, np.zeros(len(found.C)), 1e-12)


def test_reductions_do_not_change_derivatives() -> None:
    """With planar or spatial algebra, with or without redundant constraints, the crank remains the state."""
    source = with_sensors(four_bar(), f=frame_sensor("coupler", (0.1, 0.2, 0)), E=ENERGY)
    matrices = []  # they agree to rounding, as the sums differ
    for on in (True, False):
        made = copy.deepcopy(source)
        made["solver"] = {"reductions": dict.fromkeys(("planar", "redundant_rows"), on)}
        plant = started(CASES["four-bar in its plane"], made)
        found = linearized(plant)
        assert found.states == ["A.phi", "A.w"]
        matrices.append((found.C, found.D, output_derivatives(plant)))
    for first, second in zip(*matrices, strict=True):
        assert_relative("with and without", first, second, 1e-11)


# --- closed forms ---


def test_pendulum_matches_its_equation_of_motion() -> None:
    """I phi'' = -m g l sin phi - d w + tau, about the pin."""
    m, length, inertia, d = 0.8, 0.3, 0.05, 0.2
    plant = gelenk.Simulation(
        scene(
            {"bob": body(m, (0, -length, 0), (inertia, 0, inertia))},
            {
                "A": joint(
                    "revolute",
                    frame("ground"),
                    frame("bob"),
                    axis=[0, 0, 1],
                    damping=d,
                    start={"phi": 0.9, "w": -1.3, "fixed": True},
                )
            },
            gravity=[0, -GRAVITY, 0],
            motors={"drive": {"joint": "A"}},
        )
    )
    plant.initialize()
    plant.set_input("drive.tau", 0.4)
    about_pin = inertia + m * length**2
    phi, w, a = plant.values()
    found = linearized(plant)
    stiffness = m * GRAVITY * length * math.cos(phi)
    assert_relative("A", found.A, np.array([[0, 1], [-stiffness / about_pin, -d / about_pin]]), 1e-14)
    assert_relative("B", found.B, np.array([[0], [1 / about_pin]]), 1e-14)
    udot, uddot = 1.7, -4.0
    jerk = (-stiffness * w - d * a + udot) / about_pin
    snap = (m * GRAVITY * length * math.sin(phi) * w**2 - stiffness * a - d * jerk + uddot) / about_pin
    assert_relative(
        "in time",
        output_derivatives(plant, [udot], [uddot]),
        np.array([[w, a, jerk], [a, jerk, snap]]),
        1e-14,
    )


def test_cart_pole_matches_the_textbook_linearization() -> None:
    """Upright, at rest: (M + m) s'' + m l phi'' = f - c s', m l s'' + (I + m l2) phi'' = m g l phi."""
    source = mechanisms.shipped("cart_pole")
    source["joints"]["hinge"]["start"]["phi"] = 0.0
    plant = gelenk.Simulation(source)
    plant.initialize()
    M, m, length, inertia, c, d = 1.0, 0.2, 0.3, 0.006, 0.1, 0.002
    mass = np.array([[M + m, m * length], [m * length, inertia + m * length**2]])
    by_q = np.linalg.solve(mass, np.diag([0, m * GRAVITY * length]))
    by_v = np.linalg.solve(mass, -np.diag([c, d]))
    found = linearized(plant)
    assert found.states == ["track.s", "hinge.phi", "track.v", "hinge.w"]
    assert_relative("A", found.A, np.block([[np.zeros((2, 2)), np.eye(2)], [by_q, by_v]]), 1e-13)
    assert_relative("B", found.B[:, 0], np.array([0, 0, *np.linalg.solve(mass, [1, 0])]), 1e-13)


def test_double_pendulum_matches_lagrange_equations() -> None:
    """The closed form is differentiated by complex steps, exact to rounding."""
    plant = gelenk.Simulation(mechanisms.shipped("double_pendulum"))
    plant.initialize(tolerance=1e-11)
    for t in (0.0, 0.4, 1.1):
        plant.step_to(t)
        found = linearized(plant)
        x = np.array([plant.output(name) for name in found.states])
        for k in range(4):
            moved = x + 1j * 1e-20 * np.eye(4)[k]
            expected = double_pendulum_accelerations(moved).imag / 1e-20
            assert_relative(f"by {found.states[k]}", found.A[2:, k], expected, 1e-12)


def double_pendulum_accelerations(x: Array) -> Array:
    """Accelerations of shoulder and elbow; the angle of the elbow is relative to the upper rod."""
    m, l1, c, inertia = (1.0, 0.6), 0.7, (0.35, 0.25), (0.0408333333333333, 0.0125)
    a, b = x[0], x[0] + x[1]  # of the rods
    wa, wb = x[2], x[2] + x[3]
    cross = m[1] * l1 * c[1]
    mass = np.array(
        [
            [inertia[0] + m[0] * c[0] ** 2 + m[1] * l1**2, cross * np.cos(a - b)],
            [cross * np.cos(a - b), inertia[1] + m[1] * c[1] ** 2],
        ]
    )
    weight = GRAVITY * np.array([(m[0] * c[0] + m[1] * l1) * np.cos(a), m[1] * c[1] * np.cos(b)])
    turn = cross * np.sin(a - b) * np.array([wb**2, -(wa**2)])
    rods: Array = np.linalg.solve(mass, -turn - weight)
    return np.array([rods[0], rods[1] - rods[0]])
