# SPDX-License-Identifier: BSD-3-Clause
"""Tables in expressions: values and derivatives against SciPy, held segments, breaks in time, mistakes."""

from __future__ import annotations

import math
import re
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy import interpolate

KINDS = ["linear", "pchip", "akima", "spline"]
BEYOND = ["hold", "linear", "refuse", "periodic"]
X, Y = [-1.0, -0.4, 0.0, 0.3, 1.2], [0.0, 0.5, 2.0, 2.5]
VALUES = [[math.sin(3 * x) * math.exp(-y) + y for y in Y] for x in X]


def as_scipy(kind: str, x: Any, values: Any) -> Any:
    """Along the first axis."""
    if kind == "spline":
        return interpolate.CubicSpline(x, values, bc_type="natural")
    return {"pchip": interpolate.PchipInterpolator, "akima": interpolate.Akima1DInterpolator}[kind](x, values)


@pytest.mark.parametrize("kind", KINDS[1:])
def test_tables_have_the_values_and_derivatives_of_scipy(units: ModuleType, kind: str) -> None:
    """Over one argument at 200 places; over two, along lines of points, and differences in between."""
    one = units.Table("m", X, [], [row[0] for row in VALUES], KINDS.index(kind), 1)
    curve = as_scipy(kind, X, [row[0] for row in VALUES])
    expression = units.Expression("table(m, s)", ["s"], [one])
    for x in np.linspace(-1, 1.2, 201)[1:-1]:
        assert expression.value([x]) == pytest.approx(float(curve(x)), abs=1e-15)
        assert expression.gradient([x])[0] == pytest.approx(float(curve(x, 1)), abs=1e-14)
        assert expression.derivative([0, 0], [x]) == pytest.approx(float(curve(x, 2)), abs=1e-12)
        assert expression.derivative([0, 0, 0], [x]) == pytest.approx(float(curve(x, 3)), abs=1e-11)
        assert expression.derivative([0] * 4, [x]) == 0
        series = expression.series([x], [2.0], [0.5])
        assert series[1] == pytest.approx(2 * float(curve(x, 1)), abs=1e-13)
        assert series[2] == pytest.approx(float(curve(x, 1)) / 4 + 2 * float(curve(x, 2)), abs=1e-12)
    two = units.Table("m", X, Y, [value for row in VALUES for value in row], KINDS.index(kind), 0)
    expression = units.Expression("table(m, s, v)", ["s", "v"], [two])
    for j, y in enumerate(Y):
        along = as_scipy(kind, X, [row[j] for row in VALUES])
        for x in (-0.9, -0.3, 0.1, 0.7):
            assert expression.value([x, y]) == pytest.approx(float(along(x)), abs=1e-15)
            assert expression.gradient([x, y])[0] == pytest.approx(float(along(x, 1)), abs=1e-14)
    x, y, h = 0.11, 1.3, 1e-4
    a, b = 0.7, -0.4  # directions
    line = [expression.value([x + k * h * a, y + k * h * b]) for k in (-2, -1, 0, 1, 2)]
    first = (line[0] - 8 * line[1] + 8 * line[3] - line[4]) / (12 * h)
    second = (-line[0] + 16 * line[1] - 30 * line[2] + 16 * line[3] - line[4]) / (12 * h * h)
    gradient = expression.gradient([x, y])
    assert a * gradient[0] + b * gradient[1] == pytest.approx(first, abs=1e-11)  # rounding of differences
    series = expression.series([x, y], [a, b], [0.0, 0.0])
    assert 2 * series[2] == pytest.approx(second, abs=1e-6)
    symbolic = sum(
        (a, b)[j] * (a, b)[k] * expression.derivative([j, k], [x, y]) for j in (0, 1) for k in (0, 1)
    )
    assert symbolic == pytest.approx(2 * series[2], abs=1e-13)


@pytest.mark.parametrize("size", [2, 3, 4])
@pytest.mark.parametrize("kind", KINDS)
def test_tables_of_few_points(units: ModuleType, kind: str, size: int) -> None:
    x, values = [0.0, 1.0, 1.5, 3.0][:size], [1.0, 2.0, -1.0, 1.0][:size]
    found = units.Expression("table(m, s)", ["s"], [units.Table("m", x, [], values, KINDS.index(kind), 0)])
    for at, value in zip(x, values, strict=True):
        assert found.value([at]) == value
    if kind == "linear" or size == 2:
        assert found.value([0.25]) == 1.25
    elif kind != "akima":  # of three points SciPy's has another continuation of derivatives
        assert found.value([0.25]) == pytest.approx(float(as_scipy(kind, x, values)(0.25)), abs=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_held_segments_are_smooth_beyond_their_ends(units: ModuleType, kind: str) -> None:
    """The polynomial of the segment from 0 to 0.3 goes on; also where the state is many segments away."""
    table = units.Table("m", X, [], [row[0] for row in VALUES], KINDS.index(kind), 0)
    expression = units.Expression("table(m, s)", ["s"], [table])
    sides = [argument > 0 for argument in expression.arguments([0.1])]
    assert sides == [True, True, True, False, False]
    inside = [expression.value([x]) for x in (0.05, 0.1, 0.15, 0.2)]
    cubic = np.polynomial.Polynomial.fit([0.05, 0.1, 0.15, 0.2], inside, 3)
    for x in (-0.7, 0.6, 2.0):
        assert expression.held([x], sides) == pytest.approx(float(cubic(x)), abs=1e-11)


def test_breaks_of_tables_of_the_time(units: ModuleType) -> None:
    """t, forward and backward, scaled, repeated: the next point after each. None in what is not straight."""
    table = units.Table("m", X, [], [row[0] for row in VALUES], 1, 0)
    again = units.Table("m", [0.0, 0.25, 1.0], [], [0.0, 1.0, 0.0], 1, 3)

    def breaks(text: str, start: float, count: int, of: Any = table) -> list[float]:
        expression, out = units.Expression(text, ["s", "t"], [of], 1), [start]
        while len(out) <= count:
            out.append(expression.next_break(out[-1]))
        return out[1:]

    assert breaks("table(m, t)", -2.0, 6) == [*X, math.inf]
    assert breaks("table(m, 1 - 2*t)", -1.0, 6) == pytest.approx([*((1 - x) / 2 for x in X[::-1]), math.inf])
    assert breaks("s + table(m, t)^2*table(m, t - 1)", 0.25, 3) == [0.3, 0.6, 1.0]
    assert breaks("table(m, t/3)", 1e6, 1) == [math.inf]
    assert breaks("table(m, t)", 99.0, 4, again) == [99.25, 100.0, 100.25, 101.0]
    assert breaks("table(m, s*t) + table(m, sin(t))", 0.0, 1) == [math.inf]
    # Each is told once, although times are rounded.
    thirds = breaks("table(m, (t - 0.1)/3)", 0.0, 40, again)
    assert thirds == pytest.approx([0.1 + 3 * (k // 2 + 0.25 * (k % 2)) for k in range(40)])


def test_curves_that_overshoot_are_doubted(units: ModuleType) -> None:
    """Beyond 10 % of the range of values; the largest excess of SciPy's spline, found at 10,000 places."""
    x = [0.0, 1.0, 1.1, 3.0, 4.0]
    for last in (1.0, 5.0):
        values = [0.0, 0.0, 1.0, 1.0, last]
        at = np.linspace(0, 4, 400001)
        curve = as_scipy("spline", x, values)(at)
        below, above = (np.array(values)[np.clip(np.searchsorted(x, at) + k, 0, 4)] for k in (-1, 0))
        excess = np.maximum(curve - np.maximum(below, above), np.minimum(below, above) - curve)[1:].max()
        found = units.doubt_about(units.Table("m", x, [], values, 3, 0))
        assert f"by up to {round(100 * excess / max(values))} %" in found
        assert units.doubt_about(units.Table("m", x, [], values, 1, 0)) == ""
    assert units.doubt_about(units.Table("m", [0, 1, 2, 3], [], [0, 1, 1.1, 1.2], 3, 0)) == ""  # 3 %


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("table(n, s)", "found 'n', which is no table, expected one of m, two"),
        ("table(m)", "found 1 argument, expected 2: table(m, x)"),
        ("table(m, s, s)", "found 3 arguments, expected 2: table(m, x)"),
        ("table(two, s)", "found 2 arguments, expected 3: table(two, x, y)"),
        ("table('m', s)", "names are written without quotes"),
        ('table("m", s)', "names are written without quotes"),
        ("table(2, s)", "expected the name of a table"),
        ("table()", "expected the name of a table"),
        ("table(", "found the end, expected the name of a table"),
        ("table(m, s > 0)", "expected a number"),
        ("table(m, s", "without ')'"),
        ("lookup(m, s)", "write table(name, x)"),
        ("table", "table(name, x)"),
        ("m", "found 'm'"),
    ],
)
def test_mistakes_with_tables(units: ModuleType, text: str, answer: str) -> None:
    tables = [
        units.Table("m", [0.0, 1.0], [], [0.0, 1.0], 0, 0),
        units.Table("two", [0.0, 1.0], [0.0, 1.0], [0.0, 1.0, 2.0, 3.0], 0, 0),
    ]
    with pytest.raises(ValueError, match=re.escape(answer)):
        units.Expression(text, ["s"], tables)
