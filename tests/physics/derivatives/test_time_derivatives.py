# SPDX-License-Identifier: BSD-3-Clause
"""Exact time derivatives of outputs, against finite differences of accurate runs and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import warned
from mechanisms import (
    body,
    frame,
    joint,
    scene,
)
from models.derivative_cases import CASES, assert_relative, started
from models.differences import Array, in_time, linearized, output_derivatives

import gelenk


@warned.PRESSED
@pytest.mark.parametrize("name", CASES)
def test_time_derivatives_match_finite_differences_of_accurate_runs(name: str) -> None:
    """Eighth order at a tolerance of 1e-13: rounding over h^2 and truncation h^8 f10 / 3150 give 1e-6."""
    case = CASES[name]
    source = case.make()
    t = max(case.times[-1], 5 * case.step)
    plant = started(case, source, 1e-13)
    plant.step_to(t)
    found = output_derivatives(plant)

    def run_to(time: float) -> Array:
        other = started(case, source, 1e-13)
        other.step_to(time)
        return other.values()

    expected = in_time(run_to, t, case.step)
    assert_relative("first", found[0], expected[0], 1e-7)
    assert_relative("second", found[1], expected[1], 1e-6)


@warned.PRESSED
@pytest.mark.parametrize("name", CASES)
def test_first_time_derivatives_are_directional_derivatives_along_the_motion(name: str) -> None:
    """dy/dt = C xdot + D udot: two evaluations of the same sums agree to 1e-10 of them."""
    case = CASES[name]
    plant = started(case, case.make())
    plant.step_to(case.times[-1])
    found = linearized(plant)
    udot = np.linspace(-1, 2, len(plant.inputs))
    along = found.C @ found.xdot + found.D @ udot
    assert_relative("first", output_derivatives(plant, udot)[0], along, 1e-9)
    # The second derivatives are affine in u'', with the same matrix D.
    uddot = np.linspace(3, -1, len(plant.inputs))
    second = [output_derivatives(plant, udot, x)[1] for x in (uddot, 0 * uddot)]
    assert_relative("second", second[0] - second[1], found.D @ uddot, 1e-9)


def test_symmetric_top_has_the_time_derivatives_of_its_closed_form() -> None:
    """Without torques w1' = -k w2, w2' = k w1, w3' = 0 with k = (C - A) w3 / A (Euler's equations)."""
    A, C = 0.03, 0.05
    plant = gelenk.Simulation(
        scene(
            {"top": body(1.0, (0, 0, 0), (A, A, C))},
            {"F": joint("free", frame("ground"), frame("top"), start={"w": [0.7, -0.3, 5.0]})},
        )
    )
    plant.initialize()
    plant.step_to(0.37)
    k = (C - A) / A * 5.0
    w = np.array([plant.output(f"F.w[{i}]") for i in (1, 2)])
    rows = [plant._output[f"F.{x}[{i}]"] for x in "wz" for i in (1, 2)]
    turned = np.array([-w[1], w[0]])
    first, second = output_derivatives(plant)
    assert_relative("w', z'", first[rows], np.array([*(k * turned), *(-(k**2) * w)]), 1e-12)
    assert_relative("w'', z''", second[rows], np.array([*(-(k**2) * w), *(-(k**3) * turned)]), 1e-12)
