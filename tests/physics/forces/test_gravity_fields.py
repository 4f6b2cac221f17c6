# SPDX-License-Identifier: BSD-3-Clause
"""Gravity that depends on the position: Kepler's orbits, uniform gravity by expressions, its gradient."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, frame, joint, rod, scene

import gelenk


def satellites(gravity: Any, size: float = 1.0, **solver: Any) -> dict[str, Any]:
    """One in the plane y, z about [2, 0, 0], a = `size`, mu = size^3: eccentricity 0.3, period 2 pi."""
    a, e = size, 0.3
    speed = a * math.sqrt((1 + e) / (1 - e))
    return scene(
        {"S": body(2.0, com=(0.1 * size, 0, 0), inertia=(0.1 * size**2,) * 3)},
        {
            "F": joint(
                "free", frame("ground", (2 * size, 0, 0)), frame("S", (0.1 * size, 0, 0)),
                start={"r": [0, a * (1 - e), 0], "v": [0, 0, speed]},
            )
        },
        gravity=gravity,
        solver=solver,
    )  # fmt: skip


@pytest.mark.parametrize("size", [1.0, 7e6])
def test_hundred_orbits_about_a_center(size: float) -> None:
    """Energy, and after 100 periods the place where it began; also of the size of the Earth."""
    source = satellites({"mu": size**3, "center": [2 * size, 0, 0]}, size, integrator="erk")
    simulation = gelenk.Simulation(source)
    simulation.initialize(0.0, 1e-11)
    energies = []
    for k in range(1, 101):
        simulation.step_to(2 * math.pi * k)
        energies.append(simulation.diagnostic("energy.total") / size**2)
    # The drift of the energy by dE shifts the orbit by 3 pi n^2 dE a/2 along itself in n periods.
    drift = max(abs(E + 1.0) for E in energies)  # -mu m/(2 a)
    assert drift < 1e-8
    assert abs(simulation.output("F.r[3]")) / size < 3 * math.pi * 100 * drift + 1e-8
    assert simulation.output("F.r[2]") / size == pytest.approx(0.7, abs=1e-5)


def test_central_gravity_is_its_expression() -> None:
    central = satellites({"mu": 1.0, "center": [2.0, 0, 0]})
    law = [f"-({x})/((x - 2)^2 + y^2 + z^2)^1.5" for x in ("x - 2", "y", "z")]
    runs = [
        gelenk.simulate(gelenk.load(source), stop=5, step=0.5)
        for source in (central, satellites({"law": law}))
    ]
    for name in ("F.r[2]", "F.r[3]", "F.w[1]"):
        np.testing.assert_allclose(np.asarray(runs[0][name]), np.asarray(runs[1][name]), rtol=0, atol=1e-5)


@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida", "dirk"])
def test_uniform_gravity_by_expressions(integrator: str) -> None:
    """A double pendulum whose second link is two bodies, welded: the same as with a vector."""
    runs = []
    for gravity in (
        [0.5, -9.81, 0],
        {"law": [0.5, "-9.81", 0]},
        {"uniform": [0.5, 0, 0], "law": [0, -9.81, 0]},
    ):
        source = scene(
            {"a": rod(1.0, 0.5), "b": rod(0.7, 0.4), "c": body(0.3, com=(0.2, 0.1, 0), inertia=(1e-3,) * 3)},
            {
                "A": joint("revolute", frame("ground"), frame("a"), axis=[0, 0, 1], start={"phi": 0.4}),
                "B": joint("revolute", frame("a", (0.5, 0, 0)), frame("b"), axis=[0, 0, 1]),
                "W": joint("weld", frame("b", (0.4, 0, 0)), frame("c")),
            },
            gravity=gravity,
            solver={"integrator": integrator, "step": 1e-3},
        )
        simulation = gelenk.Simulation(source)
        simulation.initialize(0.0, 1e-9)
        for k in range(1, 21):
            simulation.step_to(0.05 * k)
        runs.append(simulation.values())
    np.testing.assert_allclose(runs[1], runs[0], rtol=0, atol=3e-8)
    np.testing.assert_allclose(runs[2], runs[0], rtol=0, atol=3e-8)


def test_linear_model_has_the_gradient() -> None:
    """A mass at r on a radial slide, held by a spring: s'' = -k (s - s0) - mu/s^2, A21 = -k + 2 mu/s^3."""
    k, mu, s = 5.0, 3.0, 1.2
    source = scene(
        {"mass": body(1.0, com=(0, 0, 0))},
        {
            "S": joint(
                "prismatic", frame("ground"), frame("mass"), axis=[0, 0.6, 0.8], start={"s": s},
                stiffness=k, spring_reference=s + mu / s**2 / k,
            )
        },
        gravity={"mu": mu},
    )  # fmt: skip
    model = gelenk.linearize(source, states=["S.s", "S.v"])
    truth = np.array([[0, 1], [-k + 2 * mu / s**3, 0]])
    np.testing.assert_allclose(np.asarray(model.A), truth, rtol=1e-12, atol=1e-12)


def test_field_of_gravity_is_written_and_read_again() -> None:
    for gravity in ({"mu": 3.0, "center": [1.0, 0, 0]}, {"law": ["x", "0", "-9.81"], "uniform": [1.0, 0, 0]}):
        plant = gelenk.load(satellites(gravity))
        assert plant.to_dict()["gravity"] == gravity


@pytest.mark.parametrize(
    ("gravity", "message"),
    [
        ({}, "gravity: found neither law nor mu, expected either law, or mu and center"),
        ({"mu": 1.0, "law": [0, 0, 0]}, "gravity: found law and mu"),
        ({"mu": -1.0}, r"gravity\.mu"),
        ({"law": ["x", "y"]}, r"gravity\.law: .*a list of 3"),
        ({"law": ["x", "y", "r"]}, r"gravity\.law\[3\]: .*column 1: found 'r'"),
        ({"lar": [0, 0, 0]}, r"gravity: found a mapping"),
        ({"law": [0, 0, 0], "center": [1, 0, 0]}, r"gravity\.center: found a center of a law"),
    ],
)
def test_mistakes(gravity: Any, message: str) -> None:
    with pytest.raises(gelenk.SceneError, match="(?s)" + message):
        gelenk.load(satellites(gravity))
