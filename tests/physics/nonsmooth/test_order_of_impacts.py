# SPDX-License-Identifier: BSD-3-Clause
"""Impacts that follow each other so closely that errors of a run decide on their order, which a warning says.

A wheel lands while its cart strikes a limit: three motions, by which of the two impacts comes first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gelenk

Array = npt.NDArray[np.float64]
MASS, INERTIA, RADIUS, SPEED = 6.3, 0.0122, 0.138, 5.0
LANDING = 0.1  # s, at 1 m/s
TOLERANCE = 1e-8
REACH = 10 * TOLERANCE  # m, in which errors of a run may decide


def cart(ahead: float = 0.0, friction: float = 0.8) -> dict[str, Any]:
    """The limit is reached `ahead` [m] before the wheel lands."""
    wheel = {
        "wheel": {"radius": RADIUS},
        "rotation": {"axis": [1, 0, 0], "angle": 1.5707963267948966},
        "surface": "rubber",
    }
    return {
        "gelenk": 1,
        "gravity": [0, 0, -10],
        "ground": {"shapes": {"road": {"plane": [0, 0, 1], "surface": "road"}}},
        "bodies": {
            "slide": {"mass": 0},
            "cart": {"mass": MASS - 1},
            "wheel": {"mass": 1, "inertia": [INERTIA] * 3, "shapes": {"tread": wheel}},
        },
        "joints": {
            "x": {
                "type": "prismatic",
                "axis": [1, 0, 0],
                "parent": "ground",
                "child": "slide",
                "start": {"s": ahead, "v": SPEED, "fixed": True},
                "limit": {"upper": SPEED * LANDING, "restitution": 0.5},
            },
            "z": {
                "type": "prismatic",
                "parent": "slide",
                "child": "cart",
                "start": {"s": RADIUS + 0.05, "v": 0, "fixed": True},
            },
            "axle": {
                "type": "revolute",
                "axis": [0, 1, 0],
                "parent": "cart",
                "child": "wheel",
                "start": {"phi": 0, "w": 0, "fixed": True},
            },
        },
        "contacts": {"tire": {"between": ["rubber", "road"], "friction": friction}},
    }


def run(scene: dict[str, Any], integrator: str) -> tuple[float, list[str]]:
    stop = LANDING + 1e-6  # friction of the sliding wheel changes its speed by 6e-4 rad/s
    result = gelenk.simulate(scene, stop=stop, step=stop / 3, tolerance=TOLERANCE, integrator=integrator)
    return float(result["axle.w"][-1]), [words for words in result.warnings if "uncertain" in words]


def rolling(speed: float) -> float:
    """The rate of rotation when a wheel lands with this speed, and rolls from then on."""
    impulse = speed / (1 / MASS + RADIUS**2 / INERTIA)
    return impulse * RADIUS / INERTIA


@pytest.mark.parametrize("integrator", ["auto", "erk", "dirk", "cvode", "ida"])
def test_an_order_within_the_tolerance_is_reported(integrator: str) -> None:
    for ahead, speed, first, second in (
        (0.5 * REACH, -SPEED / 2, "x.s meets its upper limit", "tire: wheel touches the ground"),
        (-0.5 * REACH, SPEED, "tire: wheel touches the ground", "x.s meets its upper limit"),
    ):
        w, words = run(cart(ahead), integrator)
        assert w == pytest.approx(rolling(speed), rel=1e-3)
        assert len(words) == 1
        assert words[0].startswith(f't = 0.1 s: {first} so close in time to "{second}"')


def test_what_comes_first_by_more_is_certain() -> None:
    # Errors of this run are far below its tolerance, so that the gap at the first impact is the difference.
    assert run(cart(-0.95 * REACH), "erk")[1]
    w, words = run(cart(-1.05 * REACH), "erk")
    assert w == pytest.approx(rolling(SPEED), rel=1e-3)
    assert words == []
    # The wheel approaches at 1 m/s while the cart moves by 5 m/s.
    assert run(cart(5 * 0.95 * REACH), "erk")[1]
    assert not run(cart(5 * 1.05 * REACH), "erk")[1]


def test_at_the_same_instant_they_are_one_impact() -> None:
    w, words = run(cart(), "erk")
    assert w == pytest.approx(-SPEED / 2 / RADIUS, rel=1e-3)
    assert words == []


def test_impacts_without_influence_on_each_other_are_certain() -> None:
    w, words = run(cart(0.5 * REACH, friction=0), "erk")
    assert w == 0
    assert words == []


def test_diagnostic_and_events() -> None:
    plant = gelenk.Simulation(cart(0.5 * REACH))
    plant.initialize(0, TOLERANCE)
    plant.step_to(0.09)
    assert plant.diagnostic("solver.ambiguous") == 0
    plant.step_to(0.11)
    assert plant.diagnostic("solver.ambiguous") == 1
    assert sum("uncertain" in text for _, text in plant.events) == 1


def test_the_end_of_series_is_certain() -> None:
    """A box comes to rest by impacts of its corners, which are all near the ground then."""
    box = {
        "mass": 1,
        "inertia": [0.002, 0.002, 0.002],
        "shapes": {"faces": {"box": [0.1, 0.1, 0.1], "surface": "wood"}},
    }
    scene = {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "bodies": {"box": box},
        "joints": {
            "free": {
                "type": "free",
                "parent": "ground",
                "child": "box",
                "start": {"r": [0, 0, 0.08], "rotation": {"axis": [0, 1, 0], "angle": 0.1}, "fixed": True},
            }
        },
        "contacts": {"c": {"between": ["wood", "floor"], "friction": 0.3, "restitution": 0.4}},
    }
    result = gelenk.simulate(scene, stop=1.0, step=0.02, tolerance=1e-6, integrator="erk")
    assert result["free.w[2]"][-1] == pytest.approx(0, abs=1e-6)
    assert sum("touches" in text for _, text in result.events) > 10
    assert not [words for words in result.warnings if "uncertain" in words]


# Of planes, into the room.
ACUTE = np.array([[-0.432, 0.823, -0.368], [0.172, -0.932, -0.319], [0.084, 0.55, 0.831]])


def corner(normals: Array, restitution: tuple[float, float, float]) -> dict[str, Any]:
    """A point mass flies into a corner of three frictionless planes, without gravity."""
    normals = normals / np.linalg.norm(normals, axis=1)[:, None]
    radius = 0.01
    position = np.linalg.solve(normals, np.array([0.28, 0.48, 0.115]) + radius)
    velocity = np.linalg.solve(normals, [-0.96, -0.52, -0.6])
    bodies = ("ground", "first", "second", "point")
    return {
        "gelenk": 1,
        "gravity": [0, 0, 0],
        "ground": {
            "shapes": {
                f"P{i}": {"plane": normal.tolist(), "surface": f"side {i}"}
                for i, normal in enumerate(normals)
            }
        },
        "bodies": {
            "first": {"mass": 0},
            "second": {"mass": 0},
            "point": {"mass": 1, "shapes": {"tip": {"sphere": radius, "surface": "tip"}}},
        },
        "joints": {
            name: {
                "type": "prismatic",
                "axis": axis.tolist(),
                "parent": bodies[i],
                "child": bodies[i + 1],
                "start": {"s": float(position[i]), "v": float(velocity[i]), "fixed": True},
            }
            for i, (name, axis) in enumerate(zip("xyz", np.eye(3), strict=True))
        },
        "contacts": {
            f"C{i}": {"between": ["tip", f"side {i}"], "restitution": e} for i, e in enumerate(restitution)
        },
    }


def test_a_series_of_which_only_the_times_become_small_is_uncertain() -> None:
    """Two planes without restitution and one with: some thirty impacts in ever shorter time, almost as fast.

    A cycle shortens the distances by a factor that is much smaller than that of the speed, so that the
    distances are lost in rounding while the point still moves: which plane is struck next is not known.
    """
    result = gelenk.simulate(corner(ACUTE, (0, 0.9, 0)), stop=3, step=0.1, tolerance=1e-8, integrator="erk")
    speed = np.linalg.norm([result[f"{axis}.v"] for axis in "xyz"], axis=0)
    assert sum("touches" in text for _, text in result.events) > 20
    moves = speed > 0
    assert speed[moves][-1] > 0.99 * speed[0]
    assert not moves[-1]  # it is at rest in the corner, which is right in the limit
    assert [words for words in result.warnings if "uncertain" in words]


def test_impacts_in_a_right_corner_are_certain() -> None:
    """Each of them changes the speed along one normal."""
    result = gelenk.simulate(corner(np.eye(3), (0, 0.9, 0)), stop=3, step=0.1, tolerance=1e-8)
    assert [result[f"{axis}.v"][-1] for axis in "xyz"] == pytest.approx([0, 0.9 * 0.52, 0], abs=1e-12)
    assert not result.warnings
