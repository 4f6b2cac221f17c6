# SPDX-License-Identifier: BSD-3-Clause
"""Many runs of one plant: designs of experiments, reductions, workers, resumption."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.sweeps.indices import sobol
    from gelenk.sweeps.runs import sweep

__all__ = ["sobol", "sweep"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(__name__, {".indices": ["sobol"], ".runs": ["sweep"]})
