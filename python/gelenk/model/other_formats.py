# SPDX-License-Identifier: BSD-3-Clause
"""Files of other programs that are given instead of scenes: error messages that say what to do with them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NoReturn

from gelenk.errors import SceneError
from gelenk.file_reading import read_start

_IMPORT = "convert it to a scene with `gelenk import`"
_BY_URDF = "convert it to URDF and use `gelenk import`, or write a scene (docs/scene-format.md)"
_BY_HAND = "write a scene with the same bodies and joints (docs/scene-format.md)"

# Kinds of files: pattern of their content, name, and advice. The first match counts.
_CONTENTS = (
    (rb"<robot\b[^>]*xmlns:xacro|<xacro:", "a xacro file", f"expand it with xacro, then {_IMPORT}"),
    (rb"<robot\b", "a URDF robot description", _IMPORT),
    (rb"<mujoco\b|<mujocoinclude\b", "an MJCF model of MuJoCo", _BY_URDF),
    (rb"<sdf\b|<gazebo\b", "an SDF model of Gazebo", _BY_URDF),
    (rb"<fmiModelDescription\b", "the description in an FMU", "use the scene from which it was exported"),
    (rb"<OpenSimDocument\b", "an OpenSim model", _BY_HAND),
    (rb"<COLLADA\b", "a COLLADA drawing", _BY_HAND),
    (rb"^\s*(?:within\b[^;\n]*;\s*)?(?:partial\s+|encapsulated\s+)*(?:model|package|class|block)\s+\w+\s*(?:\"|$|//|\n)",
     "a Modelica model", _BY_HAND),
    (rb"^\s*ADAMS\s*/|^\s*PART\s*/\s*\d+", "a data set of Adams", _BY_HAND),
    (rb"^\s*(?:part|model|marker|constraint|defaults)\s+(?:create|modify|attributes|model)\b",
     "a command file of Adams", _BY_HAND),
    (rb"^#usda\b|^PXR-USDC", "a USD scene", _BY_HAND),
    (rb"\APK\x03\x04", "a zip archive, as FMUs are", "use the scene from which it was exported"),
    (rb"<\?xml|\A\s*<[A-Za-z!]", "an XML file", _BY_HAND),
)  # fmt: skip

# A name with a colon, or an opening brace, after comments: a scene, whose errors the scene reader reports.
_SCENE = re.compile(rb"(?:\s|\xef\xbb\xbf|---|#(?!usda)[^\n]*\n)*(?:['\"]?\w+['\"]?\s*:|\{)")

_ENDINGS = {
    ".urdf": ("a URDF robot description", _IMPORT),
    ".xacro": ("a xacro file", f"expand it with xacro, then {_IMPORT}"),
    ".fmu": ("an FMU", "simulate it with `gelenk simulate`"),
    ".mjcf": ("an MJCF model of MuJoCo", _BY_URDF),
    ".sdf": ("an SDF model of Gazebo", _BY_URDF),
    ".mo": ("a Modelica model", _BY_HAND),
    ".adm": ("a data set of Adams", _BY_HAND),
    ".cmd": ("a command file of Adams", _BY_HAND),
    ".slx": ("a Simulink model", _BY_HAND),
    ".mdl": ("a Simulink model", _BY_HAND),
    ".osim": ("an OpenSim model", _BY_HAND),
    ".usd": ("a USD scene", _BY_HAND),
    ".step": ("a CAD drawing", _BY_HAND),
    ".stp": ("a CAD drawing", _BY_HAND),
}
_EXPECTED = "a scene of Gelenk (.yaml, .yml or .json)"


def refuse_ending(path: Path) -> NoReturn:
    """Raise SceneError for a file whose name is not that of a scene.

    Args:
        path: the file; its content determines the message.

    Raises:
        SceneError: always, except for a pipe or device.
        UsageError: it is a pipe or device.
        OSError: the file cannot be read.
    """
    ending = path.suffix.lower()
    content = read_start(path, 10_000)
    if not (ending in _ENDINGS and content.startswith(b"PK")):
        refuse_content(content, str(path))
    if ending in _ENDINGS:
        what, hint = _ENDINGS[ending]
        raise SceneError(f"{path}: found {what}, expected {_EXPECTED}; {hint}")
    raise SceneError(f"{path}: found the ending {ending or 'none'}, expected .yaml, .yml or .json")


def refuse_content(content: bytes, file: str, expected: str = _EXPECTED) -> None:
    """Raise SceneError if a file is one of another program, independently of its name.

    Args:
        content: content of the file.
        file: file name for messages.
        expected: the expected kind of file, for the message.
    """
    start = content[:10_000]
    if _SCENE.match(start):
        return
    for pattern, what, hint in _CONTENTS:
        found = re.search(pattern, start, re.MULTILINE)
        if found:
            first = found.start() + len(found[0]) - len(found[0].lstrip())
            line = "" if start.startswith(b"PK") else f":{start.count(b'\n', 0, first) + 1}"
            raise SceneError(f"{file}{line}: found {what}, expected {expected}; {hint}")
