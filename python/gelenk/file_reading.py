# SPDX-License-Identifier: BSD-3-Clause
"""How Gelenk reads files from others: only what is a file, and no more than fits into memory."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import BinaryIO

from gelenk.errors import MissingFileError, UsageError


def usable_name(path: str | PathLike[str]) -> Path:
    """Return the path of a name. Raises UsageError if it contains a zero byte, as no name of a file does."""
    text = os.fspath(path)
    if "\0" in text:
        raise UsageError(f"{text!r}: found a zero byte in the name of a file, expected none")
    return Path(text)


def existing(path: str | PathLike[str]) -> Path:
    """Return the path of a name. Raises UsageError as usable_name(); MissingFileError: nothing is there."""
    name = usable_name(path)
    if not name.exists():
        raise MissingFileError(name)
    return name


@contextmanager
def opened(path: str | PathLike[str], *, pipes: bool = False) -> Iterator[BinaryIO]:
    """Yield a file that is open for reading.

    Args:
        path: the file.
        pipes: whether a pipe or a device, such as /dev/stdin, is allowed; it may wait for a writer.

    Raises:
        UsageError: it is something else than a file.
        OSError: it cannot be read.
    """
    name = usable_name(path)

    def without_waiting(file: str, flags: int) -> int:
        return os.open(file, flags | getattr(os, "O_NONBLOCK", 0))

    what = _kind(name.stat().st_mode)
    if what and pipes:
        with name.open("rb") as file:
            yield file
        return
    if what:
        raise UsageError(f"{name}: found {what}, expected a file")
    with open(name, "rb", opener=without_waiting) as file:
        # What the name refers to may have changed in between.
        if what := _kind(os.fstat(file.fileno()).st_mode):
            raise UsageError(f"{name}: found {what}, expected a file")
        yield file


def read_bytes(path: str | PathLike[str], most: int, *, pipes: bool = False) -> bytes:
    """Return the content of a file.

    Args:
        path: the file.
        most: largest size [bytes].
        pipes: see `opened`.

    Raises:
        UsageError: it is larger, or something else than a file.
        OSError: it cannot be read.
    """
    content = read_start(path, most + 1, pipes=pipes)
    if len(content) > most:
        raise UsageError(f"{path}: found more than {most // 1_000_000} MB, expected at most that")
    return content


def read_start(path: str | PathLike[str], count: int, *, pipes: bool = False) -> bytes:
    """Return the first `count` bytes of a file, or all of them if it is shorter: see `read_bytes`."""
    with opened(path, pipes=pipes) as file:
        return file.read(count)


def check_file(path: str | PathLike[str]) -> Path:
    """Check that a path leads to a file that can be read, and return it: see `opened`."""
    with opened(path):
        return Path(path)


def _kind(mode: int) -> str:
    """Return what something is that is neither a file nor a folder; empty: it is one of these."""
    if stat.S_ISFIFO(mode):
        return "a pipe"
    if stat.S_ISSOCK(mode):
        return "a socket"
    return "a device" if stat.S_ISCHR(mode) or stat.S_ISBLK(mode) else ""
