# SPDX-License-Identifier: BSD-3-Clause
"""Closed meshes whose mass properties are known: points, triangles, and the boxes of which they consist."""

from collections.abc import Sequence
from typing import Any

import numpy as np

# An L of two bars of 1 x 3 and 2 x 1 in the plane z, counterclockwise, with a thickness of 2.
OUTLINE = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
CAPS = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
THICKNESS = 2.0
# Their lower and upper corners.
L_BOXES = [((0, 0, 0), (3, 1, 2)), ((0, 1, 0), (1, 3, 2))]


def prism(
    outline: Sequence[tuple[float, float]], caps: Sequence[tuple[int, int, int]], height: float
) -> dict[str, Any]:
    """Return a prism along z as a mesh; caps: triangles of the outline, counterclockwise."""
    n = len(outline)
    points = [[float(x), float(y), z] for z in (0.0, height) for x, y in outline]
    triangles = [[c, b, a] for a, b, c in caps] + [[n + a, n + b, n + c] for a, b, c in caps]
    for k in range(n):
        after = (k + 1) % n
        triangles += [[k, after, n + after], [k, n + after, n + k]]
    return {"points": points, "triangles": triangles}


def l_shape() -> dict[str, Any]:
    return prism(OUTLINE, CAPS, THICKNESS)


def box() -> dict[str, Any]:
    """A box of 1 x 2 x 3 m with a corner in the origin."""
    return prism([(0, 0), (1, 0), (1, 2), (0, 2)], [(0, 1, 2), (0, 2, 3)], 3.0)


def of_boxes(
    boxes: Sequence[tuple[Sequence[float], Sequence[float]]],
) -> tuple[float, np.ndarray, np.ndarray]:
    """Return volume, center and moments about it of boxes that do not overlap, for unit density."""
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for lower, upper in boxes:
        a, b = np.array(lower, float), np.array(upper, float)
        V, middle = float(np.prod(b - a)), (a + b) / 2
        volume += V
        first += V * middle
        second += V * (np.outer(middle, middle) + np.diag((b - a) ** 2 / 12))
    center = first / volume
    about = second - volume * np.outer(center, center)
    return volume, center, np.trace(about) * np.eye(3) - about


def ascii_stl(mesh: dict[str, Any]) -> str:
    """Return a mesh as text of an STL file, whose numbers keep all digits."""
    points = mesh["points"]
    lines = ["solid part"]
    for triangle in mesh["triangles"]:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(map(repr, points[k])) for k in triangle]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid part", ""])
