# SPDX-License-Identifier: BSD-3-Clause
"""Inputs that vary within a step according to their derivatives: u(t) = u0 + sum_k d_k (t - t0)^k / k!."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from mechanisms import body, four_bar, frame, joint, scene
from models.one_dof import OneDofMechanism
from models.planar_loops import FourBar, uniform
from models.running import Array, assert_close

import gelenk
from gelenk.errors import StepError, UsageError

COMMUNICATION = 0.05  # s
TAU = np.polynomial.Polynomial([1.5, -4.0, 9.0, 6.0, -14.0, 5.0])  # N or N m at t [s]
TOLERANCE = 1e-8
ADAPTIVE = ("auto", "erk", "ida", "cvode", "cvode-adams", "dirk")
FIXED = ("rk4", "euler", "generalized-alpha", "hht", "newmark")
LINKS = FourBar(uniform(2, 0.5), uniform(2, 1.75), uniform(2, 1.5), 2.0)

# What to set at a communication point: u, du/dt, d2u/dt2, ...
Signal = Callable[[float], Sequence[float]]


def polynomial(t: float) -> list[float]:
    return [float(TAU(t)), *(float(TAU.deriv(k)(t)) for k in range(1, 6))]


def sled() -> dict[str, Any]:
    """2 kg on a slide, pushed by `push` [N]."""
    return scene(
        {"sled": body(2.0)},
        {"S": joint("prismatic", frame("ground"), frame("sled"), axis=[1, 0, 0])},
        motors={"push": {"joint": "S"}},
    )


def start(source: Mapping[str, Any], tolerance: float = TOLERANCE, **solver: Any) -> gelenk.Simulation:
    simulation = gelenk.Simulation(gelenk.load({**source, "solver": solver}))
    simulation.initialize(0.0, tolerance)
    return simulation


def follow(
    simulation: gelenk.Simulation, name: str, signal: Signal, stop: float = 1.0, size: float = COMMUNICATION
) -> Array:
    """The first joint coordinate after each step of this size."""
    output = simulation.outputs[0].name
    rows = []
    for k in range(round(stop / size)):
        value, *derivatives = signal(k * size)
        simulation.set_input(name, value)
        for order, d in enumerate(derivatives, 1):
            simulation.set_input_derivative(name, order, d)
        simulation.step_to((k + 1) * size)
        rows.append(simulation.output(output))
    return np.array(rows)


# Fixed steps of h = 1 ms: the error of the improved Euler method is about h/2 |f'| t^2 / m, with |f'| up to
# 10 N/s, that of order 2 is h^2 / 12 |f''| t^2 / m, and that of order 4 is rounding.
BOUNDS = {"euler": 2e-3, "rk4": 1e-11, "generalized-alpha": 1e-5, "hht": 1e-5, "newmark": 1e-5}


@pytest.mark.parametrize("integrator", [*ADAPTIVE, *FIXED])
def test_polynomial_force_moves_a_mass_by_its_integral(integrator: str) -> None:
    found = follow(start(sled(), integrator=integrator, step=1e-3), "push.f", polynomial)
    times = COMMUNICATION * np.arange(1, len(found) + 1)
    bound = BOUNDS.get(integrator, 300 * TOLERANCE)
    assert_close(integrator, found, TAU.integ(2)(times) / 2.0, bound, "see above")


# Steps of 0.5 ms. Errors of index 3 add up to some hundred times the tolerance (test_dae_forms.py), those of
# order 2 to some ten times h^2. With a torque held constant over 50 ms, the error of the crank is 1e-2 rad.
LOOP_BOUNDS = {"index3": 1e-5, "generalized-alpha": 2e-5}
METHODS = [
    *((i, "projection") for i in (*ADAPTIVE, "rk4", "generalized-alpha")),
    *(("erk", f) for f in ("baumgarte", "udwadia-kalaba", "augmented-lagrangian", "independent")),
    *(("ida", f) for f in ("index3", "stabilized-index2", "penalty")),
    ("generalized-alpha", "index3"),
]


@pytest.fixture(scope="module")
def truth() -> Array:
    motion = OneDofMechanism(LINKS.geometry(), (0.0, -9.81, 0.0), lambda t, _phi, w: float(TAU(t)) - 0.1 * w)
    times: Array = COMMUNICATION * np.arange(21, dtype=float)
    phi, _ = motion.motion(1.1, 0.0, times)
    return np.asarray(phi[1:])


@pytest.mark.parametrize(("integrator", "formulation"), METHODS)
def test_polynomial_torque_drives_a_loop(integrator: str, formulation: str, truth: Array) -> None:
    plant = start(four_bar(1.1), integrator=integrator, formulation=formulation, step=5e-4)
    bound = max(LOOP_BOUNDS.get(name, 30 * TOLERANCE) for name in (integrator, formulation))
    assert_close("A.phi", follow(plant, "drive.tau", polynomial), truth, bound, "see above")


def sine(orders: int) -> Signal:
    """2 N m sin(9 t) with derivatives up to this order."""
    return lambda t: [2.0 * 9.0**k * math.sin(9.0 * t + k * math.pi / 2) for k in range(orders + 1)]


@pytest.mark.parametrize("orders", [0, 1, 2, 3])
def test_order_of_the_error_is_one_more_than_that_of_the_input_derivatives(orders: int) -> None:
    motion = OneDofMechanism(LINKS.geometry(), (0.0, -9.81, 0.0), lambda t, _p, w: sine(0)(t)[0] - 0.1 * w)
    phi, _ = motion.motion(1.1, 0.0, np.array([0.0, 1.0], float))
    errors = []
    for size in (0.05, 0.025, 0.0125):
        plant = start(four_bar(1.1), 1e-12, integrator="erk")
        errors.append(abs(follow(plant, "drive.tau", sine(orders), size=size)[-1] - phi[-1]))
    for coarse, fine in pairwise(errors):
        # The next term of the error, 9 H / 2 times this one, changes the observed order by up to 0.2.
        assert math.log2(coarse / fine) == pytest.approx(orders + 1, abs=0.2), errors


def test_input_derivatives_apply_to_one_step_and_the_final_value_remains() -> None:
    """Between communication points, u is the polynomial; after the step it keeps the value at its end."""
    plant = start(sled())
    plant.set_input("push.f", 1.0)
    for order, d in ((1, 2.0), (2, -3.0), (5, 60.0)):
        plant.set_input_derivative("push.f", order, d)
    assert [plant.input_derivative("push.f", k) for k in range(1, 6)] == [2.0, -3.0, 0.0, 0.0, 60.0]
    plant.step_to(0.5)
    reached = 1.0 + 2.0 * 0.5 - 3.0 * 0.5**2 / 2 + 60.0 * 0.5**5 / 120
    assert plant.input("push.f") == pytest.approx(reached, rel=1e-15)
    assert plant.output("S.a") == pytest.approx(reached / 2.0, rel=1e-14)
    assert [plant.input_derivative("push.f", k) for k in range(1, 6)] == [0.0] * 5
    plant.step_to(0.6)
    assert plant.input("push.f") == pytest.approx(reached, rel=1e-15)


def test_value_and_derivatives_are_set_in_either_order_and_replaced_by_a_second_call() -> None:
    ends = []
    for calls in ("vd", "dv", "xvd", "dxv"):
        plant = start(sled(), integrator="rk4")
        for call in calls:
            if call == "d":
                plant.set_input_derivative("push.f", 2, 3.0)
            else:
                plant.set_input("push.f", 4.0 if call == "v" else -1.0)
        plant.step_to(0.1)
        ends.append(plant.values().tolist())
    assert all(end == ends[0] for end in ends)


def test_inputs_of_different_islands_vary_simultaneously() -> None:
    source = sled()
    source["bodies"]["other"] = body(3.0)
    source["joints"]["T"] = joint("prismatic", frame("ground"), frame("other"), axis=[0, 1, 0])
    source["motors"]["pull"] = {"joint": "T"}
    plant = start(source)
    assert plant.size.islands == 2
    plant.set_input_derivative("push.f", 1, 6.0)
    plant.set_input_derivative("pull.f", 2, 12.0)
    plant.step_to(0.5)
    assert plant.output("S.s") == pytest.approx(6.0 * 0.5**3 / 6 / 2.0, rel=1e-7)
    assert plant.output("T.s") == pytest.approx(12.0 * 0.5**4 / 24 / 3.0, rel=1e-7)


def test_integrator_keeps_its_history_if_the_input_is_continuous() -> None:
    """The Adams method restarts at each jump, with many short steps. An input is continuous if its value is
    within rounding of the final value of the preceding polynomial.
    """
    evaluations = []
    for orders in (0, 5):
        plant = start(four_bar(1.1), 1e-6, integrator="cvode-adams")
        follow(plant, "drive.tau", sine(orders), size=0.005)
        evaluations.append(plant.diagnostics["solver.evaluations"])
    assert evaluations[1] < 0.5 * evaluations[0], evaluations


def test_failed_step_can_be_repeated_with_the_same_inputs() -> None:
    def drive(plant: gelenk.Simulation, refuse: bool) -> list[float]:
        plant.set_input("drive.tau", 2.0)
        plant.set_input_derivative("drive.tau", 1, 30.0)
        plant.step_to(0.02)
        plant.set_input_derivative("drive.tau", 1, -20.0)
        if refuse:
            plant.set_input_derivative("drive.tau", 3, 1e305)
            with pytest.raises(StepError, match=r"state is unchanged at t = 0\.02 s"):
                plant.step_to(0.04)
            plant.set_input_derivative("drive.tau", 3, 0.0)
        plant.step_to(0.04)
        return list(plant.values())

    usual, again = (drive(start(four_bar(1.1), integrator="rk4"), refuse) for refuse in (False, True))
    assert again == usual


def test_invalid_derivatives_are_rejected_and_the_previous_ones_kept() -> None:
    plant = start(sled())
    plant.set_input_derivative("push.f", 2, 3.0)
    for order in (0, 6, -1):
        with pytest.raises(
            UsageError, match=rf"push.f: found a derivative of order {order}, expected .* 1 to 5"
        ):
            plant.set_input_derivative("push.f", order, 1.0)
        with pytest.raises(UsageError, match="1 to 5"):
            plant.input_derivative("push.f", order)
    for bad in (math.nan, math.inf):
        with pytest.raises(
            UsageError, match=r"push\.f: found .* for the derivative of order 2, expected a finite"
        ):
            plant.set_input_derivative("push.f", 2, bad)
    with pytest.raises(UsageError, match="pus"):
        plant.set_input_derivative("pus.f", 1, 1.0)
    assert plant.input_derivative("push.f", 2) == 3.0
    plant.set_input_derivative("push.f", 5, 1e308)
    with pytest.raises(StepError, match=r"push\.f would not be finite"):
        plant.step_to(1e3)
    assert plant.time == 0.0


def test_output_derivatives_include_those_of_the_inputs() -> None:
    """After a step, those with which the polynomial ended; after an input is set, those of the next step."""
    plant = start(sled())

    def jerk_and_more() -> list[float]:
        a = [s.name for s in plant.outputs].index("S.a")
        first, second = np.reshape(plant._core._output_derivatives([], []), (2, -1))
        return [float(first[a]), float(second[a])]

    plant.set_input_derivative("push.f", 1, 6.0)
    plant.set_input_derivative("push.f", 3, 12.0)
    assert jerk_and_more() == pytest.approx([3.0, 0.0], abs=1e-14)
    plant.step_to(0.5)
    assert jerk_and_more() == pytest.approx([(6.0 + 6.0 * 0.5**2) / 2, 12.0 * 0.5 / 2], rel=1e-12)
    plant.set_input_derivative("push.f", 2, 5.0)
    assert jerk_and_more() == pytest.approx([0.0, 2.5], abs=1e-14)
    plant.step_to(0.6)
    plant.set_input("push.f", 1.0)
    assert jerk_and_more() == pytest.approx([0.0, 0.0], abs=1e-14)
    plant.step_to(0.7)
    assert jerk_and_more() == pytest.approx([0.0, 0.0], abs=1e-14)
