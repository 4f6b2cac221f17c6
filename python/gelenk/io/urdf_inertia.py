# SPDX-License-Identifier: BSD-3-Clause
"""Inertias that no rigid body has, and the nearest that one may have."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import SceneError
from gelenk.model.scene import Scene, from_dict

#: Of the largest second moment: the least that a repaired body has along any axis, so that no motion is
#: without inertia. Of its carrier's mass and moments: what a part without any is given.
LEAST_SHARE = 1e-6
#: m: radius of gyration of what stands for a part without extent.
LEAST_RADIUS = 0.01

_FAULT = re.compile(r"bodies\.(\w+)\.inertia: .*; no rigid body has such moments")


def nearest_inertia(inertia: NDArray[np.float64]) -> NDArray[np.float64]:
    """The physical inertia nearest to one that need not be.

    A rigid body's second moments ∫ x xᵀ dm = tr(I)/2 E − I are positive semidefinite, and any that are so
    belong to some body (Wensing, Kim & Slotine 2018). Negative ones are raised to `LEAST_SHARE` of the
    largest, mass and centre of mass kept: no other change is smaller in the Frobenius norm of the second
    moments.

    Args:
        inertia: symmetric 3x3 matrix about the centre of mass [kg m2].

    Returns:
        NDArray: likewise; zeros where no second moment is positive.
    """
    second, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    kept = np.maximum(second, LEAST_SHARE * max(second.max(), 0.0))
    S = axes @ np.diag(kept) @ axes.T
    S = (S + S.T) / 2
    return np.asarray(np.trace(S) * np.eye(3) - S)


def impossible_inertias(error: SceneError) -> list[str]:
    """The bodies that are refused for their moments."""
    return [match[1] for line in error.lines if (match := _FAULT.search(line))]


def repaired(scene: Mapping[str, Any], file: str, notes: Iterable[str]) -> Scene:
    """The scene, with the nearest physical inertias where those given are none; its report says by how much.

    Raises:
        SceneError: what else is wrong with it.
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


def _repair(body: dict[str, Any]) -> str:
    given = matrix(body["inertia"])
    nearest = nearest_inertia(given)
    body["inertia"] = entries(nearest)
    second = [np.trace(J) / 2 * np.eye(3) - J for J in (given, nearest)]
    share = np.linalg.norm(second[1] - second[0]) / np.linalg.norm(second[0])
    before, after = (", ".join(f"{x:.4g}" for x in np.linalg.eigvalsh(J)) for J in (given, nearest))
    return (
        f"no rigid body has its principal moments {before} kg m2; the nearest, {after}, are taken: "
        f"its second moments are changed by {100 * share:.2g} %"
    )


def _give(bodies: dict[str, Any], name: str, carrier: str) -> str:
    of = bodies[carrier]
    mass = LEAST_SHARE * of["mass"]
    largest = np.linalg.eigvalsh(matrix(of["inertia"])).max() if "inertia" in of else 0.0
    moment = max(LEAST_SHARE * largest, mass * LEAST_RADIUS**2)
    bodies[name] |= {"mass": mass, "inertia": [moment] * 3 + [0.0] * 3}
    return (
        f"link {name}: moves and has neither mass nor inertia, nor has what it carries; "
        f"{LEAST_SHARE:g} of those of {carrier} are taken: {mass:.4g} kg, {moment:.4g} kg m2"
    )


def _moves_without_inertia(scene: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Bodies of a tree that a joint moves while nothing from there outwards has inertia.

    With each the nearest inwards that has mass.
    """
    bodies = scene["bodies"]
    inward = {joint["child"]["body"]: joint["parent"]["body"] for joint in scene["joints"].values()}
    moved = {joint["child"]["body"] for joint in scene["joints"].values() if joint["type"] != "weld"}

    def way(name: str) -> Iterator[str]:
        while name in bodies:
            yield name
            name = inward[name]

    carries: set[str] = set()
    for name, body in bodies.items():
        if body["mass"] or any(body.get("inertia", ())):
            carries.update(way(name))
    carriers = {name: next((n for n in way(name) if bodies[n]["mass"]), None) for name in bodies}
    return [(name, of) for name, of in carriers.items() if of is not None and name in moved - carries]


def matrix(inertia: Iterable[float]) -> NDArray[np.float64]:
    """[xx, yy, zz, xy, xz, yz] as a symmetric matrix."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def entries(J: NDArray[np.float64]) -> list[float]:
    """[xx, yy, zz, xy, xz, yz] of a symmetric matrix; no minus zeros."""
    return [float(x) + 0.0 for x in (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])]
