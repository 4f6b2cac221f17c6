# SPDX-License-Identifier: BSD-3-Clause
"""Print the directories of the wheels with native libraries that Gelenk uses, one `name=directory` per line.

Packages are located without importing them. Packages that are not installed are not printed; CMake then looks
for a system package of that name.
"""

from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path


def file_of(package: str, name: str) -> Path | None:
    """Return the path of a file in an installed distribution, or None if there is no such file."""
    try:
        path = Path(str(distribution(package).locate_file(name)))
    except PackageNotFoundError:
        return None
    return path if path.exists() else None


def folder_of(module: str) -> Path | None:
    """Return the folder of an importable package, or None."""
    spec = find_spec(module)
    return Path(spec.origin).parent if spec and spec.origin else None


def main() -> None:
    """Print the directories that exist."""
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
