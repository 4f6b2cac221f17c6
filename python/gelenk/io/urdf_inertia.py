# SPDX-License-Identifier: BSD-3-Clause
"""Physically impossible inertias, and their replacement by the nearest possible ones."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import SceneError
from gelenk.model.scene import Scene, from_dict

# : Smallest second moment of a repaired body relative to its largest, so that no motion is without inertia;
# also mass : and moments of a part without inertia relative to those of its carrier.
MIN_INERTIA_RATIO = 1e-6
#: Smallest radius of gyration of a part without inertia [m].
MIN_RADIUS_OF_GYRATION = 0.01

_FAULT = re.compile(r"bodies\.(\w+)\.inertia: .*; no rigid body has such moments")


def nearest_inertia(inertia: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the physically possible inertia nearest to a given one.

    The matrix of second moments of a rigid body, ∫ x xᵀ dm = tr(I)/2 E − I, is positive semidefinite, and
    every such matrix belongs to some body (Wensing, Kim & Slotine 2018). Negative eigenvalues are raised to
    `MIN_INERTIA_RATIO` of the largest; mass and center of mass are unchanged. No other change is smaller in
    the Frobenius norm of the second moments.

    Args:
        inertia: symmetric 3x3 matrix about the center of mass [kg m2].

    Returns:
        NDArray: symmetric 3x3 matrix [kg m2]; zero if no second moment is positive.
    """
    second, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    kept = np.maximum(second, MIN_INERTIA_RATIO * max(second.max(), 0.0))
    S = axes @ np.diag(kept) @ axes.T
    S = (S + S.T) / 2
    return np.asarray(np.trace(S) * np.eye(3) - S)


def impossible_inertias(error: SceneError) -> list[str]:
    """Return the names of the bodies that an error reports for impossible moments of inertia."""
    return [match[1] for line in error.lines if (match := _FAULT.search(line))]


def repaired(scene: Mapping[str, Any], file: str, notes: Iterable[str]) -> Scene:
    """Create a scene with the nearest possible inertias; its report states the changes.

    Raises:
        SceneError: the scene is invalid for other reasons.
    """
    notes = list(notes)
    data = {**scene, "bodies": {name: dict(body) for name, body in scene["bodies"].items()}}
    for name, carrier in _moves_without_inertia(data):
        notes.append(_give(data["bodies"], name, carrier))
    try:
        return from_dict(data, file, notes)
    except SceneError as e:
        found = impossible_inertias(e)
    for name in found:
        notes.append(f"link {name}: " + _repair(data["bodies"][name]))
    return from_dict(data, file, notes)


def notes_on_missing(scene: Mapping[str, Any]) -> list[str]:
    """Return a note on each movable body without inertia, with which a scene cannot be simulated."""
    return [
        f"link {name}: can move, but neither it nor what it carries has mass or inertia, so that the scene "
        "cannot be simulated; --repair-inertia (repair_inertia=True) gives it "
        f"{MIN_INERTIA_RATIO:g} of those of {carrier}"
        for name, carrier in _moves_without_inertia(scene)
    ]


def _repair(body: dict[str, Any]) -> str:
    given = matrix(body["inertia"])
    nearest = nearest_inertia(given)
    body["inertia"] = entries(nearest)
    second = [np.trace(J) / 2 * np.eye(3) - J for J in (given, nearest)]
    ratio = np.linalg.norm(second[1] - second[0]) / np.linalg.norm(second[0])
    before, after = (", ".join(f"{x:.4g}" for x in np.linalg.eigvalsh(J)) for J in (given, nearest))
    return (
        f"no rigid body has its principal moments {before} kg m2; replaced by the nearest possible ones, "
        f"{after}: the second moments change by {100 * ratio:.2g} %"
    )


def _give(bodies: dict[str, Any], name: str, carrier: str) -> str:
    of = bodies[carrier]
    mass = MIN_INERTIA_RATIO * of["mass"]
    largest = np.linalg.eigvalsh(matrix(of["inertia"])).max() if "inertia" in of else 0.0
    moment = max(MIN_INERTIA_RATIO * largest, mass * MIN_RADIUS_OF_GYRATION**2)
    bodies[name] |= {"mass": mass, "inertia": [moment] * 3 + [0.0] * 3}
    return (
        f"link {name}: can move, but neither it nor what it carries has mass or inertia; it gets "
        f"{MIN_INERTIA_RATIO:g} of those of {carrier}: {mass:.4g} kg, {moment:.4g} kg m2"
    )


def _moves_without_inertia(scene: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the movable bodies without inertia in themselves and their descendants.

    Each is paired with its nearest ancestor that has mass.
    """
    bodies = scene["bodies"]
    inward = {joint["child"]["body"]: joint["parent"]["body"] for joint in scene["joints"].values()}
    moved = {joint["child"]["body"] for joint in scene["joints"].values() if joint["type"] != "weld"}

    def ancestors(name: str) -> Iterator[str]:
        while name in bodies:
            yield name
            name = inward[name]

    carries: set[str] = set()
    for name, body in bodies.items():
        if body["mass"] or any(body.get("inertia", ())):
            carries.update(ancestors(name))
    carriers = {name: next((n for n in ancestors(name) if bodies[n]["mass"]), None) for name in bodies}
    return [(name, of) for name, of in carriers.items() if of is not None and name in moved - carries]


def matrix(inertia: Iterable[float]) -> NDArray[np.float64]:
    """Return the symmetric matrix with the entries [xx, yy, zz, xy, xz, yz]."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def entries(J: NDArray[np.float64]) -> list[float]:
    """Return the entries [xx, yy, zz, xy, xz, yz] of a symmetric matrix, without negative zeros."""
    return [float(x) + 0.0 for x in (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])]
