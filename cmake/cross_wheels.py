# SPDX-License-Identifier: BSD-3-Clause
"""Build wheels of gelenk for other platforms with Zig, from that for linux64 and the builds of runtimes.py.

Pages, scenes and the JSON Schema are the same on all platforms; the compiled module and the runtime are not.
The module uses Python's stable ABI, so that the headers of this machine's Python are sufficient.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

from runtimes import LICENSES, PLATFORMS, run


@dataclass(frozen=True)
class CrossWheel:
    """A wheel for another platform.

    Attributes:
        platform: of FMI, whose runtime the wheel contains.
        target: of Zig.
        tag: of the wheel's file name; the system must not be older.
        module: file name of the compiled module.
    """

    platform: str
    target: str
    tag: str
    module: str = "_core.abi3.so"


WHEELS = [
    CrossWheel("aarch64-linux", "aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64"),
    CrossWheel("darwin64", "aarch64-macos.11.0", "macosx_11_0_arm64"),
    CrossWheel("darwin64", "x86_64-macos.11.0", "macosx_11_0_x86_64"),
    CrossWheel("win64", "x86_64-windows-gnu", "win_amd64", "_core.pyd"),
]
# Headers and import library of Python for Windows, from Maven Central.
WINDOWS_PYTHON = "org.bytedeco:cpython:3.14.3-1.5.13:jar:windows-x86_64"
WINDOWS_PYTHON_SHA256 = "3291bf3d8f405335ac21dbe55780521fdfd295b0f9f43f7e6e8c55bedd709cb3"


def module(wheel: CrossWheel, builds: Path) -> Path:
    """Build the Python module in the folder in which runtimes.py has built the runtime."""
    folder = builds / wheel.target / "gelenk"
    if not (folder / "CMakeCache.txt").exists():
        sys.exit(f"{folder}: found no build of the runtime for {wheel.platform}; `make runtimes` makes it")
    options = {"GELENK_PYTHON": "ON", "GELENK_PYTHON_HEADERS": sysconfig.get_path("include")}
    if wheel.platform == "win64":
        python = windows_python(builds / "windows-python")
        options |= {
            "GELENK_PYTHON_HEADERS": str(python / "include"),
            "GELENK_PYTHON_LIBRARY": str(python / "libs" / "python3.lib"),
        }
    run("cmake", folder, *(f"-D{name}={value}" for name, value in options.items()))
    run("cmake", "--build", folder, "--target", "_core")
    return folder / wheel.module


def windows_python(folder: Path) -> Path:
    """Fetch Python for Windows with Maven, verify it, and return the folder with include/ and libs/."""
    group, artifact, version, _, classifier = WINDOWS_PYTHON.split(":")
    file = folder / f"{artifact}-{version}-{classifier}.jar"
    if not file.exists():
        if shutil.which("mvn") is None:
            sys.exit("mvn: not found; it fetches Python's headers for Windows. Debian: apt-get install maven")
        run(
            "mvn",
            "-q",
            "-B",
            "dependency:copy",
            f"-Dartifact={WINDOWS_PYTHON}",
            f"-DoutputDirectory={folder}",
        )
    found = hashlib.sha256(file.read_bytes()).hexdigest()
    if found != WINDOWS_PYTHON_SHA256:
        sys.exit(
            f"{file}: SHA-256: found {found}, expected {WINDOWS_PYTHON_SHA256}; delete it to fetch it again"
        )
    with zipfile.ZipFile(file) as archive:
        archive.extractall(folder)
    return folder.joinpath(*group.split("."), artifact, classifier)


def repacked(wheel: CrossWheel, source: Path, built: Path, runtimes: Path, out: Path) -> None:
    """Write the wheel: that for linux64 with another module, another runtime and its licenses."""
    with tempfile.TemporaryDirectory() as temporary:
        run(sys.executable, "-m", "wheel", "unpack", "--dest", temporary, source)
        (root,) = Path(temporary).iterdir()
        package = root / "gelenk"
        (package / "_core.abi3.so").unlink()
        shutil.copy(built, package / wheel.module)
        shutil.rmtree(package / "runtime")
        shutil.copytree(runtimes / wheel.platform, package / "runtime" / wheel.platform)
        (info,) = root.glob("*.dist-info")
        tags = info / "WHEEL"
        text = re.sub(r"(?m)^Tag: .*\n", "", tags.read_text())
        tags.write_text(text.rstrip("\n") + f"\nTag: cp312-abi3-{wheel.tag}\n")
        replace_licenses(info, PLATFORMS[wheel.platform].licenses)
        run(sys.executable, "-m", "wheel", "pack", "--dest-dir", out, root)


def replace_licenses(info: Path, names: tuple[str, ...]) -> None:
    """Replace the license of GCC's C++ library by those of the libraries that Zig has linked."""
    metadata = info / "METADATA"
    old = "licenses/runtimes/libstdc++.txt"
    lines = []
    for name in names:
        lines.append(f"License-File: licenses/runtimes/{name}.txt")
        shutil.copy(LICENSES[name], info / "licenses" / "licenses" / "runtimes" / f"{name}.txt")
    (info / "licenses" / old).unlink()
    metadata.write_text(metadata.read_text().replace(f"License-File: {old}", "\n".join(lines)))


def main() -> None:
    """Build the wheels."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheel", type=Path, help="wheel for linux64")
    parser.add_argument("builds", type=Path, help="folder of the builds of runtimes.py")
    parser.add_argument("package", type=Path, help="folder of the source of gelenk-runtimes")
    parser.add_argument("out", type=Path, help="folder of the wheels")
    tags = [wheel.tag for wheel in WHEELS]
    parser.add_argument("--tags", nargs="*", default=tags, choices=tags, help="platforms of the wheels")
    arguments = parser.parse_args()
    for wheel in WHEELS:
        if wheel.tag not in arguments.tags:
            continue
        built = module(wheel, arguments.builds.resolve())
        runtimes = arguments.package.resolve() / "gelenk_runtimes"
        repacked(wheel, arguments.wheel.resolve(), built, runtimes, arguments.out.resolve())


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(f"{error.cmd[0]}: failed with status {error.returncode}")
