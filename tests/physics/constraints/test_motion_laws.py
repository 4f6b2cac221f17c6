# SPDX-License-Identifier: BSD-3-Clause
"""Motions prescribed by an expression of time: against closed forms, and against polynomials and sines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from mechanisms import body, four_bar, frame, joint, scene

import gelenk

FORMULATIONS = ["projection", "baumgarte", "augmented-lagrangian", "independent"]


def swung(law: str, **solver: Any) -> dict[str, Any]:
    """A rod of 2 kg, center of mass at 0.3 m, about a horizontal axis."""
    return scene(
        {"rod": body(2.0, com=(0.3, 0, 0), inertia=(0.01, 0.08, 0.08))},
        {"A": joint("revolute", frame("ground"), frame("rod"), axis=[0, 0, 1])},
        constraints={"swing": {"type": "motion", "joint": "A", "law": law}},
        gravity=[0, -9.81, 0],
        solver=solver,
    )


def torque(phi: float, acceleration: float) -> float:
    return (0.08 + 2.0 * 0.3**2) * acceleration + 2.0 * 9.81 * 0.3 * math.cos(phi)


LAWS = {
    "0.4 + 0.35*sin(2*t)*exp(-t/3)": lambda t: (
        0.4 + 0.35 * math.sin(2 * t) * math.exp(-t / 3),
        0.35 * math.exp(-t / 3) * (2 * math.cos(2 * t) - math.sin(2 * t) / 3),
        0.35 * math.exp(-t / 3) * (-4 * math.sin(2 * t) - 4 / 3 * math.cos(2 * t) + math.sin(2 * t) / 9),
    ),
    "atan(t^2) - 1": lambda t: (
        math.atan(t * t) - 1,
        2 * t / (1 + t**4),
        (2 - 6 * t**4) / (1 + t**4) ** 2,
    ),
    "sqrt(1 + t)": lambda t: (math.sqrt(1 + t), 0.5 / math.sqrt(1 + t), -0.25 * (1 + t) ** -1.5),
    "0.7": lambda _: (0.7, 0.0, 0.0),
}


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_torque_of_a_prescribed_motion_is_that_of_newton(law: str, formulation: str) -> None:
    """Coordinate, speed and torque at ten times; the coordinate is prescribed, not integrated."""
    if formulation != "projection" and law == "0.7":
        pytest.skip("a body at rest has nothing to stabilize")
    plant = gelenk.Simulation(swung(law, formulation=formulation))
    plant.initialize(0.0, 1e-10)
    # Stabilization does not hold positions exactly: its error is that of the integration.
    bound = 1e-12 if formulation in ("projection", "independent") else 1e-7
    for k in range(11):
        if k > 0:
            plant.step_to(0.2 * k)
        phi, speed, acceleration = LAWS[law](0.2 * k)
        assert abs(plant.output("A.phi") - phi) <= bound
        assert abs(plant.output("A.w") - speed) <= 10 * bound
        assert abs(plant.output("swing.tau") - torque(phi, acceleration)) <= 1e3 * bound


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_lengths_are_in_meters_at_any_size(size: float) -> None:
    """A slide of a mechanism of millimeters or kilometers, which is solved in units of its own."""
    law = f"{size}*(0.2 + 0.1*sin(3*t))"
    source = scene(
        {"block": body(1.0, com=(0.5 * size, 0, 0))},
        {"S": joint("prismatic", frame("ground"), frame("block", (size, 0, 0)), axis=[1, 0, 0])},
        constraints={"push": {"type": "motion", "joint": "S", "law": law}},
        gravity=[0, 0, 0],
    )
    plant = gelenk.Simulation(source)
    plant.initialize()
    plant.step_to(0.7)
    assert plant.output("S.s") == pytest.approx(size * (0.2 + 0.1 * math.sin(2.1)), rel=1e-13)
    assert plant.output("S.v") == pytest.approx(size * 0.3 * math.cos(2.1), rel=1e-12)
    assert plant.output("push.f") == pytest.approx(-size * 0.9 * math.sin(2.1), rel=1e-11)


def driven_four_bar(motion: dict[str, Any]) -> gelenk.Simulation:
    source = four_bar(1.1)
    source.pop("motors", None)
    source["joints"]["A"].pop("start", None)
    source["constraints"] = {"crank": {"type": "motion", "joint": "A", **motion}}
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, 1e-9)
    return plant


def test_law_of_a_driven_loop_agrees_with_a_polynomial_and_a_sine() -> None:
    """The same motion in both ways; the higher derivatives serve where a loop is driven."""
    by_law = driven_four_bar({"law": "1.1 + 0.3*t - 0.05*t^2 + 0.2*sin(2*pi*0.8*t + 0.1)"})
    by_terms = driven_four_bar(
        {"polynomial": [1.1, 0.3, -0.05], "sine": {"amplitude": 0.2, "frequency": 0.8, "phase": 0.1}}
    )
    for k in range(1, 21):
        by_law.step_to(0.1 * k)
        by_terms.step_to(0.1 * k)
        np.testing.assert_allclose(by_law.values(), by_terms.values(), rtol=1e-10, atol=1e-10)


def test_law_survives_writing_and_an_fmu(tmp_path: Any) -> None:
    law = "0.4 + 0.35*sin(2*t)*exp(-t/3)"
    loaded = gelenk.load(swung(law))
    assert loaded.to_dict()["constraints"]["swing"]["law"] == law
    again = gelenk.load(loaded.to_dict())
    direct = gelenk.simulate(again, stop=1.0, step=0.1)
    fmu = gelenk.simulate(gelenk.export_fmu(again, tmp_path / "swing.fmu"), stop=1.0, step=0.1)
    np.testing.assert_array_equal(np.asarray(direct["A.phi"]), np.asarray(fmu["A.phi"]))
    assert gelenk.load(swung("0.7")).to_dict()["constraints"]["swing"]["law"] == "0.7"
    assert gelenk.load(swung(0.7)).to_dict()["constraints"]["swing"]["law"] == "0.7"  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("0.4 + 0.35 sin(t)", r"found '0.4 \+ 0.35 sin\(t\)'.*column 12: .*'\*': 0.35\*sin"),
        ("2*time", r"column 3: found 'time', the time is t"),
        ("abs(t)", "has kinks .* expected a smooth expression"),
        ("if(t > 1, t, 1)", "has kinks"),
        ("*".join(f"sin({k}*t)" for k in range(1, 300)), "expected a shorter one"),
        ("*".join(f"sin({k}*t)" for k in range(1, 600)), "more than 512 intermediate values"),
        ([1], "expected an expression of t, inputs, states, coordinates of joints in rad"),
    ],
    ids=["multiplication", "time", "abs", "if", "derivatives", "long", "list"],
)
def test_mistakes_are_errors_of_the_scene(law: Any, message: str) -> None:
    with pytest.raises(gelenk.SceneError, match=r"(?s)constraints\.swing\.law.*" + message):
        gelenk.load(swung(law))


@pytest.mark.parametrize("law", ["log(t)", "sqrt(t)", "t^1.5 + 0*t"])
def test_motion_that_cannot_start_is_refused(law: str) -> None:
    """At t = 0, log and sqrt have no finite speed, t^1.5 no finite acceleration; at t = 1 s they start."""
    plant = gelenk.Simulation(swung(law))
    with pytest.raises(gelenk.SceneError, match=r"constraints\.swing: found no finite .* at t = 0 s"):
        plant.initialize()
    plant.initialize(1.0)
    plant.step_to(1.5)
    assert math.isfinite(plant.output("A.phi"))


@pytest.mark.parametrize("integrator", ["auto", "rk4", "ida"])
def test_motion_that_ends_ends_the_run(integrator: str) -> None:
    plant = gelenk.Simulation(swung("sqrt(1 - t)", integrator=integrator, step=1e-3))
    plant.initialize()
    plant.step_to(0.5)
    with pytest.raises(gelenk.StepError):
        plant.step_to(1.5)
    assert plant.time == 0.5
