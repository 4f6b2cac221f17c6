# SPDX-License-Identifier: BSD-3-Clause
"""Pages of docs/ with measured parts between markers; the text around them is written by hand."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class NonsmoothStudy:
    """Where a part of `make nonsmooth` writes: with `--quick`, a test, nothing of the documentation."""

    page_name: str
    quick: bool

    def __post_init__(self) -> None:
        self.numbers.mkdir(parents=True, exist_ok=True)

    @property
    def numbers(self) -> Path:
        """Return the folder of the figures."""
        return ROOT / "out" / "nonsmooth"

    @property
    def pictures(self) -> Path:
        """Return the folder of the pictures."""
        return self.numbers if self.quick else ROOT / "docs" / "pictures"

    def put(self, maker: str, parts: Mapping[str, str]) -> None:
        """Replace the parts of the page, and print what has been updated."""
        page = (self.numbers if self.quick else ROOT / "docs") / self.page_name
        put(page, maker, parts)
        print(f"{page.relative_to(ROOT)}: {len(parts)} parts updated")


def quick_parser(description: str | None) -> argparse.ArgumentParser:
    """Return a parser of command lines with the option `--quick`."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    return parser


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
