# SPDX-License-Identifier: BSD-3-Clause
"""The compiled module of the wheel for Windows, in Wine, with the Python that cross_wheels.py has fetched.

NumPy does not start there: it needs functions of complex numbers (crealf and others), which the C library of
Wine 8 lacks. A module of the same name takes its place; only what needs no arrays is tested: reading
scenes and writing FMUs.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
import zlib
from pathlib import Path

import pytest

import gelenk

from .machines import WINDOWS

lief = pytest.importorskip("lief", reason="lief is not installed: pip install --group runtimes")
pytestmark = [
    pytest.mark.platforms,
    pytest.mark.skipif(bool(WINDOWS.missing), reason=WINDOWS.missing),
]
BUILD = Path(__file__).resolve().parents[2] / "build"
PYTHON = BUILD / "runtimes" / "windows-python" / "org" / "bytedeco" / "cpython" / "windows-x86_64"
WHEELS = sorted((BUILD / "wheels").glob("gelenk-*win_amd64.whl"))
NUMPY = (
    "def asarray(values, *others, **further):\n    return memoryview(values)\n\n\narray = copy = asarray\n"
)
EXPORT = """
import pathlib, sys, types, zlib
folder = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(folder))
package = types.ModuleType("gelenk")  # without __init__.py, which imports what needs NumPy
package.__path__ = [str(folder / "gelenk")]
sys.modules["gelenk"] = package
from gelenk import _core
scene = _core.read_scene_json((folder / "scene.json").read_text(encoding="utf-8"), "scene.json")
runtime = folder / "gelenk" / "runtime" / "win64" / "gelenk_fmu.dll.gz"
licenses = folder / "gelenk" / "licenses"
_core.export_fmu(scene, [("win64", runtime)], folder / "x.fmu", licenses, zlib.compress, None)
print("exported")
"""


def add_forwarder(folder: Path, work: Path) -> None:
    """Make python3.dll, which Python for Windows has, but not this package: it refers to python314.dll."""
    import ziglang

    (own,) = folder.glob("python3[0-9][0-9].dll")
    library = lief.PE.parse(str(own))  # releases its entries
    names = sorted(entry.name for entry in library.get_export().entries if entry.name)
    lines = "".join(f"  {name}={own.stem}.{name}\n" for name in names if name.startswith(("Py", "_Py")))
    (work / "python3.def").write_text(f"LIBRARY python3.dll\nEXPORTS\n{lines}")
    (work / "empty.c").write_text("int unused;\n")
    subprocess.run(
        [str(Path(ziglang.__file__).parent / "zig"), "cc", "-target", WINDOWS.target, "-shared", "empty.c",
         "python3.def", "-o", str(folder / "python3.dll")], check=True, cwd=work,
        env={**os.environ, "ZIG_GLOBAL_CACHE_DIR": str(BUILD / "runtimes" / "zig-cache")},
    )  # fmt: skip


def readable(archive: zipfile.ZipFile, name: str) -> bytes:
    """The content of a file; of a picture the pixels, since each Python has a compressor of its own."""
    content = archive.read(name)
    if not name.endswith(".png"):
        return content
    pixels, position = b"", 8
    while position < len(content):  # chunks: length, type, data, checksum
        length = int.from_bytes(content[position : position + 4], "big")
        if content[position + 4 : position + 8] == b"IDAT":
            pixels += content[position + 8 : position + 8 + length]
        position += 12 + length
    return zlib.decompress(pixels)


def test_the_module_exports_the_same_fmu_in_wine(four_bar: gelenk.Scene, tmp_path: Path) -> None:
    """All files but the library have the content of those that are written here."""
    if not WHEELS or not PYTHON.exists():
        pytest.skip("build/wheels has no wheel for Windows: `make wheels` builds it after `make runtimes`")
    python = Path(shutil.copytree(PYTHON, tmp_path / "python"))
    add_forwarder(python, tmp_path)
    room = tmp_path / "room"
    with zipfile.ZipFile(WHEELS[-1]) as archive:
        archive.extractall(room)
    (room / "numpy.py").write_text(NUMPY)
    (room / "export.py").write_text(EXPORT)
    four_bar.save(room / "scene.json")
    program = next(filter(None, map(shutil.which, WINDOWS.programs)))
    command = [program, str(python / "python.exe"), WINDOWS.path(room / "export.py"), WINDOWS.path(room)]
    done = subprocess.run(
        command, input="", capture_output=True, text=True, timeout=600, check=False,
        env={**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert done.stdout.split() == ["exported"]
    ours = gelenk.export_fmu(gelenk.load(room / "scene.json"), tmp_path / "ours.fmu", ["win64"], view=False)
    with zipfile.ZipFile(room / "x.fmu") as there, zipfile.ZipFile(ours) as here:
        assert sorted(there.namelist()) == sorted(here.namelist())
        for name in here.namelist():
            if not name.startswith("binaries/"):
                assert readable(there, name) == readable(here, name), name
