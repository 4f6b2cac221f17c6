# SPDX-License-Identifier: BSD-3-Clause
"""A lane gets the same bits, whatever is beside it; one that fails stops alone, and says why."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk import Batch, _core

SCENES = Path(__file__).resolve().parents[2] / "scenes"
STEP = 1e-3  # s


def four_bars(count: int, first: int = 0, threads: int = 1) -> Batch:
    """Four-bars with masses, inputs and starts by their number; `first`: that of the first lane."""
    numbers = np.arange(first, first + count)
    masses = 1 + 0.1 * np.sin(numbers)  # kg
    angles = 1.1 + 0.3 * np.cos(2 * numbers)  # rad
    parameters = {"crank.mass": masses, "A.phi_start": angles}
    batch = gelenk.batch(SCENES / "four_bar.yaml", count, parameters, step=STEP, threads=threads)
    batch.inputs["drive.tau"] = 2 + np.sin(3 * numbers)  # N m
    return batch


@pytest.fixture
def plain_instructions() -> Iterator[None]:
    """Without vector instructions that not every processor has."""
    _core.use_all_lane_instructions(False)
    yield
    _core.use_all_lane_instructions(True)


def test_bits_do_not_depend_on_the_number_of_lanes_or_the_place_of_one() -> None:
    """Alone, at another place of its block, in another block, in a block that is not full."""
    many = four_bars(70)
    many.step(300)
    assert not many.errors
    for lane in (0, 31, 32, 69):
        alone = four_bars(1, first=lane)
        alone.step(300)
        assert np.array_equal(alone.array[:, 0], many.array[:, lane])
    shifted = four_bars(40, first=13)
    shifted.step(300)
    assert np.array_equal(shifted.array, many.array[:, 13:53])


def test_bits_do_not_depend_on_threads_or_on_how_steps_are_divided() -> None:
    once = four_bars(100)
    once.step(200)
    divided = four_bars(100, threads=3)
    for count in (1, 0, 99, 100):
        divided.step(count)
    assert np.array_equal(divided.array, once.array)
    assert divided.evaluations == once.evaluations


@pytest.mark.parametrize("name", ["four_bar", "free_body", "andrews", "cart_pole"])
def test_bits_do_not_depend_on_the_processor(name: str, request: pytest.FixtureRequest) -> None:
    """With the vector instructions of this processor, and with those that each has."""
    fast = gelenk.batch(SCENES / f"{name}.yaml", 5, step=STEP)
    fast.step(100)
    request.getfixturevalue("plain_instructions")
    assert _core.lane_instructions() == "baseline"
    plain = gelenk.batch(SCENES / f"{name}.yaml", 5, step=STEP)
    plain.step(100)
    assert np.array_equal(fast.array, plain.array)


def test_a_lane_that_is_not_finite_stops_alone() -> None:
    """A torque of 1e200 N m makes its speeds overflow; the others do not notice."""
    batch, others = four_bars(40), four_bars(40)
    batch.inputs["drive.tau"][17] = 1e200
    batch.step(50)
    others.step(50)
    assert list(batch.errors) == [17]
    assert "t = 0 s: " in batch.errors[17]
    assert np.array_equal(batch.running, np.arange(40) != 17)
    rest = np.delete(np.arange(40), 17)
    assert np.array_equal(batch.array[:, rest], others.array[:, rest])
    start = four_bars(40)
    assert np.array_equal(batch.array[:, 17], start.array[:, 17])  # where it was
    batch.reset()
    assert not batch.errors
    batch.inputs["drive.tau"][:] = others.inputs["drive.tau"]
    batch.step(50)
    assert np.array_equal(batch.array, others.array)  # as if nothing had happened


def parallelogram(phi: float) -> dict[str, Any]:
    """Four bars of which opposite ones are equally long: a change point where they are all in line."""
    bar = {"mass": 1.0, "com": [0.25, 0, 0], "inertia": [0.01, 0.02, 0.02]}
    hinge = {"type": "revolute", "axis": [0, 0, 1]}

    def at(body: str, x: float) -> dict[str, Any]:
        return {"body": body, "position": [x, 0, 0]}

    return {
        "gelenk": 1,
        "name": "Parallelogram",
        "gravity": [0, 0, 0],
        "bodies": {"left": bar, "top": bar, "right": bar},
        "joints": {
            "A": {
                **hinge,
                "parent": "ground",
                "child": "left",
                "start": {"phi": phi, "w": -1.0, "fixed": True},
            },
            "B": {**hinge, "parent": at("left", 0.5), "child": "top", "start": {"phi": -phi, "w": 1.0}},
            "C": {
                **hinge,
                "parent": at("top", 1.0),
                "child": at("right", 0.5),
                "start": {"phi": phi, "w": -1.0},
            },
            "D": {**hinge, "parent": at("ground", 1.0), "child": "right", "start": {"phi": phi, "w": -1.0}},
        },
    }


def test_a_lane_stops_before_a_singular_position() -> None:
    """The kinetic energy does not depend on phi, so that phi = phi_0 + w t. The bars are in line at phi = 0,
    and the lane stops shortly before.
    """
    angles = [1.0, 2.0, 0.5]  # rad
    batch = gelenk.batch(parallelogram(1.0), 3, {"A.phi_start": angles}, step=STEP)
    batch.step(700)
    assert list(batch.errors) == [2]
    assert ": C: near a singular configuration" in batch.errors[2]  # C closes the loop
    assert batch.states["A.w"][:2] == pytest.approx(-1.0, abs=1e-11)
    assert batch.states["A.phi"][:2] == pytest.approx(np.array(angles[:2]) - 0.7, abs=1e-11)
    assert 0.0 < batch.states["A.phi"][2] < 0.05  # rad: 0.03 of the largest pivot, and not much earlier
    time = float(batch.errors[2].removeprefix("t = ").split(" s")[0])
    assert batch.states["A.phi"][2] == pytest.approx(0.5 - time, abs=1e-11)


def test_a_lane_that_starts_at_a_singular_position_does_not_move() -> None:
    batch = gelenk.batch(parallelogram(1.0), 2, {"A.phi_start": [1.0, 0.0]}, step=STEP)
    batch.step(10)
    assert list(batch.errors) == [1]
    assert batch.errors[1].startswith("t = 0 s: C: near a singular configuration")
