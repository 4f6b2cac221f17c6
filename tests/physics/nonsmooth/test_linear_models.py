# SPDX-License-Identifier: BSD-3-Clause
"""Linear models with joint friction and limits: what rests is locked, what slips has a constant friction."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene
from models.running import assert_close

import gelenk

from .test_joint_friction import four_bar_with_friction, wheel

# Exact derivatives: some tens of operations on numbers about 1.
ROUNDING = 1e-13


def clutch(**start: float) -> Scene:
    """Two inertias of 0.5 and 2 kg m2 with friction between them, and a motor on the first."""
    return scene(
        {"one": body(1, inertia=(0, 0, 0.5)), "two": body(1, inertia=(0, 0, 2.0))},
        {
            "one": joint("revolute", frame("ground"), frame("one"), damping=0.1),
            "clutch": joint(
                "revolute",
                frame("one"),
                frame("two"),
                friction={"coulomb": 5.0, "static": 6.0, "stribeck": 0.5},
                start=start,
            ),
        },
        motors={"engine": {"joint": "one"}},
    )


def model(source: Scene, **arguments: Any) -> gelenk.linear.LinearModel:
    return gelenk.linear.linear_model(gelenk.load(source), **arguments)


def test_a_locked_clutch_joins_two_inertias() -> None:
    """The clutch is not among the states, and its torque depends on nothing but the motor."""
    found = model(clutch(), input_values={"engine.tau": 1.0})
    assert found.states == ("one.phi", "one.w")
    assert_close("A", found.A, [[0, 1], [0, -0.1 / 2.5]], ROUNDING, "rounding")
    assert_close("B", found.B, [[0], [1 / 2.5]], ROUNDING, "rounding")
    row = found.outputs.index("clutch.w")
    assert not found.C[row].any()
    assert found.friction == "present"


def test_a_slipping_clutch_has_the_slope_of_its_friction() -> None:
    """The torque between the inertias changes with the slip by Stribeck's curve alone."""
    slip = 0.3
    found = model(clutch(w=slip))
    slope = -(6.0 - 5.0) * 2 * slip / 0.5**2 * math.exp(-((slip / 0.5) ** 2))  # d magnitude / d slip
    assert found.states == ("one.phi", "clutch.phi", "one.w", "clutch.w")
    to_one = slope / 0.5
    to_slip = -slope * (1 / 0.5 + 1 / 2.0)
    A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, -0.1 / 0.5, to_one], [0, 0, 0.1 / 0.5, to_slip]]
    assert_close("A", found.A, A, ROUNDING, "rounding")
    assert_close("B", found.B, [[0], [0], [1 / 0.5], [-1 / 0.5]], ROUNDING, "rounding")


@pytest.mark.parametrize("friction", ["sliding", "off"])
def test_friction_can_be_left_out(friction: str) -> None:
    """At rest, sliding friction is a constant, of which the derivatives are 0."""
    found = model(clutch(), friction=friction)
    assert found.friction == friction
    assert_close("B", found.B, [[0], [0], [1 / 0.5], [-1 / 0.5]], ROUNDING, "rounding")


def test_friction_can_be_locked_in_motion() -> None:
    found = model(clutch(w=0.3), friction="locked")
    assert found.states == ("one.phi", "one.w")
    assert_close("B", found.B, [[0], [1 / 2.5]], ROUNDING, "rounding")


def test_a_linkage_at_rest_has_no_states() -> None:
    source = four_bar_with_friction()
    del source["gravity"]
    source["joints"]["A"]["start"]["w"] = 0.0
    found = model(source)
    assert found.states == ()
    assert model(source, friction="off").states == ("A.phi", "A.w")


@pytest.mark.parametrize("joint", ["A", "B", "C", "D"])
def test_friction_of_any_joint_locks_a_linkage(joint: str, tmp_path: Path) -> None:
    """Also of those whose coordinates are no states, through the loop."""
    source = four_bar_with_friction()
    del source["gravity"]
    source["joints"]["A"]["start"]["w"] = 0.0
    for other in {"A", "B", "C", "D"} - {joint}:
        del source["joints"][other]["friction"]
    assert model(source).states == ()
    fmu = gelenk.export_fmu(gelenk.load(source), tmp_path / "locked.fmu")
    assert gelenk.linear.linear_model(fmu).states == ()


def test_contact_locks_too() -> None:
    source = wheel({"coulomb": 1.0}, phi=0.5, w=0.0)
    source["joints"]["J"] |= {"limit": {"upper": 0.5}}
    del source["joints"]["J"]["friction"]
    found = model(source, input_values={"drive.tau": 1.0})
    assert found.states == ()
    row = found.outputs.index("J.a")
    assert not found.D[row].any()


@pytest.mark.parametrize("torque", [1.0, -1.0])
def test_the_boundary_of_two_modes_has_no_derivatives(torque: float) -> None:
    """Exactly at the limit of friction."""
    with pytest.raises(gelenk.UsageError, match=r"joints.J.friction is between two modes"):
        model(wheel({"coulomb": 1.0}, phi=0.0, w=0.0), input_values={"drive.tau": torque})
    assert model(wheel({"coulomb": 1.0}, phi=0.0, w=0.0), input_values={"drive.tau": 0.99}).states == ()


def test_a_limit_that_is_touched_without_a_force_has_no_derivatives() -> None:
    source = wheel({"coulomb": 1.0}, phi=0.5, w=0.0)
    source["joints"]["J"] |= {"limit": {"upper": 0.5}}
    del source["joints"]["J"]["friction"]
    with pytest.raises(gelenk.UsageError, match=r"joints.J.limit is between two modes"):
        model(source, input_values={"drive.tau": 0.0})


def test_unknown_treatment_is_refused() -> None:
    with pytest.raises(gelenk.UsageError, match=r"friction: found 'none', expected one of present, locked"):
        model(clutch(), friction="none")


def test_an_fmu_gives_the_same_model(tmp_path: Path) -> None:
    """In the present mode; other treatments of friction require the scene."""
    fmu = gelenk.export_fmu(gelenk.load(clutch()), tmp_path / "Clutch.fmu")
    found = gelenk.linear.linear_model(fmu, input_values={"engine.tau": 1.0})
    expected = model(clutch(), input_values={"engine.tau": 1.0})
    assert found.states == expected.states
    assert_close("A", found.A, expected.A, ROUNDING, "rounding")
    assert_close("B", found.B, expected.B, ROUNDING, "rounding")
    with pytest.raises(gelenk.UsageError, match="friction: found 'locked' with an FMU, expected 'present'"):
        gelenk.linear.linear_model(fmu, friction="locked")


def test_accelerations_change_as_the_model_says() -> None:
    """Differences of the outputs of the locked clutch in another torque of the motor."""
    plant = gelenk.Simulation(gelenk.load(clutch()))
    plant.initialize()
    rates = []
    for torque in (1.0, 1.5):
        plant.set_input("engine.tau", torque)
        rates.append(np.array([plant.output("one.a"), plant.output("clutch.a")]))
    found = model(clutch(), input_values={"engine.tau": 1.0}, outputs=["one.a", "clutch.a"])
    assert_close("D", found.D[:, 0], (rates[1] - rates[0]) / 0.5, ROUNDING, "a linear equation")
