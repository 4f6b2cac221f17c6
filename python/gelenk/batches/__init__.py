# SPDX-License-Identifier: BSD-3-Clause
"""Many instances of one scene that are stepped together, in the lanes of the processor's vectors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.batches.lanes import Batch, batch

__all__ = ["Batch", "batch"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".lanes": ["Batch", "batch"]})
