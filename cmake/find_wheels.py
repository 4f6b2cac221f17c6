# SPDX-License-Identifier: BSD-3-Clause
"""Prints where pip put the libraries that Gelenk's native code is built on, one `name=directory` a line.

Nothing is imported: packages are only located. What is not installed is not printed; CMake then looks for
a system package of that name.
"""

from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path


def file_of(package: str, name: str) -> Path | None:
    """The place of a file inside an installed distribution, or None where there is no such file."""
    try:
        path = Path(str(distribution(package).locate_file(name)))
    except PackageNotFoundError:
        return None
    return path if path.exists() else None


def folder_of(module: str) -> Path | None:
    """The folder of an importable package, or None."""
    spec = find_spec(module)
    return Path(spec.origin).parent if spec and spec.origin else None


def main() -> None:
    """Prints what is there."""
    sundials = file_of("sundials4py", "lib64/cmake/sundials") or file_of("sundials4py", "lib/cmake/sundials")
    eigen = file_of("cmeel-eigen", "cmeel.prefix/share/eigen3/cmake")
    yaml = file_of("cmeel-yaml-cpp", "cmeel.prefix/lib/cmake/yaml-cpp")
    zlib = file_of("cmeel-zlib", "cmeel.prefix/lib64/cmake/zlib") or file_of(
        "cmeel-zlib", "cmeel.prefix/lib/cmake/zlib"
    )
    json, fmpy, nanobind = folder_of("nlohmann_json"), folder_of("fmpy"), folder_of("nanobind")
    found = {
        "sundials": sundials,
        "eigen": eigen,
        "yaml": yaml,
        "zlib": zlib,
        "json": json / "include" if json else None,
        "fmi": fmpy / "c-code" if fmpy else None,
        "nanobind": nanobind / "cmake" if nanobind else None,
    }
    for name, directory in found.items():
        if directory and directory.is_dir():
            print(f"{name}={directory.resolve()}")


if __name__ == "__main__":
    main()
