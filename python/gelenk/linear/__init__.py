# SPDX-License-Identifier: BSD-3-Clause
"""Linear models of mechanisms about an operating point."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.linear.linearization import linear_model, linearize
    from gelenk.linear.model import LinearModel
    from gelenk.linear.nonlinear import control_system
    from gelenk.linear.operating_point import OperatingPoint

__all__ = ["LinearModel", "OperatingPoint", "control_system", "linear_model", "linearize"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(
        __name__,
        {
            ".linearization": ["linear_model", "linearize"],
            ".model": ["LinearModel"],
            ".nonlinear": ["control_system"],
            ".operating_point": ["OperatingPoint"],
        },
    )
