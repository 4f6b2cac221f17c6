# SPDX-License-Identifier: BSD-3-Clause
"""Exporting scenes as FMUs. No compiler runs: an FMU is a prebuilt library, a scene, its description."""

from __future__ import annotations

from importlib import resources
from os import PathLike
from pathlib import Path

from gelenk import _core
from gelenk.errors import ExportError
from gelenk.scene import Source, load


def export_fmu(scene: Source, out: str | PathLike[str]) -> Path:
    """Writes an FMI 2.0 co-simulation FMU, as a whole or not at all.

    Args:
        scene: anything `gelenk.load` takes.
        out: the .fmu file; one that exists is replaced.

    Returns:
        Path: the file written.

    Raises:
        SceneError: the scene is wrong.
        AssemblyError: its loops cannot be closed with the start values.
        ExportError: the file cannot be written.
        OSError: the scene cannot be read.
    """
    target = Path(out)
    if target.suffix.lower() != ".fmu":
        raise ExportError(f"{target}: found the ending {target.suffix or 'none'}, expected .fmu")
    _core.export_fmu(load(scene)._core, runtime_library(), target, licenses())
    return target


def runtime_library() -> Path:
    """The library that every FMU carries (Linux, x86-64)."""
    return _part("runtime/linux64/gelenk_fmu.so")


def licenses() -> Path:
    """The folder with the licences of what the library contains."""
    return _part("licenses")


def schema() -> str:
    """The JSON Schema of scene files, as text."""
    return _core.scene_schema()


def _part(name: str) -> Path:
    path = Path(str(resources.files("gelenk") / name))
    if not path.exists():
        raise ExportError(f"{path}: missing from this installation of gelenk")
    return path
