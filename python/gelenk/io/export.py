# SPDX-License-Identifier: BSD-3-Clause
"""Export of scenes as FMUs, which consist of a prebuilt library, the scene and its description."""

from __future__ import annotations

import json
import logging
import platform
import sys
import zlib
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module, resources
from os import PathLike
from pathlib import Path

from gelenk import _core
from gelenk.errors import ExportError, UsageError
from gelenk.file_writing import replacing
from gelenk.model.scene import Source, load

log = logging.getLogger(__name__)

# The platforms of FMUs: file names of the libraries. darwin64 is macOS on both kinds of processors.
LIBRARIES = {
    "linux64": "gelenk_fmu.so.gz",
    "aarch64-linux": "gelenk_fmu.so.gz",
    "win64": "gelenk_fmu.dll.gz",
    "darwin64": "gelenk_fmu.dylib.gz",
}
ALL = "all"
FMI_VERSIONS = (2, 3)
MAKE_RUNTIMES = "`make runtimes` in the repository of gelenk builds and installs it"
RUNTIMES_PACKAGE = "gelenk_runtimes"  # has the libraries of all platforms; gelenk itself that of its own


def export_fmu(
    scene: Source,
    out: str | PathLike[str],
    platforms: str | Sequence[str] | None = None,
    outputs: Iterable[str] | None = None,
    *,
    view: bool = True,
    fmi: int = 2,
) -> Path:
    """Write an FMU; no incomplete file remains after an error.

    Args:
        scene: anything `gelenk.load` accepts.
        out: the .fmu file; an existing file is replaced.
        platforms: platforms of the FMU: `linux64`, `aarch64-linux`, `win64`, `darwin64`, or `all` of them; by
            default that of this machine. Libraries for other machines are built by `make runtimes`.
        outputs: names and patterns of the requested outputs; by default the scene's own. Parts on which none
            of them depends are not in the FMU.
        view: whether the documentation of the FMU shows the mechanism in three dimensions, in 0.2 MB.
        fmi: version of FMI: 2 for FMI 2.0, 3 for FMI 3.0. Both are for co-simulation and, if the scene
            permits it, model exchange; with 3, scenes with event indicators are for the former only.

    Returns:
        Path: the file written.

    Raises:
        SceneError: the scene is invalid.
        UsageError: an output is unknown.
        AssemblyError: the loops cannot be closed with the start values.
        ExportError: the file cannot be written, a platform is unknown or missing, or the version of FMI is.
        OSError: the scene cannot be read.

    >>> gelenk.export_fmu(four_bar, "FourBar.fmu").name
    'FourBar.fmu'
    """
    target = Path(out)
    if target.suffix.lower() != ".fmu":
        raise ExportError(f"{target}: found the ending {target.suffix or 'none'}, expected .fmu")
    if fmi not in FMI_VERSIONS:
        raise ExportError(f"fmi: found {fmi!r}, expected {' or '.join(map(str, FMI_VERSIONS))}")
    names = platform_names(platforms)
    if missing := missing_platforms(names):
        raise ExportError("\n".join(missing.values()))
    runtimes = [(name, runtime_library(name)) for name in names]
    loaded = load(scene)
    if outputs is not None:
        loaded = loaded.with_outputs(outputs)
    with loaded.located():
        _export(loaded._core, runtimes, target, fmi, _view if view else None)
    log.info("%s: %.2f MB, %s", target, target.stat().st_size / 1e6, ", ".join(names))
    return target


def _export(
    scene: _core.Scene,
    runtimes: list[tuple[str, Path]],
    target: Path,
    fmi: int,
    view: Callable[[str, list[float]], str] | None,
) -> None:
    try:
        with replacing(target) as draft:
            try:
                _core.export_fmu(scene, runtimes, draft, licenses(), zlib.compress, view, fmi)
            except ExportError as e:
                raise ExportError(str(e).replace(str(draft), str(target))) from None
    except OSError as e:
        raise ExportError(f"{target}: the FMU could not be written: {e.strerror}") from None


def _view(scene: str, poses: list[float]) -> str:
    """Return the page that shows a scene, given as JSON, at its start; empty if Gelenk has no viewer."""
    from gelenk.simulation.recording import still
    from gelenk.viewer.pages import view_of

    try:
        return view_of(still(json.loads(scene), poses)).html
    except UsageError as e:
        log.warning("the FMU has no view in three dimensions: %s", e)
        return ""


def default_file(name: str, ending: str = ".fmu") -> Path:
    """Return the default file for a scene's name, valid on Linux, macOS and Windows."""
    return Path(f"{_core.file_stem(name)}{ending}")


def file_name_notes(name: str, output: Path | None, ending: str = ".fmu") -> list[str]:
    """Return notes about the file name of a scene's FMU or SSP archive.

    Args:
        name: name of the scene.
        output: file name that the user has given instead.
        ending: of the default file.

    Returns:
        list[str]: notes for the user; empty if there is no problem.
    """
    if output is not None:
        device = f"{output}: {output.stem!r} is the name of a device on Windows, where this file cannot exist"
        return [device] if _core.is_device_name(output.name) else []
    file = default_file(name, ending)
    if file.stem == name:
        return []
    return [
        f"name: {name!r} is not a valid file name on all systems; written to {file}, "
        "use --output for another name"
    ]


def native_platform() -> str:
    """Return the platform of this machine, as FMI 2.0 calls it."""
    if sys.platform == "win32":
        return "win64"
    if sys.platform == "darwin":
        return "darwin64"
    return "aarch64-linux" if platform.machine() in ("aarch64", "arm64") else "linux64"


def platform_names(platforms: str | Sequence[str] | None) -> list[str]:
    """Return names of platforms, each once.

    Args:
        platforms: names, or `all`; None: the platform of this machine.

    Raises:
        ExportError: a platform is unknown, or there is none.
    """
    given = [native_platform()] if platforms is None else platforms
    names = [given] if isinstance(given, str) else list(given)
    expected = f"expected {', '.join(LIBRARIES)} or {ALL}"
    if not names:
        raise ExportError(f"platforms: found none, {expected}")
    for name in names:
        if name not in LIBRARIES and name != ALL:
            raise ExportError(f"platforms: found {name!r}, {expected}")
    return list(LIBRARIES) if ALL in names else list(dict.fromkeys(names))


def missing_platforms(platforms: str | Sequence[str] | None) -> dict[str, str]:
    """Return the platforms for which this installation has no library, each with a message.

    Raises:
        ExportError: a platform is unknown, or gelenk-runtimes has another version than gelenk.
    """
    missing = {}
    for name in platform_names(platforms):
        if _library(name) is None:
            how = "reinstall gelenk" if name == native_platform() else MAKE_RUNTIMES
            missing[name] = f"{name}: found no library for it in this installation of gelenk; {how}"
    return missing


def runtime_library(of: str | None = None) -> Path:
    """Return the gzip file with the library for a platform; None: this machine's. Raises ExportError."""
    (name,) = platform_names(of)
    found = _library(name)
    if found is None:
        raise ExportError(missing_platforms(name)[name])
    return found


def _library(name: str) -> Path | None:
    """Return the library for a platform, from this package or gelenk-runtimes; None: there is none."""
    from gelenk import __version__

    own = _place(f"runtime/{name}/{LIBRARIES[name]}")
    if own.exists():
        return own
    try:
        package = import_module(RUNTIMES_PACKAGE)
    except ModuleNotFoundError:
        return None
    if package.__version__ != __version__:
        raise ExportError(
            f"{name}: found version {package.__version__} of gelenk-runtimes, expected {__version__}, "
            f"that of gelenk; {MAKE_RUNTIMES}"
        )
    other = Path(str(resources.files(package) / name / LIBRARIES[name]))
    return other if other.exists() else None


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
