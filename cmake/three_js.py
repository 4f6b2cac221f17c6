# SPDX-License-Identifier: BSD-3-Clause
"""Write three.js, as contained in the page template of the package trimesh, with its license, to a file.

three_js.py FILE
three_js.py --release   prints its release, for the bill of materials
"""

from __future__ import annotations

import importlib.util
import re
import sys
import zipfile
from pathlib import Path

LICENSE = Path(__file__).parent.parent / "licenses" / "python" / "three.js.txt"
TEMPLATE = "resources/templates/viewer.zip"
BUILD = re.compile(
    r"/\*\*\s*\* @license\s*\* Copyright \d+-\d+ Three\.js Authors.*?\*/\s*!function[^\n]+", re.DOTALL
)


def three_js() -> str:
    """Return the build of three.js, after its license as a comment."""
    spec = importlib.util.find_spec("trimesh")
    if spec is None or spec.origin is None:
        sys.exit("trimesh: not installed, expected one of the versions in pyproject.toml")
    path = Path(spec.origin).parent / TEMPLATE
    with zipfile.ZipFile(path) as archive:
        page = archive.read("viewer.html.template").decode("utf-8")
    found = BUILD.search(page)
    if not found:
        sys.exit(f"{path}: found no three.js, expected one of the versions of trimesh in pyproject.toml")
    return f"/*!\n{LICENSE.read_text(encoding='utf-8')}*/\n{found.group()}"


def release() -> str:
    """Return the release of three.js, such as 140: its constant REVISION."""
    build = three_js()
    name = re.search(r"\bREVISION\s*=\s*(\w+)", build)
    found = re.search(rf"\b{name[1]}\s*=\s*\"(\w+)\"", build) if name else None
    if found is None:
        sys.exit("three.js: found no REVISION")
    return found[1]


if __name__ == "__main__":
    if sys.argv[1] == "--release":
        print(release())
        sys.exit()
    Path(sys.argv[1]).write_text(three_js(), encoding="utf-8")
