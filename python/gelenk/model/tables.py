# SPDX-License-Identifier: BSD-3-Clause
"""Files of tables that expressions look up: numbers in lines, with commas, semicolons, tabs or spaces."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gelenk.model.file_names import FileFaultError, content_of, file_name

MAX_BYTES = 10_000_000  # of a file: text of 100,000 values
OF_FILES = ("file", "columns")
# Takes the place of a table with faults, so that the rest of the scene is checked, too.
ANY = {"x": [0, 1], "values": [0, 0]}

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)

Columns = tuple[str | int, str | int] | None


def references(data: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Return the tables of a scene that are files: path, owner and key."""
    tables: Any = data.get("tables")
    for name, table in tables.items() if isinstance(tables, dict) else ():
        if isinstance(table, dict) and "file" in table:
            yield f"tables.{name}", tables, name


def named(table: dict[str, Any]) -> tuple[str, Columns]:
    """Return the name of the file and the columns of a table. Raises FileFaultError."""
    for key in ("x", "y", "values"):
        if key in table:
            raise FileFaultError(f"'{key}' and 'file'", "one of them", key)
    columns: Any = table.get("columns")
    if columns is not None:
        are_two = isinstance(columns, list) and len(columns) == 2
        if not are_two or not all(isinstance(c, str | int) and not isinstance(c, bool) for c in columns):
            raise FileFaultError(
                repr(columns), "the headers, or the numbers from 1 on, of the columns of x and of the values",
                "columns",
            )  # fmt: skip
        columns = tuple(columns)
    return file_name(table.get("file")), columns


def load(path: Path, name: str, columns: Columns) -> dict[str, Any]:
    """Return the numbers of a file.

    Args:
        path: the file. Empty lines, and those that begin with # or %, are comments.
        name: as the scene refers to it.
        columns: those of x and of the values, by their headers in the first line or their numbers from 1 on;
            None: two columns, or a table over two arguments: the first line has y, the first column x.

    Returns:
        dict: x and values, or x, y and a list of values for each x.

    Raises:
        FileFaultError: it cannot be read, or is no such table.
    """
    lines = _Lines(content_of(path, name, MAX_BYTES), name)
    if columns is not None:
        chosen = [lines.column(column) for column in columns]
        x, values = ([lines.number(row, column) for row in lines.rows] for column in chosen)
        return {"x": x, "values": values}
    if lines.width == 2:
        x, values = ([lines.number(row, column) for row in lines.rows] for column in range(2))
        return {"x": x, "values": values}
    if lines.headers:
        raise FileFaultError(
            f"{name!r} with the columns {', '.join(lines.headers)}",
            "two columns, or columns: [.., ..], those of x and of the values",
        )
    rows = lines.rows[1:]  # the first cell of the first line is of no meaning
    y = [lines.number(lines.rows[0], column) for column in range(1, lines.width)]
    return {
        "x": [lines.number(row, 0) for row in rows],
        "y": y,
        "values": [[lines.number(row, column) for column in range(1, lines.width)] for row in rows],
    }


def _is_number(cell: str) -> bool:
    return _NUMBER.fullmatch(cell) is not None and math.isfinite(float(cell))


def _begins_as_number(cell: str) -> bool:
    return re.match(r"[-+.]?\d|nan\b|inf", cell, re.IGNORECASE) is not None


class _Lines:
    """The cells of a file."""

    def __init__(self, content: bytes, name: str) -> None:
        self._name = name
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as e:
            raise FileFaultError(
                f"{name!r}, which is no text ({e.reason} at byte {e.start})", "numbers in lines"
            ) from None
        numbered = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip()]
        numbered = [(k, line) for k, line in numbered if line.lstrip()[0] not in "#%"]
        delimiter = next((d for d in ";\t," if numbered and d in numbered[0][1]), None)
        cells = [
            line.split()
            if delimiter is None
            else [c.strip() for c in next(csv.reader([line], delimiter=delimiter))]
            for _, line in numbered
        ]
        self.headers: list[str] = []
        self.rows = [(k, row) for (k, _), row in zip(numbered, cells, strict=True)]
        if self.rows and not any(map(_begins_as_number, self.rows[0][1])):
            self.headers = self.rows.pop(0)[1]
        if len(self.rows) < 2:
            raise FileFaultError(f"{name!r} with {len(self.rows)} lines of numbers", "at least 2")
        self.width = len(self.headers or self.rows[0][1])
        for line, row in self.rows:
            if len(row) != self.width:
                raise FileFaultError(
                    f"{name!r} with {len(row)} numbers in line {line}", f"{self.width}, as in the first line"
                )
        if self.width < 2:
            raise FileFaultError(f"{name!r} with a single column", "at least 2")

    def column(self, column: str | int) -> int:
        if isinstance(column, int):
            if not 1 <= column <= self.width:
                raise FileFaultError(
                    f"{column}", f"a column from 1 to {self.width} of {self._name!r}", "columns"
                )
            return column - 1
        if self.headers.count(column) > 1:
            raise FileFaultError(
                repr(column), f"a header that only one column has, in {self._name!r}", "columns"
            )
        if column not in self.headers:
            known = (
                f"one of {', '.join(self.headers)}"
                if self.headers
                else "a number, since there are no headers"
            )
            raise FileFaultError(repr(column), f"{known}, in {self._name!r}", "columns")
        return self.headers.index(column)

    def number(self, row: tuple[int, list[str]], column: int) -> float:
        line, cells = row
        if not _is_number(cells[column]):
            comma = "; the decimal point is '.'" if "," in cells[column] else ""
            raise FileFaultError(
                f"{self._name!r} with {cells[column]!r} in line {line}", f"a finite number{comma}"
            )
        return float(cells[column])
