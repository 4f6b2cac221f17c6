# SPDX-License-Identifier: BSD-3-Clause
"""Linear models as notebooks show them: poles, operating point, matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gelenk import _html

if TYPE_CHECKING:
    from gelenk.linear.model import LinearModel

MAX_POLES = 40
MAX_NAMES = 40
MAX_ENTRIES = 1000  # of a matrix


def model_html(model: LinearModel) -> str:
    """Return a linear model as HTML."""
    counts = ((model.states, "state"), (model.inputs, "input"), (model.outputs, "output"))
    sizes = ", ".join(f"{len(names)} {what}{'' if len(names) == 1 else 's'}" for names, what in counts)
    name = f"{model.name} at t = {model.time:g} s" if model.name else f"t = {model.time:g} s"
    parts: list[_html.Cell] = [_html.heading(name, sizes)]
    parts += [_html.paragraph(text) for text in (model.residual_rates, model.idle_rotations) if text]
    if model.states:
        parts.append(_poles(model.A))
    points = (("state", model.states, model.x0), ("input", model.inputs, model.u0),
              ("output", model.outputs, model.y0))  # fmt: skip
    parts += [_point(model, what, names, values) for what, names, values in points if names]
    derivatives = [f"der({state})" for state in model.states]
    parts += [
        _html.folded(f"{title}, {matrix.shape[0]} × {matrix.shape[1]}", _matrix(matrix, rows, columns))
        for title, matrix, rows, columns in (
            ("A", model.A, derivatives, model.states), ("B", model.B, derivatives, model.inputs),
            ("C", model.C, model.outputs, model.states), ("D", model.D, model.outputs, model.inputs),
        )
        if matrix.size
    ]  # fmt: skip
    return _html.joined(parts)


def _poles(A: NDArray[np.float64]) -> _html.Fragment:
    if not np.isfinite(A).all():
        return _html.paragraph("no poles: A contains NaN or infinity")
    found = [complex(x) for x in np.linalg.eigvals(A) if x.imag >= 0]
    found.sort(key=lambda x: (abs(x), x.real))
    rows = []
    for pole in found[:MAX_POLES]:
        size = abs(pole)
        imaginary = f" ± {_html.number(pole.imag)}i" if pole.imag else ""
        damping = _html.number(-pole.real / size, 4) if size else ""
        constant = _html.number(1 / abs(pole.real), 4) if pole.real else ""
        rows.append((_html.number(pole.real) + imaginary, _html.number(size), damping, constant))
    titles = ("pole [1/s]", "natural frequency [rad/s]", "damping ratio", "time constant [s]")
    parts = [_html.table(titles, rows, [True] * 4)]
    if len(found) > MAX_POLES:
        parts.append(_html.paragraph(f"and {len(found) - MAX_POLES} more"))
    return _html.joined(parts)


def _point(
    model: LinearModel, what: str, names: Sequence[str], values: NDArray[np.float64]
) -> _html.Fragment:
    rows = [
        (name, _html.number(float(value)), _html.unit(model.units.get(name, "1")))
        for name, value in zip(names[:MAX_NAMES], values, strict=False)
    ]
    parts = [_html.table((what, "operating point", "unit"), rows, (False, True, False))]
    if len(names) > MAX_NAMES:
        parts.append(_html.paragraph(f"and {len(names) - MAX_NAMES} more"))
    return _html.joined(parts)


def _matrix(matrix: NDArray[np.float64], rows: Sequence[str], columns: Sequence[str]) -> _html.Fragment:
    if matrix.size > MAX_ENTRIES:
        return _html.paragraph(f"not shown: {matrix.size} entries")
    cells = [
        [name, *map(_html.number, map(float, row))] for name, row in zip(rows, matrix.tolist(), strict=True)
    ]
    return _html.table(("", *columns), cells)
