# SPDX-License-Identifier: BSD-3-Clause
"""Modes as a text to be read."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

import numpy as np

from gelenk.modal.mode import Mode

ABREAST = 6  # shapes in one table
WIDTH = 110
NONE = 5e-7  # of the largest: shown as 0


def table(title: str, why: str, modes: Sequence[Mode]) -> str:
    """The verdict, a line for each mode, and their shapes by coordinate."""
    parts = [title, textwrap.fill(why, WIDTH)]
    if modes:
        parts.append(_numbers(modes))
    for first in range(0, len(modes), ABREAST):
        parts.append(_shapes(modes[first : first + ABREAST]))
    return "\n\n".join(parts)


def _numbers(modes: Sequence[Mode]) -> str:
    lines = ["mode               eigenvalue [1/s]       [rad/s]          [Hz]    damping  time constant [s]"]
    for mode in modes:
        value = _complex(mode.eigenvalue)
        damping = "" if math.isnan(mode.damping) else f"{mode.damping:.4g}"
        constant = "" if math.isinf(mode.time_constant) else f"{mode.time_constant:.5g}"
        power = mode.length - 1
        chain = f", with t{f'^{power}' if power > 1 else ''}" if power > (mode.kind == "drifts") else ""
        lines.append(
            f"{mode.number:4}  {value:>29}  {mode.frequency:12.6g}  {mode.hertz:12.6g}  {damping:>9}  "
            f"{constant:>17}  {mode.kind}{chain}"
        )
    return "\n".join(line.rstrip() for line in lines)


def _complex(x: complex) -> str:
    if not x.imag:
        return f"{x.real:.6g}"
    return f"{f'{x.real:.6g} ' if x.real else ''}+- {x.imag:.6g}i"


def _shapes(modes: Sequence[Mode]) -> str:
    names = list(dict.fromkeys(name for mode in modes for name in mode.shape))
    first = max(len("shapes"), *map(len, names))
    cells = [[_cell(mode.shape[name]) if name in mode.shape else "" for mode in modes] for name in names]
    lines = ["  ".join([f"{'shapes':{first}}", *(f"{mode.number:>16}" for mode in modes)])]
    for name, row in zip(names, cells, strict=True):
        lines.append("  ".join([f"{name:{first}}", *(f"{cell:>16}" for cell in row)]).rstrip())
    return "\n".join(lines)


def _cell(x: complex) -> str:
    """A number, or magnitude and phase where the coordinate does not move in step with the largest."""
    if abs(x) < NONE:
        return "0"
    phase = round(float(np.degrees(np.angle(x))))  # damping turns phases by less than what a reader asks for
    if phase % 180 == 0:
        return f"{math.copysign(abs(x), x.real):.5g}"
    return f"{abs(x):.3g} at {phase}°"
