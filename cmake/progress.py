# SPDX-License-Identifier: BSD-3-Clause
"""Tells each step of `pip install -v`, read from stdin, in a line: what is fetched, what is compiled."""

import re
import sys

DOWNLOAD = re.compile(r"Downloading (\S+)\s.*\(([\d.]+ MB)\)")
COMPILED = re.compile(r"(\[\d+/\d+\]) (?:.*CMakeFiles/[^/]*\.dir/)?(.*?)(?:\.o)?$")


def step(line: str) -> str | None:
    """What a line of pip's output says of the progress; None if nothing."""
    if download := DOWNLOAD.match(line):
        return f"fetching {download[1]} ({download[2]})"
    if line.startswith("Installing build dependencies: started"):
        return "installing what the build needs"
    if line.startswith("*** Configuring CMake"):
        return "configuring"
    if compiled := COMPILED.match(line):
        return f"{compiled[1]} {compiled[2]}"
    if line.startswith("Successfully installed"):
        return "installed"
    return None


if __name__ == "__main__":
    for line in sys.stdin:
        if told := step(line.strip()):
            print(f"  {told}", flush=True)
