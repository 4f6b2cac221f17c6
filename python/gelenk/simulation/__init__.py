# SPDX-License-Identifier: BSD-3-Clause
"""Simulation of scenes and FMUs: plants, inputs, results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.simulation.live import live_view
    from gelenk.simulation.result import Result
    from gelenk.simulation.run import simulate
    from gelenk.simulation.simulation import Simulation
    from gelenk.simulation.views import view

__all__ = ["Result", "Simulation", "live_view", "simulate", "view"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(
        __name__,
        {
            ".live": ["live_view"],
            ".result": ["Result"],
            ".run": ["simulate"],
            ".simulation": ["Simulation"],
            ".views": ["view"],
        },
    )
