# SPDX-License-Identifier: BSD-3-Clause
"""Pages as files, in the browser and in notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gelenk import _core
from gelenk.errors import UsageError
from gelenk.file_writing import write_text
from gelenk.viewer.data import page_data
from gelenk.viewer.degrees import with_degrees
from gelenk.viewer.file_types import PICTURES, is_picture
from gelenk.viewer.overlay import overlaid
from gelenk.viewer.page import page_of

if TYPE_CHECKING:
    from gelenk.simulation.recording import Recording


class View:
    """A page that shows a mechanism in motion; notebooks display it."""

    def __init__(self, data: Mapping[str, Any], run: Mapping[str, Any] | None = None) -> None:
        """Make a view of `gelenk.viewer.data.page_data`.

        Args:
            data: of the page.
            run: of a run, for pictures and other pages, if the page computes its own.
        """
        self._data = data
        self._run = run or data
        self._name = str(data["name"])

    @cached_property
    def html(self) -> str:
        """The page: one HTML document without references to other files. Raises UsageError."""
        return page_of(self._data)

    def save(
        self,
        path: str | PathLike[str],
        *,
        size: tuple[int, int] | None = None,
        camera: str | Sequence[float] | None = None,
        span: Sequence[float] | None = None,
        frame_rate: float | None = None,
        speed: float | None = None,
        trails: bool | None = None,
        time_stamp: bool | None = None,
        dark: bool | None = None,
    ) -> Path:
        """Write the page to a file, or a picture that is drawn without a browser.

        Args:
            path: .html; .png for a still picture; .gif for a film that repeats itself; .mp4 for one
                that is encoded by ffmpeg, if it is installed.
            size: width and height of a picture [pixels]; default: (960, 720), of films (480, 360).
            camera: "start", as the page opens; "front", "side", "top"; or azimuth and elevation [deg], where
                (-90, 0) is the front view and (0, 0) the view from the right.
            span: the times from which to which a film shows the run [s]; a still picture shows the first one.
                Default: the whole run.
            frame_rate: of films [1/s]; default: 20.
            speed: of films, relative to real time; default: 1, or what lets the film last 2 to 10 s.
            trails: whether the paths of points are shown.
            time_stamp: whether the time is shown.
            dark: whether the colors are dark.

        Returns:
            Path: the file.

        Raises:
            UsageError: the ending or a choice is invalid, or Pillow is not installed.
            OSError: the file cannot be written.
        """
        out = Path(path)
        choices = {
            "size": size, "camera": camera, "span": span, "frame_rate": frame_rate, "speed": speed,
            "trails": trails, "time_stamp": time_stamp, "dark": dark,
        }  # fmt: skip
        if is_picture(out):
            from gelenk.viewer.drawing.files import write_picture

            return write_picture(self._run, out, **choices)
        given = [name for name, value in choices.items() if value is not None]
        if given:
            raise UsageError(
                f"{out}: found {', '.join(given)}, which only pictures have: {', '.join(PICTURES)}"
            )
        write_text(out, self.html)
        return out

    def overlay(self, other: View, names: Sequence[str] = ()) -> View:
        """Return a page on which another run is seen, translucent, beside this one; plots have both curves.

        Args:
            other: of a run, of the same mechanism or of another one.
            names: of this run and of the other one; by default those of the scenes.

        Raises:
            UsageError: one of them shows two runs already, or there are not two names.
        """
        return View(overlaid(self._run, other._run, names))

    def in_degrees(self) -> View:
        """Return the same page with angles, angular velocities and accelerations in degrees in its plots."""
        return View(with_degrees(self._data), self._run)

    def show(self) -> Path:
        """Open the page in the browser, from a temporary file of which the path is returned."""
        import tempfile
        import webbrowser

        with tempfile.NamedTemporaryFile(
            "w", suffix=".html", prefix=f"{_core.file_stem(self._name)}-", delete=False, encoding="utf-8"
        ) as file:
            file.write(self.html)
        webbrowser.open(Path(file.name).as_uri())
        return Path(file.name)

    def _repr_html_(self) -> str:
        from html import escape

        return (
            f'<iframe srcdoc="{escape(self.html)}" width="100%" height="520" '
            f'style="border:0" title="{escape(self._name)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<View of {self._name}, {len(self.html) / 1e6:.1f} MB; save('FILE.html') or show()>"


def view_of(recording: Recording) -> View:
    """Return the page of a recorded run."""
    return View(page_data(recording))
