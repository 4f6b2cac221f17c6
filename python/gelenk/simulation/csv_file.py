# SPDX-License-Identifier: BSD-3-Clause
"""CSV files of results and inputs: a mark that a result is complete, and reading within bounds.

A result that Gelenk has written is marked in two numbers, which have the same values without the marks, so
that other programs need not know them: the first time ends with the exponent E-00, the last one with E-000. A
file that has the first mark without the second one was cut off. Files of other programs have neither.
"""

from __future__ import annotations

import csv
import math
import re
import warnings
from array import array
from collections.abc import Iterator, Sequence
from decimal import Decimal
from io import TextIOWrapper
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import FileWarning, UsageError
from gelenk.file_reading import opened

MAX_LINE = 16_000_000  # characters; a line of 10,000 signals has about 200,000
MAX_COLUMNS = 100_000
MAX_PIPE = 4_000_000  # characters from a pipe, which may not end
_FIRST, _LAST = "E-00", "E-000"
_BEGUN = re.compile(r"-?[0-9]+(\.[0-9]+)?E-000?")


def csv_text(names: Sequence[str], rows: NDArray[np.float64]) -> str:
    """Return the text of a result: a header line and rows of numbers with all digits, time first."""
    lines = [",".join(map(repr, row)) for row in rows.tolist()]
    for k, mark in ((0, _FIRST), (-1, _LAST))[len(lines) == 1 :] if lines else ():
        time, comma, rest = lines[k].partition(",")
        lines[k] = _marked(time, mark) + comma + rest
    return "\n".join([",".join(names), *lines]) + "\n"


def _marked(number: str, mark: str) -> str:
    if not math.isfinite(float(number)):
        return number
    return f"{Decimal(number):f}{mark}"  # without an exponent of its own


def csv_table(path: Path) -> tuple[list[str], NDArray[np.float64]]:
    """Return the names and rows of a result in a CSV file.

    Raises:
        UsageError: the file is not such a result.
        OSError: the file cannot be read.

    Warns:
        FileWarning: it was cut off; the incomplete row at its end is left out.
    """
    lines = csv_rows(path)
    _, names = next(lines, (1, [""]))
    if names[0] != "time":
        raise UsageError(
            f"{path}: found no column named time first, expected a result with `time` and signals"
        )
    numbers = array("d")
    for line, cells in lines:
        if len(cells) != len(names):
            raise UsageError(f"{path}:{line}: found {len(cells)} cells, expected {len(names)}")
        try:
            numbers.extend(map(float, cells))
        except ValueError as e:
            raise UsageError(f"{path}:{line}: {e}; expected a number") from None
    if not numbers:
        raise UsageError(
            f"{path}: found no complete row of numbers after the header line, expected at least one"
        )
    return names[1:], np.frombuffer(numbers).reshape(-1, len(names))


def csv_rows(path: Path, *, pipes: bool = False) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the cells of each line that is not empty.

    Args:
        path: the file.
        pipes: whether a pipe is allowed, of up to `MAX_PIPE` characters.

    Raises:
        UsageError: the file is not a CSV file.
        OSError: the file cannot be read.

    Warns:
        FileWarning: it is a result that was cut off; the incomplete row at its end is left out.
    """
    with opened(path, pipes=pipes) as file:
        is_pipe = not file.seekable()
        lines = _Lines(
            path, TextIOWrapper(file, encoding="utf-8-sig", newline=""), MAX_PIPE if is_pipe else None
        )
        reader = csv.reader(lines)
        try:
            for line, cells in _complete(
                path, lines, ((reader.line_num, cells) for cells in reader if cells)
            ):
                if len(cells) > MAX_COLUMNS:
                    raise UsageError(
                        f"{path}:{line}: found {len(cells)} cells, expected at most {MAX_COLUMNS}"
                    )
                yield line, cells
        except (UnicodeDecodeError, csv.Error) as e:
            raise UsageError(f"{path}: not a CSV file: {e}") from None


class _Lines(Iterator[str]):
    """The lines of a text, within bounds."""

    def __init__(self, path: Path, file: TextIO, most: int | None) -> None:
        self._path = path
        self._file = file
        self._left = most
        self.ended = False  # whether the last line ended with a line break

    def __next__(self) -> str:
        line = self._file.readline(MAX_LINE)
        if not line:
            raise StopIteration
        if len(line) == MAX_LINE or "\0" in line:
            what = "a line of more than 16 MB" if len(line) == MAX_LINE else "a zero byte"
            raise UsageError(f"{self._path}: not a CSV file: found {what}")
        if self._left is not None:
            self._left -= len(line)
            if self._left < 0:
                raise UsageError(
                    f"{self._path}: found more than {MAX_PIPE // 1_000_000} MB in a pipe, expected at most "
                    "that; files may be larger"
                )
        self.ended = line.endswith(("\n", "\r"))
        return line


def _complete(
    path: Path, lines: _Lines, rows: Iterator[tuple[int, list[str]]]
) -> Iterator[tuple[int, list[str]]]:
    """Yield the header and the rows; warn of a result that was cut off, without its incomplete row."""
    header = next(rows, None)
    if header is not None:
        yield header
    last = next(rows, None)
    if header is None or last is None:
        return
    is_marked = header[1][0] == "time" and _BEGUN.fullmatch(last[1][0]) is not None
    before = None
    for row in rows:
        yield last
        before, last = last, row
    if not is_marked or (lines.ended and last[1][0].endswith(_LAST)):
        yield last
        return
    complete = last if lines.ended else before
    if lines.ended:
        yield last
    end = header[0] if complete is None else complete[0]
    warnings.warn(f"{path}: was cut off after line {end}; what follows is missing", FileWarning, stacklevel=5)
