# SPDX-License-Identifier: BSD-3-Clause
"""What touches and separates again within a step is found, however long the step: against closed forms."""

from __future__ import annotations

from math import asin, floor, pi, sqrt
from typing import Any

import pytest

import gelenk

type SceneData = dict[str, Any]

INTEGRATORS = ["auto", "erk", "cvode", "cvode-adams", "ida", "dirk", "rk4"]
OMEGA = 20.0  # rad/s
START = -0.3  # rad
ARM = 0.5  # m
STEP = 0.5  # s: more than one turn


def swung(shape: SceneData, obstacle: SceneData) -> SceneData:
    """An arm that turns freely about the y axis, with a shape at its end above an obstacle."""
    return {
        "gelenk": 1,
        "name": "Swung",
        "gravity": [0, 0, 0],
        "bodies": {"arm": {"mass": 1, "inertia": [0.1] * 3,
                           "shapes": {"tip": {"position": [ARM, 0, 0], **shape, "surface": "steel"}}}},
        "ground": {"shapes": {"obstacle": {**obstacle, "surface": "steel"}}},
        "joints": {"A": {"type": "revolute", "axis": [0, 1, 0], "parent": "ground", "child": "arm",
                         "start": {"phi": START, "w": OMEGA, "fixed": True}}},
        "contacts": {"hit": {"between": ["steel", "steel"], "restitution": 1.0}},
        "solver": {"step": 0.05},
    }  # fmt: skip


def ball_above_plane(depth: float) -> SceneData:
    """A ball would go below a plane by this part of the way from the axis to its center."""
    return swung({"sphere": 0.1}, {"plane": [0, 0, 1], "position": [0, 0, -ARM * (1 - depth) - 0.1]})


def edge_above_block(depth: float) -> SceneData:
    """The outermost edge of a cube would go below the top of a block by this part of its radius."""
    top = -(ARM + 0.05 * sqrt(2)) * (1 - depth)
    cube = {"box": [0.1] * 3, "rotation": {"axis": [0, 1, 0], "angle": pi / 4}}
    return swung(cube, {"box": [0.4, 0.3, 0.2], "position": [0, 0, top - 0.1]})


SWUNG = {"ball above a plane": ball_above_plane, "edge above a block": edge_above_block}


def angle(t: float, touches_at: float) -> float:
    """Between the angles at which it touches on either side, it turns back and forth."""
    way = pi + 2 * touches_at
    passed = (OMEGA * t + START + pi + touches_at) % (2 * way)
    return -pi - touches_at + (passed if passed <= way else 2 * way - passed)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("kind", SWUNG)
def test_what_dips_below_a_face_for_a_short_time(kind: str, depth: float, integrator: str) -> None:
    """For as short a part of a turn as the square root of the depth."""
    touches_at = asin(1 - depth)
    run = gelenk.simulate(SWUNG[kind](depth), stop=2.0, step=STEP, tolerance=1e-8, integrator=integrator)
    first, between = (touches_at - START) / OMEGA, (pi + 2 * touches_at) / OMEGA
    expected = [first + k * between for k in range(floor((2.0 - first) / between) + 1)]
    assert [event[0] for event in run.events] == pytest.approx(expected, abs=1e-7)
    assert run["A.phi"] == pytest.approx([angle(t, touches_at) for t in run.time], abs=1e-6)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("kind", SWUNG)
def test_what_passes_just_above_is_let_pass(kind: str, integrator: str) -> None:
    run = gelenk.simulate(SWUNG[kind](-1e-6), stop=2.0, step=STEP, tolerance=1e-8, integrator=integrator)
    assert not run.events
    assert run["A.phi"] == pytest.approx(START + OMEGA * run.time, abs=1e-6)


def passing_ball(height: float) -> SceneData:
    """A ball on a straight guide past the edge of a thin plate."""
    scene = swung({"sphere": 0.1}, {"box": [0.001, 0.3, 0.2], "position": [0, 0, -0.1]})
    scene["bodies"]["arm"]["shapes"]["tip"]["position"] = [0, 0, 0]
    scene["joints"] = {"A": {"type": "prismatic", "axis": [1, 0, 0], "child": "arm",
                             "parent": {"body": "ground", "position": [0, 0, height]},
                             "start": {"s": -1.0, "v": 9.0, "fixed": True}}}  # fmt: skip
    return scene


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("depth", [1e-2, 1e-5])
def test_a_ball_that_passes_an_edge(depth: float, integrator: str) -> None:
    """It touches where the edge is a radius from its center, and returns with restitution 1."""
    height = 0.1 * (1 - depth)
    at = -0.0005 - sqrt(0.1**2 - height**2)
    run = gelenk.simulate(passing_ball(height), stop=0.4, step=0.4, tolerance=1e-8, integrator=integrator)
    first = (at + 1.0) / 9.0
    assert [event[0] for event in run.events] == pytest.approx([first], abs=1e-7)
    assert run["A.s"][-1] == pytest.approx(at - 9.0 * (0.4 - first), abs=1e-6)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_ball_that_passes_an_edge_just_above_it(integrator: str) -> None:
    run = gelenk.simulate(
        passing_ball(0.1 * (1 + 1e-6)), stop=0.4, step=0.4, tolerance=1e-8, integrator=integrator
    )
    assert not run.events
    assert run["A.s"][-1] == pytest.approx(-1.0 + 9.0 * 0.4, abs=1e-9)


def spinning_cube(height: float) -> SceneData:
    """A cube that floats above a plane and turns about a horizontal axis."""
    return {
        "gelenk": 1,
        "name": "Cube",
        "gravity": [0, 0, 0],
        "bodies": {"cube": {"mass": 1, "inertia": [0.01] * 3,
                            "shapes": {"skin": {"box": [0.2] * 3, "surface": "steel"}}}},
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "steel"}}},
        "joints": {"J": {"type": "free", "parent": "ground", "child": "cube",
                         "start": {"r": [0, 0, height], "w": [0, OMEGA, 0]}}},
        "contacts": {"hit": {"between": ["steel", "steel"], "restitution": 1.0}},
        "solver": {"step": 0.05},
    }  # fmt: skip


@pytest.mark.parametrize("integrator", [name for name in INTEGRATORS if name != "rk4"])
@pytest.mark.parametrize("depth", [1e-3, 1e-5])
def test_the_corner_of_a_cube_that_floats(depth: float, integrator: str) -> None:
    """Its lowest edge touches when the diagonal to it is as upright as its height permits."""
    diagonal = 0.1 * sqrt(2)
    height = diagonal * (1 - depth)
    run = gelenk.simulate(spinning_cube(height), stop=0.2, step=0.2, tolerance=1e-8, integrator=integrator)
    leans = sqrt(1 - (1 - depth) ** 2)  # sine of the diagonal's angle to the vertical
    assert run.events[0][0] == pytest.approx((pi / 4 - asin(leans)) / OMEGA, abs=1e-6)
