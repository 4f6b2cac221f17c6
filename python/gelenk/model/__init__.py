# SPDX-License-Identifier: BSD-3-Clause
"""Scenes: reading, checking, changing and saving; their assembly branches and reductions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.model.branches import Assemblies, Branch, assemblies
    from gelenk.model.inspection import Inspection, inspect
    from gelenk.model.scene import Scene, load

__all__ = ["Assemblies", "Branch", "Inspection", "Scene", "assemblies", "inspect", "load"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(
        __name__,
        {
            ".branches": ["Assemblies", "Branch", "assemblies"],
            ".inspection": ["Inspection", "inspect"],
            ".scene": ["Scene", "load"],
        },
    )
