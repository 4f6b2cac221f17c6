# SPDX-License-Identifier: BSD-3-Clause
"""Projections onto cones of contact, against minimizations by scipy and their defining properties."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array
from scipy.optimize import minimize

GROUPS = {"t": (1, 3), "s": (3, 4), "r": (4, 6)}
ROUNDING = 4e-15  # of a few operations on numbers about 1 to 4


def minimized(y: Array, limits: list[tuple[slice, float]]) -> Array:
    """The nearest point, by sequential quadratic programming with differentiable constraints."""
    constraints: list[dict[str, Any]] = [{"type": "ineq", "fun": lambda x: x[0]}]
    for part, mu in limits:
        constraints.append(
            {"type": "ineq", "fun": lambda x, part=part, mu=mu: (mu * x[0]) ** 2 - x[part] @ x[part]}
        )
    start = np.zeros(len(y))
    start[0] = np.abs(y).max() + 1
    found = minimize(
        lambda x: 0.5 * (x - y) @ (x - y),
        start,
        jac=lambda x: x - y,
        constraints=constraints,
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    return np.asarray(found.x)


@pytest.mark.parametrize(
    "coefficients", [(0.5, 0, 0), (0.7, 0.2, 0), (0.7, 0, 0.3), (0.9, 0.3, 0.1), (2.5, 1.5, 0.5)]
)
def test_a_projection_is_the_nearest_point(units: Any, coefficients: tuple[float, float, float]) -> None:
    cone = units.Cone.contact(0, *coefficients)
    limits, first = [], 1
    for mu, size in zip(coefficients, (2, 1, 2), strict=True):
        if mu > 0:
            limits.append((slice(first, first + size), mu))
            first += size
    assert cone.size == first
    rng = np.random.default_rng(first)
    nearer = 0
    for _ in range(40):
        y = rng.normal(size=first) * [rng.choice([0.3, 3]), *[1] * (first - 1)]
        found = np.array(cone.project(list(y)))
        assert all(np.linalg.norm(found[part]) <= mu * found[0] + ROUNDING for part, mu in limits)
        reference = minimized(y, limits)
        # SLSQP stops where the objective has settled to 1e-15: some 1e-7 in x, also outside the cone.
        assert np.linalg.norm(found - y) <= np.linalg.norm(reference - y) + 1e-6
        nearer += int(np.linalg.norm(found - reference) < 1e-6)
    assert nearer > 25  # and there it is the same point


def cases(rng: np.random.Generator) -> list[tuple[tuple[float, float, float], Array]]:
    found = []
    for coefficients in [(0.5, 0.0, 0.0), (0.6, 0.2, 0.1), (1e-3, 5.0, 0.4), (1e6, 0.0, 1e-9)]:
        size = 1 + sum(n for mu, n in zip(coefficients, (2, 1, 2), strict=True) if mu > 0)
        for _ in range(50):
            found.append((coefficients, rng.normal(size=size) * 10 ** rng.uniform(-12, 6)))
    return found


def test_projections_split_vectors_into_orthogonal_parts(units: Any) -> None:
    """Moreau 1962: y = P_K(y) - P_K*(-y), the parts orthogonal; projecting twice changes nothing."""
    for coefficients, y in cases(np.random.default_rng(1)):
        cone = units.Cone.contact(0, *coefficients)
        x = np.array(cone.project(list(y)))
        rest = x - y
        size = np.linalg.norm(y)
        assert abs(x @ rest) <= 1e-14 * size**2  # six products of numbers up to |y|
        lengths, first = 0.0, 1
        for mu, n in zip(coefficients, (2, 1, 2), strict=True):
            if mu > 0:
                lengths += mu * np.linalg.norm(rest[first : first + n])
                first += n
        assert rest[0] >= lengths - 1e-14 * size * (1 + max(coefficients))  # in the dual cone
        assert np.array(cone.project(list(x))) == pytest.approx(x, abs=4e-16 * size)


def test_a_jacobian_is_the_derivative(units: Any) -> None:
    """Against finite differences, and with the properties of every projection: symmetric, between 0 and 1."""
    for coefficients, y in cases(np.random.default_rng(2))[:150]:
        cone = units.Cone.contact(0, *coefficients)
        y = y / np.linalg.norm(y)
        n = len(y)
        J = np.array(cone.projection_jacobian(list(y))).reshape(n, n)
        assert pytest.approx(J.T, abs=1e-15) == J
        values = np.linalg.eigvalsh(J)
        assert values.min() >= -ROUNDING
        assert values.max() <= 1 + ROUNDING
        h = 1e-6  # error of central differences about 1e-12 from truncation, 1e-10 from rounding
        columns = [
            (np.array(cone.project(list(y + h * e))) - np.array(cone.project(list(y - h * e)))) / (2 * h)
            for e in np.eye(n)
        ]
        # A boundary between pieces within h is met by about one of 1e5 cases.
        assert np.array(columns) == pytest.approx(J, abs=1e-5)


def test_special_points(units: Any) -> None:
    cone = units.Cone.contact(0, 0.5)
    project = cone.project
    assert project([0, 0, 0]) == [0, 0, 0]
    assert project([-1, 0.1, 0.2]) == [0, 0, 0]
    assert project([-1, 2, 0]) == [0, 0, 0]  # on the boundary of the polar cone: 0.5 * 2 = 1
    assert project([-1, 2.1, 0])[0] > 0
    assert project([1, 0.3, 0.4]) == [1, 0.3, 0.4]  # on the boundary: |t| = 0.5
    assert project([2, 0.3, 0.4]) == [2, 0.3, 0.4]
    assert project([0, 0, 5]) == pytest.approx([2, 0, 1], rel=1e-15)  # n = mu t / (1 + mu^2)


@pytest.mark.parametrize("y", [[1.0, 2.0, -3.0], [-1.0, 2.0, 3.0], [0.0, 1.0, 0.0]])
def test_components_without_friction_vanish(units: Any, y: list[float]) -> None:
    cone = units.Cone.contact(0, 0.0)
    assert cone.size == 1
    cone.tangential = 2
    assert cone.size == 3
    assert cone.project(y) == [max(y[0], 0), 0, 0]
    jacobian = np.array(cone.projection_jacobian(y)).reshape(3, 3)
    assert (jacobian == np.diag([float(y[0] > 0), 0, 0])).all()


def test_intervals(units: Any) -> None:
    inf = np.inf
    for lower, upper, y, expected, derivative in [
        (-1, 2, 0.5, 0.5, 1), (-1, 2, 3, 2, 0), (-1, 2, -3, -1, 0), (0, inf, 5, 5, 1),
        (0, inf, -1e-300, 0, 0), (-inf, inf, -7, -7, 1), (0, 0, 3, 0, 0), (0, 0, 0, 0, 0),
    ]:  # fmt: skip
        cone = units.Cone.within(0, lower, upper)
        assert cone.project([y]) == [expected]
        assert cone.projection_jacobian([y]) == [derivative]


def test_a_contact_in_a_plane_has_single_components(units: Any) -> None:
    cone = units.Cone.planar_contact(0, 0.5, 0.1)
    assert cone.size == 3
    assert cone.project([1, 2, 0.05]) == pytest.approx(
        [1.6, 0.8, 0.05], rel=1e-15
    )  # n = (1 + 0.5 * 2) / 1.25
    assert cone.project([1, -2, 0.05]) == pytest.approx([1.6, -0.8, 0.05], rel=1e-15)
