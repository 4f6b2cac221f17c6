# SPDX-License-Identifier: BSD-3-Clause
"""Printed tables of modes."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

import numpy as np

from gelenk.modal.mode import Mode

SHAPES_PER_TABLE = 6
MAX_LINE_LENGTH = 110
DISPLAY_TOLERANCE = 5e-7  # relative to the largest component of a shape; below it, a component is shown as 0


def table(title: str, why: str, modes: Sequence[Mode]) -> str:
    """Return the stability, a line for each mode, and the mode shapes by coordinate.

    Args:
        title: mechanism, time and stability.
        why: reason of the stability.
        modes: the modes to list.
    """
    parts = [title, textwrap.fill(why, MAX_LINE_LENGTH)]
    if modes:
        parts.append(_numbers(modes))
    for first in range(0, len(modes), SHAPES_PER_TABLE):
        parts.append(_shapes(modes[first : first + SHAPES_PER_TABLE]))
    return "\n\n".join(parts)


def _numbers(modes: Sequence[Mode]) -> str:
    lines = ["mode               eigenvalue [1/s]       [rad/s]          [Hz]    damping  time constant [s]"]
    for mode in modes:
        value = _complex(mode.eigenvalue)
        damping = "" if math.isnan(mode.damping_ratio) else f"{mode.damping_ratio:.4g}"
        constant = "" if math.isinf(mode.time_constant) else f"{mode.time_constant:.5g}"
        power = mode.chain_length - 1
        chain = f", with t{f'^{power}' if power > 1 else ''}" if power > (mode.kind == "drifting") else ""
        lines.append(
            f"{mode.number:4}  {value:>29}  {mode.natural_frequency:12.6g}  {mode.frequency_hz:12.6g}  "
            f"{damping:>9}  {constant:>17}  {mode.kind}{chain}"
        )
    return "\n".join(line.rstrip() for line in lines)


def _complex(x: complex) -> str:
    if not x.imag:
        return f"{x.real:.6g}"
    return f"{f'{x.real:.6g} ' if x.real else ''}+- {x.imag:.6g}i"


def _shapes(modes: Sequence[Mode]) -> str:
    names = list(dict.fromkeys(name for mode in modes for name in mode.shape))
    first = max(len("shapes"), *map(len, names))
    cells = [
        [shape_component(mode.shape[name]) if name in mode.shape else "" for mode in modes] for name in names
    ]
    lines = ["  ".join([f"{'shapes':{first}}", *(f"{mode.number:>16}" for mode in modes)])]
    for name, row in zip(names, cells, strict=True):
        lines.append("  ".join([f"{name:{first}}", *(f"{cell:>16}" for cell in row)]).rstrip())
    return "\n".join(lines)


def shape_component(x: complex) -> str:
    """Return a component of a mode shape as text.

    It is a real number, or magnitude and phase if the component is not in phase with the largest one.
    """
    if abs(x) < DISPLAY_TOLERANCE:
        return "0"
    phase = round(float(np.degrees(np.angle(x))))  # slight damping causes phases below 0.5 degrees
    if phase % 180 == 0:
        return f"{math.copysign(abs(x), x.real):.5g}"
    return f"{abs(x):.3g} at {phase}°"
