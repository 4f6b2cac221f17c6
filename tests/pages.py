# SPDX-License-Identifier: BSD-3-Clause
"""Code on the pages of the documentation."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import programs

ROOT = Path(__file__).parent.parent
WITH_CODE = sorted(
    str(page.relative_to(ROOT))
    for page in (ROOT / "README.md", *ROOT.glob("docs/**/*.md"))
    if re.search(r"^```(console|python|sh)$", page.read_text(encoding="utf-8"), re.MULTILINE)
)


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of a page in one language."""
    return re.findall(
        rf"^```{language}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


def executed(page: Path) -> dict[str, Any]:
    """What the Python blocks of a page leave behind, run one after the other where its files are."""
    create_files(page, Path.cwd())
    names: dict[str, Any] = {}
    for block in blocks(page, "python"):
        exec(compile(block, page.name, "exec"), names)
    return names


def create_files(page: Path, folder: Path) -> None:
    """Make what the reader of a page has: the scenes that it names, and the files that it asks for."""
    text = page.read_text(encoding="utf-8")
    for name in set(re.findall(r"(?:scenes|docs/gallery)/\w[\w/]*\.yaml", text)):
        link = folder / name
        link.parent.mkdir(parents=True, exist_ok=True)
        if not link.exists():
            link.symlink_to(ROOT / name)
    for source, name in re.findall(r"Copy its \[scene\]\((.*?)\) to the file `(\S+?)`", text):
        (folder / name).write_bytes((page.parent / source).read_bytes())
    if asked := re.search(r"Create a file `(\S+?\.yaml)`", text):
        whole = [piece for piece in blocks(page, "yaml") if not piece.startswith(" ")]  # no fragments
        (folder / asked[1]).write_text("".join(whole), encoding="utf-8")


def commands(page: Path) -> list[tuple[str, str]]:
    """The commands of a page and what it shows that they print."""
    return re.findall(r"^\$ (.*)\n((?:[^$].*\n|\n)*)", "".join(blocks(page, "console")), re.MULTILINE)


def printed(command: str, folder: Path, **environment: str) -> tuple[int, str]:
    """The exit code of a command `gelenk ...` in this folder, and what it prints, errors included."""
    program, *arguments = shlex.split(command)
    assert program == "gelenk"
    done = programs.gelenk(*arguments, cwd=folder, merged=True, env=environment)
    return done.returncode, done.stdout


def shown(expected: str) -> re.Pattern[str]:
    """What a page shows, as a pattern: `...` is a word, on a line of its own any lines."""
    pattern = re.escape(expected).replace(re.escape("\n...\n"), "\n(.*\n)*")
    return re.compile(pattern.replace(re.escape("..."), r"\S+"))
