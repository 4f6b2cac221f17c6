# SPDX-License-Identifier: BSD-3-Clause
"""SymPy and CasADi get the same equations; SymPy finds those of textbooks in them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gelenk

from .states import by_kernels, closed_states, closeness, random_states
from .test_traced_scenes import SCENES

PENDULUM = """
gelenk: 1
name: Pendulum
gravity: [0, 0, -9.81]
bodies:
  bob: {mass: 0.5, com: [0, 0, -0.8]}
joints:
  A: {type: revolute, axis: [0, 1, 0], parent: {body: ground}, child: {body: bob}}
"""
# Point masses m1, m2 on massless rods l1, l2; the second angle is relative to the first one.
DOUBLE = """
gelenk: 1
name: Two rods
gravity: [0, 0, -9.81]
bodies:
  upper: {mass: 0.7, com: [0, 0, -0.4]}
  lower: {mass: 0.3, com: [0, 0, -0.9]}
joints:
  A: {type: revolute, axis: [0, 1, 0], parent: {body: ground}, child: {body: upper}}
  B:
    type: revolute
    axis: [0, 1, 0]
    parent: {body: upper, position: [0, 0, -0.4]}
    child: {body: lower}
"""


def test_sympy_finds_the_equation_of_a_pendulum() -> None:
    """M l^2 phi'' + m g l sin(phi) = 0."""
    sp = pytest.importorskip("sympy")
    found = gelenk.equations(PENDULUM).to_sympy()
    (phi,), (a,) = found.q, found.vdot
    expected = 0.5 * 0.8**2 * a + 0.5 * 9.81 * 0.8 * sp.sin(phi)
    assert sp.simplify(sp.nsimplify(found.r[0] - expected, rational=True)) == 0
    energy = found.kinetic + found.potential
    (w,) = found.v
    assert sp.simplify(sp.nsimplify(sp.diff(energy, w) - found.M[0] * w, rational=True)) == 0
    assert sp.simplify(sp.nsimplify(sp.diff(energy, phi) - found.h[0], rational=True)) == 0


def lagrange_double_pendulum(sp: Any, q: Any, v: Any) -> tuple[Any, Any]:
    """M and h by Lagrange's equations (Goldstein, Classical Mechanics, ch. 1) from the masses' positions."""
    m1, m2, l1, l2, g = 0.7, 0.3, 0.4, 0.9, 9.81
    first = sp.Matrix([-l1 * sp.sin(q[0]), -l1 * sp.cos(q[0])])
    second = first + sp.Matrix([-l2 * sp.sin(q[0] + q[1]), -l2 * sp.cos(q[0] + q[1])])
    speeds = [point.jacobian(q) * v for point in (first, second)]
    T = (m1 * speeds[0].dot(speeds[0]) + m2 * speeds[1].dot(speeds[1])) / 2
    V = g * (m1 * first[1] + m2 * second[1])
    p = sp.Matrix([sp.diff(T, w) for w in v])
    h = p.jacobian(q) * v - sp.Matrix([sp.diff(T - V, of) for of in q])
    return p.jacobian(v), h


def test_a_double_pendulum_has_the_equations_of_lagrange() -> None:
    sp = pytest.importorskip("sympy")
    equations = gelenk.equations(DOUBLE)
    found = equations.to_sympy()
    M, h = lagrange_double_pendulum(sp, found.q, found.v)
    compare = sp.lambdify([*found.q, *found.v], [found.M, M, found.h, h])
    for q, v, _ in random_states(equations, 10):
        M_found, M_expected, h_found, h_expected = compare(*q, *v)
        assert closeness(M_found, M_expected) < 1e-14
        assert closeness(h_found, h_expected) < 1e-13


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar", "slider_crank", "five_bar", "heavy_top"])
def test_lambdified_matrices_are_those_of_the_kernels(name: str) -> None:
    sp = pytest.importorskip("sympy")
    equations = gelenk.equations(SCENES[name])
    found = equations.to_sympy()
    symbols = [*found.q, *found.v, *found.u]
    compute = sp.lambdify(
        symbols, [found.M, found.h, found.J, found.gamma, found.Phi], modules="numpy", cse=True
    )
    for q, v, u in random_states(equations, 10):
        expected = by_kernels(equations, (q, v, u))
        results = compute(*q, *v, *u)
        for result, quantity in zip(results, ("M", "h", "J", "gamma", "Phi"), strict=True):
            assert closeness(result, getattr(expected, quantity)) < 1e-12


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar", "slider_crank", "five_bar", "stewart"])
def test_casadi_has_the_same_numbers(name: str) -> None:
    pytest.importorskip("casadi")
    equations = gelenk.equations(SCENES[name])
    functions, numbers = equations.to_casadi(), equations.to_numpy()
    for q, v, u in closed_states(equations, numbers, 10):
        for found, expected in zip(functions.equations(q, v, u), numbers.equations(q, v, u), strict=True):
            assert closeness(np.array(found), expected) < 1e-12
        vdot, _ = functions.accelerations(q, v, u)
        assert closeness(vdot, numbers.accelerations(q, v, u)[0]) < 1e-10


def test_casadi_differentiates_as_we_do() -> None:
    """The derivative of the constraint residual along qdot = N v is J v."""
    ca = pytest.importorskip("casadi")
    equations = gelenk.equations(SCENES["four_bar"])
    functions, numbers = equations.to_casadi(), equations.to_numpy()
    q, u = ca.SX.sym("q", len(equations.q)), ca.SX.sym("u", len(equations.u))
    by_casadi = ca.Function("J", [q, u], [ca.jacobian(functions.Phi(q, u), q)])
    for state in random_states(equations, 10):
        assert closeness(np.array(by_casadi(state[0], state[2])), numbers.J(state[0])) < 1e-13
