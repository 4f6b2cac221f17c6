# SPDX-License-Identifier: BSD-3-Clause
"""Input jumps at every communication step, as from a co-simulation master,
do not reduce the accuracy of multistep methods.

The reference is the textbook equations of the double pendulum with the same torques, solved by SciPy from
jump to jump.
"""

from __future__ import annotations

import copy
import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gelenk
from gelenk.chart.mechanisms import governor
from physics.trees.test_double_pendulum import START, TEXTBOOK, double_pendulum

MULTISTEP = ("ida", "cvode", "cvode-adams")
STEP = 1e-3  # s
STEPS = 1500


def torque(k: int) -> float:
    """N m, on the upper joint in step k; as large as the moments of the weights."""
    return 4.0 * math.sin(2.1 * k * k)


@cache
def reference() -> tuple[float, ...]:
    """phi1, phi2 (relative) at the end."""
    y = np.array([START[0], START[0] + START[1], START[2], START[2] + START[3]])

    def driven(t: float, y: np.ndarray, tau: float) -> np.ndarray:
        by_torque = np.linalg.solve(TEXTBOOK.mass(y), [tau, 0])
        out: np.ndarray = TEXTBOOK.rates(t, y) + np.concatenate([[0, 0], by_torque])
        return out

    for k in range(STEPS):
        y = solve_ivp(driven, (0, STEP), y, "DOP853", rtol=1e-12, atol=1e-13, args=(torque(k),)).y[:, -1]
    return float(y[0]), float(y[1] - y[0])


def plant(integrator: str, tolerance: float) -> gelenk.Simulation:
    source = copy.deepcopy(double_pendulum())
    source["motors"] = {"drive": {"joint": "P1"}}
    source["solver"] = {"integrator": integrator}
    out = gelenk.Simulation(source)
    out.initialize(0.0, tolerance)
    return out


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("integrator", MULTISTEP)
def test_torque_jump_each_millisecond_does_not_reduce_accuracy(integrator: str, tolerance: float) -> None:
    """The bound is 100 times the tolerance, as without jumps. If they integrate across the jumps, or restart
    at each, these methods have errors of 500 to 30,000 times that with 50 to 170 evaluations per step; the
    starter takes 4 to 7.
    """
    found = plant(integrator, tolerance)
    for k in range(STEPS):
        found.set_input("drive.tau", torque(k))
        found.step_to((k + 1) * STEP)
    errors = [abs(found.output(f"P{i + 1}.phi") - angle) for i, angle in enumerate(reference())]
    assert max(errors) < 100 * tolerance, f"{max(errors) / tolerance:.3g} times the tolerance"
    assert found.diagnostics["solver.evaluations"] < 10 * STEPS


def test_jumps_are_integrated_by_the_method_itself_if_stiff() -> None:
    """The stiff governor with a torque jump every 0.1 s: `erk` needs about 60 steps for each."""
    source = governor()
    source["motors"] = {"drive": {"joint": next(iter(source["joints"]))}}
    evaluations = {}
    for integrator in ("erk", "ida", "cvode"):
        found = gelenk.Simulation({**source, "solver": {"integrator": integrator}})
        found.initialize(0.0, 1e-6)
        for k in range(50):
            found.set_input("drive.tau", 5 * math.sin(2.1 * k * k))
            found.step_to(0.1 * (k + 1))
        evaluations[integrator] = found.diagnostics["solver.evaluations"]
    assert max(evaluations["ida"], evaluations["cvode"]) < 0.25 * evaluations["erk"], evaluations


@pytest.mark.parametrize("integrator", MULTISTEP)
def test_method_resumes_after_the_last_jump(integrator: str) -> None:
    """For 2 s without jumps `erk` at 1e-8 needs more than twice the evaluations of Adams' method."""
    found, other = plant(integrator, 1e-8), plant("erk", 1e-8)
    for each in (found, other):
        each.set_input("drive.tau", 1.0)
        each.step_to(0.1)
    start = found.diagnostics, other.diagnostics
    for each in (found, other):
        each.step_to(4.1)
    end = found.diagnostics, other.diagnostics
    steps = [b["solver.steps"] - a["solver.steps"] for a, b in zip(start, end, strict=True)]
    assert steps[0] > 3 * steps[1], "BDF and Adams' methods take shorter steps than one of order 8"
    jacobians = end[0]["solver.jacobians"] - start[0]["solver.jacobians"]
    assert (jacobians > 0) == (integrator != "cvode-adams")
