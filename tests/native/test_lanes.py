# SPDX-License-Identifier: BSD-3-Clause
"""Programs on lanes against tapes, to the bit, and sines against those of the library."""

from __future__ import annotations

import random
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

NAMES = ["a", "b", "c", "d"]
BINARY = ["+", "-", "*", "/"]
FUNCTIONS = ["exp", "tanh", "sqrt", "cbrt", "atan", "erf", "abs"]


def drawn(rng: random.Random, depth: int) -> str:
    """An expression without sines, which differ from those of the library in the last bit."""
    if depth == 0:
        return rng.choice([*NAMES, f"{rng.uniform(0.5, 2):.3f}"])
    draw = rng.random()
    inner = drawn(rng, depth - 1)
    if draw < 0.1:
        return f"{rng.choice(FUNCTIONS)}({inner})"
    if draw < 0.15:
        return f"({inner})^{rng.choice([-2, 2, 3, 5])}"
    if draw < 0.2:
        return f"if({drawn(rng, depth - 1)} > 0, {inner}, {drawn(rng, depth - 1)})"
    if draw < 0.25:
        return f"atan2({inner}, {drawn(rng, depth - 1)})"
    if draw < 0.3:
        return f"-({inner})"
    return f"({inner}) {rng.choice(BINARY)} ({drawn(rng, depth - 1)})"


def lanes_of(units: ModuleType, rng: random.Random) -> list[list[float]]:
    return [[rng.uniform(-2, 2) for _ in range(units.lanes_per_block)] for _ in NAMES]


@pytest.fixture(params=[True, False], ids=["all instructions", "baseline"])
def instructions(units: ModuleType, request: pytest.FixtureRequest) -> Iterator[None]:
    """Those of this processor, and those that each has."""
    units.use_all_lane_instructions(request.param)
    yield
    units.use_all_lane_instructions(True)


by_each = pytest.mark.usefixtures("instructions")


@by_each
def test_programs_are_tapes_to_the_bit(units: ModuleType) -> None:
    """Random expressions, several of them in one program, which shares their terms: each lane gets what the
    tape computes for its arguments. NaN and infinite numbers are results, too.
    """
    rng = random.Random(5)
    codes: set[int] = set()
    for _ in range(150):
        made = units.Lanes([drawn(rng, rng.randint(1, 5)) for _ in range(rng.randint(1, 6))], NAMES)
        x = lanes_of(units, rng)
        found = np.array(made.by_lanes(x))
        expected = np.array([made.by_tape(list(of_lane)) for of_lane in zip(*x, strict=True)]).T
        assert np.array_equal(found, expected, equal_nan=True)
        codes |= made.codes()
    sines = units.Lanes(["sin(a)", "cos(b)", "sin(c)*cos(c)"], NAMES).codes()
    copies = units.Lanes(["a", "a"], NAMES).codes()
    assert codes | sines | copies == set(range(units.lane_codes))  # every kind of instruction was tested


def test_a_program_alone_has_the_bits_of_a_lane(units: ModuleType) -> None:
    """By machine code, and where the system permits none. Large ones need more than the registers."""
    rng = random.Random(6)
    for trial in range(200):
        count = rng.randint(1, 6) if trial % 3 else rng.randint(20, 60)
        made = units.Lanes([drawn(rng, rng.randint(1, 5)) for _ in range(count)], NAMES)
        assert made.are_encoded()[1] is False
        assert made.are_encoded()[0] is units.has_encoder
        x = [
            [rng.choice([rng.uniform(-2, 2), 0.0, -0.0, 1.0]) for _ in range(units.lanes_per_block)]
            for _ in NAMES
        ]
        expected = np.array(made.by_lanes(x))
        for lane in range(6):
            for encoded in (True, False):
                found = made.alone([of[lane] for of in x], encoded)
                assert np.array_equal(found, expected[:, lane], equal_nan=True)


def test_a_program_alone_has_the_sines_of_lanes(units: ModuleType) -> None:
    """Also of many turns, and with arithmetic before, between and after them."""
    rng = random.Random(7)
    texts = [
        "sin(a)", "cos(b)", "sin(c)*cos(c)", "sin(a*b + cos(c - d))*c - a", "sin(cos(sin(a)))",
        "a*cos(b)/sin(b)",
    ]  # fmt: skip
    made = units.Lanes(texts, NAMES)
    for size in (1e-8, 1.0, 100.0, 1e7):
        x = [[rng.uniform(-size, size) for _ in range(units.lanes_per_block)] for _ in NAMES]
        by_lanes = np.array(made.by_lanes(x))
        for lane in range(units.lanes_per_block):
            for encoded in (True, False):
                alone = made.alone([of[lane] for of in x], encoded)
                assert np.array_equal(alone, by_lanes[:, lane])


@by_each
def test_sums_of_products_are_rounded_twice(units: ModuleType) -> None:
    """a*b + c with c = -fl(a*b) is 0; a fused multiply-add would give the rounding error of the product."""
    made = units.Lanes(["a*b + c", "a*b - d", "c + a*b"], NAMES)
    n = units.lanes_per_block
    a = [1 + 2.0**-30 + k * 2.0**-52 for k in range(n)]
    b = [1 - 2.0**-29 for _ in range(n)]
    product = [x * y for x, y in zip(a, b, strict=True)]
    assert not np.array(made.by_lanes([a, b, [-p for p in product], product])).any()


def exact(function: Any, x: NDArray[np.float64]) -> NDArray[np.float64]:
    with mpmath.workprec(400):
        return np.array([float(function(mpmath.mpf(float(value)))) for value in x])


@by_each
@pytest.mark.parametrize("size", [1e-300, 1e-9, 0.7, 3.0, 100.0, 9.9e5, 1.1e6, 1e15, 1e300])
def test_sines_and_cosines_err_by_one_unit_in_the_last_place(units: ModuleType, size: float) -> None:
    """Against 120 digits, at random angles: our own reduction up to 1e6 rad, that of the library beyond."""
    rng = np.random.default_rng(3)
    n = units.lanes_per_block
    made = units.Lanes(["sin(a)", "cos(a)", "sin(b)", "cos(c)"], NAMES)
    for _ in range(20):
        x = rng.uniform(-size, size, n)
        found = np.array(made.by_lanes([list(x)] * 4))
        for row, function in ((0, mpmath.sin), (1, mpmath.cos), (2, mpmath.sin), (3, mpmath.cos)):
            truth = exact(function, x)
            assert (np.abs(found[row] - truth) <= np.spacing(np.maximum(np.abs(truth), 1e-300))).all()


@by_each
def test_sines_of_what_is_not_finite_are_not_numbers(units: ModuleType) -> None:
    n = units.lanes_per_block
    x = [0.3] * n
    x[3], x[7], x[9] = np.inf, -np.inf, np.nan
    sine, cosine = units.Lanes(["sin(a)", "cos(a)"], NAMES).by_lanes([x] * 4)
    for row in (sine, cosine):
        assert [k for k in range(n) if np.isnan(row[k])] == [3, 7, 9]
        assert (
            len({row[k] for k in range(n)} - {row[3], row[7], row[9]}) == 1
        )  # and do not disturb the others


@by_each
def test_signs_and_zeros_of_sines(units: ModuleType) -> None:
    """sin(-x) = -sin(x) and cos(-x) = cos(x) to the bit, sin(0) = 0, sin(-0) = -0, cos(0) = 1."""
    n = units.lanes_per_block
    x = np.concatenate([[0.0, -0.0], np.linspace(-30, 30, n - 2)])
    made = units.Lanes(["sin(a)", "cos(a)", "sin(b)", "cos(b)"], NAMES)
    sine, cosine, other_sine, other_cosine = np.array(made.by_lanes([list(x), list(-x)] * 2))
    assert np.array_equal(sine, -other_sine)
    assert np.array_equal(cosine, other_cosine)
    assert sine[0] == 0
    assert not np.signbit(sine[0])
    assert np.signbit(sine[1])
    assert cosine[0] == cosine[1] == 1
