# SPDX-License-Identifier: BSD-3-Clause
"""Equations as Python source for SymPy."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

from gelenk.symbolic.languages import SymPy
from gelenk.symbolic.python_text import body, comment, nested
from gelenk.symbolic.system import System


def array(shape: tuple[int, ...], texts: Sequence[str]) -> str:
    """Return a matrix of these entries."""
    if not shape:
        return f"sp.sympify({texts[0]})"
    rows, columns = shape[0], shape[1] if len(shape) > 1 else 1
    return f"sp.Matrix({rows}, {columns}, {nested((len(texts),), texts)})"


def text(system: System) -> str:
    """Return the module."""
    lines = []
    for letter, arguments in system.lists("qvu"):
        names = [argument.name for argument in arguments]
        lines.append(f"{letter} = sp.Matrix({len(names)}, 1, sp.symbols({names!r}, real=True))")
        lines += [f"{', '.join(names)}{',' if len(names) == 1 else ''} = {letter}"] if names else []
    quantities = [of for of in system.quantities.values() if of.name != "rates" or system.states]
    lines += body(system, quantities, SymPy(), array)
    accelerations = [f"a{k + 1}" for k in range(len(system.v))]
    multipliers = [f"lambda{k + 1}" for k in range(len(system.rows))]
    lines += [
        f"vdot = sp.Matrix({len(system.v)}, 1, sp.symbols({accelerations!r}, real=True))",
        f"lambda_ = sp.Matrix({len(multipliers)}, 1, sp.symbols({multipliers!r}, real=True))",
        "r = M * vdot + h + J.T * lambda_  # 0 in motion",
    ]
    return "\n".join(comment(system)) + "\nimport sympy as sp\n\n" + "\n".join(lines) + "\n"


def matrices(system: System) -> SimpleNamespace:
    """Return the matrices and symbols of the module."""
    names: dict[str, object] = {}
    exec(compile(text(system), f"<equations of {system.name}>", "exec"), names)
    wanted = {*system.quantities, "q", "v", "u", "vdot", "lambda_", "r"}
    return SimpleNamespace(**{name: value for name, value in names.items() if name in wanted})
