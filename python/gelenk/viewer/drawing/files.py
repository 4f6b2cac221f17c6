# SPDX-License-Identifier: BSD-3-Clause
"""Pictures and films as files."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from gelenk.errors import UsageError
from gelenk.file_writing import replacing, writing
from gelenk.viewer.drawing.options import PictureOptions
from gelenk.viewer.drawing.painter import Painter

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

STILL_SIZE, FILM_SIZE = (960, 720), (480, 360)
COLORS = 63  # colors of a film; one more means that a pixel remains as it was
MAX_FRAMES = 1500  # of a film, which is made in memory
SAMPLES = 12  # frames that determine the palette
REPEATS = 5  # of a periodic motion in an .mp4 file, which players do not repeat
LAST_PAUSE = 0.6  # s; the end of a film is shown for so long before it begins again


def write_picture(data: Mapping[str, Any], path: Path, **choices: Any) -> Path:
    """Write a still picture (.png) or a film (.gif, .mp4) of `gelenk.viewer.data.page_data`.

    Args:
        data: what to show.
        path: the file.
        choices: fields of `PictureOptions`; None: the default.

    Raises:
        UsageError: a choice is invalid, or Pillow is not installed.
        OSError: the file cannot be written.
    """
    is_film = path.suffix.lower() != ".png"
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise UsageError(f"{path}: .mp4 files require ffmpeg, which is not installed")
    given = {name: value for name, value in choices.items() if value is not None}
    options = PictureOptions(**{"size": FILM_SIZE if is_film else STILL_SIZE, **given})
    first, last = options.span_in(float(data["time"][0]), float(data["time"][-1]))
    painter = Painter(data, options)
    if not is_film:
        with writing(path) as file:
            painter.frame(first).save(file, "PNG", optimize=True)
        return path
    speed = options.speed_for(last - first)
    # GIF files count in 1/100 s.
    delay = max(2, round(100 / options.frame_rate))
    count = max(1, round((last - first) / speed * 100 / delay))
    times = [min(last, first + k * speed * delay / 100) for k in range(count + 1)]
    is_periodic = bool(data.get("periodic"))
    if is_periodic:
        times = times[:-1]  # the first frame again
    if len(times) > MAX_FRAMES:
        raise UsageError(
            f"{path}: found {len(times)} frames, expected up to {MAX_FRAMES}; choose a shorter span, a lower "
            "frame rate or a higher speed"
        )
    frames = [painter.frame(t) for t in times]
    if path.suffix.lower() == ".gif":
        with writing(path) as file:
            _write_gif(frames, file, 10 * delay, 0 if is_periodic else LAST_PAUSE)
    else:
        with replacing(path) as draft:
            _write_mp4(frames, draft, path, 10 * delay, REPEATS if is_periodic else 1)
    return path


def _write_mp4(frames: list[Picture], draft: Path, path: Path, delay: int, repeats: int) -> None:
    """Write frames that last `delay` [ms] with ffmpeg, several times.

    Args:
        frames: the frames.
        draft: the file to write.
        path: the file that it will be, for messages.
        delay: of each frame [ms].
        repeats: how many times they are shown.

    Raises:
        UsageError: ffmpeg fails.
    """
    width, height = frames[0].size
    command = [
        shutil.which("ffmpeg") or "", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{width}x{height}", "-r", f"{1000 / delay:g}", "-i", "-", "-pix_fmt", "yuv420p",
        "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-f", "mp4", str(draft.absolute()),
    ]  # fmt: skip
    pixels = b"".join(frame.tobytes() for frame in frames) * repeats
    done = subprocess.run(command, input=pixels, capture_output=True, check=False)
    if done.returncode:
        why = done.stderr.decode(errors="replace").strip().replace(str(draft.absolute()), str(path))
        raise UsageError(f"{path}: ffmpeg failed: {why}")


def _write_gif(frames: list[Picture], file: BinaryIO, delay: int, pause: float) -> None:
    """Write frames that last `delay` [ms] and a pause [s] at the end.

    All have one palette, so that what does not move costs nothing.
    """
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
    durations = [delay] * (len(images) - 1) + [delay + round(1000 * pause)]
    images[0].save(
        file, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0, disposal=1,
        palette=bytes(colors), transparency=COLORS, optimize=True,
    )  # fmt: skip


def _distinct(colors: list[int]) -> list[int]:
    """Return a palette of COLORS + 1 colors of which none occurs twice, as Pillow identifies them."""
    rows = list(dict.fromkeys(zip(*[iter(colors)] * 3, strict=True)))
    unused = ((0, 0, blue) for blue in range(256) if (0, 0, blue) not in rows)
    rows += [next(unused) for _ in range(COLORS + 1 - len(rows))]
    return [component for row in rows for component in row]
