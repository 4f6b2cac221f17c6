# SPDX-License-Identifier: BSD-3-Clause
"""Which massless bodies are replaced by distance constraints, which remain bodies,
and what inspection reports about them.
"""

from __future__ import annotations

from typing import Any

import pytest
import warned
from mechanisms import body, reaction, with_sensors
from models.rods import hung_plank, hung_platform, planar_four_bar, sizes, spatial_four_bar

import gelenk

# --- sizes ---


def test_planar_four_bar_has_two_coordinates_and_one_constraint_equation() -> None:
    assert sizes(planar_four_bar()) == (2, 1, 1)
    assert sizes(planar_four_bar(), massless=False) == (3, 2, 1)


@pytest.mark.parametrize("first", ["universal", "spherical"])
def test_spatial_four_bar_has_two_coordinates_and_one_constraint_equation(first: str) -> None:
    assert sizes(spatial_four_bar(first)) == (2, 1, 1)


@warned.GUESSES
def test_one_of_the_rods_that_hold_a_body_remains_in_the_tree() -> None:
    """The first of three rods is in the tree: its joints add fewer states than a free body.
    The other two are constraints.
    """
    assert sizes(hung_platform(3, {"phi_a": 0.5})) == (5, 2, 3)
    assert sizes(hung_platform(1, {"phi_a": 0.5})) == (5, 0, 5)


# --- bodies that are not replaced ---

UNCHANGED: dict[str, dict[str, Any]] = {
    "motor": {"motors": {"m": {"joint": "B"}}},
    "damping": {"joints": {"B": {"damping": 0.1}}},
    "stiffness": {"joints": {"C": {"stiffness": 0.1}}},
    "stop": {"joints": {"B": {"stop": {"upper": 9.0, "stiffness": 0.1}}}},
    "force": {"forces": {"f": {"type": "wrench", "body": "coupler", "force": [0.1, 0, 0]}}},
    "spring": {
        "forces": {
            "f": {
                "type": "spring_damper",
                "from": {"body": "coupler"},
                "to": {"body": "ground"},
                "stiffness": 1.0,
            }
        }
    },
    "mass": {"bodies": {"coupler": body(1e-6, (0.5, 0, 0), [1e-6] * 3)}},
    "massless neighbor": {"bodies": {"rocker": body(0)}},
}


@pytest.mark.parametrize("what", UNCHANGED)
def test_rod_with_an_element_attached_remains_a_body(what: str) -> None:
    source = planar_four_bar()
    for section, entries in UNCHANGED[what].items():
        for name, fields in entries.items():
            source.setdefault(section, {}).setdefault(name, {}).update(fields)
    assert sizes(source) == (3, 2, 1)


def test_rod_with_reaction_outputs_remains_a_body() -> None:
    source = with_sensors(spatial_four_bar(), R=reaction("S"))
    assert sizes(source) == sizes(spatial_four_bar(), massless=False)


@pytest.mark.parametrize("axes", [[[1, 0, 0], [0.3, 1, 0]], [[1, 0, 0], [0, 0.3, 1]]])
def test_rod_whose_joint_limits_its_direction_remains_a_body(axes: list[list[float]]) -> None:
    source = spatial_four_bar()
    source["joints"]["U"]["axes"] = axes
    assert sizes(source) == sizes(source, massless=False)


def test_spinning_rod_is_refused_without_the_reduction() -> None:
    source = spatial_four_bar("spherical")
    with pytest.raises(gelenk.SceneError, match=r"bodies\.rod: moves without inertia"):
        sizes(source, massless=False)


# --- reports ---


@warned.GUESSES
def test_inspection_names_the_rods_and_their_joints() -> None:
    report = gelenk.inspect(spatial_four_bar()).reductions["massless"]
    assert report.changed
    assert list(report.notes) == [
        "massless rod rod (universal U, spherical S): replaced by one distance constraint"
    ]
    report = gelenk.inspect(hung_platform(3, {"phi_a": 0.5})).reductions["massless"]
    assert list(report.notes) == [
        "massless rods rod1 (universal U1, spherical S1) and rod2 (universal U2, spherical S2): "
        "each replaced by one distance constraint",
    ]


def test_inspection_reports_that_a_rod_can_spin() -> None:
    report = gelenk.inspect(spatial_four_bar("spherical"))
    assert (report.degrees_of_freedom, report.counted_degrees_of_freedom) == (1, 2)
    assert list(report.mobility) == [
        "1 rod rotates about its axis between spherical joints, which moves no mass and is not counted "
        "as a degree of freedom",
    ]


def test_inspection_counts_constraints_in_space_for_rods_of_the_planar_model() -> None:
    """A plank on three hinged rods: in space the two rods replaced by constraints
    would be bodies without inertia.
    """
    report = gelenk.inspect(hung_plank(3))
    assert (report.degrees_of_freedom, report.counted_degrees_of_freedom) == (1, -6)
    assert {joint for joint, _ in report.redundant_constraints} == {"B1", "B2"}
