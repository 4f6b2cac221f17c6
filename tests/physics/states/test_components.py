# SPDX-License-Identifier: BSD-3-Clause
"""Components: against the same by hand, closed forms, their limits, and what every component obeys."""

from __future__ import annotations

import copy
import json
import math

import numpy as np
import pytest
from circuits import values
from mechanisms import four_bar

import gelenk
from gelenk import _core

from .component_kinds import HAND, KINDS, OF_SLIDES, START, by_hand, plant, with_component


def motion(kind: str) -> list[str]:
    return ["axle.s", "axle.v", "axle.a"] if kind in OF_SLIDES else ["axle.phi", "axle.w", "axle.a"]


def test_every_kind_is_here() -> None:
    registered = {kind["name"] for kind in _core.elements.kinds()["components"]}
    assert registered == set(KINDS) == set(HAND)


@pytest.mark.parametrize("integrator", ["erk", "auto"])
@pytest.mark.parametrize("kind", KINDS)
def test_is_the_same_as_by_hand(kind: str, integrator: str) -> None:
    solver = {"integrator": integrator}
    times = [0.05, 0.2, 0.5, 1.0]
    states, expressions, _ = HAND[kind]
    own = [name for name in (*states, *expressions) if name not in ("out", "spring", "pull")]
    found = values(
        with_component(kind, solver=solver), motion(kind) + [f"M.{n.rstrip('_')}" for n in own], times, 1e-9
    )
    expected = values(by_hand(kind) | {"solver": solver}, motion(kind) + own, times, 1e-9)
    scale = np.abs(expected).max(axis=0) + 1e-9
    assert (np.abs(found - expected) / scale).max() < 1e-7  # tolerances, of steps that differ by rounding


@pytest.mark.parametrize("kind", KINDS)
def test_signals_that_are_not_given_are_inputs(kind: str) -> None:
    """They act as the same signal given as an expression of an input does."""
    fields = dict(KINDS[kind])
    signals = [
        field["name"]
        for one in _core.elements.kinds()["components"]
        if one["name"] == kind
        for field in one["fields"]
        if field["type"] == "formula" and field["name"] not in ("feedforward", "target_speed")
    ]
    for name in signals:
        fields.pop(name)
    source = plant(kind, components={"M": {"type": kind, **fields}})
    given = plant(
        kind,
        inputs={f"in_{name}": {} for name in signals} | {"u": {"start": START}},
        components={"M": {"type": kind, **fields, **{name: f"in_{name}" for name in signals}}},
    )
    size = 1e-5 if kind in OF_SLIDES else 0.7
    runs = []
    for one, inputs in ((source, [f"M.{n}" for n in signals]), (given, [f"in_{n}" for n in signals])):
        simulation = gelenk.Simulation(gelenk.load(one))
        for name in inputs:
            simulation.set_input(name, size)
        simulation.initialize(0.0, 1e-9)
        simulation.step_to(0.3)
        runs.append([simulation.output(name) for name in motion(kind)])
    assert signals or kind in ("maxwell", "line_maxwell")
    np.testing.assert_allclose(runs[0], runs[1], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kind", [k for k in KINDS if "joint" in KINDS[k] and k not in OF_SLIDES])
def test_acts_in_a_loop_as_by_hand(kind: str) -> None:
    source = four_bar(1.1)
    source.pop("motors", None)
    hand = copy.deepcopy(source)
    inputs = {"inputs": {"u": {"start": START}}}
    fields = {**KINDS[kind], "joint": "A"}
    fields.pop("rotor_inertia", None) if kind != "series_elastic_drive" else None
    source |= inputs | {"components": {"M": {"type": kind, **fields}}}
    states, expressions, effort = HAND[kind]
    text = json.dumps([states, expressions, effort]).replace("axle.", "A.")
    states, expressions, effort = json.loads(text)
    hand |= inputs | {"states": states, "expressions": expressions}
    hand["joints"]["A"]["law"] = {"effort": effort}
    names, times = ["A.phi", "A.w", "C.phi", "C.w"], [0.1, 0.3]
    found, expected = (values(one, names, times, 1e-9) for one in (source, hand))
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-7)


def test_rotor_inertia_is_reflected() -> None:
    """J = 0.05 + 2^2 * 0.01 about the axis, without current."""
    fields = KINDS["dc_motor"] | {"voltage": "0.8*w", "start": {"i": 0.0}, "current_limit": 100.0}
    source = plant("dc_motor", components={"M": {"type": "dc_motor", **fields}})
    source["joints"]["axle"]["start"] = {"w": 2.0}
    w = values(source, ["axle.w"], [1.0], 1e-10)[0, 0]
    assert w == pytest.approx(2 * math.exp(-0.02 / 0.09), rel=1e-8)


@pytest.mark.parametrize("voltage", ["24", "24*sign(sin(9*t))", "24 + 0*w"])
@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida"])
def test_limited_current_never_passes_its_limit(voltage: str, integrator: str) -> None:
    """Stalled, 24 V would drive 20 A."""
    fields = {"joint": "axle", "voltage": voltage, "resistance": 1.2, "inductance": 0.005, "constant": 0.4}
    source = plant(
        "dc_motor",
        components={"M": {"type": "dc_motor", "current_limit": 3.0, **fields}},
        solver={"integrator": integrator},
    )
    result = gelenk.simulate(source, stop=2.0, step=0.01, tolerance=1e-7)
    assert np.abs(result["M.i"]).max() <= 3 * (1 + 1e-6)
    assert np.abs(result["M.i"]).max() > 2.9


def test_map_of_an_engine() -> None:
    """At 30 rad/s and half throttle between the points of a bilinear map, in equilibrium with the load."""
    source = plant(
        "engine",
        tables={"map": {"x": [0, 60], "y": [0, 1], "values": [[0, 40], [0, 20]], "interpolation": "linear"}},
        inputs={"throttle": {"start": 0.5}},
        components={
            "M": {
                "type": "engine",
                "joint": "axle",
                "torque": "table(map, w, throttle)",
                "time_constant": 0.05,
            },
            "load": {"type": "engine", "joint": "axle", "torque": "-0.48*w"},
        },
    )
    result = gelenk.simulate(source, stop=5.0, tolerance=1e-9)
    assert result["axle.w"][-1] == pytest.approx(30, rel=1e-6)  # 20 - w/6 = (0.48 + 0.02) w
    assert result["M.tau"][-1] == pytest.approx(15, rel=1e-6)
    assert result["load.tau"][-1] == pytest.approx(-14.4, rel=1e-6)


def test_anti_windup_is_two_events_and_prevents_an_overshoot() -> None:
    """A step of the target that takes the limit: without leading back, the integral overshoots."""
    overshoots = []
    for tracking in (0.05, 1e6):
        servo = {
            "type": "speed_servo",
            "joint": "axle",
            "target": "10",
            "gain": 0.3,
            "reset_time": 0.3,
            "limit": 0.4,
        }
        source = plant("speed_servo", components={"M": servo | {"tracking_time": tracking}})
        simulation = gelenk.Simulation(gelenk.load(source))
        simulation.initialize(0.0, 1e-8)
        most = 0.0
        for k in range(2000):
            simulation.step_to(0.01 * (k + 1))
            most = max(most, simulation.output("axle.w"))
        overshoots.append(most - 10)
        assert simulation.output("axle.w") == pytest.approx(10, rel=1e-5)
        assert abs(simulation.output("M.tau") - 0.2) < 1e-5
    assert overshoots[0] < 0.2 * overshoots[1]


def test_components_name_each_other_and_their_numbers() -> None:
    """A motor at a constant current warms its winding: T' = (R i^2 - T/Rth)/C."""
    source = plant(
        "dc_motor",
        components={
            "M": {
                "type": "dc_motor",
                "joint": "axle",
                "voltage": "M.emf + 2*M.resistance",
                "resistance": 1.5,
                "inductance": 0.01,
                "constant": 0.01,
                "start": {"i": 2.0},
            },
            "winding": {
                "type": "thermal_mass",
                "heat": "M.loss",
                "capacity": 10,
                "resistance": 2.0,
                "ambient_temperature": 0,
                "start": {"temperature": 0},
            },
            "shown": {"type": "first_order", "input": "winding.temperature", "time_constant": 1e-4},
        },
        expressions={"heated": "winding.capacity*winding.temperature"},
    )
    names = ["M.i", "winding.temperature", "heated", "shown.y"]
    current, warm, heated, shown = values(source, names, [5.0], 1e-10)[0]
    expected = 2 * 6 * (1 - math.exp(-5 / 20))
    assert current == pytest.approx(2, rel=1e-9)
    assert warm == pytest.approx(expected, rel=1e-8)
    assert heated == pytest.approx(10 * expected, rel=1e-8)
    assert shown == pytest.approx(expected, rel=1e-3)


MISTAKES = {
    "a prismatic joint for a chamber": (
        {"type": "pneumatic_chamber", "joint": "axle", "area": 1, "volume": 1},
        "axle",
    ),
    "no joint": ({"type": "dc_motor", "resistance": 1, "inductance": 1, "constant": 1}, "joint"),
    "an unknown kind": ({"type": "dcmotor", "joint": "axle"}, "dc_motor"),
    "no inductance": (
        {"type": "dc_motor", "joint": "axle", "resistance": 1, "inductance": 0, "constant": 1},
        "inductance",
    ),
    "an unknown name": (
        {"type": "first_order", "input": "speed_of_axle", "time_constant": 1},
        "speed_of_axle",
    ),
    "a misspelled output": ({"type": "first_order", "input": "M.yy", "time_constant": 1}, "M.y"),
    "a circle": (
        {
            "type": "dc_motor",
            "joint": "axle",
            "voltage": "M.power",
            "resistance": 1,
            "inductance": 1,
            "constant": 1,
        },
        "circle",
    ),
    "a start of no state": (
        {"type": "first_order", "input": "u", "time_constant": 1, "start": {"x": 1}},
        "expected y",
    ),
    "a start that is no mapping": (
        {"type": "first_order", "input": "u", "time_constant": 1, "start": 1},
        "a mapping from states to their start values",
    ),
    "a negative limit": (
        {"type": "speed_servo", "joint": "axle", "gain": 1, "limit": -1},
        "limit",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_answered(mistake: str) -> None:
    component, told = MISTAKES[mistake]
    source = plant("dc_motor", components={"M": component})
    with pytest.raises(gelenk.SceneError) as error:
        gelenk.load(source)
    assert "components.M" in str(error.value)
    assert told in str(error.value)


def test_a_component_whose_outputs_are_not_wanted_is_left_out() -> None:
    source = plant("dc_motor")
    source["bodies"]["other"] = copy.deepcopy(source["bodies"]["rotor"])
    source["joints"]["second"] = source["joints"]["axle"] | {"child": "other"}
    source["components"] = {
        name: {"type": "dc_motor", **KINDS["dc_motor"], "joint": at}
        for name, at in (("one", "axle"), ("two", "second"))
    }
    source["outputs"] = ["one.i"]
    result = gelenk.simulate(source, stop=0.3)
    assert result.names == ("one.i",)
    whole = {key: value for key, value in source.items() if key != "outputs"}
    assert np.array_equal(result["one.i"], gelenk.simulate(whole, stop=0.3)["one.i"])
