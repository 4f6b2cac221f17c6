# SPDX-License-Identifier: BSD-3-Clause
"""Code on the pages of the documentation."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of a page in one language."""
    return re.findall(
        rf"^```{language}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


def executed(page: Path) -> dict[str, Any]:
    """What the Python blocks of a page leave behind, run one after the other."""
    names: dict[str, Any] = {}
    for block in blocks(page, "python"):
        exec(compile(block, page.name, "exec"), names)
    return names
