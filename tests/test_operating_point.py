# SPDX-License-Identifier: BSD-3-Clause
"""gelenk.OperatingPoint: one object for what calls about a point take one by one."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk.linear import linear_model

# A motor turns the left arm for a while: all that a point may be made of.
MOVING: dict[str, Any] = {
    "at": 0.2,
    "input_values": {"motor_left.tau": ([0.0, 0.1, 0.2], [0.0, 0.2, 0.1])},
    "parameters": {"right.phi_start": 2.0},
    "tolerance": 1e-9,
}
HELD: dict[str, Any] = {"at": {"left.phi": 1.0}, "input_values": {"motor_left.tau": 0.1}}


@pytest.fixture
def five_bar(root: Path) -> Path:
    return root / "scenes" / "five_bar.yaml"


@pytest.fixture(params=["scene", "fmu"])
def source(request: pytest.FixtureRequest, five_bar: Path, tmp_path: Path) -> Path:
    return five_bar if request.param == "scene" else gelenk.export_fmu(five_bar, tmp_path / "x.fmu")


@pytest.mark.parametrize("given", [{}, MOVING, HELD], ids=["start", "moving", "held"])
def test_a_point_gives_the_numbers_that_its_parts_give(source: Path, given: dict[str, Any]) -> None:
    one_by_one = linear_model(source, **given)
    point = gelenk.OperatingPoint(source, **given)
    for _ in range(2):  # it is not used up
        found = linear_model(point)
        for matrix in ("A", "B", "C", "D", "x0", "u0", "y0", "rates"):
            assert np.array_equal(getattr(found, matrix), getattr(one_by_one, matrix))
        assert found.time == one_by_one.time == (0.2 if given is MOVING else 0.0)


@pytest.mark.filterwarnings("ignore::gelenk.OperatingPointWarning")
def test_all_that_ask_about_a_point_take_one(five_bar: Path) -> None:
    point = gelenk.OperatingPoint(five_bar, **HELD)
    states = ["right.phi", "left.phi"]
    plant, again = gelenk.linearize(point, states=states), gelenk.linearize(five_bar, **HELD, states=states)
    assert plant.state_labels == again.state_labels
    assert np.array_equal(plant.A, again.A)
    assert (
        gelenk.modes(point, states=states).to_dict()
        == gelenk.modes(five_bar, **HELD, states=states).to_dict()
    )
    motors = ["motor_left.tau", "motor_right.tau"]
    pose = {"left.phi": 1.0, "right.phi": 2.0}
    found, alike = (
        gelenk.equilibrium(source, hold=pose, solve_for=motors, **given)
        for source, given in ((point, {}), (five_bar, HELD))
    )
    assert found.to_dict() == alike.to_dict()
    assert found.values["left.phi"] == pytest.approx(1.0, abs=1e-12)  # attained exactly, to rounding


@pytest.mark.parametrize("call", [gelenk.linearize, linear_model, gelenk.modes, gelenk.equilibrium])
def test_a_point_has_its_own_arguments(call: Callable[..., Any], five_bar: Path) -> None:
    """Each of its fields is an argument of the call, with the same default, and is refused beside it."""
    point = gelenk.OperatingPoint(five_bar)
    known = inspect.signature(call).parameters
    fields = [field for field in dataclasses.fields(point) if field.name != "source"]
    taken = [field for field in fields if field.name in known]
    assert [f.name for f in fields if f not in taken] in ([], ["tolerance"])  # an equilibrium takes no time
    for field in taken:
        assert known[field.name].default is field.default is None
        with pytest.raises(gelenk.UsageError) as caught:
            call(point, **{field.name: MOVING[field.name]})
        assert str(caught.value) == f"{field.name}: not allowed with an operating point, which contains them"


def test_a_point_stays_as_it_was_made(five_bar: Path) -> None:
    values = {"motor_left.tau": 0.1, "left.phi": 1.0}
    point = gelenk.OperatingPoint(five_bar, at=values)
    linear_model(point)
    assert values == {"motor_left.tau": 0.1, "left.phi": 1.0}  # inputs are taken out of a copy
    with pytest.raises(dataclasses.FrozenInstanceError):
        point.at = 1.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("at", "sentence"),
    [
        (-1e-9, "at: found -1e-09 s, expected 0 or more"),
        (float("nan"), "at: found nan, expected a finite number"),
        ({"left.phi": 1.0, "left.phi_start": 1.0}, "left.phi_start: given twice"),
        ({"lefft.phi": 1.0}, "lefft.phi: no such state, parameter or input; did you mean left.phi"),
    ],
)
def test_a_point_that_cannot_be_is_told(at: Any, sentence: str, five_bar: Path) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        linear_model(gelenk.OperatingPoint(five_bar, at=at))
    assert str(caught.value).startswith(sentence)


def test_a_time_of_zero_is_the_start(five_bar: Path) -> None:
    at_zero, at_start = (linear_model(gelenk.OperatingPoint(five_bar, at=at)) for at in (0.0, None))
    assert np.array_equal(at_zero.A, at_start.A)
    assert np.array_equal(at_zero.y0, at_start.y0)


def test_values_that_are_told_are_attained_where_a_scene_begins_at_rest(root: Path) -> None:
    """They say where the point is; parameters say only from where its rest is looked for."""
    source = gelenk.load(root / "scenes" / "double_pendulum.yaml").to_dict()
    source["solver"] = {**source.get("solver", {}), "start": "equilibrium"}
    told = linear_model(source, at={"shoulder.phi": 0.5, "elbow.phi": 0.2})
    assert dict(zip(told.outputs, told.y0, strict=True))["shoulder.phi"] == 0.5
    found = linear_model(source, parameters={"shoulder.phi_start": 0.5})
    assert np.abs(found.rates).max() < 1e-8
