# SPDX-License-Identifier: BSD-3-Clause
"""The equations of a scene, recorded from the kernels that simulate it."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

from gelenk import _core
from gelenk.extras import extra
from gelenk.model.scene import Source, load
from gelenk.symbolic import c_text, casadi_text, latex_text, numpy_text, sympy_text
from gelenk.symbolic.graph import Graph
from gelenk.symbolic.names import argument_names
from gelenk.symbolic.system import Argument, Quantity, System


@dataclass(frozen=True)
class Equations:
    """The equations of motion of a scene, in SI units, in the coordinates of its spanning trees.

    They are

        M(q) vdot + h(q, v, u) + J(q)^T lambda = 0,   J(q) vdot = gamma(q, v, u),   Phi(q, u) = 0

    with qdot = N(q) v. h contains all forces, also those of motors and springs.

    Attributes:
        q: coordinates: name in the texts, signal of the scene, unit, description, start value.
        v: velocities: the same.
        u: inputs, the time if forces depend on it, element states, and prescribed motions.
        rows: for each constraint equation the joint or constraint to which it belongs.
        notes: what the equations leave out, as sentences.
    """

    _system: System

    @property
    def q(self) -> tuple[Argument, ...]:
        """The coordinates."""
        return self._system.q

    @property
    def v(self) -> tuple[Argument, ...]:
        """The velocities."""
        return self._system.v

    @property
    def u(self) -> tuple[Argument, ...]:
        """The inputs."""
        return self._system.u

    @property
    def rows(self) -> tuple[str, ...]:
        """What the constraint equations belong to."""
        return self._system.rows

    @property
    def notes(self) -> tuple[str, ...]:
        """What the equations leave out."""
        return self._system.notes

    def to_c(self) -> str:
        """Return C99 source without allocation that needs the mathematical library only.

        Besides the equations it has a function that solves them for accelerations and multipliers, and one
        that makes a step of the Runge-Kutta method of order 4 with projection onto the constraints.
        """
        return c_text.text(self._system)

    def numpy_text(self) -> str:
        """Return Python source with a function for each quantity."""
        return numpy_text.text(self._system)

    def to_numpy(self) -> SimpleNamespace:
        """Return these functions: M(q), h(q, v, u), J(q), gamma(q, v, u), accelerations(q, v, u), ..."""
        return numpy_text.functions(self._system)

    def sympy_text(self) -> str:
        """Return Python source that builds the matrices of SymPy."""
        return sympy_text.text(self._system)

    def to_sympy(self) -> SimpleNamespace:
        """Return these matrices, M, h, J, gamma, ..., and the symbols q, v, u, vdot, lambda_.

        Raises:
            UsageError: SymPy is not installed.
        """
        extra("sympy", "symbolic equations are made with sympy")
        return sympy_text.matrices(self._system)

    def casadi_text(self) -> str:
        """Return Python source with a function of CasADi's symbols for each quantity."""
        return casadi_text.text(self._system)

    def to_casadi(self) -> SimpleNamespace:
        """Return a `casadi.Function` for each quantity: M(q), h(q, v, u), accelerations(q, v, u), ...

        Raises:
            UsageError: CasADi is not installed.
        """
        casadi = extra("casadi", "functions for optimal control are made with casadi")
        return casadi_text.functions(self._system, casadi)

    def to_latex(self) -> str:
        """Return the equations as formulas of LaTeX, with the terms that they share."""
        return latex_text.text(self._system)


def equations(scene: Source) -> Equations:
    """Return the equations of motion of a scene.

    Args:
        scene: scene or scene file.

    Returns:
        Equations: M, h, J, gamma, Phi and energies, as C, NumPy, SymPy, LaTeX or CasADi.

    Raises:
        SceneError: the scene is invalid, or has an element that cannot be written as expressions; the message
            names it.

    >>> four_bar = gelenk.equations("scenes/four_bar.yaml")
    >>> [coordinate.name for coordinate in four_bar.q]
    ['phi_A', 'phi_B', 'phi_D']
    """
    read = load(scene)
    return Equations(system_of(_core.TracedScene(read._core), read.name))


def system_of(traced: _core.TracedScene, name: str) -> System:
    """Return what the core has recorded, with names for texts."""
    given = [*traced.q, *traced.v, *traced.u]
    names = argument_names([argument.name for argument in given])
    arguments = [
        Argument(text, of.name, of.unit, of.text, of.start) for text, of in zip(names, given, strict=True)
    ]
    nq, nv, rows = len(traced.q), len(traced.v), len(traced.rows)
    quantities = (
        Quantity("M", "mass matrix", (nv, nv), tuple(traced.M), "q"),
        Quantity("h", "bias: forces for vdot = 0", (nv,), tuple(traced.h), "qvu"),
        Quantity("J", "Jacobian of the constraints", (rows, nv), tuple(traced.J), "q"),
        Quantity("gamma", "right side of J vdot = gamma", (rows,), tuple(traced.gamma), "qvu"),
        Quantity("Phi", "constraint residual", (rows,), tuple(traced.Phi), "qu"),
        Quantity("rate", "residual of the constraints on velocities", (rows,), tuple(traced.rate), "qvu"),
        Quantity("qdot", "rates of the coordinates", (nq,), tuple(traced.qdot), "qv"),
        Quantity("kinetic", "kinetic energy [J]", (), (traced.kinetic,), "qv"),
        Quantity("potential", "potential energy [J]", (), (traced.potential,), "q"),
        Quantity("rates", "rates of the element states", (len(traced.states),), tuple(traced.rates), "qvu"),
    )
    return System(
        name,
        Graph(traced.nodes()),
        tuple(arguments[:nq]),
        tuple(arguments[nq : nq + nv]),
        tuple(arguments[nq + nv :]),
        tuple(traced.rows),
        tuple(traced.notes),
        {of.name: of for of in quantities},
        len(traced.states),
        traced,
    )
