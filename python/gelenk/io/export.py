# SPDX-License-Identifier: BSD-3-Clause
"""Export of scenes as FMUs, which consist of a prebuilt library, the scene and its description."""

from __future__ import annotations

import json
import logging
import zlib
from collections.abc import Iterable, Sequence
from importlib import resources
from os import PathLike
from pathlib import Path

from gelenk import _core
from gelenk.errors import ExportError, UsageError
from gelenk.model.scene import Source, load

log = logging.getLogger(__name__)

RUNTIMES = {"linux64": "runtime/linux64/gelenk_fmu.so.gz", "win64": "runtime/win64/gelenk_fmu.dll.gz"}


def export_fmu(
    scene: Source,
    out: str | PathLike[str],
    platforms: Sequence[str] = ("linux64",),
    outputs: Iterable[str] | None = None,
    *,
    view: bool = True,
) -> Path:
    """Write an FMI 2.0 co-simulation FMU; no incomplete file remains after an error.

    Args:
        scene: anything `gelenk.load` accepts.
        out: the .fmu file; an existing file is replaced.
        platforms: platforms of the FMU, `linux64` or `win64`; see `missing_platforms`.
        outputs: names and patterns of the requested outputs; by default the scene's own. Parts on which none
            of them depends are not in the FMU.
        view: whether the documentation of the FMU shows the mechanism in three dimensions, in 0.2 MB.

    Returns:
        Path: the file written.

    Raises:
        SceneError: the scene is invalid.
        UsageError: an output is unknown.
        AssemblyError: the loops cannot be closed with the start values.
        ExportError: the file cannot be written, or a platform is unknown or missing.
        OSError: the scene cannot be read.

    >>> gelenk.export_fmu(four_bar, "FourBar.fmu").name
    'FourBar.fmu'
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
        _core.export_fmu(loaded._core, runtimes, target, licenses(), zlib.compress, _view if view else None)
    log.info("%s: %.2f MB, %s", target, target.stat().st_size / 1e6, ", ".join(platforms))
    return target


def _view(scene: str, poses: list[float]) -> str:
    """Return the page that shows a scene, given as JSON, at its start; empty if Gelenk has no viewer."""
    from gelenk.simulation.recording import still
    from gelenk.viewer.pages import view_of

    try:
        return view_of(still(json.loads(scene), poses)).html
    except UsageError as e:
        log.warning("the FMU has no view in three dimensions: %s", e)
        return ""


def fmu_file(name: str) -> Path:
    """Return the default FMU file for a scene's name, valid on Linux, macOS and Windows."""
    return Path(f"{_core.file_stem(name)}.fmu")


def file_name_notes(name: str, output: Path | None) -> list[str]:
    """Return notes about the file name of a scene's FMU.

    Args:
        name: name of the scene.
        output: file name that the user has given instead.

    Returns:
        list[str]: notes for the user; empty if there is no problem.
    """
    if output is not None:
        device = f"{output}: {output.stem!r} is the name of a device on Windows, where this file cannot exist"
        return [device] if _core.is_device_name(output.name) else []
    file = fmu_file(name)
    if file.stem == name:
        return []
    return [
        f"name: {name!r} is not a valid file name on all systems; written to {file}, "
        "use --output for another name"
    ]


def missing_platforms(platforms: Sequence[str]) -> dict[str, str]:
    """Return the platforms for which this installation has no library, each with a message.

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
        how = "run `make win64` in Gelenk's source" if platform == "win64" else "reinstall gelenk"
        missing[platform] = f"{platform}: this installation of gelenk has no {path.name} ({path}); {how}"
    return missing


def runtime_library(platform: str = "linux64") -> Path:
    """Return the gzip file with the library of FMUs for a platform (x86-64). Raises ExportError."""
    return _part(RUNTIMES[platform])


def licenses() -> Path:
    """Return the folder with the licenses of the components of the library. Raises ExportError."""
    return _part("licenses")


def schema() -> str:
    """Return the JSON Schema of scene files as text."""
    return _core.scene_schema()


def _place(name: str) -> Path:
    return Path(str(resources.files("gelenk") / name))


def _part(name: str) -> Path:
    path = _place(name)
    if not path.exists():
        raise ExportError(f"{path}: missing from this installation of gelenk")
    return path
