# SPDX-License-Identifier: BSD-3-Clause
"""Rotations that take the z-axis to a direction, above all near its opposite, where there are several."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array

ROUNDING = 2e-15  # an entry (1 - cos) a a has four roundings of numbers up to 2


def rotation(units: Any, n: Array) -> Array:
    return np.array(units.rotation_taking_z_to(*n))


def normalized(*n: float) -> Array:
    return np.array(n) / np.linalg.norm(n)


@pytest.mark.parametrize("down", [1, -1])
def test_z_goes_where_it_should_however_near_its_opposite(units: Any, down: int) -> None:
    """Directions whose z-component is -1 but for rounding: 1 + cos has no correct digit there."""
    rng = np.random.default_rng(1)
    for exponent in np.arange(-20.0, 0.1, 0.5):
        for _ in range(20):
            x, y = 10**exponent * rng.uniform(-1, 1, 2)
            n = normalized(x, y, down * np.sqrt(max(0.0, 1 - x * x - y * y)))
            R = rotation(units, n)
            # Directions within 1e-15 of -z are taken for -z.
            np.testing.assert_allclose(R[:, 2], n, rtol=0, atol=1.1e-15)
            np.testing.assert_allclose(R.T @ R, np.eye(3), rtol=0, atol=ROUNDING)
            assert np.linalg.det(R) > 0


def test_a_component_of_minus_one_with_an_error_in_the_last_place(units: Any) -> None:
    """Products of rotation matrices give such normals."""
    for z in (-1.0, np.nextafter(-1.0, 0), np.nextafter(-1.0, -2), -1 + 4e-16):
        for x, y in ((0.0, 0.0), (1e-17, -3e-17), (-0.0, 1e-16)):
            np.testing.assert_array_equal(rotation(units, np.array([x, y, z])), np.diag([1, -1, -1]))


def test_the_rotation_is_the_shortest(units: Any) -> None:
    """Its axis is perpendicular to z and n, so its trace is 1 + 2 cos."""
    for n in (normalized(1, 2, 3), normalized(1, 2, -3), normalized(1e-3, 0, -1), normalized(1, 0, 0)):
        R = rotation(units, n)
        assert np.trace(R) == pytest.approx(1 + 2 * n[2], abs=1e-15)
        axis = np.cross([0, 0, 1], n)
        np.testing.assert_allclose(R @ axis, axis, rtol=0, atol=ROUNDING)
