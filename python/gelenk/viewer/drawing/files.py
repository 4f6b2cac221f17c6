# SPDX-License-Identifier: BSD-3-Clause
"""Pictures and films as files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelenk.errors import UsageError
from gelenk.viewer.drawing.options import PictureOptions
from gelenk.viewer.drawing.painter import Painter

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

STILL_SIZE, FILM_SIZE = (960, 720), (480, 360)
COLORS = 63  # colors of a film; one more stands for what remains as it was
MAX_FRAMES = 1500  # of a film, which is made in memory
SAMPLES = 12  # frames that determine the palette
LAST_PAUSE = 0.6  # s; the end of a film is shown for so long before it begins again


def write_picture(data: Mapping[str, Any], path: Path, **choices: Any) -> Path:
    """Write a still picture (.png) or a film (.gif) of `gelenk.viewer.data.page_data`.

    Args:
        data: what to show.
        path: the file.
        choices: fields of `PictureOptions`; None: the default.

    Raises:
        UsageError: a choice is invalid, or Pillow is not installed.
        OSError: the file cannot be written.
    """
    is_film = path.suffix.lower() == ".gif"
    given = {name: value for name, value in choices.items() if value is not None}
    options = PictureOptions(**{"size": FILM_SIZE if is_film else STILL_SIZE, **given})
    first, last = options.span_in(float(data["time"][0]), float(data["time"][-1]))
    painter = Painter(data, options)
    if not is_film:
        painter.frame(first).save(path, optimize=True)
        return path
    speed = options.speed_for(last - first)
    # GIF files count in 1/100 s.
    delay = max(2, round(100 / options.frame_rate))
    count = max(1, round((last - first) / speed * 100 / delay))
    times = [min(last, first + k * speed * delay / 100) for k in range(count + 1)]
    if len(times) > MAX_FRAMES:
        raise UsageError(
            f"{path}: found {len(times)} frames, expected up to {MAX_FRAMES}; choose a shorter span, a lower "
            "frame rate or a higher speed"
        )
    _write_gif([painter.frame(t) for t in times], path, 10 * delay)
    return path


def _write_gif(frames: list[Picture], path: Path, delay: int) -> None:
    """Write frames that last `delay` [ms], with one palette, so that what does not move costs nothing."""
    from PIL import Image

    width, height = frames[0].size
    chosen = [frames[k] for k in np.unique(np.linspace(0, len(frames) - 1, SAMPLES).round().astype(int))]
    strip = Image.new("RGB", (width, height * len(chosen)))
    for k, frame in enumerate(chosen):
        strip.paste(frame, (0, k * height))
    # Colors of small parts, such as pins, are as important as those of large ones.
    palette = strip.quantize(COLORS, method=Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE)
    colors = _distinct((palette.getpalette() or [])[: 3 * COLORS])
    palette.putpalette(colors)
    images = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [delay] * (len(images) - 1) + [delay + round(1000 * LAST_PAUSE)]
    images[0].save(
        path, save_all=True, append_images=images[1:], duration=durations, loop=0, disposal=1,
        palette=bytes(colors), transparency=COLORS, optimize=True,
    )  # fmt: skip


def _distinct(colors: list[int]) -> list[int]:
    """Return a palette of COLORS + 1 colors of which none occurs twice, as Pillow identifies them."""
    rows = list(dict.fromkeys(zip(*[iter(colors)] * 3, strict=True)))
    unused = ((0, 0, blue) for blue in range(256) if (0, 0, blue) not in rows)
    rows += [next(unused) for _ in range(COLORS + 1 - len(rows))]
    return [component for row in rows for component in row]
