# SPDX-License-Identifier: BSD-3-Clause
"""Files of meshes to which shapes of a scene refer: their points and triangles replace the names."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import numpy as np

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.file_reading import read_bytes

ENDINGS = (".stl", ".obj", ".ply", ".off")
MAX_BYTES = 60_000_000  # of a file: text of 200,000 triangles
MAX_TRIANGLES = 200_000  # with more, the scene would be larger than scenes may be
# Takes the place of a mesh with faults, so that the rest of the scene is checked, too.
_ANY_SOLID = {
    "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}


class _Entries(dict[str, Any]):
    """A mapping that writes repeated keys, too: the reader of scenes reports them."""

    def __init__(self, pairs: list[tuple[str, Any]]) -> None:
        super().__init__(pairs)
        self._pairs = pairs

    def items(self) -> Any:
        """Return all pairs."""
        return super().items() if len(self) == len(self._pairs) else self._pairs


class Meshes:
    """The files of meshes of one scene, each of which is read once."""

    def __init__(self, file: str) -> None:
        """Store where they are.

        Args:
            file: the scene, to whose folder names of files are relative; empty: to the current folder.
        """
        self._file = file
        self._folder = Path(file).parent if file else Path()
        self._read: dict[tuple[str, float], dict[str, Any]] = {}

    @property
    def folder(self) -> Path:
        """The folder to which names of files are relative."""
        return self._folder

    def resolved(self, text: str) -> tuple[str, list[str]]:
        """Replace the names of files.

        Args:
            text: a scene in JSON.

        Returns:
            tuple: the scene with points and triangles, and faults, one line each.
        """
        if '"mesh"' not in text:
            return text, []
        try:
            data = json.loads(text, object_pairs_hook=_Entries)
        except (ValueError, RecursionError):
            return text, []  # the reader of scenes reports it
        faults = []
        found = False
        for path, shape in _shapes(data):
            if not refers_to_file(shape["mesh"]):
                continue
            found = True
            try:
                shape["mesh"] = self._of(shape["mesh"])
            except _FaultError as fault:
                faults.append(f"{self._file or 'scene'}: {path}.mesh{fault}")
                shape["mesh"] = _ANY_SOLID
        return (json.dumps(data) if found else text), faults

    def _of(self, mesh: Any) -> dict[str, Any]:
        name, scale = _file_and_scale(mesh)
        key = (name, scale)
        if key not in self._read:
            self._read[key] = _load(self._path(name), name, scale)
        return self._read[key]

    def _path(self, name: str) -> Path:
        is_absolute = PurePosixPath(name).is_absolute() or PureWindowsPath(name).is_absolute()
        if is_absolute or ".." in PurePosixPath(name.replace("\\", "/")).parts:
            raise _FaultError(
                f"'{name}'",
                "a file in the folder of the scene, or in a folder of it, so that both can be moved",
            )
        return self._folder / name


class _FaultError(Exception):
    """What is wrong with a mesh, as the rest of a line of a message."""

    def __init__(self, found: str, expected: str, field: str = "") -> None:
        super().__init__(f"{'.' if field else ''}{field}: found {found}, expected {expected}")


def refers_to_file(mesh: Any) -> bool:
    """Return whether a mesh is given by the name of a file."""
    return isinstance(mesh, str) or (isinstance(mesh, Mapping) and "points" not in mesh)


def _shapes(data: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Return the meshes of a scene that may have faults, with their paths."""

    def below(owner: Any, path: str) -> Iterator[tuple[str, dict[str, Any]]]:
        shapes = owner.get("shapes") if isinstance(owner, dict) else None
        for name, shape in shapes.items() if isinstance(shapes, dict) else ():
            if isinstance(shape, dict) and "mesh" in shape:
                yield f"{path}.shapes.{name}", shape

    if not isinstance(data, dict):
        return
    bodies = data.get("bodies")
    for name, body in bodies.items() if isinstance(bodies, dict) else ():
        yield from below(body, f"bodies.{name}")
    yield from below(data.get("ground"), "ground")


def _file_and_scale(mesh: Any) -> tuple[str, float]:
    fields = {"file": mesh} if isinstance(mesh, str) else mesh
    for key in fields:
        if key not in ("file", "scale"):
            raise _FaultError(f"'{key}'", "file and scale, or points and triangles")
    name: Any = fields.get("file")
    scale: Any = fields.get("scale", 1.0)
    if not isinstance(name, str) or not name:
        raise _FaultError("nothing" if name in (None, "") else repr(name), "the name of a file", "file")
    is_number = isinstance(scale, int | float) and not isinstance(scale, bool)
    if not (is_number and 0 < scale < math.inf):
        raise _FaultError(repr(scale), "a positive number, the length of the file's unit in m", "scale")
    return name, float(scale)


def _load(path: Path, name: str, scale: float) -> dict[str, Any]:
    """Return the points and triangles of a file, equal points merged."""
    if path.suffix.lower() not in ENDINGS:
        raise _FaultError(f"'{name}'", f"a file of triangles: {', '.join(ENDINGS)}")
    try:
        content = read_bytes(path, MAX_BYTES)
    except (OSError, UsageError) as e:
        why = e.strerror if isinstance(e, OSError) else str(e).partition(": ")[2]
        raise _FaultError(
            f"{name!r}, which cannot be read ({why})", "a file in the folder of the scene"
        ) from None
    try:
        reader = extra("trimesh", "files of meshes are read by trimesh")
    except UsageError as e:
        raise _FaultError(f"'{name}'", f"the package trimesh, which reads it ({e})") from None
    points, triangles = _parsed(reader, content, path.suffix.lower(), name)
    if len(triangles) == 0:
        raise _FaultError(f"'{name}', which contains no triangles", "a closed surface")
    if len(triangles) > MAX_TRIANGLES:
        raise _FaultError(
            f"'{name}' with {len(triangles)} triangles",
            f"at most {MAX_TRIANGLES}; simplify it in the program it is from",
        )
    if not np.isfinite(points).all():
        raise _FaultError(f"'{name}', which contains numbers that are not finite", "a closed surface")
    # Adding 0 makes zeros of both signs equal.
    unique, number = np.unique(points * scale + 0.0, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[triangles]
    # Edges of triangles that have shrunk to an edge cancel, so that the surface stays closed.
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    return {"points": unique.tolist(), "triangles": triangles.tolist()}


def _parsed(trimesh: Any, content: bytes, ending: str, name: str) -> tuple[Any, Any]:
    from io import BytesIO

    read: Callable[..., Any] = trimesh.load
    try:
        mesh = read(BytesIO(content), file_type=ending[1:], force="mesh", process=False)
        return np.asarray(mesh.vertices, float).reshape(-1, 3), np.asarray(mesh.faces, np.int64).reshape(
            -1, 3
        )
    except Exception as e:  # readers of the formats raise anything for faulty files
        raise _FaultError(
            f"'{name}', which is not a mesh ({type(e).__name__}: {e})", "a file of triangles"
        ) from None
