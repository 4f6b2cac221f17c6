# SPDX-License-Identifier: BSD-3-Clause
"""Equilibria at rest or in steady motion, and the inputs that hold them (trim)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.equilibria.trim import Equilibrium, equilibrium

__all__ = ["Equilibrium", "equilibrium"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".trim": ["Equilibrium", "equilibrium"]})
