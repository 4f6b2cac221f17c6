# SPDX-License-Identifier: BSD-3-Clause
"""Examples of Modelica's rotational and translational mechanics against a search through all modes.

OneWayClutch, OneWayClutchDisengaged, LossyGearDemo1 to 3 and Rotational.Friction are in test_drive_trains.py,
CoupledClutches in test_coupled_clutches.py.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import warned
from mechanisms import Array
from models import modelica_drives as drives
from models import modelica_vehicles as vehicles
from models.drive_cases import INTEGRATORS, Case, different, run, truth_of
from models.drive_trains import DriveTrain
from models.running import assert_close
from samples import thorough_beyond

import gelenk

pytestmark = warned.PRESSED

CASES: dict[str, Callable[[], Case]] = {
    "Rotational.Backlash": drives.backlash,
    "Rotational.SimpleGearShift": drives.gear_shift,
    "Rotational.HeatLosses": drives.rotational_heat_losses,
    "Translational.Brake": drives.brake,
    "Translational.ElastoGap": drives.elasto_gap,
    "Translational.Friction": drives.translational_friction,
    "Translational.HeatLosses": drives.translational_heat_losses,
    "Translational.PreLoad": vehicles.preload,
    "Translational.Vehicle": vehicles.vehicle,
}


@cache
def truth(name: str) -> tuple[Array, DriveTrain]:
    return truth_of(CASES[name]())


@pytest.mark.filterwarnings("ignore:solver.tolerance")
@pytest.mark.parametrize("tolerance", thorough_beyond([1e-6, 1e-8, 1e-10], [1e-8]))
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", CASES)
def test_motions_agree_with_a_search_through_all_modes(name: str, integrator: str, tolerance: float) -> None:
    case = CASES[name]()
    expected, _ = truth(name)
    found, _ = run(case, integrator, tolerance)
    if case.positions is None:
        expected = expected[:, len(case.start) :]
    sizes = np.maximum(1.0, np.abs(expected).max(axis=0))
    assert_close(
        "motion", found / sizes, expected / sizes, 100 * tolerance, "100 times the tolerance, of the largest"
    )


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", CASES)
def test_events_are_those_of_the_exact_solution(name: str, integrator: str) -> None:
    case = CASES[name]()
    _, train = truth(name)
    _, times = run(case, integrator, 1e-8)
    expected, found = different(train.instants), different(times)
    assert len(found) == len(expected)
    assert_close("times", [0.0, *found], [0.0, *expected], 1e-6, "100 times the tolerance")


def power_of_friction(case: Case, plant: gelenk.Simulation, name: str) -> float:
    """Compare what a joint without motor supplies with its friction and damping; return that of friction."""
    outputs = {str(signal.name) for signal in plant.outputs}
    effort, speed = ("tau", "w") if f"{name}.w" in outputs else ("f", "v")
    v = plant.output(f"{name}.{speed}")
    friction = plant.output(f"{name}.friction.{effort}") * v
    supplied = friction - case.source["joints"][name].get("damping", 0.0) * v * v
    total = plant.output("power.total" if name == "mass" else f"power_{name}.total")
    assert_close("power", total, supplied, 1e-12, "rounding of wrenches of 10 N m times velocities of 0.1")
    return friction


@pytest.mark.parametrize(
    ("name", "losing"), [("Translational.Brake", ("mass",)), ("Rotational.HeatLosses", drives.LOSSES)]
)
def test_dissipated_power_is_an_output(name: str, losing: tuple[str, ...]) -> None:
    """In place of Modelica's heat ports: the power that a joint supplies, which has no motor."""
    case = CASES[name]()
    plant = gelenk.Simulation(gelenk.load(case.source))
    lost = dict.fromkeys(losing, 0.0)
    for k in range(case.segments):
        case.set_inputs(plant, k)
        if k == 0:
            plant.initialize(0.0, 1e-8)
        plant.step_to((k + 1) * case.segment)
        for joint in losing:
            power = power_of_friction(case, plant, joint)
            assert power <= 0
            lost[joint] -= power
    assert all(lost[joint] > 0 for joint in losing if joint != "six"), lost  # the brake holds
