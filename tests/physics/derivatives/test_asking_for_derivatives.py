# SPDX-License-Identifier: BSD-3-Clause
"""Where there are no derivatives, by which states they are, and that asking for them changes no run."""

from __future__ import annotations

import math

import numpy as np
import pytest
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


def test_singular_position_is_told() -> None:
    """The flat parallelogram: its rows have lost rank, two branches meet."""
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


def test_dead_centre_is_told_for_the_states_that_do_not_lead_over_it() -> None:
    """Crank and coupler in one line: the rocker stands for a moment, so its angle cannot tell theirs."""
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
    assert np.isfinite(output_derivatives(plant)).all()  # the motion goes on all the same
    plant.step_to(0.3)
    linearized(plant)


def test_other_states_give_the_inverse_slopes() -> None:
    plant = started(CASES["four-bar in its plane"], four_bar())
    plant.step_to(0.4)
    rows = [plant._output["A.phi"], plant._output["D.phi"]]
    by_crank = linearized(plant)
    plant._core._take_states([rows[1]], [plant._output["D.w"]])
    by_rocker = linearized(plant)
    assert by_rocker.states == ["D.phi", "D.w"]
    assert by_crank.C[rows[1], 0] * by_rocker.C[rows[0], 0] == pytest.approx(1, abs=1e-13)
    assert_relative("D", by_rocker.D, by_crank.D, 1e-13)
    # The chain rule: y by (D.phi, D.w) is y by (A.phi, A.w), times these by those.
    rows_A = [plant._output["A.phi"], plant._output["A.w"]]
    assert_relative("C", by_rocker.C, by_crank.C @ by_rocker.C[rows_A], 1e-11)


def test_a_joint_that_closes_the_loop_is_no_state() -> None:
    plant = started(CASES["four-bar in its plane"], four_bar())
    cut = next(j for j in "BC" if f"{j}.phi" not in tree_coordinates(plant))
    with pytest.raises(gelenk.UsageError, match=rf"{cut}\.phi is no state"):
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
def test_asking_changes_no_bit(integrator: str, formulation: str) -> None:
    runs = []
    for asked in (True, False):
        source = with_sensors(four_bar(), E=ENERGY)
        source["solver"] = {"integrator": integrator, "formulation": formulation}
        plant = started(CASES["four-bar in its plane"], source, 1e-8)
        rows = []
        for k in range(1, 31):
            plant.step_to(k * 0.02)
            if k % 3 == 0:
                plant.set_input("drive.tau", math.sin(k))
            if asked:
                linearized(plant)
                output_derivatives(plant)
            if k % 5 == 0:
                rows.append([*plant.values(), *plant.diagnostics.values()])
        runs.append(rows)
    assert runs[0] == runs[1]


def test_asking_near_singular_positions_changes_no_bit() -> None:
    """The parallelogram passes its change point, where the accelerations are carried on."""
    runs = []
    for asked in (True, False):
        plant = gelenk.Simulation(mechanisms.parallelogram(1.0, -3.0))
        plant.initialize(tolerance=1e-9)
        rows = []
        for k in range(1, 101):
            plant.step_to(k * 0.01)
            if asked:
                linearized(plant)
            rows.append(list(plant.values()))
        assert plant.diagnostic("solver.singular_positions") > 0
        runs.append(rows)
    assert runs[0] == runs[1]


def test_finite_numbers_come_out_everywhere() -> None:
    """Sizes: nothing moves, nothing is an input, nothing is an output of a joint."""
    still = scene(
        {"box": body(1.0)}, {"W": joint("weld", frame("ground"), frame("box"))}, sensors={"E": ENERGY}
    )
    plant = gelenk.Simulation(still)
    plant.initialize()
    found: Linear = linearized(plant)
    assert found.states == []
    assert found.C.shape == (3, 0)
    assert not output_derivatives(plant).any()
    assert_close("energy", np.array([plant.output("E.kinetic")]), np.zeros(1), 1e-15, "it stands")
