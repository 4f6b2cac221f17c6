# SPDX-License-Identifier: BSD-3-Clause
"""Colors, lines and markers of the methods, the same on all charts."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from gelenk.chart.methods import AUTO, DEFAULT, Method
from gelenk.file_writing import writing

# Colors distinguish integrators (after Okabe & Ito), lines and markers distinguish formulations.
COLORS = {
    "erk": "#0072B2", "ida": "#D55E00", "rk4": "#009E73", "euler": "#999999", "cvode": "#E69F00",
    "cvode-adams": "#56B4E9", "dirk": "#CC79A7", "generalized-alpha": "#7F3C8D", "hht": "#8C564B",
    "newmark": "#BCBD22", "moreau-jean": "#A50F15",
}  # fmt: skip
LINES = {
    "projection": ("-", "o"), "baumgarte": ("--", "s"), "udwadia-kalaba": (":", "v"),
    "penalty": ("-.", "D"), "augmented-lagrangian": ((0, (5, 1, 1, 1, 1, 1)), "P"),
    "independent": ((0, (1, 1)), "^"), "stabilized-index2": ((0, (7, 2)), "<"),
    "index3": ((0, (3, 3)), ">"),
}  # fmt: skip
SPARE = "#4B4B4B"
PALETTE_SIZE = 256


def look(method: Method) -> dict[str, Any]:
    """Return the line properties of a method for matplotlib."""
    if method == AUTO:
        return {"color": "black", "linestyle": "-", "marker": "o", "linewidth": 2.6, "markersize": 6,
                "zorder": 5}  # fmt: skip
    line, marker = LINES.get(method.formulation, ("-", "X"))
    plain = method.formulation == DEFAULT
    return {"color": COLORS.get(method.integrator, SPARE), "linestyle": line, "marker": marker,
            "linewidth": 1.5 if plain else 1.0, "markersize": 4.5, "zorder": 3 if plain else 2}  # fmt: skip


def save(figure: Any, path: Path, dpi: int) -> None:
    """Write a figure as PNG with a palette, which has a third of the size. Raises OSError."""
    from PIL import Image

    whole = io.BytesIO()
    figure.savefig(whole, format="png", dpi=dpi)
    # Quantization by coverage keeps rare colors.
    few = Image.open(whole).convert("RGB").quantize(PALETTE_SIZE, Image.Quantize.MAXCOVERAGE)
    with writing(path) as file:
        few.save(file, "PNG", optimize=True)
