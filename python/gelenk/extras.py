# SPDX-License-Identifier: BSD-3-Clause
"""Packages that not every user needs: what brings them, and what is said where one is missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from gelenk.errors import UsageError

EXTRAS = {"matplotlib": "charts", "tqdm": "progress", "yourdfpy": "urdf"}  # of pyproject.toml


def extra(package: str, use: str) -> Any:
    """A package that an extra of Gelenk brings.

    Args:
        package: one of `EXTRAS`.
        use: what it is for, as the beginning of a sentence: "charts are drawn with matplotlib".

    Raises:
        UsageError: it is missing; names the extra. Or it cannot be imported, and why.
    """
    try:
        return import_module(package)
    except ImportError as e:
        missing = isinstance(e, ModuleNotFoundError) and e.name == package
        why = "" if missing else f", which cannot be imported here ({e})"
        raise UsageError(f"{use}{why}: pip install 'gelenk[{EXTRAS[package]}]'") from None


def pyplot() -> Any:
    """Matplotlib's, drawing into files. Raises UsageError: it is not installed."""
    extra("matplotlib", "charts are drawn with matplotlib").use("Agg")
    return import_module("matplotlib.pyplot")
