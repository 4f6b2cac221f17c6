# SPDX-License-Identifier: BSD-3-Clause
"""Exporting scenes as FMUs. No compiler runs: an FMU is a prebuilt library, a scene, its description."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Sequence
from importlib import resources
from os import PathLike
from pathlib import Path

from gelenk import _core
from gelenk.errors import ExportError
from gelenk.model.scene import Source, load

RUNTIMES = {"linux64": "runtime/linux64/gelenk_fmu.so.gz", "win64": "runtime/win64/gelenk_fmu.dll.gz"}


def export_fmu(
    scene: Source,
    out: str | PathLike[str],
    platforms: Sequence[str] = ("linux64",),
    outputs: Iterable[str] | None = None,
) -> Path:
    """Writes an FMI 2.0 co-simulation FMU, as a whole or not at all.

    Args:
        scene: anything `gelenk.load` takes.
        out: the .fmu file; one that exists is replaced.
        platforms: for whom, `linux64` or `win64`; what is missing is an error (see `missing_platforms`).
        outputs: names and patterns of the outputs that are wanted; by default the scene's own. What none of
            them depends on is not in the FMU.

    Returns:
        Path: the file written.

    Raises:
        SceneError: the scene is wrong.
        UsageError: an entry of `outputs` that names no output.
        AssemblyError: its loops cannot be closed with the start values.
        ExportError: the file cannot be written, or a platform is unknown or missing.
        OSError: the scene cannot be read.
    """
    target = Path(out)
    if target.suffix.lower() != ".fmu":
        raise ExportError(f"{target}: found the ending {target.suffix or 'none'}, expected .fmu")
    if not platforms:
        raise ExportError(f"platforms: found none, expected {' or '.join(RUNTIMES)}")
    for sentence in missing_platforms(platforms).values():
        raise ExportError(sentence)
    runtimes = [runtime_library(platform) for platform in dict.fromkeys(platforms)]
    loaded = load(scene)
    if outputs is not None:
        loaded = loaded.with_outputs(outputs)
    with loaded.located():
        _core.export_fmu(loaded._core, runtimes, target, licenses(), zlib.compress)
    return target


def fmu_file(name: str) -> Path:
    """The file in the present folder for a scene of that name, on Linux, macOS and Windows alike."""
    return Path(f"{_core.file_stem(name)}.fmu")


def file_name_notes(name: str, output: Path | None) -> list[str]:
    """What to tell of the file of a scene's FMU, as sentences. output: what the user asked for instead."""
    if output is not None:
        device = f"{output}: Windows takes {output.stem!r} for a device and has no such file"
        return [device] if _core.is_device_name(output.name) else []
    file = fmu_file(name)
    if file.stem == name:
        return []
    return [f"name: {name!r} is no file's name everywhere; written to {file}, --output gives another"]


def missing_platforms(platforms: Sequence[str]) -> dict[str, str]:
    """Of the platforms those for which this installation has no library, each with the reason as a sentence.

    Raises:
        ExportError: a platform is unknown.
    """
    missing = {}
    for platform in platforms:
        if platform not in RUNTIMES:
            raise ExportError(f"platforms: found {platform!r}, expected {' or '.join(RUNTIMES)}")
        path = _place(RUNTIMES[platform])
        if path.exists():
            continue
        how = "`make win64` in Gelenk's source builds it" if platform == "win64" else "install gelenk anew"
        missing[platform] = f"{platform}: this installation of gelenk has no {path.name} ({path}); {how}"
    return missing


def runtime_library(platform: str = "linux64") -> Path:
    """The library that an FMU carries for a platform (x86-64), as a gzip file."""
    return _part(RUNTIMES[platform])


def licenses() -> Path:
    """The folder with the licences of what the library contains."""
    return _part("licenses")


def schema() -> str:
    """The JSON Schema of scene files, as text."""
    return _core.scene_schema()


def _place(name: str) -> Path:
    return Path(str(resources.files("gelenk") / name))


def _part(name: str) -> Path:
    path = _place(name)
    if not path.exists():
        raise ExportError(f"{path}: missing from this installation of gelenk")
    return path
