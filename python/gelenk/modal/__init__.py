# SPDX-License-Identifier: BSD-3-Clause
"""Modes of vibration: eigenvalues and mode shapes of linear models, and their animation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.modal.analysis import Modes, modes
    from gelenk.modal.mode import Mode

__all__ = ["Mode", "Modes", "modes"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".analysis": ["Modes", "modes"], ".mode": ["Mode"]})
