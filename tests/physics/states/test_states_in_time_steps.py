# SPDX-License-Identifier: BSD-3-Clause
"""States of elements beside contacts, in steps with impulses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from circuits import rotor, values
from mechanisms import body, frame, joint, scene

import gelenk


def driven_ball(integrator: str, **solver: Any) -> dict[str, Any]:
    """A ball of 1 kg on a floor, pulled along it by an actuator with 3 N and 0.1 s."""
    return scene(
        {"ball": body(1.0, inertia=(0.004,) * 3) | {"shapes": {"skin": {"sphere": 0.1, "surface": "skin"}}}},
        {"F": joint("free", frame("ground"), frame("ball"), start={"r": [0, 0, 0.1]})},
        gravity=[0, 0, -10],
        ground={"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        contacts={"c": {"between": ["skin", "floor"], "friction": 0.0}},
        forces={"pull": {"type": "body_force", "body": "ball", "force": ["f1", "0", "0"]}},
        states={"f1": "(3 - f1)/0.1"},
        solver={"integrator": integrator, **solver},
    )


@pytest.mark.parametrize("integrator", ["auto", "moreau-jean", "dirk"])
def test_states_beside_contacts(integrator: str) -> None:
    """The path is 3/2 t^2 - 0.3 t + 0.03 (1 - exp(-10 t)), while the ball rests on the floor."""
    found = values(driven_ball(integrator, step=1e-3), ["F.r[1]", "F.v[1]", "f1"], [0.2, 1.0], 1e-8)
    accuracy = 1e-5 if integrator == "moreau-jean" else 1e-7
    for t, (x, v, f) in zip([0.2, 1.0], found, strict=True):
        decay = math.exp(-10 * t)
        assert x == pytest.approx(1.5 * t**2 - 0.3 * t + 0.03 * (1 - decay), abs=accuracy)
        assert v == pytest.approx(3 * t - 0.3 * (1 - decay), abs=accuracy)
        assert f == pytest.approx(3 * (1 - decay), abs=10 * accuracy)


def test_steps_with_impulses_are_of_second_order_between_impacts() -> None:
    errors = []
    for step in (4e-3, 2e-3):
        found = values(driven_ball("moreau-jean", step=step), ["F.v[1]", "f1"], [0.4], 1e-6)[0]
        decay = math.exp(-4)
        errors.append(np.abs(found - [1.2 - 0.3 * (1 - decay), 3 * (1 - decay)]).max())
    assert errors[0] / errors[1] > 3.6


def test_stiff_circuit_beside_contacts() -> None:
    """A time constant of 1 us at steps of 1 ms."""
    source = driven_ball("moreau-jean", step=1e-3)
    source["states"] = {"f1": {"rate": "(3 - f1)/1e-6", "start": 3.0}}
    x, v = values(source, ["F.r[1]", "F.v[1]"], [1.0], 1e-6)[0]
    assert x == pytest.approx(1.5, abs=1e-6)
    assert v == pytest.approx(3.0, abs=1e-6)


def test_steps_with_impulses_damp_stiff_states_and_pass_jumps_of_rates() -> None:
    """An input that jumps before a time constant of 10 us; and a rate that jumps at 0.5."""
    source = rotor(
        effort="fast", states={"fast": "(u - fast)/1e-5"}, inputs={"u": {}},
        solver={"integrator": "moreau-jean", "step": 1e-3},
    )  # fmt: skip
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-6)
    simulation.step_to(0.1)
    simulation.set_input("u", 1.0)
    simulation.step_to(0.103)
    assert simulation.output("fast") == pytest.approx(1.0, abs=1e-3)
    for start in (0.0, 0.3e-3, 0.5e-3, 0.7e-3):
        states = {"q1": {"rate": "if(q1 > 0.5, 0.2, 1)", "start": start}}
        found = values(
            rotor(states=states, solver={"integrator": "moreau-jean", "step": 1e-3}), ["q1"], [1.0], 1e-6
        )
        reached = 0.5 - start
        assert found[0, 0] == pytest.approx(0.5 + 0.2 * (1 - reached), abs=1e-3)
