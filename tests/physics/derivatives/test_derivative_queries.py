# SPDX-License-Identifier: BSD-3-Clause
"""Positions without derivatives, the choice of states, and runs unchanged by computing derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
import warned
from mechanisms import (
    body,
    four_bar,
    frame,
    joint,
    scene,
    with_sensors,
)
from models.derivative_cases import CASES, ENERGY, assert_relative, started
from models.differences import Linear, linearized, output_derivatives
from models.running import assert_close

import gelenk
from gelenk.chart import mechanisms


@warned.SINGULAR
def test_singular_configuration_is_reported() -> None:
    """The flat parallelogram: its constraint Jacobian loses rank, and two branches meet."""
    plant = gelenk.Simulation(mechanisms.parallelogram(0.0, 1.0))
    plant.initialize()
    assert (
        len(plant.independent_coordinates) == plant.size.degrees_of_freedom == 1
    )  # though here none depends on another
    for ask in (plant._core._linearize, lambda: plant._core._output_derivatives([], [])):
        with pytest.raises(
            gelenk.UsageError, match="t = 0 s: a loop is in or close to a singular configuration"
        ):
            ask()


def test_dead_center_is_reported_for_states_that_do_not_determine_the_other_coordinates() -> None:
    """Crank and coupler in line: the rocker is at its limit, where its angle does not determine theirs."""
    crank, coupler, rocker, ground = 0.5, 1.75, 1.5, 2.0
    reach = crank + coupler
    phi = math.acos((ground**2 + reach**2 - rocker**2) / (2 * ground * reach))
    plant = gelenk.Simulation(four_bar(phi))
    plant.initialize()
    assert_relative(
        "the crank leads over it", linearized(plant).C[plant._output["D.w"], 1:], np.zeros(1), 1e-7
    )
    plant._core._take_states([plant._output["D.phi"]], [plant._output["D.w"]])
    with pytest.raises(gelenk.UsageError, match=r"the states D\.phi do not determine the other coordinates"):
        plant._core._linearize()
    assert np.isfinite(output_derivatives(plant)).all()  # the motion continues
    plant.step_to(0.3)
    linearized(plant)


def test_derivatives_by_other_states_follow_from_the_chain_rule() -> None:
    plant = started(CASES["four-bar in its plane"], four_bar())
    plant.step_to(0.4)
    rows = [plant._output["A.phi"], plant._output["D.phi"]]
    by_crank = linearized(plant)
    plant._core._take_states([rows[1]], [plant._output["D.w"]])
    by_rocker = linearized(plant)
    assert by_rocker.states == ["D.phi", "D.w"]
    assert by_crank.C[rows[1], 0] * by_rocker.C[rows[0], 0] == pytest.approx(1, abs=1e-13)
    assert_relative("D", by_rocker.D, by_crank.D, 1e-13)
    # The derivatives of y by (D.phi, D.w) are those by (A.phi, A.w) times the derivatives of (A.phi, A.w).
    rows_A = [plant._output["A.phi"], plant._output["A.w"]]
    assert_relative("C", by_rocker.C, by_crank.C @ by_rocker.C[rows_A], 1e-11)


def test_coordinate_of_the_loop_closing_joint_cannot_be_a_state() -> None:
    plant = started(CASES["four-bar in its plane"], four_bar())
    cut = next(j for j in "BC" if f"{j}.phi" not in tree_coordinates(plant))
    with pytest.raises(gelenk.UsageError, match=rf"{cut}\.phi cannot be a state"):
        plant._core._take_states([plant._output[f"{cut}.phi"]], [plant._output[f"{cut}.w"]])


def tree_coordinates(plant: gelenk.Simulation) -> list[str]:
    out = []
    for j in "ABCD":
        try:
            plant._core._take_states([plant._output[f"{j}.phi"]], [plant._output[f"{j}.w"]])
            out.append(f"{j}.phi")
        except gelenk.UsageError:
            continue
    return out


@pytest.mark.parametrize("integrator", ["auto", "erk", "ida", "cvode", "generalized-alpha"])
@pytest.mark.parametrize("formulation", ["projection", "independent", "baumgarte"])
def test_computing_derivatives_does_not_change_a_run(integrator: str, formulation: str) -> None:
    runs = []
    for compute in (True, False):
        source = with_sensors(four_bar(), E=ENERGY)
        source["solver"] = {"integrator": integrator, "formulation": formulation}
        plant = started(CASES["four-bar in its plane"], source, 1e-8)
        rows = []
        for k in range(1, 31):
            plant.step_to(k * 0.02)
            if k % 3 == 0:
                plant.set_input("drive.tau", math.sin(k))
            if compute:
                linearized(plant)
                output_derivatives(plant)
            if k % 5 == 0:
                rows.append([*plant.values(), *plant.diagnostics.values()])
        runs.append(rows)
    assert runs[0] == runs[1]


def test_computing_derivatives_near_singular_configurations_does_not_change_a_run() -> None:
    """The parallelogram crosses its change point, where constraints do not determine the accelerations."""
    runs = []
    for compute in (True, False):
        plant = gelenk.Simulation(mechanisms.parallelogram(1.0, -3.0))
        plant.initialize(tolerance=1e-9)
        rows = []
        for k in range(1, 101):
            plant.step_to(k * 0.01)
            if compute:
                linearized(plant)
            rows.append(list(plant.values()))
        assert plant.diagnostic("solver.singular_positions") > 0
        runs.append(rows)
    assert runs[0] == runs[1]


def test_mechanism_without_states_and_inputs_has_empty_matrices() -> None:
    """Nothing moves, and there are neither inputs nor outputs of joints."""
    still = scene(
        {"box": body(1.0)}, {"W": joint("weld", frame("ground"), frame("box"))}, sensors={"E": ENERGY}
    )
    plant = gelenk.Simulation(still)
    plant.initialize()
    found: Linear = linearized(plant)
    assert found.states == []
    assert found.C.shape == (3, 0)
    assert not output_derivatives(plant).any()
    assert_close("energy", np.array([plant.output("E.kinetic")]), np.zeros(1), 1e-15, "it is at rest")
