# SPDX-License-Identifier: BSD-3-Clause
"""The chart of docs/coupling.md: orders of the error of laws that a master closes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks import coupling


@pytest.mark.parametrize("make", coupling.LOOPS, ids=lambda make: make.__name__)
def test_each_derivative_adds_an_order(make: Callable[[], coupling.Loop]) -> None:
    """At 1 and 2 ms; the drive that sticks is at rest for most of its run, with the same orders."""
    found = coupling.measured(make(), (2e-3, 1e-3))
    for expected, way in enumerate(coupling.WAYS[:-1], 1):
        # The gas spring gains energy from a held force, by which its error grows in addition.
        slack = 1.2 if make is coupling.gas_spring and way == "held" else 0.25
        assert abs(coupling.order(found[way], 2e-3, 1e-3) - expected) < slack, way
    assert all(of.error < 1e-11 for of in found["inside"].values()), "10 tolerances of the plant"


def test_a_run_that_diverges_is_shown_as_such() -> None:
    assert coupling.cell(coupling.Measured(3.0, 0)) == "diverged"
    assert coupling.cell(coupling.Measured(1e-14, 0)) == "< 1e-12"
    assert coupling.cell(coupling.Measured(2e-3, 0)) == "2e-03"
