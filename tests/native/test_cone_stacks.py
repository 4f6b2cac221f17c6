# SPDX-License-Identifier: BSD-3-Clause
"""Hyperstatic stacks of boxes: more contact impulses in the corners than degrees of freedom."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array

KICK = 9.81e-3  # m/s, of gravity in a step of 1 ms
MU = 0.5
TOLERANCE = 1e-10  # m/s


HALF = 0.1  # m, of an edge


def rows_of_corners(boxes: int) -> Array:
    """Return the Jacobian of a tower of cubes of 0.2 m with contacts in their corners."""
    half = HALF
    jacobian = np.zeros((12 * boxes, 6 * boxes))
    for k in range(boxes):
        for c in range(4):
            corner = half * np.array([(-1) ** c, (-1) ** (c // 2), -1])
            rows = slice(12 * k + 3 * c, 12 * k + 3 * c + 3)
            for body, sign, arm in ((k, 1, corner), (k - 1, -1, corner * [1, 1, -1])):
                if body < 0:
                    continue
                x, y, z = arm
                turn = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])  # v + w x arm
                block = sign * np.hstack([np.eye(3), turn])[[2, 0, 1]]  # normal first
                jacobian[rows, 6 * body : 6 * body + 6] += block
    return jacobian


def inverse_masses(boxes: int) -> Array:
    """Of cubes of 1 kg: inverse masses [1/kg] and moments of inertia [1/(kg m2)]."""
    return np.tile([1, 1, 1, *[1.5 / HALF**2] * 3], boxes)


def stack_root(boxes: int) -> Array:
    """Return W^T of G = W^T W."""
    return rows_of_corners(boxes) * np.sqrt(inverse_masses(boxes))


def stack(boxes: int, seed: int | None = None, push: float = 0.0) -> tuple[Array, Array]:
    """Return G and b of the tower.

    seed: of random velocities up to 1 % of `push`; push: velocity of the top cube along x [m/s].
    """
    jacobian = rows_of_corners(boxes)
    v = np.zeros(6 * boxes)
    v[2::6] = -KICK
    v[6 * boxes - 6] += push
    if seed is not None:
        v += 0.01 * push * np.random.default_rng(seed).uniform(-1, 1, len(v))
    return jacobian @ np.diag(inverse_masses(boxes)) @ jacobian.T, jacobian @ v


def solve(units: Any, name: str, G: Array, b: Array, **options: Any) -> Any:
    cones = [units.Cone.contact(3 * i, MU) for i in range(len(b) // 3)]
    given = {"tolerance": TOLERANCE, "max_iterations": 2000, **options}
    start = list(given.pop("start", np.zeros(len(b))))
    return units.ConeSolver(name).solve(G.tolist(), list(b), cones, start, **given)


@pytest.mark.parametrize("boxes", [1, 2, 5, 10, 20])
def test_a_stack_rests(units: Any, boxes: int) -> None:
    """Every interface carries the weight above it; nothing moves, not even by a rounding error that grows."""
    G, b = stack(boxes)
    found = solve(units, "hybrid", G, b)
    x = np.array(found.x)
    assert found.converged
    assert np.abs(G @ x + b).max() < 2 * TOLERANCE
    weights = x[::3].reshape(boxes, 4).sum(axis=1)
    assert weights == pytest.approx(KICK * np.arange(boxes, 0, -1), rel=1e-6)
    assert x[::3].min() > 0  # no corner is left out
    again = solve(units, "hybrid", G, b, start=x)
    assert again.iterations == 0


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(("boxes", "push"), [(5, 0.3), (10, 1.0), (20, 0.3)])
def test_pushed_stacks_are_solved_to_the_tolerance(units: Any, boxes: int, push: float, exact: bool) -> None:
    """Corners slide, stick and open at once; Newton's method with monotone steps fails in these."""
    for seed in range(4):
        G, b = stack(boxes, seed, push)
        found = solve(units, "hybrid", G, b, exact=exact)
        assert found.converged, (seed, found.residual, found.iterations)
        u = (G @ np.array(found.x) + b).reshape(-1, 3)
        x = np.array(found.x).reshape(-1, 3)
        lift = np.zeros(len(u)) if exact else MU * np.hypot(u[:, 1], u[:, 2])
        assert (u[:, 0] >= lift - 1e-9).all()
        # Power of friction and normal impulses: complementarity up to the tolerance times the impulses.
        shift = MU * np.hypot(u[:, 1], u[:, 2]) if exact else np.zeros(len(u))
        assert np.abs((x * u).sum(axis=1) + x[:, 0] * shift).max() < 1e-8 * np.abs(x).max()


@pytest.mark.parametrize("matrix_free", [False, True])
def test_beyond_a_hundred_contacts_gradients_come_first(units: Any, matrix_free: bool) -> None:
    """32 boxes, 384 unknowns: with a matrix Newton's method finishes; without one it is never formed."""
    few, many = (stack(boxes) for boxes in (25, 26))  # 300 and 312 unknowns
    assert solve(units, "hybrid", *few).iterations < 100  # Newton's method alone
    found = solve(units, "hybrid", *many, matrix_free=matrix_free, max_iterations=4000)
    assert found.iterations > 300
    assert found.products < 2 * found.iterations
    if not matrix_free:
        assert found.converged
    else:
        assert found.residual < 1e-6
