# SPDX-License-Identifier: BSD-3-Clause
"""Designs of sweeps: which values the runs have."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

import gelenk
from gelenk.sweeps.design import designed


def test_a_grid_has_all_combinations_in_the_order_of_the_arrays() -> None:
    found = designed({"a": [1, 2], "b": 7.0, "c": ["x", "y", "z"]}, "grid", None, 0)
    pairs = list(zip(found.columns["a"].tolist(), found.columns["c"].tolist(), strict=True))
    assert pairs == [(1, "x"), (1, "y"), (1, "z"), (2, "x"), (2, "y"), (2, "z")]
    assert found.constants == {"b": 7.0}
    assert found.runs == 6


def test_a_list_takes_values_together() -> None:
    found = designed({"a": np.array([1.0, 2.0]), "b": (3, 3)}, "list", None, 0)
    assert {name: column.tolist() for name, column in found.columns.items()} == {"a": [1, 2], "b": [3, 3]}


@pytest.mark.parametrize(
    ("law", "quantiles"),
    [
        ("uniform(2, 4)", {0.25: 2.5, 0.5: 3.0}),
        ("loguniform(1, 100)", {0.5: 10.0}),
        ("normal(5, 0.1)", {0.5: 5.0, stats.norm.cdf(2): 5.2}),
        ("lognormal(3, 0.5)", {0.5: 3.0, stats.norm.cdf(1): 3 * np.exp(0.5)}),
        ("truncnormal(1, 0.1, 0.9, 1.1)", {0.5: 1.0}),
        ("triangular(0, 1, 2)", {0.5: 1.0, 0.125: 0.5}),  # F(x) = x^2 / 2 below the mode
    ],
)
def test_distributions_have_their_quantiles(law: str, quantiles: dict[float, float]) -> None:
    """A Latin hypercube of n points has one point in each of n intervals of equal probability."""
    n = 200
    x = np.sort(designed({"a": law}, "latin", n, 3).columns["a"])
    for probability, value in quantiles.items():
        below = np.count_nonzero(x <= value)
        assert abs(below - probability * n) <= 1  # the interval with the quantile itself counts half
    assert len(x) == n


def test_every_interval_of_a_latin_hypercube_has_one_point() -> None:
    found = designed({"a": "uniform(0, 1)", "b": stats.uniform()}, "latin", 64, 0)
    for column in found.columns.values():
        assert np.sort(np.floor(column * 64)).tolist() == list(range(64))


def test_every_elementary_interval_of_sobol_points_has_one_point() -> None:
    """2^m points in two dimensions are a (0, m, 2)-net (Sobol 1967): so are 4 x 16 boxes of 64 points."""
    found = designed({"a": "uniform(0, 1)", "b": "uniform(0, 1)"}, "sobol", 64, 5)
    boxes = np.floor(found.columns["a"] * 4) * 16 + np.floor(found.columns["b"] * 16)
    assert np.sort(boxes).tolist() == list(range(64))


def test_seeds_repeat_and_differ() -> None:
    def points(kind: str, seed: int) -> bytes:
        return designed({"a": "normal(0, 1)"}, kind, 16, seed).columns["a"].tobytes()

    for kind in ("latin", "sobol", "random"):
        assert points(kind, 1) == points(kind, 1) != points(kind, 2)


@pytest.mark.parametrize(
    ("parameters", "options", "sentence"),
    [
        (
            {"a": [1, 2], "b": [1]},
            {"design": "list"},
            "found 2 of a, 1 of b; expected as many values of each",
        ),
        ({"a": [1, 1]}, {}, "a: found a value twice"),
        ({"a": []}, {}, "a: found an array of shape (0,), expected a list of values"),
        ({"a": "normal(1, 2)"}, {}, "a: found a distribution with the design grid"),
        ({"a": [1, 2]}, {"design": "latin", "samples": 4}, "a: found a list of values with the design latin"),
        ({"a": "normal(1)"}, {"design": "latin"}, "found normal(1), expected normal(mean, deviation)"),
        ({"a": "normal(1, -2)"}, {"design": "latin"}, "deviations positive"),
        ({"a": "uniform(2, 1)"}, {"design": "latin"}, "in increasing order"),
        (
            {"a": "weibull(1)"},
            {"design": "latin"},
            "found the distribution 'weibull', expected one of uniform",
        ),
        ({"a": "normal(1, 2)"}, {"design": "latin"}, "samples: found None"),
        (
            {"a": "normal(1, 2)"},
            {"design": "sobol", "samples": 100},
            "expected a power of 2 for the design sobol",
        ),
        ({"a": 1}, {"design": "latin", "samples": 4}, "parameters: found no distribution"),
        ({"a": [1, 2]}, {"design": "cube"}, "design: found 'cube', expected one of grid, list"),
        ({"a": [1, 2]}, {"samples": 3}, "samples: found 3 with the design grid, expected none"),
        ({"a": range(20_000), "b": range(20_000)}, {}, "the design has 400000000 runs, expected at most"),
    ],
)
def test_designs_that_cannot_be_made_say_why(
    parameters: dict[str, Any], options: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(gelenk.UsageError) as caught:
        designed(parameters, options.get("design", "grid"), options.get("samples"), 0)
    assert sentence in str(caught.value)
