# SPDX-License-Identifier: BSD-3-Clause
"""Names of files in a scene, and what is said of files that cannot be used."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gelenk.errors import UsageError
from gelenk.file_reading import read_bytes


class FileFaultError(Exception):
    """What is wrong with a file or its name, as the rest of a line of a message."""

    def __init__(self, found: str, expected: str, field: str = "") -> None:
        """Store the message.

        Args:
            found: what was found.
            expected: what was expected in its place.
            field: of the reference, if that is wrong.
        """
        super().__init__(f"{'.' if field else ''}{field}: found {found}, expected {expected}")


def file_name(name: Any) -> str:
    """Return the name of a file. Raises FileFaultError if it is none."""
    if not isinstance(name, str) or not name:
        raise FileFaultError("nothing" if name in (None, "") else repr(name), "the name of a file", "file")
    return name


def content_of(path: Path, name: str, most: int) -> bytes:
    """Return the content of a file.

    Args:
        path: the file.
        name: as the scene refers to it.
        most: largest size [bytes].

    Raises:
        FileFaultError: it cannot be read, or is larger.
    """
    try:
        return read_bytes(path, most)
    except (OSError, UsageError) as e:
        why = e.strerror if isinstance(e, OSError) else str(e).partition(": ")[2]
        raise FileFaultError(
            f"{name!r}, which cannot be read ({why})", "a file in the folder of the scene"
        ) from None
