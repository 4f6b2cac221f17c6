# SPDX-License-Identifier: BSD-3-Clause
"""Print one line for each step of `pip install -v`, read from stdin: downloads and compiled files."""

import re
import sys

DOWNLOAD = re.compile(r"Downloading (\S+)\s.*\(([\d.]+ MB)\)")
TOGETHER = re.compile(r"Unity/unity_([^_]+)_?(.*)_cxx\.cxx")  # the files of a folder
COMPILED = re.compile(r"(\[\d+/\d+\]) (?:.*CMakeFiles/[^/]*\.dir/)?(.*?)(?:\.o)?$")


def step(line: str) -> str | None:
    """Return the progress reported by a line of pip's output, or None."""
    if download := DOWNLOAD.match(line):
        return f"fetching {download[1]} ({download[2]})"
    if line.startswith("Installing build dependencies: started"):
        return "installing the build requirements"
    if line.startswith("*** Configuring CMake"):
        return "configuring"
    if compiled := COMPILED.match(line):
        together = TOGETHER.fullmatch(compiled[2])
        return f"{compiled[1]} {'/'.join(filter(None, together.groups())) if together else compiled[2]}"
    if line.startswith("Successfully installed"):
        return "installed"
    return None


if __name__ == "__main__":
    for line in sys.stdin:
        if progress := step(line.strip()):
            print(f"  {progress}", flush=True)
