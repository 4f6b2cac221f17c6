# SPDX-License-Identifier: BSD-3-Clause
"""Inputs as functions of time, the clock, archives, brackets, cubics, stages and the singularity monitor."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

# --- archives ---

LARGEST = {"small": (2**31 - 1) >> 3, "large": (2**63 - 1) >> 15}  # largest counts that are accepted


def sample(units: Any, **values: Any) -> Any:
    out = units.Sample()
    given = {"x": -1.5e-300, "word": 2**64 - 1, "flag": True, "small": -7, "large": 2**40, "place": 3}
    for name, value in (given | {"list": [0.1, -0.0, math.inf]} | values).items():
        setattr(out, name, value)
    return out


def values_of(x: Any) -> tuple[Any, ...]:
    return (repr(x.x), x.word, x.flag, x.small, x.large, x.place, repr(list(x.list)))


def test_an_archive_returns_what_was_written(units: Any) -> None:
    written = sample(units)
    words = written.words()
    assert len(words) == 6 + 3
    other = sample(units, x=0.0, word=0, flag=False, small=0, large=0, place=0, list=[1.0, 1.0, 1.0])
    other.read(words)
    assert values_of(other) == values_of(written)
    assert other.words() == words


def test_nan_keeps_its_bits(units: Any) -> None:
    odd = 0x7FF8000000ABCDEF  # a NaN with a payload
    words = sample(units).words()
    other = sample(units)
    other.read([odd, *words[1:]])
    assert other.words()[0] == odd


def test_an_archive_too_short_or_long_is_rejected(units: Any) -> None:
    words = sample(units).words()
    for wrong in (*(words[:k] for k in range(len(words))), [*words, 0]):
        with pytest.raises(ValueError, match="it is not of this plant, or damaged"):
            sample(units).read(wrong)


FIELDS = {"flag": 2, "small": 3, "large": 4, "place": 5}


@pytest.mark.parametrize(
    ("name", "value", "taken"),
    [
        *(("flag", value, value in (0, 1)) for value in (-1, 0, 1, 2, 2**40)),
        *(("place", value, 0 <= value <= 3) for value in (-1, 0, 3, 4, 2**32)),
        *((name, sign * (most + more), more == 0)
          for (name, most), sign, more in itertools.product(LARGEST.items(), (1, -1), (0, 1))),
        ("small", 2**32, False),  # 0 in 32 bits
    ],
)  # fmt: skip
def test_a_count_out_of_range_is_rejected(units: Any, name: str, value: int, taken: bool) -> None:
    words = sample(units).words()
    words[FIELDS[name]] = value % 2**64
    read = sample(units)
    if taken:
        read.read(words)
        assert getattr(read, name) == value
    else:
        with pytest.raises(ValueError, match="damaged"):
            read.read(words)


# --- inputs ---

LAW = (0.7, -2.0, 3.0, 5.0, -8.0, 20.0)  # value and derivatives at 0


def law(t: float, order: int = 0) -> float:
    """The derivative of this order of the Taylor polynomial."""
    return sum(d * t**k / math.factorial(k) for k, d in enumerate(LAW[order:]))


def moving(units: Any, start: float = 2.0) -> Any:
    """Two inputs, the second of which follows the law from `start` on."""
    u = units.Inputs(2)
    u.start(start)
    u.set(1, LAW[0])
    for order in range(1, units.Inputs.highest_order + 1):
        u.set_derivative(1, order, LAW[order])
    return u


@pytest.mark.parametrize("t", [2.0, 2.001, 2.5, 1.75])
def test_inputs_follow_their_polynomials(units: Any, t: float) -> None:
    u = moving(units)
    assert u.moving
    u.go_to(t)
    assert u.now == pytest.approx([0.0, law(t - 2.0)], rel=1e-14)  # of six terms
    for order in range(6):
        assert u.derivative_at(1, order, t) == pytest.approx(law(t - 2.0, order), rel=1e-14)
        assert u.derivative_at(0, order, t) == 0.0
    u.set(0, 4.0)  # also resets now() to the start of the polynomials
    assert u.now == [4.0, LAW[0]]


def test_a_step_ends_motions_and_holds_the_value_reached(units: Any) -> None:
    u = moving(units)
    u.finish(2.5)
    assert not u.moving
    assert u.value(1) == pytest.approx(law(0.5), rel=1e-14)
    assert [u.derivative(1, k) for k in range(1, 6)] == [0.0] * 5
    # Outputs read at this time depend on the motion up to it.
    assert [u.rate(1, k) for k in (1, 2)] == pytest.approx([law(0.5, k) for k in (1, 2)], rel=1e-14)
    u.finish(3.0)
    assert [u.rate(1, k) for k in (1, 2)] == [0.0, 0.0]
    u.go_to(3.2)
    assert u.now == pytest.approx([0.0, law(0.5)], rel=1e-14)


def test_an_interrupted_step_keeps_the_rest_of_the_motion(units: Any) -> None:
    u = moving(units)
    u.interrupt(2.2)
    assert u.moving
    u.go_to(2.7)
    assert u.now[1] == pytest.approx(law(0.7), rel=1e-13)
    u.finish(2.7)
    assert u.value(1) == pytest.approx(law(0.7), rel=1e-13)


@pytest.mark.parametrize(("ratio", "change"), [(0.0, "none"), (0.9, "smooth"), (1.1, "jump"), (1e6, "jump")])
def test_a_difference_beyond_rounding_of_the_motion_is_a_jump(units: Any, ratio: float, change: str) -> None:
    """1e-10 of the value plus its largest possible change in the step."""
    u = moving(units)
    u.finish(2.5)
    most = sum(abs(d) * 0.5**k / math.factorial(k) for k, d in enumerate(LAW) if k)
    reached = u.value(1)
    found = u.set(1, reached + ratio * 1e-10 * (abs(reached) + most))
    assert found == getattr(units.Change, change)


def test_after_a_step_that_was_held_any_other_value_is_a_jump(units: Any) -> None:
    u = units.Inputs(1)
    u.start(0.0)
    u.set(0, 1.0)
    u.finish(1.0)
    assert u.set(0, 1.0) == units.Change.none
    assert u.set(0, math.nextafter(1.0, 2.0)) == units.Change.jump


def test_inputs_are_the_same_functions_or_not(units: Any) -> None:
    assert moving(units).same(moving(units))
    assert not moving(units).same(moving(units, start=2.1))
    held = [units.Inputs(1) for _ in range(2)]
    for u, t in zip(held, (0.0, 5.0), strict=True):
        u.start(t)
    assert held[0].same(held[1])  # the start is irrelevant for constants
    held[1].set(0, 1e-300)
    assert not held[0].same(held[1])


def test_saved_inputs_continue(units: Any) -> None:
    u, other = moving(units), units.Inputs(2)
    u.interrupt(2.2)
    u.go_to(2.3)
    other.read(u.words())
    for one in (u, other):
        one.go_to(2.4)
    assert other.same(u)
    assert other.now == u.now
    assert other.words() == u.words()


@pytest.mark.parametrize(
    ("order", "value", "fine"),
    [
        *((0, 1.0, False), (1, 1.0, True), (5, -1e300, True), (6, 1.0, False)),
        *((1, math.inf, False), (2, math.nan, False)),
    ],
)
def test_orders_and_values_of_derivatives_are_checked(
    units: Any, order: int, value: float, fine: bool
) -> None:
    fault = units.Inputs.fault(order, value)
    assert (fault == "") == fine
    assert fine or (fault.startswith("found ") and ", expected " in fault)


# --- clock ---


@pytest.mark.parametrize("h", [1e-3, 0.1, 1 / 3, 1e-7])
@pytest.mark.parametrize("start", [0.0, 1e3])
def test_masters_that_round_differently_see_the_same_instants(units: Any, h: float, start: float) -> None:
    """One master multiplies, one sums."""
    clocks = [units.Clock() for _ in range(2)]
    for clock in clocks:
        clock.start(start)
    summed = start
    for k in range(2000):
        multiplied = start + k * h
        assert clocks[0].continues_at(multiplied, h)
        assert clocks[1].continues_at(summed, h)
        found = [clocks[0].step(multiplied, h), clocks[1].step(summed, h)]
        summed += h
        # If the sum differs from the counted steps by 1e-9 of a step, the count restarts there.
        drift = abs(summed - (start + (k + 1) * h))
        if drift <= 1e-9 * h:
            assert found[0] == found[1] == start + (k + 1) * h
        assert abs(found[1] - summed) <= 1e-9 * h + math.ulp(summed)


@pytest.mark.parametrize(("ratio", "fine"), [(0.9, True), (-0.9, True), (1.2, False), (-1.2, False)])
def test_steps_begin_where_the_last_one_ended(units: Any, ratio: float, fine: bool) -> None:
    clock = units.Clock()
    clock.start(0.0)
    clock.step(0.0, 0.1)
    assert clock.end == 0.1
    assert clock.continues_at(0.1 + ratio * 1e-9 * 0.1, 0.1) == fine


def test_another_step_size_restarts_the_count(units: Any) -> None:
    clock = units.Clock()
    clock.start(0.0)
    for k in range(3):
        clock.step(k * 0.1, 0.1)
    t = 3 * 0.1
    assert clock.step(t, 0.05) == t + 0.05
    assert clock.step(t + 0.05, 0.05) == t + 2 * 0.05
    other = units.Clock()
    other.read(clock.words())
    assert other.step(t + 0.1, 0.05) == clock.step(t + 0.1, 0.05)
    assert other.words() == clock.words()


# --- brackets ---

FUNCTIONS: dict[
    str, tuple[Callable[[float], float], float, tuple[float, float]]
] = {  # function, zero, and the ends of an interval around it
    "line": (lambda x: 3 * x - 1, 1 / 3, (0.0, 1.0)),
    "cosine": (lambda x: math.cos(x) - x, 0.7390851332151607, (0.0, 1.0)),
    "flat": (lambda x: (x - 0.3) ** 9, 0.3, (-1.0, 1.0)),
    "steep": (lambda x: math.exp(200 * (x - 0.9)) - 1, 0.9, (0.0, 1.0)),
    "jump": (lambda x: -1.0 if x < 0.123456 else 2.0, 0.123456, (0.0, 1.0)),
}


@pytest.mark.parametrize("downwards", [False, True])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_zero_remains_in_its_bracket_until_it_is_found(units: Any, name: str, downwards: bool) -> None:
    """Bisection takes 44 trials to 1e-13; a smooth function a quarter of them."""
    rising, zero, (low, high) = FUNCTIONS[name]
    sign = 1 if (rising(low) < 0) != downwards else -1

    def f(x: float) -> float:
        return sign * rising(x)

    nearest = 1e-13
    bracket = units.Bracket(low, f(low), high, f(high))
    trials = 0
    while bracket.width > 2 * nearest:
        x = bracket.next(nearest)
        assert bracket.low < x < bracket.high
        bracket.update(x, f(x))
        assert f(bracket.low) * f(bracket.high) <= 0
        trials += 1
    assert abs(bracket.low - zero) < 4 * nearest or abs(f(bracket.low)) < 1e-15
    assert trials <= {"line": 4, "cosine": 10, "jump": 50, "steep": 25, "flat": 70}[name]


# --- cubics of a step ---


def cubic_of(units: Any, c: list[float]) -> tuple[Any, Callable[[float], float]]:
    """The cubic c0 + c1 s + c2 s^2 + c3 s^3, from values and derivatives at its ends and as a function."""

    def f(s: float) -> float:
        return c[0] + s * (c[1] + s * (c[2] + s * c[3]))

    return units.Cubic(f(0), c[1], f(1), c[1] + 2 * c[2] + 3 * c[3]), f


def test_a_cubic_is_determined_by_its_ends(units: Any) -> None:
    rng = np.random.default_rng(7)
    for c in rng.uniform(-1, 1, (50, 4)):
        cubic, f = cubic_of(units, list(c))
        for s in (0, 0.2, 0.5, 0.9, 1):
            assert cubic.value(s) == pytest.approx(
                f(s), abs=1e-14
            )  # some rounding errors of numbers of size 1
        if f(0) * f(1) < 0:
            assert abs(f(cubic.zero())) < 1e-14
        rates = c[1], c[1] + 2 * c[2] + 3 * c[3]
        assert cubic.has_extremum() == (rates[0] * rates[1] < 0)
        if cubic.has_extremum():
            s = cubic.extremum()
            assert abs(c[1] + s * (2 * c[2] + 3 * s * c[3])) < 1e-13


def test_without_rates_a_cubic_is_the_line(units: Any) -> None:
    line = units.Cubic(-1.0, math.nan, 3.0, 0.0)
    assert line.zero() == pytest.approx(0.25, abs=1e-15)
    assert line.value(0.5) == pytest.approx(1, abs=1e-15)
    assert not line.has_extremum()


# --- stages of a state ---


def test_results_of_a_stage_are_invalid_when_it_is_realized_again(units: Any) -> None:
    position, velocity = units.Stage.position, units.Stage.velocity
    stages, factors, bias = units.Stages(), units.Computed(position), units.Computed(velocity)
    assert not stages.has(position)
    assert not factors.holds(stages)
    stages.realize(position)
    factors.set(stages)
    assert stages.has(position)
    assert not stages.has(velocity)
    assert factors.holds(stages)
    assert not bias.holds(stages)
    stages.realize(velocity)
    bias.set(stages)
    assert stages.has(position)
    assert stages.has(velocity)
    assert factors.holds(stages)
    assert bias.holds(stages)
    stages.realize(velocity)  # other velocities at the same position
    assert factors.holds(stages)
    assert not bias.holds(stages)
    bias.set(stages)
    stages.realize(position)
    assert not factors.holds(stages)
    assert not bias.holds(stages)
    assert not stages.has(velocity)
    factors.set(stages)
    factors.drop()
    assert not factors.holds(stages)
    factors.set(stages)
    stages.clear()
    assert not stages.has(position)
    assert not factors.holds(stages)


# --- singular configurations ---


def course(units: Any, nearest: float, step: float = 0.01) -> Any:
    """A pivot ratio that decreases to `nearest` at 0.503 s and increases again like |t - t0|."""
    passages = units.Passages()
    for t in np.arange(0, 1 + step / 2, step):
        passages.seen(t, math.hypot(t - 0.503, nearest))
        passages.accepted(t)
    return passages


@pytest.mark.parametrize(("ratio", "count"), [(0.0, 1), (0.9, 1), (1.1, 0), (10.0, 0)])
def test_a_crossing_is_reported_if_the_ratio_reaches_zero(units: Any, ratio: float, count: int) -> None:
    """The threshold is 0.02 of the best ratio; the minimum may be on either side of the lowest step."""
    best_ratio = 0.503
    found = course(units, ratio * 0.02 * best_ratio)
    assert found.count == count
    if count:
        assert found.last == pytest.approx(0.503, abs=0.005)  # half a step


def test_a_crossing_is_undone_with_the_run(units: Any) -> None:
    found = course(units, 0.0)
    again = units.Passages()
    again.read(found.words())
    assert (again.count, again.last) == (found.count, found.last)
    found.restart(0.7)
    assert found.count == 1
    found.restart(0.4)
    assert found.count == 0
