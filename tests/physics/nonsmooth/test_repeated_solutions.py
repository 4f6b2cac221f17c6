# SPDX-License-Identifier: BSD-3-Clause
"""The last solution is returned under the same conditions: nothing depends on it.

Without the reduction of outputs each solution computes them, and none is repeated.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from models import contact_law_cases, joint_law_cases, laws_that_meet
from models.both_schemes import STEPS, Case, Running

CASES: dict[str, Callable[[], Case]] = {
    **joint_law_cases.CASES, **contact_law_cases.CASES, **laws_that_meet.CASES
}  # fmt: skip


@pytest.mark.parametrize(
    "scheme",
    [
        "auto",
        "moreau-jean",
        *(pytest.param(name, marks=pytest.mark.thorough) for name in ("rk4", "erk", "dirk")),
    ],
)
def test_runs_are_the_same_to_the_bit(scheme: str) -> None:
    for name, make in CASES.items():
        runs = []
        for repeats in (True, False):
            case = make()
            running = Running(case, scheme, STEPS[0], reductions=None if repeats else {"outputs": False})
            runs.append(np.array([running.advance(t) for t in case.times()]))
        assert np.array_equal(runs[0], runs[1], equal_nan=True), name
