# SPDX-License-Identifier: BSD-3-Clause
"""The malformed scenes of scene_errors/ and what is expected of each.

A YAML file says it in comments at its top, `# expect: LINE` for every line of the error; a JSON file has a
.txt beside it. `# raised by: initialize` marks scenes that read well but cannot be simulated.
"""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parent / "scene_errors"
SCENES = Path(__file__).parent.parent / "scenes"
GALLERY = Path(__file__).parent.parent / "docs" / "gallery"


def malformed() -> list[Path]:
    """Scenes that `gelenk.load` must refuse."""
    return [path for path in _scene_files() if not _header(path, "raised by")]


def impossible() -> list[Path]:
    """Scenes that can be read and not simulated."""
    return [path for path in _scene_files() if _header(path, "raised by")]


def good() -> list[Path]:
    """The ready scenes."""
    return sorted(SCENES.glob("*.yaml"))


def gallery() -> dict[str, Path]:
    """The scenes that the gallery shows, by the names of their folders: its own, and all ready ones."""
    own = {path.parent.name: path for path in GALLERY.glob("*/scene.yaml")}
    return dict(sorted((own | {path.stem: path for path in good()}).items()))


def expected(path: Path) -> list[str]:
    """The lines that the error must have."""
    if path.suffix == ".json":
        return path.with_suffix(".txt").read_text(encoding="utf-8").splitlines()
    return _header(path, "expect")


def _scene_files() -> list[Path]:
    return sorted(path for path in FOLDER.iterdir() if path.suffix in (".yaml", ".json"))


def _header(path: Path, word: str) -> list[str]:
    start = f"# {word}: "
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line.removeprefix(start) for line in lines if line.startswith(start)]
