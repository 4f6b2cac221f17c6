# SPDX-License-Identifier: BSD-3-Clause
"""Contacts in a recorded run: their forces on bodies, and when they begin, end, stick and slide."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gelenk.model.skeleton import GROUND, Data, frame_rotation
from gelenk.viewer.arrows import Arrow

if TYPE_CHECKING:
    from gelenk.simulation.loads import Motion

type Array = NDArray[np.float64]

FLAT = 1e-3  # relative to the size of a shape: points this much lower are touched, too
MOST_CHANGES = 100  # of a contact; more marks would cover the time slider


def contact_arrows(motion: Motion) -> Iterator[Arrow]:
    """Yield the forces of contacts between two bodies, or a body and the ground.

    The outputs of a contact are sums over all pairs of its shapes: contacts with more bodies have no arrows.
    A force acts at the middle of the points of the body that are farthest in the direction of the other one.
    """
    for name, contact in motion.scene.get("contacts", {}).items():
        pair = _pair(motion.scene, contact["between"])
        if pair is None:
            continue
        (first, first_shapes), (second, second_shapes) = pair
        force = motion.signal_vector(f"{name}.f")
        for body, own, other, sign in (
            (first, first_shapes, second_shapes, 1.0),
            (second, second_shapes, first_shapes, -1.0),
        ):
            if body == GROUND:
                continue
            normal = _normal(other)
            towards = np.broadcast_to(-sign * force if normal is None else -normal, force.shape)
            points = _farthest(own, motion.in_body(body, towards))
            yield Arrow(name, "contact", "N", body, points, sign * force)


def contact_events(scene: Data, time: Array, signals: Mapping[str, Array]) -> list[tuple[float, str]]:
    """Return when contacts begin, end, stick and slide: times [s], and what happens.

    Args:
        scene: the scene as plain data.
        time: of the signals [s].
        signals: outputs by name; contacts without an output `mode` have no events.
    """
    found: list[tuple[float, str]] = []
    for name in scene.get("contacts", {}):
        if f"{name}.mode" not in signals:
            continue
        modes = np.asarray(signals[f"{name}.mode"]).round().astype(int)
        changes = [(k + 1, a, b) for k, (a, b) in enumerate(pairwise(modes.tolist())) if a != b]
        if len(changes) > MOST_CHANGES:
            continue
        for k, before, after in changes:
            what = (
                "opens" if after == 0 else "closes" if before == 0 else "sticks" if after == 1 else "slides"
            )
            found.append((float(time[k]), f"{name} {what}"))
    return sorted(found)


type _Owner = tuple[str, list[Data]]  # a body, or the ground, and its shapes that touch


def _pair(scene: Data, surfaces: Sequence[str]) -> tuple[_Owner, _Owner] | None:
    """Return the owners of the first and of the second surface, or None if there are more than two."""
    bodies = {**scene["bodies"], GROUND: scene.get("ground", {})}

    def owners(surface: str) -> list[_Owner]:
        rows = [
            (name, [s for s in body.get("shapes", {}).values() if s.get("surface") == surface])
            for name, body in bodies.items()
        ]
        return [row for row in rows if row[1]]

    one, other = owners(surfaces[0]), owners(surfaces[1])
    if surfaces[0] == surfaces[1]:
        return (one[0], one[1]) if len(one) == 2 else None
    return (one[0], other[0]) if len(one) == len(other) == 1 and one[0][0] != other[0][0] else None


def _normal(shapes: Sequence[Data]) -> Array | None:
    """Return the outward normal of a single half-space in the world, or None for other shapes."""
    if len(shapes) != 1 or "plane" not in shapes[0]:
        return None
    z: Array = frame_rotation(shapes[0])[:, 2]
    return z


def _farthest(shapes: Sequence[Data], directions: Array) -> Array:
    """Return the middles of the farthest points of shapes in directions in their body, shape (frames, 3)."""
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    d = np.divide(directions, length, out=np.zeros_like(directions), where=length > 0)
    found = []
    for shape in shapes:
        R, p = frame_rotation(shape), np.array(shape.get("position", (0, 0, 0)), float)
        found.append(p + _support(shape, d @ R) @ R.T)
    reach = np.array([np.einsum("ij,ij->i", points, d) for points in found])
    out: Array = np.array(found)[reach.argmax(axis=0), np.arange(len(d))]
    return out


def _support(shape: Data, d: Array) -> Array:
    """Return the middles of the farthest points of a shape in directions in its frame, shape (frames, 3)."""
    if "sphere" in shape:
        out: Array = float(shape["sphere"]) * d
    elif "capsule" in shape:
        radius, length = (shape["capsule"][key] for key in ("radius", "length"))
        ends = length / 2 * np.array([[0, 0, -1.0], [0, 0, 1.0]])
        out = _middles(ends, d, radius + length / 2) + radius * d
    elif "wheel" in shape:
        radius, crown = shape["wheel"]["radius"], shape["wheel"].get("crown", 0.0)
        across = np.linalg.norm(d[:, :2], axis=1, keepdims=True)
        rim = np.divide(d[:, :2], across, out=np.zeros_like(d[:, :2]), where=across > FLAT)
        out = np.column_stack([(radius - crown) * rim, np.zeros(len(d))]) + crown * d
    elif "cylinder" in shape:
        radius, length = (shape["cylinder"][key] for key in ("radius", "length"))
        across = np.linalg.norm(d[:, :2], axis=1, keepdims=True)
        rim = np.divide(d[:, :2], across, out=np.zeros_like(d[:, :2]), where=across > FLAT)
        ends = length / 2 * np.array([[0, 0, -1.0], [0, 0, 1.0]])
        out = _middles(ends, d, length) + np.column_stack([radius * rim, np.zeros(len(d))])
    elif "box" in shape:
        edges = np.array(shape["box"], float)
        corners = edges / 2 * [[(-1) ** (k >> i) for i in range(3)] for k in range(8)]
        out = _middles(corners, d, float(np.linalg.norm(edges)))
    else:
        points = np.array(shape["mesh"]["points"] if "mesh" in shape else shape["hull"], float)
        out = _middles(points, d, float(np.linalg.norm(np.ptp(points, axis=0))))
    return out


def _middles(points: Array, d: Array, size: float) -> Array:
    """Return the mean of the points that are farthest in each direction, up to FLAT of the size."""
    out = np.empty_like(d)
    for k, direction in enumerate(d):
        height = points @ direction
        out[k] = points[height >= height.max() - FLAT * size].mean(axis=0)
    return out
