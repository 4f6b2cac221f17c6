# SPDX-License-Identifier: BSD-3-Clause
"""Pages that show mechanisms in motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.viewer.pages import View

__all__ = ["View"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".pages": ["View"]})
