# SPDX-License-Identifier: BSD-3-Clause
"""Solvers of cone complementarity problems, by a hundred problems with known solutions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array

from gelenk.chart.cone_problems import COUNT, ConeProblem, cone_problem

TOLERANCE = 1e-10  # of the published natural map, relative to |b|
SOLVERS = ["hybrid", "p-spg-fb", "apgd", "newton", "admm", "gauss-seidel"]
# Problems solved of 50 dense ones, 25 chains and 25 redundant ones to 1e-8 within 3000 iterations. Methods of
# first order stall at some of condition 1e6.
SOLVED = {"p-spg-fb": (38, 25, 22), "apgd": (50, 25, 25), "newton": (50, 25, 25), "admm": (40, 25, 19),
          "gauss-seidel": (44, 25, 17)}  # fmt: skip


def cones_of(units: Any, problem: ConeProblem) -> list[Any]:
    cones = []
    for i, mu in enumerate(problem.friction):
        cone = units.Cone.contact(3 * i, mu)
        cone.tangential = 2  # without friction, too
        cones.append(cone)
    return cones


def solve(units: Any, name: str, problem: ConeProblem, start: Array | None = None, **options: Any) -> Any:
    given = {"tolerance": 1e-11 * np.linalg.norm(problem.b), "exact": False, **options}
    start = np.zeros(len(problem.b)) if start is None else start
    return units.ConeSolver(name).solve(
        problem.G.tolist(), list(problem.b), cones_of(units, problem), list(start), **given
    )


def test_the_problems_are_those_published() -> None:
    """Figures that the authors of the problems give for a port: trace of G, least value, norms of x and u."""
    for number, cones, trace, value, x, u in [
        (0, 13, 3.9932526957707317, -3.990067026622851, 14.627564661821122, 8.0223329349998),
        (2, 27, 484.7928952685238, -494.13758366410497, 11.787257302466923, 25.900337450050387),
        (3, 28, 40.812617925422394, -52.391576709805236, 14.14661469472447, 21.331959820949113),
    ]:
        problem = cone_problem(number)
        assert problem.cones == cones
        found = [np.trace(problem.G), problem.objective, np.linalg.norm(problem.x), np.linalg.norm(problem.u)]
        assert found == pytest.approx([trace, value, x, u], rel=1e-12)  # about a thousand operations


@pytest.mark.parametrize("kind", ["dense", "chain", "redundant"])
def test_the_default_solves_all_problems(units: Any, kind: str) -> None:
    for problem in map(cone_problem, range(COUNT)):
        if problem.kind != kind:
            continue
        found = solve(units, "hybrid", problem)
        x = np.array(found.x)
        assert found.converged, problem.number
        assert problem.residual(x) < TOLERANCE, problem.number
        u = problem.G @ x + problem.b
        # Relative errors; u depends on x less than the residual does on either.
        assert np.linalg.norm(u - problem.u) < 1e-8 * np.linalg.norm(problem.u), problem.number
        objective = 0.5 * x @ problem.G @ x + problem.b @ x
        assert objective == pytest.approx(problem.objective, rel=1e-9), problem.number
        if kind == "chain":  # the solution is unique and the condition moderate
            assert x == pytest.approx(problem.x, abs=1e-7 * np.linalg.norm(problem.x)), problem.number


@pytest.mark.parametrize("name", SOLVED)
def test_every_solver_solves_most_problems(units: Any, name: str) -> None:
    solved = dict.fromkeys(("dense", "chain", "redundant"), 0)
    for problem in map(cone_problem, range(COUNT)):
        found = solve(units, name, problem, tolerance=1e-9 * np.linalg.norm(problem.b), max_iterations=3000)
        assert found.iterations <= 3000
        solved[problem.kind] += problem.residual(np.array(found.x)) < 1e-8
    assert all(count >= least for count, least in zip(solved.values(), SOLVED[name], strict=True)), solved


@pytest.mark.parametrize("name", SOLVERS)
def test_the_solution_as_initial_guess_costs_one_product(units: Any, name: str) -> None:
    for number in (0, 2, 3):
        problem = cone_problem(number)
        found = solve(units, name, problem, problem.x)
        assert found.converged
        assert found.iterations == 0
        assert found.products == 1
        assert np.array(found.x) == pytest.approx(problem.x, rel=1e-13)  # scaled and back


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("name", SOLVERS)
def test_a_solver_that_is_stopped_is_not_worse_than_its_start(units: Any, name: str, exact: bool) -> None:
    rng = np.random.default_rng(4)
    for number in range(0, COUNT, 5):
        problem = cone_problem(number)
        start = problem.x + 1e-3 * projected(units, problem, rng.normal(size=len(problem.x)))
        at_start = solve(units, name, problem, start, max_iterations=0, exact=exact)
        for most in (1, 2, 3, 7):
            found = solve(units, name, problem, start, max_iterations=most, exact=exact)
            assert found.iterations <= most
            assert found.residual <= at_start.residual


def projected(units: Any, problem: ConeProblem, y: Array) -> Array:
    cones = cones_of(units, problem)
    return np.concatenate(
        [cone.project(list(part)) for cone, part in zip(cones, y.reshape(-1, 3), strict=True)]
    )


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("name", SOLVERS)
def test_results_lie_in_the_cones(units: Any, name: str, exact: bool) -> None:
    for number in range(0, COUNT, 7):
        problem = cone_problem(number)
        x = np.array(solve(units, name, problem, max_iterations=5, exact=exact).x).reshape(-1, 3)
        assert (x[:, 0] >= 0).all()
        lengths = np.hypot(x[:, 1], x[:, 2])
        assert (lengths <= problem.friction * x[:, 0] * (1 + 1e-15) + 1e-300).all()


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("name", SOLVERS)
def test_the_same_calls_give_the_same_bits_and_allocate_once(units: Any, name: str, exact: bool) -> None:
    solver = units.ConeSolver(name)
    large, small = cone_problem(17), cone_problem(9)
    assert large.cones > small.cones

    def run(solver: Any, problem: ConeProblem) -> Any:
        b = list(problem.b)
        options = {"exact": exact, "max_iterations": 60}
        return solver.solve(problem.G.tolist(), b, cones_of(units, problem), [0.0] * len(b), **options)

    first = run(solver, large)
    assert first.allocations > 0  # the count works
    results = [run(solver, problem) for problem in (small, large, small)]
    assert [found.allocations for found in results] == [0, 0, 0]
    assert results[1].x == first.x
    assert results[0].x == results[2].x
    assert run(units.ConeSolver(name), small).x == results[0].x
    warm = units.ConeSolver(name)  # its first call is at the solution, and needs little
    b = list(large.b)
    assert warm.solve(large.G.tolist(), b, cones_of(units, large), first.x, 1e9).iterations == 0
    assert run(warm, large).allocations == 0


@pytest.mark.parametrize("name", SOLVERS)
def test_an_operator_without_a_matrix_gives_the_same(units: Any, name: str) -> None:
    problem = cone_problem(6)
    dense, hidden = (solve(units, name, problem, matrix_free=free) for free in (False, True))
    assert hidden.x == dense.x
    formed = len(problem.b) if name in ("hybrid", "newton", "admm", "gauss-seidel") else 0
    assert hidden.products == dense.products + formed


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("exact", [True, False])
def test_balls(units: Any, name: str, exact: bool) -> None:
    """Limits that are given, in two and three dimensions beside a contact: held within, or opposed."""
    rng = np.random.default_rng(7)
    for trial in range(20):
        A = rng.normal(size=(8, 10))
        G = A @ A.T
        b = 3 * rng.normal(size=8)
        radius = [0.1 * (1 + trial % 5), 0.6]
        cones = [
            units.Cone.ball(0, 3, radius[0]),
            units.Cone.contact(3, 0.4),
            units.Cone.ball(6, 2, radius[1]),
        ]
        found = units.ConeSolver(name).solve(
            G.tolist(), list(b), cones, [0.0] * 8, tolerance=1e-10, exact=exact, max_iterations=20000
        )
        x = np.array(found.x)
        u = G @ x + b
        for first, size, r in ((0, 3, radius[0]), (6, 2, radius[1])):
            part, speed = x[first : first + size], u[first : first + size]
            assert np.linalg.norm(part) <= r * (1 + 1e-14)
            if np.linalg.norm(part) < r * (1 - 1e-9):
                assert np.abs(speed).max() < 1e-7, (trial, found.residual)
            else:  # the force opposes the motion
                assert part @ speed == pytest.approx(-r * np.linalg.norm(speed), abs=1e-7), trial
