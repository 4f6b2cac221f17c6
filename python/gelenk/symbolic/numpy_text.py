# SPDX-License-Identifier: BSD-3-Clause
"""Equations as Python source for NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

from gelenk.symbolic.languages import NumPy
from gelenk.symbolic.python_text import comment, nested, quantity_functions
from gelenk.symbolic.system import System

# Velocities are scaled by their masses, and constraint equations to coefficients of order 1, so that a small
# singular value means a redundant equation. One with tiny coefficients keeps them:
# they may be rounding errors.
ACCELERATIONS = '''\
def accelerations(q, v, u):
    """Return vdot and lambda, of minimum norm where constraint equations are redundant."""
    M_, h_, J_, gamma_ = equations(q, v, u)
    n = len(h_)
    diagonal = np.diag(M_)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1))
    rows = J_ * scale
    size = np.abs(rows).max(axis=1, initial=0)
    largest = size.max(initial=0) or 1
    weight = 1 / np.where(size > 1e-6 * largest, size, largest)
    rows *= weight[:, None]
    matrix = np.block([[M_ * np.outer(scale, scale), rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    right = np.concatenate([-h_ * scale, gamma_ * weight])
    x = np.zeros(len(right))
    for _ in range(2):  # the second time corrects rounding errors
        x += np.linalg.lstsq(matrix, right - matrix @ x, rcond=1e-12)[0]
    return x[:n] * scale, x[n:] * weight
'''


def array(shape: tuple[int, ...], texts: Sequence[str]) -> str:
    """Return an array of these entries."""
    if not shape:
        return texts[0]
    if 0 in shape:
        return f"np.zeros({shape})"
    return f"np.array({nested(shape, texts)}, float)"


def text(system: System) -> str:
    """Return the module."""
    has_choices = any(node.operation == "choose" for node in system.graph.nodes)
    # What only one branch needs is computed with both of them.
    before = '@np.errstate(divide="ignore", invalid="ignore")\n' if has_choices else ""
    functions = quantity_functions(system, NumPy(), array, "np.asarray({}, float)", before)
    imports = "import math\n\nimport numpy as np" if "math." in "".join(functions) else "import numpy as np"
    return "\n".join(comment(system)) + f"\n{imports}\n\n\n" + "\n\n".join([*functions, ACCELERATIONS])


def functions(system: System) -> SimpleNamespace:
    """Return the functions of the module."""
    names: dict[str, object] = {}
    exec(compile(text(system), f"<equations of {system.name}>", "exec"), names)
    return SimpleNamespace(**{name: value for name, value in names.items() if callable(value)})
