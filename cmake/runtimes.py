# SPDX-License-Identifier: BSD-3-Clause
"""Build the FMU runtimes of other platforms with Zig, and the package gelenk-runtimes that contains them.

The same sources give the same bytes.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import ziglang
import zopfli.gzip
from fat_binary import fat_binary
from sundials_source import sundials_source

SOURCE = Path(__file__).resolve().parent.parent
ZIG = Path(ziglang.__file__).parent / "zig"


@dataclass(frozen=True)
class Platform:
    """A platform of FMI 2.0.

    Attributes:
        targets: of Zig; several for a library that contains the code of several processors.
        library: file name of the runtime.
        licenses: of what it contains beside Gelenk's own dependencies, see LICENSES.
    """

    targets: Sequence[str]
    library: str
    licenses: tuple[str, ...] = ("LLVM",)


# glibc 2.17 is the first one for AArch64. macOS 11 is the first one on ARM.
PLATFORMS = {
    "aarch64-linux": Platform(["aarch64-linux-gnu.2.17"], "gelenk_fmu.so"),
    "win64": Platform(["x86_64-windows-gnu"], "gelenk_fmu.dll", ("LLVM", "MinGW-w64")),
    "darwin64": Platform(["x86_64-macos.11.0", "aarch64-macos.11.0"], "gelenk_fmu.dylib"),
}
# linux64 is shipped as GCC builds it. tests/platforms/test_speed.py compares the two compilers.
COMPARED = "x86_64-linux-gnu.2.17"
LICENSES = {
    "LLVM": ZIG.parent / "lib" / "libcxx" / "LICENSE.TXT",  # the C++ library
    "MinGW-w64": SOURCE / "licenses" / "runtimes" / "MinGW-w64.txt",
}
SUNDIALS_OPTIONS = {
    "CMAKE_BUILD_TYPE": "Release",
    "BUILD_SHARED_LIBS": "OFF",
    "CMAKE_C_VISIBILITY_PRESET": "hidden",  # on macOS, the library would export SUNDIALS, too
    "BUILD_CVODE": "OFF",
    "BUILD_IDA": "OFF",
    "BUILD_KINSOL": "OFF",
    "EXAMPLES_ENABLE_C": "OFF",
    "EXAMPLES_INSTALL": "OFF",
    "SUNDIALS_LOGGING_LEVEL": "0",
}


def run(*command: str | Path) -> None:
    """Run a command; its output goes to stdout. Raises CalledProcessError."""
    subprocess.run([str(word) for word in command], check=True)


def configured(source: Path, build: Path, toolchain: Path, options: dict[str, str]) -> None:
    """Configure a build with the toolchain file."""
    settings = {"CMAKE_TOOLCHAIN_FILE": str(toolchain)} | options
    run(
        "cmake",
        "-G",
        "Ninja",
        "-S",
        source,
        "-B",
        build,
        *(f"-D{n}={value}" for n, value in settings.items()),
    )


def toolchain_of(target: str, folder: Path) -> Path:
    """Write the toolchain file of a target of Zig."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "toolchain.cmake"
    # Where the linker cannot redirect malloc: see fmu/memory.cpp.
    flags = (
        "" if "linux" in target or "wasm" in target else f"-include {SOURCE / 'cmake' / 'sundials_memory.h'}"
    )
    lines = {
        "GELENK_ZIG": ZIG,
        "GELENK_ZIG_TARGET": target,
        "GELENK_ZIG_TOOLS": folder / "tools",
        "GELENK_ZIG_C_FLAGS": flags,
    }
    text = "".join(f'set({name} "{value}")\n' for name, value in lines.items())
    file.write_text(text + f'include("{SOURCE / "cmake" / "zig.cmake"}")\n')
    return file


def sundials(folder: Path, toolchain: Path, source: Path) -> Path:
    """Build SUNDIALS and return the folder of its CMake package."""
    options = SUNDIALS_OPTIONS | {"CMAKE_INSTALL_PREFIX": str(folder / "install")}
    configured(source, folder / "sundials", toolchain, options)
    run("cmake", "--build", folder / "sundials", "--target", "install")
    return folder / "install" / "lib" / "cmake" / "sundials"


def compiled(name: str, target: str, folder: Path, source: Path, options: dict[str, str]) -> Path:
    """Build a CMake target for a target of Zig and return the folder with what is built."""
    toolchain = toolchain_of(target, folder)
    all_options = {
        "SUNDIALS_DIR": str(sundials(folder, toolchain, source)),
        "Python_EXECUTABLE": sys.executable,
        "GELENK_SCENES": "OFF",
        "GELENK_WITH_YAML": "OFF",
        "CMAKE_TRY_COMPILE_TARGET_TYPE": "STATIC_LIBRARY",  # linking would compile the C++ library once more
    } | options
    configured(SOURCE, folder / "gelenk", toolchain, all_options)
    run("cmake", "--build", folder / "gelenk", "--target", name)
    return folder / "gelenk" / "runtime"


def library(target: str, folder: Path, source: Path, options: dict[str, str]) -> Path:
    """Build the runtime for a target of Zig and return the library."""
    built = compiled("gelenk_fmu", target, folder, source, options).glob("*/gelenk_fmu.*")
    (found,) = (file for file in built if file.suffix in (".so", ".dll", ".dylib"))
    return found


def add_to_package(package: Path, name: str, content: bytes, sbom: Path) -> None:
    """Put a runtime into the package, compressed, with its licenses and its bill of materials."""
    platform = PLATFORMS[name]
    folder = package / name
    (folder / "licenses").mkdir(parents=True, exist_ok=True)
    for license_name in platform.licenses:
        shutil.copyfile(LICENSES[license_name], folder / "licenses" / f"{license_name}.txt")
    shutil.copyfile(sbom, folder / "licenses" / sbom.name)
    file = folder / f"{platform.library}.gz"
    # 3.5 % smaller than by zlib, and as quickly read.
    file.write_bytes(zopfli.gzip.compress(content, numiterations=5))
    print(f"{file}: {file.stat().st_size / 1e6:.1f} MB", flush=True)


def write_package(folder: Path, linux64: Path | None) -> None:
    """Write what gelenk-runtimes contains beside the runtimes built here.

    linux64: folder with the runtime built with GCC, for installations of gelenk on other platforms.
    """
    package = folder / "gelenk_runtimes"
    (found,) = re.findall(r"project\(gelenk VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text())
    title = "Libraries of Gelenk's FMUs for Linux, Windows and macOS."
    (package / "__init__.py").write_text(f'"""{title}"""\n\n__version__ = "{found}"\n')
    shutil.copyfile(SOURCE / "cmake" / "runtimes.toml", folder / "pyproject.toml")
    shutil.copyfile(SOURCE / "LICENSE", folder / "LICENSE")
    if linux64 is not None:
        shutil.copytree(linux64, package / "linux64", dirs_exist_ok=True)
    (package / "licenses").mkdir(exist_ok=True)
    for license_file in (SOURCE / "licenses").glob("*.txt"):
        shutil.copyfile(license_file, package / "licenses" / license_file.name)


def main() -> None:
    """Build the runtimes and the source of the package."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="folder of the builds")
    parser.add_argument("package", type=Path, help="folder of the source of gelenk-runtimes")
    parser.add_argument("--platforms", nargs="*", default=list(PLATFORMS), choices=list(PLATFORMS))
    parser.add_argument("--linux64", type=Path, help="folder with the runtime built with GCC")
    parser.add_argument("--compare", action="store_true", help="build linux64 only, which is not packed")
    parser.add_argument("--quick", action="store_true", help="do not optimize, to try the build itself")
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    # Zig keeps the libraries that it has compiled.
    for kind in ("GLOBAL", "LOCAL"):
        os.environ.setdefault(f"ZIG_{kind}_CACHE_DIR", str(build / "zig-cache"))
    source = sundials_source(build / "sundials-source")
    options = {"CMAKE_BUILD_TYPE": "Release"}
    if arguments.quick:
        options = {"CMAKE_BUILD_TYPE": "None", "CMAKE_CXX_FLAGS_NONE": "-O0"}
    if arguments.compare:
        print(library(COMPARED, build / COMPARED, source, options))
        return
    for name in arguments.platforms:
        targets = PLATFORMS[name].targets
        libraries = [library(target, build / target, source, options) for target in targets]
        content = fat_binary(libraries) if len(libraries) > 1 else libraries[0].read_bytes()
        (sbom,) = (build / targets[0] / "gelenk").glob("sbom-*.cdx.json")
        add_to_package(arguments.package / "gelenk_runtimes", name, content, sbom)
    write_package(arguments.package, arguments.linux64)


if __name__ == "__main__":
    main()
