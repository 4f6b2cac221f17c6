# SPDX-License-Identifier: BSD-3-Clause
"""The equations of a scene as text and as functions: C, NumPy, SymPy, LaTeX, CasADi."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.symbolic.scene_equations import Equations, equations

__all__ = ["Equations", "equations"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".scene_equations": ["Equations", "equations"]})
