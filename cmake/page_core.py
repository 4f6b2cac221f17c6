# SPDX-License-Identifier: BSD-3-Clause
"""Build the core as WebAssembly with Zig, for pages that compute, as a part of the package gelenk."""

from __future__ import annotations

import argparse
import os
import shutil
from pathlib import Path

import zopfli.gzip
from runtimes import LICENSES, ZIG, compiled
from sundials_source import sundials_source

LIBC = ZIG.parent / "lib" / "libc" / "wasi"
LIBC_LICENSES = (
    "LICENSE",
    "LICENSE-MIT",
    "libc-bottom-half/cloudlibc/LICENSE",
    "libc-top-half/musl/COPYRIGHT",
)
TARGET = "wasm32-wasi"
LIBRARY = "gelenk.wasm"


def built(folder: Path, source: Path) -> Path:
    """Build the core and return it."""
    runtime = compiled("gelenk_page", TARGET, folder, source, {"CMAKE_BUILD_TYPE": "Release"})
    return runtime / "wasm32" / LIBRARY


def put(core: Path, package: Path) -> Path:
    """Put the core, compressed, with its licenses and its bill of materials, into a folder of a package."""
    folder = package / "runtime" / "wasm32"
    (folder / "licenses").mkdir(parents=True, exist_ok=True)
    shutil.copyfile(LICENSES["LLVM"], folder / "licenses" / "LLVM.txt")
    libc = [(LIBC / name).read_text(encoding="utf-8") for name in LIBC_LICENSES]
    (folder / "licenses" / "wasi-libc.txt").write_text("\n\n".join(libc), encoding="utf-8")
    (sbom,) = (core.parent.parent.parent).glob("sbom-*.cdx.json")
    shutil.copyfile(sbom, folder / "licenses" / sbom.name)
    file = folder / f"{LIBRARY}.gz"
    file.write_bytes(zopfli.gzip.compress(core.read_bytes(), numiterations=5))
    return file


def main() -> None:
    """Build the core."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="folder of the build")
    parser.add_argument("package", type=Path, help="folder of what the package gets")
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    for kind in ("GLOBAL", "LOCAL"):
        os.environ.setdefault(f"ZIG_{kind}_CACHE_DIR", str(build / "zig-cache"))
    core = built(build / TARGET, sundials_source(build / "sundials-source"))
    file = put(core, arguments.package)
    print(f"{file}: {file.stat().st_size / 1e6:.2f} MB of {core.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
