# SPDX-License-Identifier: BSD-3-Clause
"""The scenes of docs/howto-drives.md, against closed forms and balances of energy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from pages import blocks
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import gelenk

J, M = 0.5, 2.0  # kg.m2, kg
NAMES = ("dc", "pmsm", "speed", "position", "maxwell", "elastic", "cylinder", "heat")


def drive(root: Path, name: str, start: dict[str, float] | None = None, **inputs: float) -> dict[str, Any]:
    """A block of the page with a rotor of 0.5 kg m2 or a mass of 2 kg, and these start values of inputs."""
    number = NAMES.index(name)
    part: dict[str, Any] = yaml.safe_load(blocks(root / "docs" / "howto-drives.md", "yaml")[number])
    joint = next(iter(part["joints"].values()))
    joint["start"] = start or {}
    for key, value in inputs.items():
        part["inputs"][key]["start"] = value
    return {"gelenk": 1, "bodies": {joint["child"]: {"mass": M, "inertia": [J, J, J]}}} | part


def run(source: dict[str, Any], end: float, tolerance: float = 1e-9) -> gelenk.Simulation:
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, tolerance)
    simulation.step_to(end)
    return simulation


def test_dc_motor(root: Path) -> None:
    simulation = run(drive(root, "dc", u=12.0), 0.4)
    A = np.array([[0, 0.4 / J], [-0.4 / 0.05, -1.2 / 0.05]])
    rest = -np.linalg.solve(A, [0, 12 / 0.05])
    w, i = rest - expm(0.4 * A) @ rest
    assert [simulation.output("axle.w"), simulation.output("i")] == pytest.approx([w, i], abs=1e-7)
    assert simulation.output("electrical") == pytest.approx(12 * i, abs=1e-5)


def test_synchronous_motor_balances_its_energy(root: Path) -> None:
    """Electrical work = heat + magnetic energy 3/4 (Ld id^2 + Lq iq^2) + kinetic energy."""
    source = drive(root, "pmsm", ud=-1.0, uq=20.0)
    source["states"] |= {"supplied": "electrical", "lost": "heat"}
    for end in (0.01, 0.1, 1.0):
        simulation = run(source, end)
        i_d, i_q, w = (simulation.output(name) for name in ("id", "iq", "axle.w"))
        stored = 0.75 * (2e-3 * i_d**2 + 3e-3 * i_q**2) + J * w**2 / 2
        assert simulation.output("supplied") == pytest.approx(simulation.output("lost") + stored, rel=1e-7)
    assert simulation.output("axle.w") > 10


def test_speed_controller_is_that_of_another_solver(root: Path) -> None:
    def rates(_: float, y: np.ndarray) -> list[float]:
        w, error = y
        wanted = 4 * (2 - w) + 8 * error
        torque = min(max(wanted, -1.5), 1.5)
        return [torque / J, 2 - w + (torque - wanted) / 0.1]

    truth = solve_ivp(rates, (0, 3), [0, 0], rtol=1e-10, atol=1e-12, max_step=1e-3).y[:, -1]
    simulation = run(drive(root, "speed"), 3.0)
    assert [simulation.output("axle.w"), simulation.output("sum")] == pytest.approx(truth, abs=1e-6)


def test_position_controller_follows_its_filter(root: Path) -> None:
    """The command is beyond the permitted rate for 0.2 s; then the filter settles, and the axle too."""
    simulation = run(drive(root, "position", command=0.6), 0.1, 1e-8)
    assert simulation.output("limited") == pytest.approx(0.3, abs=1e-7)
    simulation.step_to(5.0)
    for name in ("limited", "set", "axle.phi"):
        assert simulation.output(name) == pytest.approx(0.6, abs=1e-6)
    assert simulation.diagnostic("solver.events") <= 2


def test_maxwell_element(root: Path) -> None:
    simulation = run(drive(root, "maxwell", {"s": 0.1}), 0.7)
    A = np.array([[0, 1, 0], [-400 / M, 0, 400 / M], [20, 0, -20]])
    found = [simulation.output(name) for name in ("rod.s", "rod.v", "x1")]
    assert found == pytest.approx(expm(0.7 * A) @ [0.1, 0, 0], abs=1e-8)


def test_series_elastic_drive(root: Path) -> None:
    simulation = run(drive(root, "elastic", drive=2.0), 0.5)
    A = np.array(
        [[0, 1, 0, 0], [-150 / J, 0, 150 / J, 0], [0, 0, 0, 1], [150 / 0.02, 0, -150 / 0.02, -0.05 / 0.02]]
    )
    whole = np.zeros((5, 5))
    whole[:4, :4], whole[3, 4] = A, 2 / 0.02
    names = ("axle.phi", "axle.w", "angle", "turning")
    found = [simulation.output(name) for name in names]
    assert found == pytest.approx((expm(0.5 * whole) @ [0, 0, 0, 0, 1])[:4], abs=1e-7)


def test_closed_chamber_is_adiabatic(root: Path) -> None:
    """Without flow p V^1.4 is constant; the piston swings between two positions of equal energy."""
    source = drive(root, "cylinder", {"s": 0.0, "v": 3.0}, flow=0.0)
    for end in (0.01, 0.05, 0.2):
        simulation = run(source, end, 1e-10)
        s, v, p = (simulation.output(name) for name in ("rod.s", "rod.v", "pressure"))
        assert p * (0.1 + s) ** 1.4 == pytest.approx(1e5 * 0.1**1.4, rel=1e-8)
        work = 1e5 * 2e-3 * 0.1**1.4 * ((0.1 + s) ** -0.4 - 0.1**-0.4) / 0.4  # stored in the gas
        assert M * v**2 / 2 + work + 1e5 * 2e-3 * s == pytest.approx(M * 9 / 2, rel=1e-7)


def test_heat_of_losses(root: Path) -> None:
    """All kinetic energy becomes heat: 50 J/K of warmth and what has flowed off."""
    source = drive(root, "heat", {"w": 30.0})
    source["states"]["gone"] = "warmth/resistance"
    simulation = run(source, 3.0)
    heat = 50 * simulation.output("warmth") + simulation.output("gone")
    assert heat + J * simulation.output("axle.w") ** 2 / 2 == pytest.approx(J * 30**2 / 2, rel=1e-7)
    assert simulation.output("damping") < 0.8
    assert math.isfinite(simulation.output("lost"))
