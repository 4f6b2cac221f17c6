# SPDX-License-Identifier: BSD-3-Clause
"""Coulomb's law, spinning and rolling friction, limits, by closed forms; degenerate problems."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import Array

from gelenk.chart.cone_problems import COUNT, cone_problem

SOLVERS = ["hybrid", "p-spg-fb", "apgd", "newton", "admm", "gauss-seidel"]
TOLERANCE = 1e-12  # m/s


def solve(
    units: Any, name: str, G: Any, b: Any, cones: list[Any], *, converges: bool = True, **options: Any
) -> tuple[Array, Array]:
    """Return x and u = G x + b."""
    G, b = np.asarray(G, float), np.asarray(b, float)
    given = {"tolerance": TOLERANCE, "max_iterations": 5000, **options}
    start = given.pop("start", np.zeros(len(b)))
    found = units.ConeSolver(name).solve(G.tolist(), list(b), cones, list(start), **given)
    assert found.converged == converges
    x = np.array(found.x)
    assert np.isfinite(x).all()
    return x, G @ x + b


@pytest.mark.parametrize("name", SOLVERS)
def test_a_block_on_an_incline_sticks_or_slides(units: Any, name: str) -> None:
    """Impulses of a step of 1 ms from rest, m = 2 kg: tan(angle) below and above the coefficient."""
    m, mu, kick = 2.0, 0.5, 9.81e-3
    for angle in (0.2, 0.46, 0.47, 0.7):  # arctan(0.5) = 0.4636
        direction = np.array([0.6, 0.8])
        b = kick * np.array([-np.cos(angle), *(np.sin(angle) * direction)])
        x, u = solve(units, name, np.eye(3) / m, b, [units.Cone.contact(0, mu)])
        n = m * kick * np.cos(angle)
        assert x[0] == pytest.approx(n, rel=1e-9)
        slides = np.tan(angle) > mu
        friction = mu * n if slides else m * kick * np.sin(angle)
        assert x[1:] == pytest.approx(-friction * direction, rel=1e-9)
        assert abs(u[0]) <= 2 * TOLERANCE  # it does not lift
        speed = kick * (np.sin(angle) - mu * np.cos(angle)) if slides else 0
        assert u[1:] == pytest.approx(speed * direction, abs=2 * TOLERANCE)


@pytest.mark.parametrize("name", SOLVERS)
def test_the_convex_relaxation_lifts_what_slides(units: Any, name: str) -> None:
    """u_n = mu |u_t|: with G = 1/m and b = (-w, v, 0), n = m (w + mu v) / (1 + mu^2)."""
    m, mu, w, v = 2.0, 0.5, 1.0, 3.0
    x, u = solve(units, name, np.eye(3) / m, [-w, v, 0], [units.Cone.contact(0, mu)], exact=False)
    assert x[0] == pytest.approx(m * (w + mu * v) / (1 + mu**2), rel=1e-11)
    assert u[0] == pytest.approx(mu * np.hypot(u[1], u[2]), rel=1e-11)
    assert u[0] > 0.9


def ball(m: float, r: float) -> Array:
    """Delassus matrix of a homogeneous ball on a plane: normal, two tangents, spin, two rolling rates."""
    inertia = 0.4 * m * r**2
    J = np.zeros((6, 6))  # of (v_x, v_y, v_z, w_x, w_y, w_z)
    J[0, 2] = 1
    J[1, 0], J[1, 4] = 1, -r  # velocity of the point in contact
    J[2, 1], J[2, 3] = 1, r
    J[3, 5] = 1
    J[4, 3] = J[5, 4] = 1
    return J @ np.diag([1 / m] * 3 + [1 / inertia] * 3) @ J.T


@pytest.mark.parametrize("name", SOLVERS)
def test_a_ball_slides_or_rolls(units: Any, name: str) -> None:
    """A ball that falls with w and slides with v: friction stops the slip if m v / 3.5 <= mu m w."""
    m, r, mu, w = 1.3, 0.05, 0.3, 0.4
    for v in (0.41, 0.43):  # 3.5 mu w = 0.42
        b = [-w, 0.6 * v, 0.8 * v, 0, 0, 0]
        x, u = solve(units, name, ball(m, r)[:3, :3], b[:3], [units.Cone.contact(0, mu)])
        assert x[0] == pytest.approx(m * w, rel=1e-9)
        assert np.hypot(x[1], x[2]) == pytest.approx(min(m * v / 3.5, mu * m * w), rel=1e-9)
        assert u[1:] == pytest.approx(max(0, v - 3.5 * mu * w) * np.array([0.6, 0.8]), abs=1e-11)


@pytest.mark.parametrize("name", SOLVERS)
def test_spinning_and_rolling_friction_are_limited_by_the_normal_impulse(units: Any, name: str) -> None:
    """The moments slow the rates by at most d n / I. Without tangential friction."""
    m, r, w = 1.3, 0.05, 0.4
    inertia, spinning, rolling = 0.4 * m * r**2, 1e-3, 2e-4
    parts = [0, 3, 4, 5]
    G = ball(m, r)[np.ix_(parts, parts)]
    most = np.array([spinning, rolling]) * m * w / inertia  # rad/s
    for spin, roll in [(0.9, 1.1), (1.1, 0.9), (2.0, 3.0), (0.5, 0.5)]:
        b = np.array([-w, spin * most[0], 0.6 * roll * most[1], -0.8 * roll * most[1]])
        x, u = solve(units, name, G, b, [units.Cone.contact(0, 0, spinning, rolling)])
        assert x[0] == pytest.approx(m * w, rel=1e-9)
        assert u[0] == pytest.approx(0, abs=2 * TOLERANCE)
        # 1e-10 rad/s: the residual counts rates with the length sqrt(I / m) = 0.03 m.
        assert u[1] == pytest.approx(max(0, spin - 1) * most[0], abs=1e-10)
        assert u[2:] == pytest.approx(max(0, roll - 1) * most[1] * np.array([0.6, -0.8]), abs=1e-10)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_rolling_ball_is_stopped_by_rolling_friction(units: Any, name: str) -> None:
    """The moment d n acts on (7/5) m r^2 about the contact: the speed falls by d n / (1.4 m r)."""
    m, r, w, rolling = 1.3, 0.05, 0.4, 1e-3
    G = ball(m, r)
    parts = [0, 1, 2, 4, 5]
    fall = rolling * w / (1.4 * r)
    for v in (0.5 * fall, 2 * fall):
        b = [-w, 0, 0, 0, v / r]
        x, u = solve(units, name, G[np.ix_(parts, parts)], b, [units.Cone.contact(0, 0.5, 0, rolling)])
        assert u[:4] == pytest.approx(np.zeros(4), abs=1e-10)
        assert u[4] == pytest.approx(max(0, v - fall) / r, abs=1e-10)
        assert abs(x[4]) == pytest.approx(min(fall, v) / fall * rolling * m * w, rel=1e-8)


@pytest.mark.parametrize("name", SOLVERS)
def test_limits_and_contacts_in_one_problem(units: Any, name: str) -> None:
    """Dry friction of a joint, a joint limit and a contact on unconnected bodies do not affect each other."""
    inf = np.inf
    cones = [units.Cone.within(0, -0.1, 0.1), units.Cone.within(1, 0, inf), units.Cone.within(2, 0, inf),
             units.Cone.within(3, -0.3, 0.3), units.Cone.planar_contact(4, 0.5)]  # fmt: skip
    x, u = solve(units, name, np.diag([2.0, 2, 2, 2, 1, 1]), [1, -1, 1, -0.5, -1, 2], cones)
    assert x == pytest.approx([-0.1, 0.5, 0, 0.25, 1, -0.5], abs=1e-11)
    assert u == pytest.approx([0.8, 0, 1, 0, 0, 1.5], abs=1e-11)


def check_coulomb(x: Array, u: Array, mu: float, size: float) -> str:
    """Assert the law for one contact; returns its mode. size: of rounding and tolerance in u."""
    n, t, slip = x[0], x[1:], np.linalg.norm(u[1:])
    assert u[0] >= -size
    if n > 0:
        assert abs(u[0]) <= size or n < 1e-6
    if slip <= 10 * size or n < 1e-6:
        return "stick or open"
    assert t == pytest.approx(-mu * n * u[1:] / slip, abs=1e-6 * (1 + n))
    return "slide"


def test_the_default_solves_coulomb_s_law(units: Any) -> None:
    """The matrices of the hundred problems with the exact law: no contact that slides lifts."""
    sliding = 0
    for problem in map(cone_problem, range(COUNT)):
        cones = []
        for i, mu in enumerate(problem.friction):
            cone = units.Cone.contact(3 * i, mu)
            cone.tangential = 2
            cones.append(cone)
        norm = np.linalg.norm(problem.b)
        x, u = solve(units, "hybrid", problem.G, problem.b, cones, tolerance=1e-11 * norm)
        for i, mu in enumerate(problem.friction):
            part = slice(3 * i, 3 * i + 3)
            sliding += check_coulomb(x[part], u[part], mu, 1e-9 * norm) == "slide"
    assert sliding > 500


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("size", [1e-12, 1.0, 1e6])
def test_problems_have_any_unit(units: Any, name: str, size: float) -> None:
    x, u = solve(units, name, np.eye(3) / 2, size * np.array([-1, 3, 0]), [units.Cone.contact(0, 0.5)],
                 tolerance=1e-10 * size)  # fmt: skip
    assert x / size == pytest.approx([2, -1, 0], abs=1e-9)
    assert u / size == pytest.approx([0, 2.5, 0], abs=1e-9)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("exact", [False, True])
def test_degenerate_problems_are_solved(units: Any, name: str, exact: bool) -> None:
    contact = units.Cone.contact
    two = [contact(0, 0.5), contact(3, 0.5)]
    nothing = np.zeros((3, 3))
    x, _ = solve(units, name, nothing, [1, 0.2, 0], two[:1], exact=exact)  # nothing moves, nothing closes
    assert (x == 0).all()
    x, u = solve(units, name, np.kron(np.diag([1, 0]), np.eye(3)), [-1, 0.2, 0, 0, 0, 0], two, exact=exact)
    assert x == pytest.approx([1, -0.2, 0, 0, 0, 0], abs=1e-11)
    for v in (0.2, 3.0):  # one contact given twice: its impulse is shared in some way
        x, u = solve(units, name, np.kron(np.ones((2, 2)), np.eye(3)), [-1, v, 0] * 2, two, exact=exact)
        single, _ = solve(units, name, np.eye(3), [-1, v, 0], two[:1], exact=exact)
        assert x[:3] + x[3:] == pytest.approx(single, abs=1e-10)
    masses = np.array([[1e-3, -1e-3], [-1e-3, 1e-3 + 1e3]])  # 1 g on 1 t
    x, u = solve(units, name, np.kron(masses, np.eye(3)), [-1, 0, 0, -1, 0, 0], two, exact=exact)
    assert u == pytest.approx(np.zeros(6), abs=1e-11)


@pytest.mark.parametrize("name", SOLVERS)
def test_problems_without_solution_end_with_finite_numbers(units: Any, name: str) -> None:
    """A contact that closes between immobile bodies."""
    solve(units, name, np.zeros((3, 3)), [-1, 0.2, 0], [units.Cone.contact(0, 0.5)], converges=False)


def test_numbers_that_are_not_finite_change_nothing(units: Any) -> None:
    cone = [units.Cone.contact(0, 0.5)]
    for b in ([np.nan, 0, 0], [np.inf, 0, 0]):
        found = units.ConeSolver("hybrid").solve(np.eye(3).tolist(), b, cone, [1.0, 0.2, 0.0])
        assert found.x == [1, 0.2, 0]
        assert not found.converged
        assert found.residual == np.inf


def test_nothing_is_solved_by_nothing(units: Any) -> None:
    found = units.ConeSolver("hybrid").solve([], [], [], [])
    assert found.converged
    assert found.residual == 0


def test_cones_must_fit_the_problem(units: Any) -> None:
    cone = units.Cone
    solver = units.ConeSolver("hybrid")
    one, three = [[1.0]], np.eye(3).tolist()
    for G, b, cones in [
        (three, [0, 0, 0], [cone.contact(1, 0.5)]),
        (three, [0, 0, 0], [cone.within(0, 0, 1), cone.within(2, 0, 1), cone.within(1, 0, 1)]),
        (three, [0, 0], [cone.contact(0, 0.5)]),
        (three, [0, 0, 0], [cone.within(0, 0, 1)]),
        (three, [0, 0, 0], [cone.contact(0, np.nan, 0.1, 0.1)]),
        (three, [0, 0, 0], [cone.contact(0, np.inf)]),
        (one, [0], [cone.within(0, 1, 0)]),
        (one, [0], [cone.within(0, np.nan, 0)]),
    ]:
        with pytest.raises(ValueError, match="cone"):
            solver.solve(G, b, cones, [0.0] * len(G))


def test_the_solvers_are_listed(units: Any) -> None:
    assert [name for name, _ in units.cone_solvers()] == SOLVERS
    with pytest.raises(IndexError, match="simplex"):
        units.ConeSolver("simplex")
