# SPDX-License-Identifier: BSD-3-Clause
"""Expressions with names: as outputs, with their derivatives, and as parts of other expressions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, scene

import gelenk


def motor(**more: Any) -> dict[str, Any]:
    """A DC motor with a controlled speed and a limited voltage, its powers and its heat."""
    law = {"effort": "k*i - d*w"}
    out = scene(
        {"rotor": body(2.0, inertia=(0.5, 0.5, 0.5))},
        {
            "A": joint(
                "revolute", frame("ground"), frame("rotor"), axis=[0, 0, 1], start={"phi": 0.0}, law=law
            )
        },
        constants={"R": 1.0, "L": 0.05, "k": 0.4, "d": 0.02, "limit": 12.0},
        inputs={"target": {"unit": "rad/s", "start": 5.0}},
        expressions={
            "wanted": "20*(target - A.w) + 5*e",
            "u": {"value": "clip(wanted, -limit, limit)", "unit": "V", "text": "voltage"},
            "electrical": {"value": "u*i", "unit": "W"},
            "mechanical": {"value": "k*i*A.w", "unit": "W"},
            "loss": {"value": "R*i^2 + d*A.w^2", "unit": "W"},
        },
        states={
            "e": "if(abs(wanted) > limit, 0, target - A.w)",
            "i": {"rate": "(u - R*i - k*A.w)/L", "unit": "A"},
            "heat": {"rate": "loss", "unit": "J"},
            "work": {"rate": "electrical", "unit": "J"},
        },
    )
    return out | more


@pytest.mark.parametrize("integrator", ["auto", "dirk", "cvode", "ida"])
def test_energy_that_flows_in_is_stored_or_lost(integrator: str) -> None:
    """Work of the voltage = L i^2/2 + J w^2/2 + heat, from rest, through the limit of the voltage."""
    simulation = gelenk.Simulation(motor(solver={"integrator": integrator}))
    simulation.initialize(0.0, 1e-9)
    for t in (0.1, 0.5, 1.0, 3.0):
        simulation.step_to(t)
        at = {
            name: simulation.output(name) for name in ("i", "A.w", "heat", "work", "u", "electrical", "loss")
        }
        stored = 0.05 * at["i"] ** 2 / 2 + 0.5 * at["A.w"] ** 2 / 2
        assert at["work"] == pytest.approx(stored + at["heat"], rel=1e-7)
        assert at["electrical"] == pytest.approx(at["u"] * at["i"], rel=1e-14)
        assert at["loss"] == pytest.approx(at["i"] ** 2 + 0.02 * at["A.w"] ** 2, rel=1e-14)
    assert simulation.output("A.w") == pytest.approx(5.0, abs=0.3)


def test_linear_model_has_their_derivatives() -> None:
    """C and D of the powers, by central differences of outputs at displaced states."""
    source = motor()
    source["states"]["i"]["start"] = 2.0
    source["joints"]["A"]["start"] = {"phi": 0.3, "w": 4.9}
    with pytest.warns(gelenk.OperatingPointWarning):
        model = gelenk.linearize(source, states=["A.phi", "A.w"])
    labels = list(model.output_labels)
    C, D = np.asarray(model.C), np.asarray(model.D)
    assert list(model.state_labels) == ["A_phi", "A_w", "e", "i", "heat", "work"]
    w, i, k, target, e = 4.9, 2.0, 0.4, 5.0, 0.0
    u = 20 * (target - w) + 5 * e
    np.testing.assert_allclose(C[labels.index("electrical")], [0, -20 * i, 5 * i, u, 0, 0], atol=1e-12)
    np.testing.assert_allclose(D[labels.index("electrical")], [20 * i], atol=1e-12)
    np.testing.assert_allclose(C[labels.index("mechanical")], [0, k * i, 0, k * w, 0, 0], atol=1e-12)
    np.testing.assert_allclose(C[labels.index("loss")], [0, 0.04 * w, 0, 2 * i, 0, 0], atol=1e-12)


def test_kinks_of_outputs_are_no_events() -> None:
    source = motor()
    source["states"] = {"i": "(3*sin(9*t) - i)/0.05"}
    source["expressions"] = {"size": "abs(i)", "side": "sign(A.w)"}
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-8)
    for k in range(1, 101):
        simulation.step_to(0.02 * k)
        assert simulation.output("size") == abs(simulation.output("i"))
    assert simulation.diagnostic("solver.events") == 0


def test_expressions_of_constants_and_of_nothing_that_moves() -> None:
    """They remain when the rest of the scene is left out."""
    source = motor(outputs=["A.w"])
    source["expressions"]["half"] = "limit/2"
    source["expressions"]["u"]["value"] = "clip(wanted, -2*half, 2*half)"
    whole, part = gelenk.Simulation(motor()), gelenk.Simulation(source)
    for simulation in (whole, part):
        simulation.initialize(0.0, 1e-9)
        simulation.step_to(0.7)
    assert part.output("A.w") == pytest.approx(whole.output("A.w"), abs=1e-9)


def test_expressions_that_name_others_twice() -> None:
    """Each is read once: read as often as they are named, forty of them would be 2^40 texts."""
    expressions = {"e0": "A.phi"}
    for k in range(1, 40):
        expressions[f"e{k}"] = f"sin(e{k - 1}) + cos(e{k - 1})/2"
    simulation = gelenk.Simulation(motor(expressions=motor()["expressions"] | expressions))
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.3)
    value = simulation.output("A.phi")
    for _ in range(1, 40):
        value = math.sin(value) + math.cos(value) / 2
    assert simulation.output("e39") == pytest.approx(value, abs=1e-13)


@pytest.mark.parametrize("size", [1e-5, 1e4])
def test_units_of_other_sizes(size: float) -> None:
    """A mass on a spring: its energy by an expression."""
    m, k = size**3, 40 * size**3
    source = scene(
        {"mass": body(m)},
        {
            "S": joint(
                "prismatic", frame("ground"), frame("mass", (size, 0, 0)), axis=[1, 0, 0],
                start={"s": 0.5 * size},
                law={"effort": f"-{k}*s"},
            )
        },
        expressions={"energy": {"value": f"{m}*S.v^2/2 + {k}*S.s^2/2", "unit": "J"}},
    )  # fmt: skip
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-10)
    simulation.step_to(1.3)
    assert simulation.output("energy") == pytest.approx(k * (0.5 * size) ** 2 / 2, rel=1e-8)
    assert simulation.output("S.s") == pytest.approx(
        0.5 * size * math.cos(math.sqrt(40) * 1.3), abs=1e-8 * size
    )


@pytest.mark.parametrize(
    ("expressions", "message"),
    [
        ({"a1": "b1 + 1", "b1": "2*a1"}, "expressions.a1.*in a circle"),
        ({"a1": "2*nothing"}, "expressions.a1.*nothing"),
        ({"a1": {"unit": "W"}}, "expressions.a1.*value"),
        ({"limit": "1"}, "expressions.limit.*constants.limit"),
        ({"a1": "A.b"}, "expressions.a1.*A.b.*expected one of A.a, A.phi, A.w"),
        ({"a1": "A.phi +"}, "expressions.a1.*column"),
    ],
)
def test_mistakes_are_errors_of_the_scene(expressions: dict[str, Any], message: str) -> None:
    source = motor()
    source["expressions"] |= expressions
    with pytest.raises(gelenk.SceneError, match=r"(?s)" + message):
        gelenk.Simulation(source)
