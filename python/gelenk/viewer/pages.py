# SPDX-License-Identifier: BSD-3-Clause
"""Pages as files, in the browser and in notebooks."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from gelenk.viewer.data import page_data
from gelenk.viewer.page import page_of

if TYPE_CHECKING:
    from gelenk.simulation.recording import Recording


class View:
    """A page that shows a mechanism in motion; notebooks display it."""

    def __init__(self, name: str, html: str) -> None:
        """Make a view of its page."""
        self._name = name
        #: The page: one HTML document without references to other files.
        self.html = html

    def save(self, path: str | PathLike[str]) -> Path:
        """Write the page to a file, and return its path. Raises OSError."""
        out = Path(path)
        out.write_text(self.html, encoding="utf-8")
        return out

    def show(self) -> Path:
        """Open the page in the browser, from a temporary file of which the path is returned."""
        import tempfile
        import webbrowser

        with tempfile.NamedTemporaryFile(
            "w", suffix=".html", prefix=f"{self._name}-", delete=False, encoding="utf-8"
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
    data = page_data(recording)
    return View(str(data["name"]), page_of(data))
