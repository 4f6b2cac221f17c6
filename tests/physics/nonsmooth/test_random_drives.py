# SPDX-License-Identifier: BSD-3-Clause
"""Random drives with clutches, one-way clutches and gears with losses, against a search through all modes."""

from __future__ import annotations

import pytest
from models.random_drives import TOLERANCE, difference, random_drive


@pytest.mark.parametrize("seed", range(60))
def test_speeds_of_random_drives(seed: int) -> None:
    """`python -m models.random_drives` compares more of them."""
    integrator = ("erk", "cvode", "ida", "dirk")[seed % 4]
    # The tolerance is that of a step; errors of the instants of ten events add up.
    assert difference(random_drive(seed), integrator) <= 1000 * TOLERANCE
