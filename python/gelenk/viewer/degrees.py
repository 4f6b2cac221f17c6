# SPDX-License-Identifier: BSD-3-Clause
"""Angles in degrees, for plots and pages; everything else, and all files of results, are in radians."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

IN_DEGREES = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2"}  # by units of signals
DEGREE = math.pi / 180  # rad


def with_degrees(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return `gelenk.viewer.data.page_data` with angles of its plots in degrees."""
    signals = []
    for row in data["signals"]:
        if row["unit"] not in IN_DEGREES:
            signals.append(row)
            continue
        curves = {key: row[key] / row[key].dtype.type(DEGREE) for key in ("values", "second") if key in row}
        signals.append({**row, **curves, "unit": IN_DEGREES[row["unit"]]})
    return {**data, "signals": signals}
