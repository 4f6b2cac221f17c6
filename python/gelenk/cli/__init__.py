# SPDX-License-Identifier: BSD-3-Clause
"""The `gelenk` command."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.cli.commands import app, main

__all__ = ["app", "main"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".commands": ["app", "main"]})
