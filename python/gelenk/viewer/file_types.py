# SPDX-License-Identifier: BSD-3-Clause
"""Endings of the files that a view is written to."""

from __future__ import annotations

from pathlib import Path

PICTURES = (".png", ".gif", ".mp4")


def is_picture(file: Path) -> bool:
    """Return whether a file is a picture or a film, by its ending."""
    return file.suffix.lower() in PICTURES
