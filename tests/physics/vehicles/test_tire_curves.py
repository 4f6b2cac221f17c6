# SPDX-License-Identifier: BSD-3-Clause
"""Tires whose forces are expressions of the slips: against the Magic Formula and linear tires."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warned
from models.tires import LAT, LONG, RADIUS, rig

import gelenk

OF_NUMBERS = ("slip_stiffness", "cornering_stiffness", "friction_long", "shape_long", "curvature_long",
              "friction_lat", "shape_lat", "curvature_lat")  # fmt: skip


def formula(x: str, B: float, C: float, D: float, E: float) -> str:
    return f"{D}*tire_load*sin({C}*atan({B}*{x} - {E}*({B}*{x} - atan({B}*{x}))))"


def curves(velocity: tuple[float, float], spin: float, **changes: Any) -> dict[str, Any]:
    """The rig with the Magic Formula of each pure slip as expressions."""
    scene = rig(velocity, spin)
    tire = {key: value for key, value in scene["forces"]["tire"].items() if key not in OF_NUMBERS}
    laws = {"force_long": formula("tire_slip", *LONG), "force_lat": "-" + formula("tan(tire_angle)", *LAT)}
    scene["forces"]["tire"] = tire | laws | changes
    return scene


def outputs(scene: dict[str, Any], end: float = 0.0) -> list[float]:
    plant = gelenk.Simulation(gelenk.load(scene))
    plant.initialize(0.0, 1e-9)
    if end > 0:
        plant.step_to(end)
    return [plant.output(f"tire.{name}") for name in ("f_n", "f_long", "f_lat", "slip", "slip_angle", "tau")]


@pytest.mark.parametrize("slip", [-0.6, -0.05, 1e-3, 0.08, 0.5])
def test_longitudinal_slip_is_as_by_numbers(slip: float) -> None:
    spin = 20 * (1 + slip) / RADIUS
    for end in (0.0, 0.2):
        found, expected = (outputs(make((20.0, 0.0), spin), end) for make in (curves, rig))
        assert found == pytest.approx(expected, rel=1e-7 if end else 1e-12, abs=1e-4 if end else 1e-8)


@pytest.mark.parametrize("side", [-3.0, 0.2, 5.0])
def test_lateral_slip_is_as_by_numbers(side: float) -> None:
    found, expected = (outputs(make((20.0, side), 20 / RADIUS)) for make in (curves, rig))
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-8)


@warned.MOVING
def test_linear_model_is_that_of_numbers() -> None:
    scenes = [make((20.0, 0.0), 20.0 / RADIUS) for make in (curves, rig)]
    found, expected = (gelenk.linearize(one, friction="present") for one in scenes)
    np.testing.assert_allclose(found.A, expected.A, rtol=1e-10, atol=1e-10)


def test_table_of_the_slip() -> None:
    scene = curves(
        (20.0, 0.0), 22 / RADIUS,
        force_long="tire_load*table(mu, tire_slip)", force_lat="-5e4*tire_angle",
    )  # fmt: skip
    scene["tables"] = {
        "mu": {"x": [-1, -0.1, 0, 0.1, 1], "values": [-0.7, -1, 0, 1, 0.7], "interpolation": "linear"}
    }
    f_n, f_long, *_ = outputs(scene)
    assert f_long == pytest.approx(f_n * 1.0, rel=1e-12)  # a slip of 0.1


def test_limit_of_a_curve_is_an_event() -> None:
    """A wheel that spins up by its drive passes the end of the linear range."""
    scene = curves(
        (20.0, 0.0), 20 / RADIUS, force_long="1e4*clip(tire_slip, -0.02, 0.02)", force_lat="-5e4*tire_angle"
    )
    scene["joints"]["hub"]["law"] = {"effort": "300"}
    result = gelenk.Simulation(gelenk.load(scene))
    result.initialize(0.0, 1e-8)
    result.step_to(0.5)
    assert result.output("tire.slip") > 0.02
    assert result.output("tire.f_long") == pytest.approx(200, rel=1e-12)
    assert result.diagnostic("solver.events") == 1


def test_lifted_wheel_has_no_force() -> None:
    scene = curves(
        (20.0, 1.0),
        22 / RADIUS,
        load=0,
        stiffness=2e5,
        force_long="1000*tire_slip",
        force_lat="-1000*tire_angle",
    )
    scene["joints"]["road"]["parent"]["position"] = [0, 0, RADIUS + 0.01]
    assert outputs(scene)[:3] == [0, 0, 0]
    scene["joints"]["road"]["parent"]["position"] = [0, 0, RADIUS - 0.01]
    f_n, f_long, _, slip, *_ = outputs(scene)
    assert [f_n, f_long] == pytest.approx([2000, 1000 * slip], rel=1e-12)


MISTAKES: dict[str, tuple[dict[str, Any], str]] = {
    "no lateral force": ({"force_lat": None}, "force_lat: found nothing"),
    "friction beside": ({"friction_long": 1.0, "friction_lat": 1.0}, "one of them"),
    "an unknown name": ({"force_long": "1000*kappa"}, "kappa"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_answered(mistake: str) -> None:
    changes, told = MISTAKES[mistake]
    scene = curves((20.0, 0.0), 20 / RADIUS, **changes)
    scene["forces"]["tire"] = {
        key: value for key, value in scene["forces"]["tire"].items() if value is not None
    }
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.load(scene)
    assert "forces.tire" in str(error.value)
    assert told in str(error.value)
