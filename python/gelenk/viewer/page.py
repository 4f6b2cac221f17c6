# SPDX-License-Identifier: BSD-3-Clause
"""The viewer's page: one HTML file without references to others."""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from gelenk.errors import UsageError
from gelenk.viewer.computing import core_file

LIBRARY = "three.min.js"  # the build of Gelenk takes it from the package trimesh: cmake/three_js.py
SCRIPTS = "script-src 'unsafe-inline'"  # in the page's content security policy
COMPUTING = f"{SCRIPTS} 'wasm-unsafe-eval'; worker-src blob:"  # the same of a page that computes

# Unpacks the scripts of a page that computes.
UNPACK = """\
(async function () {
  const bytes = Uint8Array.from(atob(document.getElementById("packed").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.append(script);
})();
"""


def page_of(data: Mapping[str, Any]) -> str:
    """Return the page that shows `gelenk.viewer.data.page_data`.

    Raises:
        UsageError: this installation has no viewer, or no core for a page that computes.
    """
    computes = "computes" in data
    page = text_of("page", "page.html")
    # "</script>" in a string would end the element.
    plain = json.dumps(data, allow_nan=False, separators=(",", ":"), default=packed).replace("<", "\\u003c")
    parts = {
        "title": html.escape(str(data["name"])),
        "style": text_of("page", "style.css"),
        "three": text_of("page", LIBRARY),
        "scripts": scripts_of("page"),
        "core": "",
        "licenses": "",
        "data": plain,
    }
    if computes:
        page = page.replace(SCRIPTS, COMPUTING, 1)
        parts |= computing_parts(parts["three"], parts["scripts"])
    out = []
    rest = page
    for name, part in sorted(parts.items(), key=lambda item: rest.index("{{" + item[0] + "}}")):
        before, rest = rest.split("{{" + name + "}}", 1)
        out += [before, part]
    return "".join([*out, rest])


def text_of(folder: str, name: str) -> str:
    """Return a file of the viewer. Raises UsageError if it is missing."""
    file = files("gelenk.viewer") / folder / name
    try:
        return file.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise UsageError(f"this installation of Gelenk has no viewer: {file} is missing") from None


def scripts_of(folder: str) -> str:
    """Return the scripts of a folder of the viewer, without the library."""
    names = [file.name for file in (files("gelenk.viewer") / folder).iterdir()]
    own = sorted(name for name in names if name.endswith(".js") and name != LIBRARY)
    return "\n".join(text_of(folder, name) for name in own)


def computing_parts(library: str, scripts: str) -> dict[str, str]:
    """Return the parts of a page that differ if it computes: what is large is compressed.

    Args:
        library: three.js, which begins with its license.
        scripts: of all pages.

    Raises:
        UsageError: this installation has no core for pages.
    """
    core = core_file()
    elements = {
        "worker": scripts_of("worker"),
        "core": base64.b64encode(core.read_bytes()).decode("ascii"),
        "packed": base64.b64encode(gzip.compress(f"{library}\n{scripts}".encode(), 9, mtime=0)).decode(
            "ascii"
        ),
    }
    folders = (Path(str(files("gelenk"))) / "licenses", core.parent / "licenses")
    found = sorted((file.stem, file) for folder in folders for file in folder.glob("*.txt"))
    licenses = [f"{name}\n\n{file.read_text(encoding='utf-8')}" for name, file in found]
    licenses.append("three.js\n\n" + library.partition("*/")[0].removeprefix("/*!"))
    text = html.escape("\n\n".join(licenses), quote=False)
    return {
        "three": "",
        "scripts": UNPACK,
        # No scripts until the page makes them so.
        "core": "\n".join(
            f'<script type="text/plain" id="{name}">{part}</script>' for name, part in elements.items()
        ),
        "licenses": f"<details><summary>Licenses</summary><pre>{text}</pre></details>",
    }


def packed(values: Any) -> str:
    """Return the numbers of an array as base64, little endian."""
    array = np.ascontiguousarray(values)
    return base64.b64encode(array.astype(array.dtype.newbyteorder("<")).tobytes()).decode("ascii")
