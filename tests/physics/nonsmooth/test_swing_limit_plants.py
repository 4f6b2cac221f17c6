# SPDX-License-Identifier: BSD-3-Clause
"""Ball joints with a limit of their swing: saved states, FMUs, linear models, equilibria, files, errors."""

from __future__ import annotations

import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import warned

import gelenk
from gelenk.io import export

from .test_swing_limits import ARM, MASS, G, Source, pendulum

pytestmark = [warned.GUESSES, warned.TIGHT]


@pytest.mark.parametrize("integrator", ["erk", "dirk", "ida", "moreau-jean"])
def test_restored_to_the_bit(integrator: str) -> None:
    source = pendulum(0.6, restitution=0.4, angle=0.3, axis=[1, 2, 0], w=[2.5, 4.0, 3.0])
    source["solver"] = {"integrator": integrator}
    names = ["J.Q[1]", "J.Q[4]", "J.w[1]", "J.w[2]", "J.w[3]", "J.limit.tau", "J.limit.mode"]
    plant = gelenk.Simulation(source)
    plant.initialize(0, 1e-8)
    states, values = [], []
    for k in range(60):
        states.append(plant.save())
        plant.step_to(0.02 * (k + 1))
        values.append(plant.values(names))
    for k in (50, 3, 20, 59, 0):
        plant.restore(states[k])
        plant.step_to(0.02 * (k + 1))
        assert np.array_equal(plant.values(names), values[k])


def test_as_an_fmu(tmp_path: Path) -> None:
    source = pendulum(0.6, restitution=0.4, angle=0.3, axis=[1, 2, 0], w=[2.5, 4.0, 3.0])
    source["parameters"] = ["J.limit.swing", "J.limit.restitution"]
    path = tmp_path / "cone.fmu"
    gelenk.export_fmu(gelenk.load(source), path)
    changed = {"J.limit.swing": 0.5, "J.limit.restitution": 0.8}
    found = gelenk.simulate(path, stop=1.0, step=0.01, tolerance=1e-8, parameters=changed)
    source["joints"]["J"]["limit"] = {"swing": 0.5, "restitution": 0.8}
    expected = gelenk.simulate(source, stop=1.0, step=0.01, tolerance=1e-8)
    for name in ("J.Q[1]", "J.w[2]", "J.limit.tau", "J.limit.mode"):
        assert np.array_equal(found[name], expected[name])


def test_linear_model_on_the_cone() -> None:
    """Upright and pressed against the cone, the rod turns about the vertical and about itself freely."""
    source = pendulum(0.4, angle=0.4, gravity=+G)
    model = gelenk.linearize(source)
    assert model.nstates == 4
    assert np.abs(np.linalg.eigvals(model.A)).max() < 1e-6
    assert gelenk.linearize(pendulum(0.4)).nstates == 6


def test_equilibria() -> None:
    """The cone holds a rod that is pressed against it, and is not known to the search."""
    source = pendulum(0.4, angle=0.4, gravity=+G)
    (point,) = gelenk.equilibrium(source, friction="present").contact_points
    assert point.contact == "J.limit"
    assert point.bodies == ("ground", "rod")
    assert point.normal == pytest.approx(MASS * G * ARM * math.sin(0.4), rel=1e-12)
    assert str(point).endswith(f"torque {point.normal:.6g} N m")
    source["gravity"] = [0, 0, -G]
    with pytest.raises(
        gelenk.EquilibriumError, match=r"joints\.J\.limit would have to pull with 1\.98\d* N m"
    ):
        gelenk.equilibrium(source, friction="present")
    found = gelenk.equilibrium(pendulum(0.4, angle=0.1))
    assert abs(found.values["J.Q[1]"]) < 1e-9
    source = pendulum(0.3, angle=-0.4)
    source["joints"]["J"]["limit"]["parent_axis"] = [0, math.sin(0.4), math.cos(0.4)]
    message = r"the one found has J at a swing of 0\.4 rad, beyond its limit of 0\.3 rad"
    with pytest.raises(gelenk.EquilibriumError, match=message):
        gelenk.equilibrium(source)


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ({"swing": 4.0}, r"joints\.J\.limit\.swing: found 4 rad, expected less than pi rad"),
        ({"swing": 0.0}, r"joints\.J\.limit\.swing: found 0 rad"),
        ({"restitution": 0.5}, r"joints\.J\.limit\.swing: found nothing"),
        ({"swing": 0.5, "restitution": 1.5}, r"joints\.J\.limit\.restitution: found 1\.5"),
        ({"swing": 0.5, "upper": 1}, r"joints\.J\.limit\.upper: found an unknown field"),
        ({"swing": 0.1}, r"joints\.J\.limit\.swing: found a start with a swing 0\.2 rad beyond it"),
    ],
)
def test_errors(limit: Source, message: str) -> None:
    source = pendulum(0.5, angle=0.3)
    source["joints"]["J"]["limit"] = limit
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.simulate(source, stop=0.1, step=0.1)


def test_needs_the_formulation_projection() -> None:
    source = pendulum(0.5)
    source["solver"] = {"formulation": "baumgarte", "integrator": "rk4"}
    with pytest.raises(
        gelenk.SceneError, match=r"'baumgarte' with joints\.J\.limit, expected the formulation projection"
    ):
        gelenk.load(source)


def test_file_and_schema(tmp_path: Path) -> None:
    source = pendulum(0.5, restitution=0.25)
    source["joints"]["J"]["limit"]["child_axis"] = [0, 0, 2]
    jsonschema.validate(source, json.loads(export.schema()))
    scene = gelenk.load(source)
    scene.save(tmp_path / "scene.yaml")
    again = gelenk.load(tmp_path / "scene.yaml").to_dict()["joints"]["J"]["limit"]
    assert again["swing"] == 0.5
    assert again["restitution"] == 0.25
    assert again["child_axis"] == [0, 0, 1]
    source["parameters"] = ["J.limit.swing"]
    scene = gelenk.load(source)
    assert scene.with_parameters({"J.limit.swing": 0.6}).to_dict()["joints"]["J"]["limit"]["swing"] == 0.6
    source["joints"]["J"]["limit"]["upper"] = 1
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(source, json.loads(export.schema()))
