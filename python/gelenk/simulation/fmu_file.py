# SPDX-License-Identifier: BSD-3-Clause
"""FMUs as files: archives whose names and sizes are checked before anything in them is used."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

from gelenk.errors import UsageError
from gelenk.file_reading import opened

DESCRIPTION = "modelDescription.xml"
SCENE = "resources/scene.json"
MAX_SIZE = 1_000_000_000  # bytes, unpacked
FREE_SIZE = 50_000_000  # bytes that any FMU may have unpacked
MAX_COMPRESSION = 100  # of a larger FMU; libraries and descriptions are compressed by 2 to 30
MAX_TEXT = 100_000_000  # bytes of a description or scene; 2 kB of description for each body are usual
MAX_FILES = 20_000
MAX_NAME = 255  # bytes of a part of a name, as in file systems; five times that of all of it
_FAULTS = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, ValueError)


@contextmanager
def archive_of(path: str | PathLike[str]) -> Iterator[zipfile.ZipFile]:
    """Yield the archive of an FMU.

    Raises:
        UsageError: it is not an FMU, or unpacking it could do harm.
        OSError: it cannot be read.
    """
    with opened(path) as file:
        try:
            archive = zipfile.ZipFile(file)
            names = set(archive.namelist())
        except _FAULTS:
            names = set()
        if DESCRIPTION not in names:
            raise UsageError(f"{path}: not an FMU (a zip file with a modelDescription.xml)")
        _check(Path(path), archive)
        yield archive


def text_in(path: str | PathLike[str], name: str) -> bytes:
    """Return a text file in an FMU.

    Raises:
        UsageError: it is not an FMU, or damaged.
        KeyError: it does not contain the file.
        OSError: it cannot be read.
    """
    with archive_of(path) as archive:
        if (size := archive.getinfo(name).file_size) > MAX_TEXT:
            raise UsageError(
                f"{path}: {name}: found {size / 1e6:.0f} MB, expected up to {MAX_TEXT / 1e6:.0f} MB"
            )
        try:
            return archive.read(name)
        except _FAULTS as e:
            raise _damaged(path, e) from None


def extract(path: str | PathLike[str], folder: str) -> None:
    """Unpack an FMU into a folder. Raises UsageError, OSError: see `archive_of`."""
    with archive_of(path) as archive:
        try:
            archive.extractall(folder)
        except _FAULTS as e:
            raise _damaged(path, e) from None


def _damaged(path: str | PathLike[str], error: Exception) -> UsageError:
    return UsageError(f"{path}: the zip file is damaged: {error}")


def _check(path: Path, archive: zipfile.ZipFile) -> None:
    files = archive.infolist()
    size = sum(file.file_size for file in files)  # nothing is unpacked beyond it
    if size > MAX_SIZE or size > max(FREE_SIZE, MAX_COMPRESSION * path.stat().st_size):
        packed = path.stat().st_size / 1e6
        raise UsageError(
            f"{path}: found {size / 1e6:.0f} MB packed in {packed:.3g} MB, which is not unpacked"
        )
    if len(files) > MAX_FILES:
        raise UsageError(f"{path}: found {len(files)} files in it, expected up to {MAX_FILES}")
    names = {file.orig_filename.rstrip("/") for file in files}
    for file in files:
        if fault := _fault_of_name(file.orig_filename, names):
            raise UsageError(f"{path}: found {fault} in it: {file.orig_filename[:MAX_NAME]!r}")


def _fault_of_name(name: str, names: set[str]) -> str:
    """Return what is wrong with the name of a file in an archive; empty: nothing."""
    parts = name.rstrip("/").split("/")
    if name.startswith("/") or ":" in name:
        return "an absolute path"
    if "\\" in name or any(ord(c) < 32 for c in name):
        return "a name with a backslash or control character"
    if ".." in parts or "." in parts or "" in parts:
        return "a path that leads elsewhere"
    if len(name.encode("utf-8", "replace")) > 5 * MAX_NAME or any(
        len(part.encode("utf-8", "replace")) > MAX_NAME for part in parts
    ):
        return "a name that is too long"
    above = ("/".join(parts[:n]) for n in range(1, len(parts)))
    return "a file as the folder of another one" if any(folder in names for folder in above) else ""
