# SPDX-License-Identifier: BSD-3-Clause
"""Pages of docs/ with measured parts between markers; the text around them is written by hand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path


def put(page: Path, maker: str, parts: Mapping[str, str], unread: str = "") -> None:
    """Replace the parts of a page that `maker` generates, by name.

    A part that the page does not have yet is appended, followed by the text `unread`.
    """
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    for name, content in parts.items():
        begin, end = f"<!-- made by {maker}: {name} -->", f"<!-- end of {name} -->"
        block = f"{begin}\n{content.strip()}\n{end}"
        if begin in text:
            before, rest = text.split(begin)
            text = before + block + rest.split(end, 1)[1]
        else:
            text += f"\n{block}\n{unread}"
    page.write_text(text, encoding="utf-8")
