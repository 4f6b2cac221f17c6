# SPDX-License-Identifier: BSD-3-Clause
"""Modes as notebooks show them: the stability, a table of eigenvalues, and the shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gelenk import _html
from gelenk.modal.mode import Mode
from gelenk.modal.table import shape_component

MAX_MODES = 60
MAX_SHAPES = 12


def modes_html(title: str, stability: str, why: str, modes: Sequence[Mode]) -> str:
    """Return modes as HTML.

    Args:
        title: mechanism and time.
        stability: of the mechanism.
        why: reason of the stability.
        modes: the modes to list.
    """
    parts: list[_html.Cell] = [_html.heading(title, stability), _html.paragraph(why)]
    if modes:
        titles = ("mode", "eigenvalue [1/s]", "[rad/s]", "[Hz]", "damping ratio", "time constant [s]", "")
        rows = map(_row, modes[:MAX_MODES])
        parts.append(_html.table(titles, rows, [*[True] * 6, False]))
        parts.append(_html.folded("mode shapes", _shapes(modes[:MAX_SHAPES])))
    if len(modes) > MAX_MODES:
        parts.append(_html.paragraph(f"and {len(modes) - MAX_MODES} more"))
    return _html.joined(parts)


def _row(mode: Mode) -> list[str]:
    value = mode.eigenvalue
    text = _html.number(value.real) if value.real or not value.imag else ""
    if value.imag:
        text += f" ± {_html.number(value.imag)}i"
    damping = "" if math.isnan(mode.damping_ratio) else _html.number(mode.damping_ratio, 4)
    constant = "" if math.isinf(mode.time_constant) else _html.number(mode.time_constant, 5)
    return [str(mode.number), text.strip(), _html.number(mode.natural_frequency),
            _html.number(mode.frequency_hz), damping, constant, mode.kind]  # fmt: skip


def _shapes(modes: Sequence[Mode]) -> _html.Fragment:
    names = list(dict.fromkeys(name for mode in modes for name in mode.shape))
    rows = (
        [name, *(shape_component(mode.shape[name]) if name in mode.shape else "" for mode in modes)]
        for name in names
    )
    return _html.table(("", *(f"mode {mode.number}" for mode in modes)), rows)
