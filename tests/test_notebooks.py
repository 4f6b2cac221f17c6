# SPDX-License-Identifier: BSD-3-Clause
"""What notebooks show: tables and pictures as HTML, in which every name is text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mechanisms import body, frame, joint, scene

import gelenk
from gelenk import _html
from gelenk.linear.model import LinearModel
from gelenk.simulation.result_html import BINS, MAX_EVENTS, MAX_SIGNALS, extremes_in_bins
from gelenk.simulation.run import open_plant

TAGS = {"div", "p", "b", "br", "table", "thead", "tbody", "tr", "th", "td", "details", "summary"}
TAGS |= {"svg", "polyline", "polygon", "circle", "text"}
# Names that would be markup, or end an attribute, if they were not escaped.
NAMES = st.text(st.sampled_from("ab.[1]<>&\"'/;=!-"), min_size=1, max_size=12)
UNIQUE = st.lists(NAMES, min_size=1, max_size=4, unique=True)


def parsed(shown: Any) -> ElementTree.Element:
    """The HTML of an object, which is also well-formed XML, without scripts and handlers."""
    root = ElementTree.fromstring(shown._repr_html_())
    for element in root.iter():
        assert element.tag.rpartition("}")[2] in TAGS
        assert not any(name.startswith("on") or name in ("href", "src") for name in element.attrib)
    return root


def rows(table: ElementTree.Element) -> list[list[str]]:
    return [["".join(cell.itertext()) for cell in row] for row in table.iter("tr")]


def tables(root: ElementTree.Element) -> list[list[list[str]]]:
    return [rows(table) for table in root.iter("table")]


def result(names: Sequence[str], values: Any, units: Sequence[str] | None = None) -> gelenk.Result:
    table = np.column_stack([np.arange(len(values)), values])
    return gelenk.Result(names, table, dict(zip(names, units or ["1"] * len(names), strict=True)))


@settings(max_examples=100, deadline=None)
@given(UNIQUE, NAMES, NAMES)
def test_names_of_results_are_text(names: list[str], unit: str, event: str) -> None:
    found = result(names, np.ones((3, len(names))), [unit] * len(names))
    found.events = ((1.0, event),)
    signals, events = tables(parsed(found))
    assert [row[0] for row in signals[1:]] == names
    assert {row[1] for row in signals[1:]} == {_html.unit(unit)}
    assert events[1:] == [["1", event]]


def linear(
    name: str, states: Sequence[str], inputs: Sequence[str], outputs: Sequence[str], A: Any
) -> LinearModel:
    x, u, y = (np.zeros(len(names)) for names in (states, inputs, outputs))
    B, C, D = (np.zeros((len(a), len(b))) for a, b in ((x, u), (y, x), (y, u)))
    units = dict.fromkeys((*states, *inputs, *outputs), "<m&>")
    A = np.asarray(A, float).reshape(len(x), len(x))
    return LinearModel(name, 0.0, tuple(states), tuple(inputs), tuple(outputs), A, B, C, D, x, u, y, x, units)


@settings(max_examples=100, deadline=None)
@given(NAMES, UNIQUE, UNIQUE, UNIQUE)
def test_names_of_linear_models_and_modes_are_text(
    name: str, states: list[str], inputs: list[str], outputs: list[str]
) -> None:
    model = linear(name, states, inputs, outputs, -np.diag(1.0 + np.arange(len(states))))
    root = parsed(model)
    assert next(root.iter("b")).text == f"{name} at t = 0 s"
    _, x, u, y, A, B, C, D = tables(root)
    for listed, names in ((x, states), (u, inputs), (y, outputs)):
        assert [row[0] for row in listed[1:]] == names
        assert {row[2] for row in listed[1:]} == {"<m&>"}
    assert A[0][1:] == C[0][1:] == states
    assert B[0][1:] == D[0][1:] == inputs
    assert [row[0] for row in C[1:]] == outputs
    _, shapes = tables(parsed(gelenk.modes(model)))
    assert [row[0] for row in shapes[1:]] == states


@settings(max_examples=50, deadline=None)
@given(NAMES)
def test_names_of_scenes_are_text(name: str) -> None:
    """Names of bodies and joints are identifiers."""
    pendulum = scene(
        {"rod": body(1.0, com=(0.5, 0, 0))}, {"A": joint("revolute", frame("ground"), frame("rod"))}
    )
    found = gelenk.load({**pendulum, "name": name})
    assert next(parsed(found).iter("b")).text == name
    assert next(parsed(gelenk.inspect(found)).iter("b")).text == name


def test_results_show_extremes_with_their_times() -> None:
    """A parabola 1 - (t - 1)² and its negative, at 0, 1, 2 and 3 s."""
    x = np.array([0.0, 1.0, 0.0, -3.0])
    (table,) = tables(parsed(result(("up", "down"), np.column_stack([x, -x]), ("m", "rad"))))
    assert [row[:8] for row in table[1:]] == [
        ["up", "m", "0", "−3", "3", "1", "1", "−3"],
        ["down", "rad", "0", "−1", "1", "3", "3", "3"],
    ]


def test_results_without_finite_values_are_shown() -> None:
    values = np.array([[math.nan, math.nan, math.inf], [math.nan, 2.0, -math.inf]])
    (table,) = tables(parsed(result(("none", "one", "infinite"), values)))
    assert [row[2:8] for row in table[1:]] == [
        ["–", "–", "–", "–", "–", "–"],
        ["–", "2", "1", "2", "1", "2"],
        ["∞", "–", "–", "–", "–", "−∞"],
    ]


def test_empty_results_are_shown() -> None:
    assert "empty" in result(("x",), np.empty((0, 1)))._repr_html_()
    assert tables(parsed(result((), np.empty((2, 0))))) == []
    (table,) = tables(parsed(result(("x",), np.ones((1, 1)))))
    assert table[1] == ["x", "", "1", "1", "0", "1", "0", "1", ""]  # a chart has two points at least


@pytest.mark.parametrize("more", [0, 1])
def test_long_lists_end_with_the_number_of_what_is_left(more: int) -> None:
    count = MAX_SIGNALS + more
    found = result([f"x{k}" for k in range(count)], np.ones((2, count)))
    found.events = tuple((float(k), "meets") for k in range(MAX_EVENTS + more))
    text = "".join(parsed(found).itertext())
    assert ("and 1 more; result.names lists all" in text) == bool(more)
    assert text.endswith("and 1 more") == bool(more)


def points(shown: ElementTree.Element) -> list[list[tuple[float, float]]]:
    lines = [e.attrib["points"].split() for e in shown.iter("polyline")]
    return [[(float(x), float(y)) for x, y in (pair.split(",") for pair in line)] for line in lines]


def test_charts_are_inside_their_frames_and_have_gaps() -> None:
    """A triangle from the lower left to the top to the lower right; NaN divides a line."""
    triangle = ElementTree.fromstring(_html.sparkline([0, 1, 2], [0, 5, 0], 100, 30))
    assert points(triangle) == [[(2, 27), (50, 3), (98, 27)]]
    gap = ElementTree.fromstring(_html.sparkline([0, 1, 2, 3], [0, math.nan, 1, 1], 100, 30))
    assert [len(line) for line in points(gap)] == [2, 2]  # a single point is a line of length 0
    assert points(ElementTree.fromstring(_html.sparkline([0, 1], [7, 7], 100, 30))) == [[(2, 15), (98, 15)]]
    assert _html.sparkline([0, 1], [math.nan, math.inf]) == ""


@settings(deadline=None)
@given(st.lists(st.floats(), min_size=2, max_size=30), st.integers(1, 5))
def test_charts_draw_any_numbers_inside_their_frames(y: list[float], width: int) -> None:
    kept = extremes_in_bins(np.array(y), width)
    text = _html.sparkline(kept.tolist(), [y[k] for k in kept], 100, 30)
    for line in points(ElementTree.fromstring(text)) if text else []:
        assert all(2 <= a <= 98 and 3 <= b <= 27 for a, b in line)


@settings(deadline=None)
@given(st.lists(st.floats(-1, 1), min_size=1, max_size=1000))
def test_charts_of_long_runs_keep_the_extremes(values: list[float]) -> None:
    x = np.array(values)
    kept = extremes_in_bins(x)
    assert len(kept) <= 2 * BINS + 2
    assert (np.diff(kept) > 0).all()
    assert {0, len(x) - 1} <= {*kept.tolist()}
    assert (x[kept].min(), x[kept].max()) == (x.min(), x.max())


def test_poles_of_a_damped_oscillator() -> None:
    """Of x'' + 2 d w x' + w² x = 0: -d w ± i w sqrt(1 - d²); w = 5 rad/s, d = 0.6."""
    poles = tables(parsed(linear("", ["x", "v"], [], ["y"], [[0, 1], [-25, -6]])))[0]
    assert poles[1:] == [["−3 ± 4i", "5", "0.6", "0.3333"]]


def test_models_without_states_inputs_and_numbers_are_shown() -> None:
    assert tables(parsed(linear("", [], [], [], np.empty((0, 0))))) == []
    assert "NaN" in linear("", ["x"], [], [], [[math.nan]])._repr_html_()


def test_modes_and_their_stability(root: Path) -> None:
    found = gelenk.modes(root / "scenes" / "cart_pole.yaml", at={"hinge.phi": 0})
    shown = parsed(found)
    assert "".join(shown[0].itertext()).endswith(": unstable")
    assert shown[1].text == found.why
    assert [row[-1] for row in tables(shown)[0][1:]] == [mode.kind for mode in found.modes]


def test_inspections_show_the_numbers_of_their_text(four_bar: gelenk.Scene) -> None:
    report = gelenk.inspect(four_bar, without=["weld"])
    sizes, reductions = tables(parsed(report))
    assert ["constraint equations", "5", "2"] in sizes
    assert [row[0] for row in reductions[1:]] == list(report.reductions)
    assert {row[0]: row[2] for row in reductions[1:]}["weld"].startswith("switched off")


def test_scenes_show_their_picture(four_bar: gelenk.Scene) -> None:
    root = parsed(four_bar)
    assert root[0][0].text == "FourBar"
    labels = {e.text for e in root.iter() if e.tag.endswith("}text")}
    assert labels >= {"crank", "coupler", "rocker", "A", "B", "C", "D"}


def test_scenes_that_cannot_be_assembled_show_the_reason(four_bar: gelenk.Scene) -> None:
    torn = four_bar.to_dict()
    torn["joints"]["D"]["parent"]["position"] = [50.0, 0.0, 0.0]
    text = "".join(parsed(gelenk.load(torn)).itertext())
    assert "cannot be closed: smallest closure error" in text


def test_reprs_name_what_there_is(four_bar: gelenk.Scene) -> None:
    found = gelenk.simulate(four_bar, stop=0.01, outputs=["A.phi", "A.w"])
    assert repr(found) == "<Result 0 to 0.01 s, 11 rows: A.phi, A.w>"
    found.events = ((0.0, "meets"),)
    assert repr(found) == "<Result 0 to 0.01 s, 11 rows, 1 event: A.phi, A.w>"
    many = result([f"x{k}" for k in range(14)], np.ones((2, 14)))
    assert repr(many).endswith("x10, x11 and 2 more>")
    assert repr(result((), np.empty((2, 0)))) == "<Result 0 to 1 s, 2 rows: no signals>"


def test_reprs_of_analyses_are_one_line(root: Path) -> None:
    cart = root / "scenes" / "cart_pole.yaml"
    model = gelenk.linear.linear_model(cart, at={"hinge.phi": 0})
    assert repr(model) == "<LinearModel CartPole at t = 0 s: 4 states, 1 input, 6 outputs>"
    assert repr(gelenk.modes(model)) == "<Modes of CartPole at t = 0 s: 4 modes, unstable>"
    found = repr(gelenk.inspect(cart))
    assert found.startswith("<Inspection of CartPole: 2 degrees of freedom, as counted")
    assert repr(open_plant(cart, ())) == "<ScenePlant CartPole: 1 input, 6 outputs>"


def test_an_equilibrium_is_shown_as_tables(root: Path) -> None:
    held = gelenk.equilibrium(
        root / "scenes" / "cart_pole.yaml",
        parameters={"gravity[1]": -1},
        hold={"track.s": 0.5},
        solve_for="drive.f",
    )
    inputs, outputs = tables(parsed(held))
    assert inputs == [["input", "value", "unit"], ["drive.f", "1.2", "N"]]
    assert ["track.s", "0.5", "m"] in outputs
    assert len(outputs) == 1 + len(held.values)
    arm = scene(
        bodies={"arm": body(2, (0.5, 0, 0), (0.01, 0.2, 0.2))},
        joints={
            "A": joint(
                "revolute",
                frame("ground"),
                frame("arm"),
                axis=[0, -1, 0],
                friction={"coulomb": 8, "static": 10},
            )
        },
    )
    (_, held_by) = tables(parsed(gelenk.equilibrium(arm, friction="present")))
    assert held_by[0] == ["held", "by"]
    assert held_by[1][1].startswith("friction ")


def test_branches_are_shown_side_by_side(four_bar: gelenk.Scene) -> None:
    found = gelenk.assemblies(four_bar)
    root_element = parsed(found)
    assert "FourBar: 2 branches found in" in "".join(root_element.itertext())
    (table,) = tables(root_element)
    assert table[0] == ["", "unit", "1 (start values)", "2"]
    assert [row[0] for row in table[1:]] == ["distance", "found", *found[0].values]
    for row in table[3:]:
        assert [float(cell.replace("−", "-")) for cell in row[2:]] == [
            pytest.approx(branch.values[row[0]], rel=1e-5) for branch in found
        ]


def test_the_model_of_linearize_is_shown_with_its_operating_point(root: Path) -> None:
    """It is a StateSpace of python-control, which shows matrices without names."""
    model = gelenk.linearize(root / "scenes" / "cart_pole.yaml", at={"hinge.phi": 0})
    same = gelenk.linear.linear_model(root / "scenes" / "cart_pole.yaml", at={"hinge.phi": 0})
    assert model._repr_html_() == same._repr_html_()
    assert ["hinge.phi", "0", "rad"] in [row for table in tables(parsed(model)) for row in table]
