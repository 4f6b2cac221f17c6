# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of runs, and what follows from them: fits to measurements, optimal designs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.gradients.differentiation import sensitivity
    from gelenk.gradients.fitting import Fit, fit
    from gelenk.gradients.optimization import Optimum, optimize
    from gelenk.gradients.run import DifferentiatedRun, jvp, vjp

__all__ = ["DifferentiatedRun", "Fit", "Optimum", "fit", "jvp", "optimize", "sensitivity", "vjp"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(
        __name__,
        {
            ".fitting": ["Fit", "fit"],
            ".optimization": ["Optimum", "optimize"],
            ".run": ["DifferentiatedRun", "jvp", "vjp"],
            ".differentiation": ["sensitivity"],
        },
    )
