# SPDX-License-Identifier: BSD-3-Clause
"""Equations as Python source for CasADi."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

from gelenk.symbolic.independent import independent
from gelenk.symbolic.languages import CasADi
from gelenk.symbolic.python_text import comment, nested, quantity_functions
from gelenk.symbolic.system import System

# CasADi solves without pivots, by orthogonal columns that are not orthogonal to rounding error where the
# matrix is badly scaled or nearly singular: equations are scaled, and the solution is corrected once.
ACCELERATIONS = '''\
def accelerations(q, v, u):
    """Return vdot and lambda, which is 0 where constraint equations are redundant."""
    M_, h_, J_, gamma_ = equations(q, v, u)
    n, kept = h_.numel(), ROWS
    zeros = ca.SX(len(kept), len(kept))
    scale = ca.DM([2.0**k for k in EXPONENTS])
    matrix = ca.densify(ca.blockcat([[M_, J_[kept, :].T], [J_[kept, :], zeros]])) * (scale @ scale.T)
    right = ca.vertcat(-h_, gamma_[kept]) * scale
    x = ca.solve(matrix, right)
    x = (x + ca.solve(matrix, right - matrix @ x)) * scale
    lambda_ = ca.SX.zeros(gamma_.numel(), 1)
    if kept:
        lambda_[kept] = x[n:]
    return x[:n], lambda_
'''


def array(shape: tuple[int, ...], texts: Sequence[str]) -> str:
    """Return a matrix of these entries."""
    if not shape:
        return texts[0]
    if 0 in shape:
        return f"ca.SX({shape[0]}, {shape[1] if len(shape) > 1 else 1})"
    if len(shape) == 1:
        return f"ca.vertcat({', '.join(texts)})"
    return f"ca.blockcat({nested(shape, texts)})"


def text(system: System) -> str:
    """Return the module."""
    found = independent(system)
    accelerations = ACCELERATIONS.replace("ROWS", repr(list(found.rows)))
    accelerations = accelerations.replace("EXPONENTS", repr(list(found.exponents)))
    parts = [*quantity_functions(system, CasADi(), array, "ca.vertsplit({})"), accelerations]
    return "\n".join(comment(system)) + "\nimport casadi as ca\n\n\n" + "\n\n".join(parts)


def functions(system: System, ca: Any) -> SimpleNamespace:
    """Return a `casadi.Function` for each function of the module."""
    names: dict[str, Any] = {}
    exec(compile(text(system), f"<equations of {system.name}>", "exec"), names)
    symbols = {letter: ca.SX.sym(letter, len(arguments)) for letter, arguments in system.lists("qvu")}
    out: dict[str, Any] = {}
    for name in (*system.quantities, "equations", "accelerations"):
        if name not in names:
            continue
        letters = list(system.quantities[name].arguments if name in system.quantities else "qvu")
        result = names[name](*(symbols[letter] for letter in letters))
        results = list(result) if isinstance(result, tuple) else [result]
        labels = {"equations": ["M", "h", "J", "gamma"], "accelerations": ["vdot", "lambda_"]}.get(
            name, [name]
        )
        out[name] = ca.Function(
            name, [symbols[letter] for letter in letters], [ca.SX(of) for of in results], letters, labels
        )
    return SimpleNamespace(**out)
