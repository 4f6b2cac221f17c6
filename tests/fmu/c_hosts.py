# SPDX-License-Identifier: BSD-3-Clause
"""The hosts written in C: compiled here, and told what they are to load."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
HEADERS = Path(fmpy.__file__).parent / "c-code"


def compiled(name: str, folder: Path, *flags: str, where: Path = HERE) -> Path | None:
    """NAME.c, from `where`, as a program in the folder; None where there is no C compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    out = folder / name
    # -rdynamic: a malloc of the host's is then the library's too.
    subprocess.run(
        [compiler, "-O1", "-g", "-Wall", "-Wextra", "-Werror", "-rdynamic", *flags,
         f"-I{HEADERS}", f"-I{HERE}", str(where / f"{name}.c"), "-o", str(out), "-ldl", "-lpthread"],
        check=True,
    )  # fmt: skip
    return out


def extracted(fmu: Path, folder: Path, library: Path | None = None) -> list[str]:
    """Unpacks an FMU; the arguments of a host, for its library or one in its place.

    The input is the first one, or 0 if there is none.
    """
    description = fmpy.read_model_description(str(fmu))
    fmpy.extract(str(fmu), str(folder))
    (own,) = (folder / "binaries" / "linux64").glob("*.so")
    if library is not None:
        shutil.copyfile(library, own)
    outputs = [v.valueReference for v in description.modelVariables if v.causality == "output"]
    inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
    assert outputs == list(range(outputs[0], outputs[0] + len(outputs)))
    return [
        str(own),
        description.guid,
        (folder / "resources").as_uri(),
        *(str(n) for n in (inputs[0] if inputs else 0, outputs[0], len(outputs))),
    ]
