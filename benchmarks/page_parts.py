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


def marks(maker: str, name: str) -> tuple[str, str]:
    """Return the lines before and after a part that `maker` generates."""
    return f"<!-- made by {maker}: {name} -->", f"<!-- end of {name} -->"


def part(page: Path, maker: str, name: str) -> str:
    """Return a part of a page; empty: the page does not have it."""
    begin, end = marks(maker, name)
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    return text.split(begin)[1].split(end)[0].strip() if begin in text else ""


def put(page: Path, maker: str, parts: Mapping[str, str], unread: str = "") -> None:
    """Replace the parts of a page that `maker` generates, by name.

    A part that the page does not have yet is appended, followed by the text `unread`.
    """
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    for name, content in parts.items():
        begin, end = marks(maker, name)
        block = f"{begin}\n{content.strip()}\n{end}"
        if begin in text:
            before, rest = text.split(begin)
            text = before + block + rest.split(end, 1)[1]
        else:
            text += f"\n{block}\n{unread}"
    page.write_text(text, encoding="utf-8")


def merged_tables(old: str, new: str) -> str:
    """Return the table `new`, and the text after it, with the rows of `old` that it lacks before its own.

    Rows are known by their first cells.

    Raises:
        ValueError: the columns differ, so that all of the table must be measured.
    """
    before, rest = ([line for line in text.splitlines() if line.startswith("|")] for text in (old, new))
    if before and before[0] != rest[0]:
        raise ValueError(f"other columns than in the page: {rest[0]}")
    replacing = {row_name(line): line for line in rest[2:]}
    kept = [replacing.pop(row_name(line), line) for line in before[2:]]
    after = [line for line in new.splitlines() if not line.startswith("|")]
    return "\n".join([*rest[:2], *kept, *replacing.values(), *after])


def row_name(line: str) -> str:
    """Return the first cell of a row."""
    return line.split("|")[1].strip()
