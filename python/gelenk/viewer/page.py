# SPDX-License-Identifier: BSD-3-Clause
"""The viewer's page: one HTML file without references to others."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import numpy as np

from gelenk.errors import UsageError

LIBRARY = "three.min.js"  # the build of Gelenk takes it from the package trimesh: cmake/three_js.py


def page_of(data: Mapping[str, Any]) -> str:
    """Return the page that shows `gelenk.viewer.data.page_data`.

    Raises:
        UsageError: this installation has no viewer.
    """
    folder = files("gelenk.viewer") / "page"

    def text(name: str) -> str:
        try:
            return (folder / name).read_text(encoding="utf-8")
        except FileNotFoundError:
            raise UsageError(
                f"this installation of Gelenk has no viewer: {folder / name} is missing"
            ) from None

    names = (file.name for file in folder.iterdir())
    scripts = sorted(name for name in names if name.endswith(".js") and name != LIBRARY)
    # "</script>" in a string would end the element.
    plain = json.dumps(data, allow_nan=False, separators=(",", ":"), default=packed).replace("<", "\\u003c")
    parts = {
        "title": html.escape(str(data["name"])),
        "style": text("style.css"),
        "three": text(LIBRARY),
        "scripts": "\n".join(map(text, scripts)),
        "data": plain,
    }
    out = []
    rest = text("page.html")
    for name, part in sorted(parts.items(), key=lambda item: rest.index("{{" + item[0] + "}}")):
        before, rest = rest.split("{{" + name + "}}", 1)
        out += [before, part]
    return "".join([*out, rest])


def packed(values: Any) -> str:
    """Return the numbers of an array as base64, little endian."""
    array = np.ascontiguousarray(values)
    return base64.b64encode(array.astype(array.dtype.newbyteorder("<")).tobytes()).decode("ascii")
