# SPDX-License-Identifier: BSD-3-Clause
"""Plants for reinforcement learning."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.learning.make import environment, vector_environment

__all__ = ["environment", "vector_environment"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".make": ["environment", "vector_environment"]})
