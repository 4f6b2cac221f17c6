# SPDX-License-Identifier: BSD-3-Clause
"""PNG and GIF files of `gelenk view`, and what can be chosen for them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageSequence
from typer.testing import CliRunner

import gelenk
from gelenk.cli import app
from gelenk.viewer.drawing.files import FILM_SIZE, STILL_SIZE
from gelenk.viewer.drawing.options import LONGEST, SHORTEST, PictureOptions
from gelenk.viewer.drawing.painter import Painter

SIZE = (160, 120)


@pytest.fixture(scope="module")
def page(root: Path) -> gelenk.View:
    return gelenk.view(root / "scenes" / "four_bar.yaml", stop=5.0, inputs={"drive.tau": 3.0})


def opened(file: Path) -> tuple[str | None, tuple[int, int]]:
    """The format and the size of a picture."""
    with Image.open(file) as picture:
        return picture.format, picture.size


def command(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["view", *map(str, arguments)])


def test_a_film_shows_the_frames_of_the_run(page: gelenk.View, tmp_path: Path) -> None:
    """Decoded frames have the colors painted but for the palette, whose steps are about 16 of 255."""
    painter = Painter(page._data, PictureOptions(size=SIZE))
    durations = []
    file = page.save(tmp_path / "film.gif", size=SIZE, span=(1.0, 3.0), frame_rate=10)
    with Image.open(file) as film:
        for k, shown in enumerate(ImageSequence.Iterator(film)):
            durations.append(shown.info["duration"])
            expected = np.asarray(painter.frame(1.0 + 0.1 * k), float)
            assert np.abs(np.asarray(shown.convert("RGB"), float) - expected).max() < 40
            other = np.asarray(painter.frame(1.0 + 0.1 * k + 0.05), float)
            assert np.abs(np.asarray(shown.convert("RGB"), float) - other).max() > 60
        assert film.info["loop"] == 0
    assert durations == [100] * 20 + [700]  # 2 s, and a pause


@pytest.mark.thorough
def test_films_are_small(page: gelenk.View, tmp_path: Path) -> None:
    """5 s with the default choices; every body moves."""
    file = page.save(tmp_path / "film.gif")
    with Image.open(file) as film:
        assert film.size == FILM_SIZE
        assert film.n_frames == 101  # type: ignore[attr-defined]
    assert file.stat().st_size < 450e3


def test_a_mechanism_at_rest_is_a_film_that_can_be_shown(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    file = gelenk.view(four_bar, stop=0.0).save(tmp_path / "film.gif", size=SIZE)
    assert opened(file) == ("GIF", SIZE)


def test_a_still_picture_shows_the_first_time(page: gelenk.View, tmp_path: Path) -> None:
    painter = Painter(page._data, PictureOptions(size=SIZE))
    found = Image.open(page.save(tmp_path / "x.png", size=SIZE, span=(2.5, 2.5)))
    assert (np.asarray(found) == np.asarray(painter.frame(2.5))).all()
    assert opened(page.save(tmp_path / "y.png")) == ("PNG", STILL_SIZE)


@pytest.mark.parametrize("duration", [1e-4, 0.03, 1.0, 2.0, 5.0, 10.0, 10.1, 60.0, 1e5])
def test_films_last_neither_too_short_nor_too_long(duration: float) -> None:
    speed = PictureOptions(SIZE).speed_for(duration)
    assert duration / speed >= SHORTEST * (1 - 1e-12)
    assert duration / speed <= LONGEST * (1 + 1e-12)
    assert (speed == 1) == (SHORTEST <= duration <= LONGEST)
    assert PictureOptions(SIZE, speed=3.0).speed_for(duration) == 3.0


@pytest.mark.parametrize(
    ("choices", "sentence"),
    [
        ({"size": (15, 100)}, "size: found (15, 100), expected width and height from 16 to 4096 pixels"),
        ({"size": (100, 4097)}, "size: found (100, 4097), expected width and height from 16 to 4096 pixels"),
        ({"frame_rate": 0.0}, "frame_rate: found 0.0, expected more than 0, up to 50 1/s"),
        ({"frame_rate": 51.0}, "frame_rate: found 51.0, expected more than 0, up to 50 1/s"),
        ({"speed": -1.0}, "speed: found -1.0, expected more than 0"),
        ({"speed": float("nan")}, "speed: found nan, expected more than 0"),
        ({"span": (0.0, 6.0)}, "span: found (0.0, 6.0), expected two times within 0 to 5 s"),
        ({"span": (2.0, 1.0)}, "span: found (2.0, 1.0), expected two times within 0 to 5 s"),
        ({"camera": "back"}, "camera: found back, expected start, front, side, top, or azimuth and"),
        ({"camera": (0.0, 91.0)}, "camera: found (0.0, 91.0), expected start, front, side, top, or azimuth"),
        ({"speed": 0.01}, "found 10001 frames, expected up to 1500; choose a shorter span"),
    ],
)  # fmt: skip
def test_wrong_choices(choices: Any, sentence: str, page: gelenk.View, tmp_path: Path) -> None:
    with pytest.raises(gelenk.UsageError) as found:
        page.save(tmp_path / "x.gif", **choices)
    assert sentence in str(found.value)
    assert not (tmp_path / "x.gif").exists()


def test_a_page_has_no_choices(page: gelenk.View, tmp_path: Path) -> None:
    with pytest.raises(
        gelenk.UsageError, match=r"x\.html: found speed, dark, which only pictures have: \.png"
    ):
        page.save(tmp_path / "x.html", speed=1.0, dark=True)


def test_command(four_bar_file: Path, tmp_path: Path) -> None:
    png, gif, html = (tmp_path / f"x.{ending}" for ending in ("png", "gif", "html"))
    done = command(
        four_bar_file, "--stop", "0.2", "--png", png, "--gif", gif, "-o", html, "--size", "160x120",
        "--camera=-90,20", "--fps", 10, "--span", "0.1:0.2", "--trails", "--time", "--dark",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert [line.split(":")[0] for line in done.output.splitlines()] == [str(html), str(png), str(gif)]
    assert opened(png) == ("PNG", SIZE)
    assert opened(gif) == ("GIF", SIZE)
    assert html.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert command(four_bar_file, "--stop", "0.2", "-o", tmp_path / "y.PNG").exit_code == 0
    assert opened(tmp_path / "y.PNG") == ("PNG", STILL_SIZE)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["-o", "x.pdf"], "--output x.pdf: expected FILE.html or FILE.png or FILE.gif"),
        (["--png", "x.gif"], "--png x.gif: expected FILE.png"),
        (["--gif", "x.png"], "--gif x.png: expected FILE.gif"),
        (["--png", "x.png", "--size", "big"], "--size big: expected WIDTHxHEIGHT in pixels"),
        (["--png", "x.png", "--span", "1:2:3"], "--span 1:2:3: expected FROM:TO in seconds, or one time"),
        (["--png", "x.png", "--camera", "a,b"], "--camera: found 'a', expected a number"),
        (["-o", "x.html", "--fps", "5", "--time"], "--fps, --time: only for pictures, expected --png"),
    ],
)  # fmt: skip
def test_wrong_commands(arguments: list[str], sentence: str, four_bar_file: Path) -> None:
    done = command(four_bar_file, *arguments)
    assert done.exit_code == 1
    assert sentence in done.output
