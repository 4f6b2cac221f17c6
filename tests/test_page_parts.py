# SPDX-License-Identifier: BSD-3-Clause
"""Measured parts of pages of docs/: they are replaced, and rows that are not measured again remain."""

from __future__ import annotations

from pathlib import Path

import pytest
from benchmarks import page_parts


def test_rows_that_are_not_measured_again_remain() -> None:
    """Columns of equal names, and the text after the table, which is that of the new one."""
    head = "| scene | best | best |\n| --- | --- | --- |\n"
    old = head + "| a | 1 | 2 |\n| b | 3 | 4 |\n\nold text"
    new = head + "| b | 5 | 6 |\n| c | 7 | 8 |\n\nnew text"
    merged = page_parts.merged_tables(old, new)
    assert merged == head + "| a | 1 | 2 |\n| b | 5 | 6 |\n| c | 7 | 8 |\n\nnew text"
    assert page_parts.merged_tables("", new) == new
    with pytest.raises(ValueError, match="other columns"):
        page_parts.merged_tables(old.replace("scene", "mechanism"), new)


def test_parts_of_pages_are_read_and_replaced(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    assert page_parts.part(page, "maker", "one") == ""
    page_parts.put(page, "maker", {"one": "1", "two": "2"})
    page_parts.put(page, "maker", {"one": "3"})
    assert [page_parts.part(page, "maker", name) for name in ("one", "two")] == ["3", "2"]
