# SPDX-License-Identifier: BSD-3-Clause
"""What is held lets go within a step, however long it is, where its load comes and goes with the time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene
from scipy.integrate import quad
from scipy.optimize import brentq

import gelenk

INTEGRATORS = ["auto", "erk", "dirk", "cvode", "cvode-adams", "ida"]
PULSE = "2*exp(-((t - 4.3)/0.3)^2)"


def pulse(t: float) -> float:
    return 2 * math.exp(-(((t - 4.3) / 0.3) ** 2))


def displacement() -> float:
    """Of 1 kg under the pulse less 1 N of friction, from where it exceeds this until the speed is 0 again."""
    start = 4.3 - 0.3 * math.sqrt(math.log(2))

    def speed(t: float) -> float:
        return float(quad(pulse, start, t, epsabs=1e-13)[0]) - (t - start)

    end = brentq(speed, 4.6, 6.0, xtol=1e-14)
    return float(quad(lambda t: (end - t) * (pulse(t) - 1), start, end, epsabs=1e-13)[0])


def slide(**fields: Any) -> dict[str, Any]:
    solver = fields.pop("solver")
    return scene(
        {"mass": body(1.0, com=(0, 0, 0))},
        {"S": joint("prismatic", frame("ground"), frame("mass"), axis=[1, 0, 0], **fields)},
        gravity=[0, 0, 0],
        solver=solver,
    )


def box(integrator: str) -> dict[str, Any]:
    """The same by a box on the ground: mu m g = 1 N."""
    out = scene(
        {"box": body(1.0, com=(0, 0, 0), inertia=(0.1, 0.1, 0.1))},
        {"F": joint("free", frame("ground"), frame("box"), start={"r": [0, 0, 0.1]})},
        gravity=[0, 0, -10],
        solver={"integrator": integrator},
    )
    out["bodies"]["box"]["shapes"] = {"whole": {"box": [0.2, 0.2, 0.2], "surface": "box"}}
    out["ground"] = {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}}
    out["contacts"] = {"rest": {"between": ["box", "floor"], "friction": 0.1}}
    out["forces"] = {"push": {"type": "body_force", "body": "box", "force": [PULSE, "0", "0"]}}
    return out


def end_of(description: dict[str, Any], steps: int, output: str, stop: float = 10.0) -> tuple[float, Any]:
    simulation = gelenk.Simulation(description)
    simulation.initialize(0.0, 1e-8)
    for k in range(steps):
        simulation.step_to(stop * (k + 1) / steps)
    return simulation.output(output), simulation


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 10, 100])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_friction_that_a_pulse_exceeds(integrator: str, steps: int) -> None:
    law = slide(law={"effort": PULSE}, friction={"coulomb": 1.0}, solver={"integrator": integrator})
    found, _ = end_of(law, steps, "S.s")
    assert found == pytest.approx(displacement(), abs=1e-6)


@pytest.mark.parametrize("steps", [1, 3, 10])
@pytest.mark.parametrize("integrator", ["auto", "cvode"])
def test_box_on_the_ground_that_a_pulse_moves(integrator: str, steps: int) -> None:
    found, _ = end_of(box(integrator), steps, "F.r[1]")
    assert found == pytest.approx(displacement(), abs=1e-6)


@pytest.mark.parametrize("steps", [1, 2, 3, 10, 100])
def test_swinging_load_just_above_friction(steps: int) -> None:
    """1.05 N sin(2 pi t/10) against 1 N: to and fro by the same way, as the halves are equal."""
    law = slide(
        law={"effort": "1.05*sin(2*pi*t/10)"}, friction={"coulomb": 1.0}, solver={"integrator": "auto"}
    )
    found, simulation = end_of(law, steps, "S.s")
    assert found == pytest.approx(0, abs=1e-6)
    if steps == 1:
        assert len([text for _, text in ((e[0], e[1]) for e in simulation.events) if "slips" in text]) == 2


def test_table_in_one_step_of_a_minute() -> None:
    """Forty teeth of 1.5 N against 1 N, each of which moves the mass by the same amount."""
    teeth = {"x": [0, 0.5, 0.7, 0.9, 1.5], "values": [0, 0, 1.5, 0, 0], "interpolation": "linear"}
    description = slide(
        law={"effort": "table(tooth, t)"}, friction={"coulomb": 1.0}, solver={"integrator": "auto"}
    ) | {"tables": {"tooth": teeth | {"extrapolation": "periodic"}}}
    one, _ = end_of(description, 1, "S.s", 1.5)
    assert one > 1e-3
    many, _ = end_of(description, 1, "S.s", 60.0)
    assert many == pytest.approx(40 * one, rel=1e-6)


def test_limit_from_which_a_pulse_pulls() -> None:
    """Pressed against a hard limit by 1 N, pulled off by the pulse; it comes back and stays."""
    law = slide(
        law={"effort": f"1 - {PULSE}"}, limit={"lower": -1.0, "upper": 0.0}, start={"s": 0.0},
        solver={"integrator": "auto"},
    )  # fmt: skip
    simulation = gelenk.Simulation(law)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(10.0)
    texts = [event[1] for event in simulation.events]
    assert any("leaves" in text or "comes off" in text or "moves away" in text for text in texts), texts


@pytest.mark.parametrize("order", [1, 2])
def test_input_that_is_given_by_derivatives(order: int) -> None:
    """An input that rises and falls within one communication step: 2 t, or 4 t - 2 t^2 N, against 1 N."""
    description = slide(friction={"coulomb": 1.0}, solver={"integrator": "auto"})
    description["motors"] = {"drive": {"joint": "S"}}
    simulation = gelenk.Simulation(description)
    simulation.initialize(0.0, 1e-9)
    for k, value in enumerate((2.0, 0.0) if order == 1 else (4.0, -4.0), 1):
        simulation.set_input_derivative("drive.f", k, value)
    stop = 2.0
    simulation.step_to(stop)

    def force(t: float) -> float:
        return 2 * t if order == 1 else 4 * t - 2 * t * t

    start = brentq(lambda t: force(t) - 1, 0, 1)
    times = np.linspace(start, stop, 200_001)
    speed = np.concatenate([[0], np.cumsum(np.diff(times) * (force_of(force, times) - 1))])
    turns = np.flatnonzero(speed[1:] <= 0)
    last = int(turns[0]) + 1 if len(turns) else len(times) - 1
    exact = float(np.trapezoid(speed[: last + 1], times[: last + 1]))
    assert simulation.output("S.s") == pytest.approx(exact, abs=1e-6)


def force_of(force: Any, times: np.ndarray) -> np.ndarray:
    """At the middles of intervals."""
    middles = (times[1:] + times[:-1]) / 2
    return np.array([force(t) for t in middles])


def test_what_does_not_depend_on_the_time_pays_nothing() -> None:
    """Held by friction under a constant load: evaluations as without the search."""
    description = slide(friction={"coulomb": 1.0}, law={"effort": "0.5"}, solver={"integrator": "auto"})
    _, simulation = end_of(description, 1, "S.s", 100.0)
    assert simulation.diagnostic("solver.evaluations") < 150
