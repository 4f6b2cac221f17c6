# SPDX-License-Identifier: BSD-3-Clause
"""Colors of the viewer, light and dark: those of the page's style sheet."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

type Color = NDArray[np.float64]  # red, green, blue from 0 to 1

LEAST_CONTRAST = 2.4  # of a color and the background, as WCAG defines it
LIGHTNESS_STEP, DARK = 0.04, 0.2  # of one adjustment; luminance below which a background is dark
SPRING_COLOR = "#7d8590"


@dataclass(frozen=True)
class Theme:
    """Colors of what is not a body."""

    background: str
    grid: str
    text: str


LIGHT = Theme(background="#f3f4f6", grid="#7c8694", text="#1c2026")
DARK_THEME = Theme(background="#15181d", grid="#7d8999", text="#e8eaee")


def color_of(code: str) -> Color:
    """Return a color from its code #rrggbb."""
    return np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)]) / 255


def luminance(color: Color) -> float:
    """Return the relative luminance as WCAG defines it."""
    linear = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def readable(color: Color, background: Color) -> Color:
    """Return a color with a lightness that distinguishes it from the background."""
    behind = luminance(background)
    hue, lightness, saturation = colorsys.rgb_to_hls(*color)
    for _ in range(20):
        pair = sorted([luminance(color), behind])
        if (pair[1] + 0.05) / (pair[0] + 0.05) >= LEAST_CONTRAST:
            break
        lightness = float(np.clip(lightness + LIGHTNESS_STEP * (1 if behind < DARK else -1), 0, 1))
        color = np.array(colorsys.hls_to_rgb(hue, lightness, saturation))
    return color
