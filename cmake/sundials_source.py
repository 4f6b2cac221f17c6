# SPDX-License-Identifier: BSD-3-Clause
"""Fetch the source of SUNDIALS, which the Rust package `sundials-sys` contains, with Cargo, and verify it."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from pathlib import Path

# The wheels of SUNDIALS have libraries for few platforms; this package has the source of version 7.1.1.
PACKAGE, VERSION = "sundials-sys", "0.6.2"
SHA256 = "a53535d8355025f42b7aa88a83ce474fcdba02af93e5808d77d346ff3e13c711"
MANIFEST = f"""\
[package]
name = "sources"
version = "0.0.0"
[dependencies]
{PACKAGE} = "={VERSION}"
"""


def checksum(folder: Path) -> str:
    """Return the SHA-256 of the names and contents of all files in a folder."""
    found = hashlib.sha256()
    for file in sorted(folder.rglob("*")):
        if file.is_file():
            name = file.relative_to(folder).as_posix().encode()
            content = file.read_bytes()
            found.update(b"%d %s %d " % (len(name), name, len(content)) + content)
    return found.hexdigest()


def sundials_source(folder: Path) -> Path:
    """Return the folder with the source of SUNDIALS, fetched to `folder` if it is not there yet.

    Exits with a message if Cargo is not installed or the source is not the expected one.
    """
    source = folder / "vendor" / PACKAGE / "vendor"
    if not source.is_dir():
        cargo = shutil.which("cargo")
        if cargo is None:
            sys.exit("cargo: not found; it fetches the source of SUNDIALS. Debian: apt-get install cargo")
        (folder / "src").mkdir(parents=True, exist_ok=True)
        (folder / "src" / "lib.rs").touch()
        (folder / "Cargo.toml").write_text(MANIFEST)
        subprocess.run([cargo, "vendor", "--quiet"], cwd=folder, stdout=subprocess.DEVNULL, check=True)
    found = checksum(source)
    if found != SHA256:
        sys.exit(f"{source}: SHA-256: found {found}, expected {SHA256}; delete the folder to fetch it again")
    return source


if __name__ == "__main__":
    print(sundials_source(Path(sys.argv[1]).resolve()))
