# SPDX-License-Identifier: BSD-3-Clause
"""Write requirements.lock: names, versions and hashes of what pyproject.toml names and of what that requires.

The lock is for tests and releases (`make LOCKED=1 ...`), on Linux, x86-64, with the Python that runs this
script. Users install by the ranges of pyproject.toml; `lock.py --lowest` prints the lower ends of those of
the package, `lock.py --extras` its optional requirements.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
LOCK = ROOT / "requirements.lock"
GROUPS = ("test", "lint", "runtimes")
HEADER = """# Names, versions and hashes for tests and releases, on Linux, x86-64, Python {python}; written by `make lock`.
# It names no places: pip takes each from the index that it is configured to use.
"""  # noqa: E501


def requirements(project: dict[str, Any]) -> list[str]:
    """Return what the package, its build, its extras and the groups of development require, each once."""
    found = [*project["build-system"]["requires"], *project["project"]["dependencies"], *extras(project)]
    for group in GROUPS:
        found += project["dependency-groups"][group]
    return list(dict.fromkeys(found))


def extras(project: dict[str, Any]) -> list[str]:
    """Return the optional requirements of the package, each once."""
    found = (line for extra in project["project"]["optional-dependencies"].values() for line in extra)
    return [line for line in dict.fromkeys(found) if not line.startswith("gelenk[")]


def lowest(project: dict[str, Any]) -> list[str]:
    """Return the lowest versions that the ranges of the package and of its extras permit."""
    ranges = dict.fromkeys([*project["project"]["dependencies"], *extras(project)])
    return [re.sub(r"^([\w.-]+)>=([\w.]+).*$", r"\1==\2", line) for line in ranges]


def locked(report: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of the lock for a report of pip."""
    for entry in sorted(report["install"], key=lambda entry: normalized(entry["metadata"]["name"])):
        meta = entry["metadata"]
        digest = entry["download_info"]["archive_info"]["hashes"]["sha256"]
        yield f"{normalized(meta['name'])}=={meta['version']} --hash=sha256:{digest}"


def normalized(name: str) -> str:
    """Return a name as indexes spell it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def main() -> None:
    """Resolve the requirements with pip, which downloads metadata only, and write the lock."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    if sys.argv[1:] == ["--lowest"]:
        print(*lowest(project))
        return
    if sys.argv[1:] == ["--extras"]:
        print(*extras(project), sep="\n")
        return
    command = [
        sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "install", "--dry-run",
        "--ignore-installed", "--only-binary=:all:", "--report", "-", *requirements(project),
    ]  # fmt: skip
    done = subprocess.run(command, stdout=subprocess.PIPE, check=True)
    lines = list(locked(json.loads(done.stdout)))
    python = ".".join(map(str, sys.version_info[:2]))
    LOCK.write_text(HEADER.format(python=python) + "\n".join(lines) + "\n", encoding="utf-8")
    print(f"{LOCK.name}: {len(lines)} packages")


if __name__ == "__main__":
    main()
