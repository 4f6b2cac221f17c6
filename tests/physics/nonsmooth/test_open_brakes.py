# SPDX-License-Identifier: BSD-3-Clause
"""Brakes that are open cost nothing, and act at the step in which they are engaged, tuned or restored."""

from __future__ import annotations

from typing import Any

import pytest

import gelenk

INTEGRATORS = ["auto", "erk", "dirk", "cvode", "cvode-adams", "rk4"]
MASS = 2.0


def sledge(coulomb: float, speed: float, integrator: str) -> dict[str, Any]:
    """A mass on a rail with a brake."""
    return {
        "gelenk": 1,
        "bodies": {"sledge": {"mass": MASS, "inertia": [0.1] * 3}},
        "joints": {
            "P": {
                "type": "prismatic",
                "parent": "ground",
                "child": "sledge",
                "axis": [1, 0, 0],
                "friction": {"coulomb": coulomb, "input": "engagement"},
                "start": {"s": 0, "v": speed, "fixed": True},
            }
        },
        "motors": {"drive": {"joint": "P"}},
        "experiment": {"step": 0.01},
        "solver": {"integrator": integrator},
    }


def started(coulomb: float, speed: float, integrator: str) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(sledge(coulomb, speed, integrator)))
    plant.initialize(tolerance=1e-8)
    return plant


def tune(plant: gelenk.Simulation, coulomb: float, speed: float, integrator: str) -> None:
    plant._core.tune(gelenk.load(sledge(coulomb, speed, integrator))._core)


def to(plant: gelenk.Simulation, end: float) -> None:
    while plant.time < end - 1e-9:
        plant.step_to(round(plant.time + 0.01, 10))


@pytest.mark.parametrize("engaged_before", [True, False])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_friction_tuned_from_zero_holds_at_once(integrator: str, engaged_before: bool) -> None:
    plant = started(0.0, 0.0, integrator)
    plant.set_input("P.friction.engagement", float(engaged_before))
    to(plant, 0.1)
    tune(plant, 5.0, 0.0, integrator)
    plant.set_input("P.friction.engagement", 1.0)
    plant.set_input("drive.f", 4.0)
    to(plant, 0.5)
    assert plant.values(["P.s", "P.v"]) == pytest.approx([0, 0], abs=0)
    plant.set_input("drive.f", 6.0)
    to(plant, 1.0)
    assert plant.values(["P.s", "P.v"]) == pytest.approx([0.5 / MASS * 0.5**2, 1 / MASS * 0.5], abs=1e-7)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_friction_tuned_from_zero_brakes_at_once(integrator: str) -> None:
    plant = started(0.0, 1.0, integrator)
    plant.set_input("P.friction.engagement", 1.0)
    to(plant, 0.1)
    tune(plant, 5.0, 1.0, integrator)
    to(plant, 0.3)
    assert plant.values(["P.v"]) == pytest.approx([1 - 5 / MASS * 0.2], abs=1e-7)
    to(plant, 1.0)  # it stops 0.4 s after the change, and rests
    assert plant.values(["P.s", "P.v"]) == pytest.approx([0.1 + 0.2, 0], abs=1e-7)
    tune(plant, 0.0, 1.0, integrator)
    plant.set_input("drive.f", 1.0)
    to(plant, 1.1)
    assert plant.values(["P.v"]) == pytest.approx([0.1 / MASS], abs=1e-7)


@pytest.mark.parametrize("speed", [0.0, 1.0])
@pytest.mark.parametrize("saved_at", [0.05, 0.1, 0.11, 0.2])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_states_restored_on_either_side_of_an_engagement(
    integrator: str, saved_at: float, speed: float
) -> None:
    """The brake engages at 0.1 s, opens at 0.2 s, and engages again at 0.3 s; the force is constant."""

    def drive_on(plant: gelenk.Simulation, end: float) -> list[list[float]]:
        out = []
        while plant.time < end - 1e-9:
            plant.set_input("P.friction.engagement", float(round(plant.time * 100) // 10 % 2))
            plant.set_input("drive.f", 3.0)
            plant.step_to(round(plant.time + 0.01, 10))
            out.append(list(plant.values(["P.s", "P.v", "P.a"])))
        return out

    plant = started(12.0, speed, integrator)
    drive_on(plant, saved_at)
    saved = plant.save()
    expected = drive_on(plant, 0.5)
    other = started(12.0, 0.0, integrator)
    for _ in range(2):
        other.restore(saved)
        assert drive_on(other, 0.5) == expected
    # From rest it stops in each engagement; from 1 m/s it never does.
    assert expected[-1][1] == pytest.approx(0.55 if speed else 0.15, abs=1e-6)
