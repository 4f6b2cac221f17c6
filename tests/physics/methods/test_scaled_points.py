# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria, trims, steady motions, linear models and their warnings do not
depend on the size and mass of a mechanism.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, four_bar, frame, joint, scene
from models.scaled import scaled, size

import gelenk
from gelenk.chart import mechanisms
from gelenk.linear import LinearModel, linear_model
from physics.analysis.test_steady_motion import conical

pytestmark = warned.GRAVITY

SIZES = [(1e-6, 1.0), (1e-6, 1e-12), (1e-3, 1e6), (1e3, 1e-6), (1e6, 1e6)]  # scales of lengths and masses
# Newton's method converges to round-off, 1e-15 divided by a derivative at worst a thousandth of the largest.
CLOSE = 1e-11
UNITS = {"phi": "rad", "w": "rad/s", "s": "m", "v": "m/s"}


def cart_on_incline() -> Scene:
    """A cart-pole on a track inclined by 0.2 rad: a horizontal force is needed to hold it."""
    source = gelenk.load(mechanisms.shipped("cart_pole")).to_dict()
    source["gravity"] = [-GRAVITY * math.sin(0.2), 0, -GRAVITY * math.cos(0.2)]
    return source


def sprung_slider() -> Scene:
    """A mass on an incline held by a spring; its equilibrium depends on gravity."""
    return scene(
        {"block": body(2.0)},
        {"J": joint("prismatic", frame("ground"), frame("block", (0, 0, 0.2)), axis=[1, 0, 0.3],
                    stiffness=300.0, spring_reference=0.1, start={"s": 0.4})},
        gravity=[0, 0, -GRAVITY], motors={"push": {"joint": "J"}}, name="Sprung",
    )  # fmt: skip


def hanging_four_bar() -> Scene:
    out = four_bar(1.1)
    out["joints"]["D"] |= {"stiffness": 15.0, "spring_reference": 1.0}
    return out


CASES: dict[str, tuple[Callable[[], Scene], dict[str, Any]]] = {
    "block on a spring": (sprung_slider, {}),
    "four-bar with a spring": (hanging_four_bar, {}),
    "cart on a slope": (cart_on_incline, {"hold": {"track.s": 0.3}, "solve_for": ["drive.f"]}),
    "crank held by its motor": (
        lambda: gelenk.load(mechanisms.shipped("slider_crank")).to_dict(),
        {"hold": {"cylinder.s": 1.1}, "solve_for": ["starter.tau"]},
    ),
    "conical pendulum": (conical, {"steady": {"S.w": 5.0}, "at": {"H.phi": 0.6}}),
}


def sized(arguments: dict[str, Any], length: float) -> dict[str, Any]:
    out = {}
    for key, given in arguments.items():
        if isinstance(given, dict):
            given = {n: x * size(UNITS[n.partition(".")[2]], length, 1.0) for n, x in given.items()}
        out[key] = given
    return out


def assert_same(
    found: dict[str, float], expected: dict[str, float], units: dict[str, str], scales: Any
) -> None:
    """Compare relative to the largest value of the same unit."""
    largest: dict[str, float] = {}
    for name, value in expected.items():
        floor = 1.0 if units[name].endswith("s2") else 1e-3  # accelerations are only round-off
        largest[units[name]] = max(largest.get(units[name], floor), abs(value))
    for name, value in expected.items():
        there = found[name] / size(units[name], *scales)
        assert abs(there - value) <= CLOSE * largest[units[name]], (name, there, value)


@pytest.mark.parametrize("scales", SIZES)
@pytest.mark.parametrize("case", CASES)
def test_equilibria_do_not_depend_on_scale(case: str, scales: tuple[float, float], tmp_path: Path) -> None:
    """Equilibria of a scene and of its FMU; the model can be linearized about both without a warning."""
    make, arguments = CASES[case]
    expected = gelenk.equilibrium(make(), **arguments)
    units = dict(expected.units)
    source = scaled(gelenk.load(make()).to_dict(), *scales)
    given = sized(arguments, scales[0])
    fmu = gelenk.export_fmu(source, tmp_path / "x.fmu")
    for plant in (source, fmu):
        found = gelenk.equilibrium(plant, **given)
        assert_same(dict(found.values), dict(expected.values), units, scales)
        assert_same(dict(found.inputs), dict(expected.inputs), units, scales)
        assert list(found.advancing) == list(expected.advancing)
        with warnings.catch_warnings():
            warnings.simplefilter("error", gelenk.OperatingPointWarning)
            gelenk.linearize(plant, at=found.at)


def in_units_of_the_original(model: LinearModel, scales: tuple[float, float]) -> list[Any]:
    x, u, y = (
        np.array([size(model.units[n], *scales) for n in names])
        for names in (model.states, model.inputs, model.outputs)
    )
    return [
        model.A * x / x[:, None],
        model.B * u / x[:, None],
        model.C * x / y[:, None],
        model.D * u / y[:, None],
        model.rates / x,
    ]


@pytest.mark.parametrize("scales", SIZES)
@pytest.mark.parametrize("off", [0.0, 1e-6])
@pytest.mark.parametrize("case", CASES)
def test_linear_models_and_warnings_do_not_depend_on_scale(
    case: str, off: float, scales: tuple[float, float]
) -> None:
    """At an equilibrium, and displaced from it by a millionth of the mechanism's size,
    where a warning is given.
    """
    make, arguments = CASES[case]
    at = dict(gelenk.equilibrium(make(), **arguments).at)
    exact = linear_model(make(), at=at)
    beside = (
        "cylinder.s_start"
        if "cylinder.s_start" in at
        else f"{exact.states[len(exact.states) // 2 - 1]}_start"
    )
    at[beside] = float(at[beside]) + off
    expected = linear_model(make(), at=at)
    moved = dict(at)
    for name in [name for name, value in at.items() if name.endswith("_start")]:
        unit = UNITS[name.rpartition(".")[2].removesuffix("_start")]
        moved[name] = float(at[name]) * size(unit, scales[0], 1.0)
    units = expected.units
    moved |= {n: float(at[n]) * size(units[n], *scales) for n in expected.inputs if n in at}
    found = linear_model(scaled(gelenk.load(make()).to_dict(), *scales), at=moved, states=expected.states)
    for mine, there in zip(
        in_units_of_the_original(expected, (1.0, 1.0)), in_units_of_the_original(found, scales), strict=True
    ):
        assert np.abs(mine - there).max(initial=0.0) <= 1e-10 * (1 + np.abs(mine).max(initial=0.0))
    assert bool(expected.residual_rates) == bool(found.residual_rates) == (off > 0)
    # The same states are named.
    names = [[n for n in m.states if f"{n} changes" in m.residual_rates] for m in (expected, found)]
    assert names[0] == names[1]


@pytest.mark.parametrize("stiffness", [1e4, 1e9])
def test_round_off_of_stiff_springs_is_not_taken_for_motion(stiffness: float) -> None:
    """A pendulum beside a mass on a spring: x = m g / k for any k, and the pendulum hangs down."""
    source = scene(
        {"block": body(2.0), "bob": body(0.5, (0, 0, -0.4))},
        {"J": joint("prismatic", frame("ground"), frame("block"), axis=[0, 0, 1], stiffness=stiffness,
                    spring_reference=0.7),
         "H": joint("revolute", frame("block"), frame("bob"), axis=[0, 1, 0], start={"phi": 0.4})},
        gravity=[0, 0, -GRAVITY], name="Stiff",
    )  # fmt: skip
    found = gelenk.equilibrium(source)
    assert found.values["J.s"] == pytest.approx(0.7 - 2.5 * GRAVITY / stiffness, rel=1e-14)
    assert found.values["H.phi"] == pytest.approx(0, abs=1e-12)
    assert not linear_model(source, at=found.at).residual_rates


@pytest.mark.parametrize("length", [1e-8, 1e4])
def test_rest_is_judged_by_gravity_over_length(length: float, tmp_path: Path) -> None:
    """A pendulum of 10 nm oscillates at 5 kHz, and the round-off of its accelerations is 1e-7 1/s2; one of 10
    km, displaced by a millionth of a radian, accelerates at 1e-9 1/s2.
    """
    moment = 1e-20 * length**2
    source = scene(
        {"bob": body(1e-18, (0, 0, -length), (moment, moment, moment))},
        {"H": joint("revolute", frame("ground"), frame("bob"), axis=[0, 1, 0], start={"phi": 0.4})},
        gravity=[0, 0, -GRAVITY], motors={"drive": {"joint": "H"}}, name="Pendulum",
    )  # fmt: skip
    torque = 0.3 * 1e-18 * GRAVITY * length
    for plant in (source, gelenk.export_fmu(source, tmp_path / "x.fmu")):
        found = gelenk.equilibrium(plant, input_values={"drive.tau": torque})
        assert found.values["H.phi"] == pytest.approx(math.asin(0.3), rel=1e-13)
        assert not linear_model(plant, at=found.at).residual_rates
        beside = linear_model(plant, at={**found.at, "H.phi_start": found.values["H.phi"] + 1e-6})
        assert "H.w changes" in beside.residual_rates


@warned.GUESSES
@pytest.mark.parametrize("weights", [{}, {"main": 3.0, "cylinder": 2.0}, {"main": 1.0, "cylinder": 1.0}])
@pytest.mark.parametrize("length", [2.0**-20, 2.0**20])
def test_weights_are_relative_to_the_size_of_the_mechanism(weights: dict[str, float], length: float) -> None:
    """Conflicting initial guesses give the same angle for any size; a weight of 1 is the default.
    The largest length is 0.9 m: in units of powers of two the scene and its copies are equal.
    """

    def crank(given: dict[str, float], factor: float) -> float:
        source = scaled(gelenk.load(mechanisms.shipped("slider_crank")).to_dict(), 1.0, 1.0)
        for name, start in (("main", {"phi": 0.7}), ("cylinder", {"s": 0.95})):
            source["joints"][name]["start"] = start | ({"weight": given[name]} if name in given else {})
        plant = gelenk.Simulation(gelenk.load(scaled(source, factor, 1.0)))
        plant.initialize(0.0)
        return float(plant.output("main.phi"))

    found = crank(weights, length)
    assert found == pytest.approx(crank(weights, 1.0), rel=1e-12)
    if set(weights.values()) == {1.0}:
        assert found == pytest.approx(crank({}, 1.0), rel=1e-12)
    assert abs(found - 0.7) > 1e-3  # the guesses contradict each other
