# SPDX-License-Identifier: BSD-3-Clause
"""Import of files of other programs as scenes, and export of scenes as FMUs and SSP archives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gelenk._lazy import lazy

if TYPE_CHECKING:
    from gelenk.io.export import export_fmu
    from gelenk.io.ssp import export_ssp
    from gelenk.io.urdf import import_urdf

__all__ = ["export_fmu", "export_ssp", "import_urdf"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy(
        __name__, {".export": ["export_fmu"], ".ssp": ["export_ssp"], ".urdf": ["import_urdf"]}
    )
