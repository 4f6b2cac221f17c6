# SPDX-License-Identifier: BSD-3-Clause
"""Cone problems with a sparse root of G, which Newton's methods factorize in the space of velocities."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from mechanisms import Array

from gelenk.chart.cone_problems import COUNT, cone_problem

from .test_cone_solvers import cones_of
from .test_cone_stacks import KICK, MU, TOLERANCE, stack, stack_root


def solve(units: Any, W: Array, b: Array, cones: list[Any] | None = None, **options: Any) -> Any:
    """W: columns of the root, one row of the array for each unknown."""
    cones = cones or [units.Cone.contact(3 * i, MU) for i in range(len(b) // 3)]
    given = {"start": [0.0] * len(b), "tolerance": TOLERANCE, "max_iterations": 2000, **options}
    return units.ConeSolver("hybrid").solve_root(W.tolist(), list(b), cones, **given)


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("kind", ["dense", "chain", "redundant"])
def test_problems_with_a_root_are_solved(units: Any, kind: str, exact: bool) -> None:
    """The hundred problems, whose published solutions are those of the convex ones."""
    for problem in map(cone_problem, range(COUNT)):
        if problem.kind != kind:
            continue
        values, vectors = np.linalg.eigh(problem.G)
        W = vectors * np.sqrt(np.maximum(values, 0))
        tolerance = 1e-11 * np.linalg.norm(problem.b)
        found = solve(units, W, problem.b, cones_of(units, problem), tolerance=tolerance, exact=exact)
        assert found.converged, (problem.number, found.residual)
        # W W^T differs from G by rounding, which condition numbers up to 1e6 amplify.
        if not exact:
            assert problem.residual(np.array(found.x)) < 1e-9, problem.number


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(("boxes", "push"), [(10, 1.0), (20, 0.3), (40, 0.3), (60, 0.1)])
def test_pushed_towers_are_solved_to_the_tolerance(units: Any, boxes: int, push: float, exact: bool) -> None:
    """Corners slide, stick and open at once, with singular matrices G of condition boxes^4.

    Convex problems are solved to the rounding of such matrices, those of Coulomb's law at least to 1e-6.
    """
    for seed in range(3):
        G, b = stack(boxes, seed, push)
        found = solve(units, stack_root(boxes), b, exact=exact)
        bound = 1e-6 if exact else 2 * TOLERANCE
        assert found.residual <= bound, (seed, found.iterations)
        x = np.array(found.x).reshape(-1, 3)
        u = (G @ x.ravel() + b).reshape(-1, 3)
        assert (np.hypot(x[:, 1], x[:, 2]) <= MU * x[:, 0] * (1 + 1e-12)).all()
        shift = MU * np.hypot(u[:, 1], u[:, 2]) if exact else np.zeros(len(u))
        assert (u[:, 0] + shift >= MU * np.hypot(u[:, 1], u[:, 2]) - 10 * bound).all()
        assert np.abs((x * u).sum(axis=1) + x[:, 0] * shift).max() < 100 * bound * np.abs(x).max()


def test_a_tower_of_a_hundred_boxes_rests(units: Any) -> None:
    """Every interface carries the weight above it, and the solution is that of the next step."""
    G, b = stack(100)
    found = solve(units, stack_root(100), b)
    x = np.array(found.x)
    assert found.converged
    assert np.abs(G @ x + b).max() < 2 * TOLERANCE
    assert x[::3].reshape(100, 4).sum(axis=1) == pytest.approx(KICK * np.arange(100, 0, -1), rel=1e-6)
    assert x[::3].min() > 0
    assert solve(units, stack_root(100), b, start=list(x)).iterations == 0


@pytest.mark.parametrize(("exact", "most"), [(False, 4), (True, 20)])
def test_a_change_of_rounding_is_solved_beside_the_last_solution(units: Any, exact: bool, most: int) -> None:
    """A tower pushed apart by 1e-11 m/s: redundant impulses do not wander, few factorizations suffice.

    Newton's method alone takes 47 for Coulomb's law from the same start.
    """
    b = stack(60)[1]
    x = np.array(solve(units, stack_root(60), b, exact=exact).x)
    change = stack_root(60) @ np.random.default_rng(1).uniform(-1e-11, 1e-11, 360)
    found = solve(units, stack_root(60), b + change, exact=exact, start=list(x), tolerance=1e-13)
    assert found.converged
    assert 0 < found.iterations <= most
    assert np.abs(found.x - x).max() < 1e-4


def sweeps(units: Any, velocities: int, unknowns: int, max_iterations: int = 3000) -> bool:
    """Whether a problem with a dense root is solved by sweeps, or, of few iterations, is begun by them.

    They count one product each; up to 300 unknowns, a sweep is an iteration, beyond, five are.
    """
    rng = np.random.default_rng(1)
    W = rng.normal(size=(unknowns, velocities)) / np.sqrt(velocities)
    b = rng.normal(size=unknowns)
    found = solve(units, W, b, exact=False, max_iterations=max_iterations, tolerance=1e-8)
    assert found.converged or found.residual < 1e-4 or found.iterations == max_iterations < 100
    each = 1 if unknowns <= 300 else 5
    return found.products - each * found.iterations in (1, 2)


def test_factors_that_fill_in_are_not_used(units: Any) -> None:
    """Cubes of the number of velocities, by three, on either side of 3e8 multiplications."""
    assert not sweeps(units, 940, 1470, max_iterations=12)
    assert sweeps(units, 990, 1485, max_iterations=12)


def test_loose_heaps_are_swept(units: Any) -> None:
    """Where a factorization costs more than eight products, unless unknowns exceed velocities by half."""
    assert not sweeps(units, 45, 45)  # 45^2 / 6 / 45 = 7.5 products
    assert sweeps(units, 54, 54)  # 9
    assert not sweeps(units, 54, 84)  # 5.8
    assert sweeps(units, 84, 120)  # 9.8
    assert not sweeps(units, 84, 129)  # 9.1, but 129 > 126


def test_the_same_problems_give_the_same_bits(units: Any) -> None:
    """Also after another problem: patterns and factors that are kept do not change results."""
    b = stack(12, 3, 0.3)[1]
    first = solve(units, stack_root(12), b)
    solver = units.ConeSolver("hybrid")
    for boxes in (12, 15, 12):
        other = stack(boxes, 3, 0.3)[1]
        last = solver.solve_root(
            stack_root(boxes).tolist(),
            list(other),
            [units.Cone.contact(3 * i, MU) for i in range(len(other) // 3)],
            [0.0] * len(other),
            tolerance=TOLERANCE,
            max_iterations=500,
        )
    assert last.x == first.x


def block_diagonal(parts: list[Array]) -> Array:
    out = np.zeros((sum(len(p) for p in parts), sum(p.shape[1] for p in parts)))
    row = column = 0
    for part in parts:
        out[row : row + len(part), column : column + part.shape[1]] = part
        row += len(part)
        column += part.shape[1]
    return out


@pytest.mark.parametrize("with_root", [False, True])
@pytest.mark.parametrize("boxes", [(2, 3, 1), (2, 20)])  # 12 rows each: the last one is beyond 200
def test_parts_that_do_not_act_on_each_other_are_solved_apart(
    units: Any, boxes: tuple[int, ...], with_root: bool
) -> None:
    """To the bit whatever the others do, and as alone, although contacts of different towers take turns."""
    problems = [stack(n, seed, 0.3) for seed, n in enumerate(boxes)]
    b = np.concatenate([of_part for _, of_part in problems])
    contacts = np.arange(len(b)).reshape(-1, 3)
    order = np.random.default_rng(0).permutation(len(contacts))
    rows = contacts[order].ravel()
    options = {"tolerance": TOLERANCE, "max_iterations": 500}

    def cones(n: int) -> list[Any]:
        return [units.Cone.contact(3 * i, MU) for i in range(n // 3)]

    def solved(rows: npt.NDArray[np.int_], b: Array) -> Any:
        solver = units.ConeSolver("hybrid", in_parts=True)
        start = [0.0] * len(rows)
        if with_root:
            W = block_diagonal([stack_root(n) for n in boxes])[rows]
            return solver.solve_root(W.tolist(), list(b[rows]), cones(len(rows)), start, **options)
        G = block_diagonal([G for G, _ in problems])[np.ix_(rows, rows)]
        return solver.solve(G.tolist(), list(b[rows]), cones(len(rows)), start, **options)

    together = solved(rows, b)
    tower = np.repeat(np.arange(len(boxes)), [12 * n for n in boxes])
    alone = []
    for part in range(len(boxes)):
        of_part = tower[rows] == part
        x = np.array(together.x)[of_part]
        others_differ = solved(rows, np.where(tower == part, b, 3 * b))
        np.testing.assert_array_equal(np.array(others_differ.x)[of_part], x)
        assert x.any()
        if not with_root:  # small parts have a matrix, which differs from that of another solver by rounding
            alone.append(solved(rows[of_part], b))
            np.testing.assert_array_equal(alone[-1].x, x)
    if alone:
        assert together.residual == max(of.residual for of in alone)
        assert together.iterations == max(of.iterations for of in alone)
        assert together.products == sum(of.products for of in alone)
