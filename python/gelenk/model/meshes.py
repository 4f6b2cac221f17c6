# SPDX-License-Identifier: BSD-3-Clause
"""Files of meshes to which shapes of a scene refer: their points and triangles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gelenk.errors import UsageError
from gelenk.extras import extra
from gelenk.model.file_names import FileFaultError, content_of, file_name

ENDINGS = (".stl", ".obj", ".ply", ".off")
OF_FILES = ("file", "scale")
MAX_BYTES = 60_000_000  # of a file: text of 200,000 triangles
MAX_TRIANGLES = 200_000  # with more, the scene would be larger than scenes may be
# Takes the place of a mesh with faults, so that the rest of the scene is checked, too.
ANY = {
    "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
}


def refers_to_file(mesh: Any) -> bool:
    """Return whether a mesh is given by the name of a file."""
    return isinstance(mesh, str) or (isinstance(mesh, Mapping) and "points" not in mesh)


def references(data: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Return the meshes of a scene that are files: path, owner and key."""
    owners = [("ground", data.get("ground"))]
    bodies = data.get("bodies")
    owners += [(f"bodies.{name}", body) for name, body in bodies.items()] if isinstance(bodies, dict) else []
    for path, owner in owners:
        shapes = owner.get("shapes") if isinstance(owner, dict) else None
        for name, shape in shapes.items() if isinstance(shapes, dict) else ():
            if isinstance(shape, dict) and "mesh" in shape and refers_to_file(shape["mesh"]):
                yield f"{path}.shapes.{name}.mesh", shape, "mesh"


def named(mesh: Any) -> tuple[str, float]:
    """Return the name of the file and the scale of a mesh. Raises FileFaultError."""
    fields = {"file": mesh} if isinstance(mesh, str) else mesh
    for key in fields:
        if key not in ("file", "scale"):
            raise FileFaultError(f"'{key}'", "file and scale, or points and triangles")
    scale: Any = fields.get("scale", 1.0)
    is_number = isinstance(scale, int | float) and not isinstance(scale, bool)
    if not (is_number and 0 < scale < math.inf):
        raise FileFaultError(repr(scale), "a positive number, the length of the file's unit in m", "scale")
    return file_name(fields.get("file")), float(scale)


def load(path: Path, name: str, scale: float) -> dict[str, Any]:
    """Return the points and triangles of a file, equal points merged."""
    if path.suffix.lower() not in ENDINGS:
        raise FileFaultError(f"'{name}'", f"a file of triangles: {', '.join(ENDINGS)}")
    content = content_of(path, name, MAX_BYTES)
    try:
        reader = extra("trimesh", "files of meshes are read by trimesh")
    except UsageError as e:
        raise FileFaultError(f"'{name}'", f"the package trimesh, which reads it ({e})") from None
    points, triangles = _parsed(reader, content, path.suffix.lower(), name)
    if len(triangles) == 0:
        raise FileFaultError(f"'{name}', which contains no triangles", "a closed surface")
    if len(triangles) > MAX_TRIANGLES:
        raise FileFaultError(
            f"'{name}' with {len(triangles)} triangles",
            f"at most {MAX_TRIANGLES}; simplify it in the program it is from",
        )
    if not np.isfinite(points).all():
        raise FileFaultError(f"'{name}', which contains numbers that are not finite", "a closed surface")
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
        raise FileFaultError(
            f"'{name}', which is not a mesh ({type(e).__name__}: {e})", "a file of triangles"
        ) from None
