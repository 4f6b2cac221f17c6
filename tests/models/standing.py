# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that rest, roll or slide on others, in any orientation of the whole scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from mechanisms import Array
from scipy.spatial.transform import Rotation

SceneData = dict[str, Any]
G = 9.81  # m/s2
UNTURNED = Rotation.identity()
TURNED = Rotation.from_rotvec([0.7, -0.4, 1.1])  # rad


def quaternion(turn: Rotation) -> list[float]:
    """Return x, y, z and the scalar part last, as in start values of joints."""
    return [float(x) for x in turn.as_quat()]


def ground(turn: Rotation, shapes: Mapping[str, Mapping[str, Any]]) -> SceneData:
    """Return the shapes of the ground, turned; their `position` [m] and `turn` are those before."""
    out = {}
    for name, shape in shapes.items():
        fields = {"surface": "floor", **shape}
        at = np.array(fields.pop("position", (0, 0, 0)), float)
        own = fields.pop("turn", UNTURNED)
        if "plane" in fields:
            fields["plane"] = [float(x) for x in turn.apply(fields["plane"])]
            fields["position"] = [float(x) for x in turn.apply(at)]
        else:
            vector = (turn * own).as_rotvec()
            angle = float(np.linalg.norm(vector))
            fields["position"] = [float(x) for x in turn.apply(at)]
            if angle > 0:
                fields["rotation"] = {"axis": [float(x) for x in vector / angle], "angle": angle}
        out[name] = fields
    return {"shapes": out}


def free_body(
    shape: Mapping[str, Any],
    mass: float,
    moments: Sequence[float],
    at: Sequence[float],
    *,
    turn: Rotation = UNTURNED,
    own: Rotation = UNTURNED,
    com: Sequence[float] = (0, 0, 0),
    v: Sequence[float] = (0, 0, 0),
    w: Sequence[float] = (0, 0, 0),
    friction: float | Mapping[str, Any] = 1.0,
    on: Mapping[str, Mapping[str, Any]] | None = None,
    gravity: Sequence[float] = (0, 0, -G),
    forces: Mapping[str, Any] | None = None,
) -> SceneData:
    """Return a free body (joint J) that touches the ground, with an input force `push` at its frame's origin.

    Args:
        shape: its shape, about the frame of the body.
        mass: kg.
        moments: about axes through the center of mass [kg m2].
        at: position of its frame [m].
        turn: of the whole scene.
        own: the body's own rotation before that.
        com: center of mass in the body [m].
        v: velocity of the frame's origin [m/s], in the scene before it is turned.
        w: angular velocity in the body [rad/s].
        friction: coefficient, or all fields of the contact `floor`.
        on: shapes of the ground; a horizontal plane by default.
        gravity: m/s2.
        forces: other forces.
    """
    law = friction if isinstance(friction, Mapping) else {"friction": friction}
    on = on or {"plane": {"plane": [0, 0, 1]}}
    x = turn.apply(np.array(at, float))
    return {
        "gelenk": 1,
        "gravity": [float(a) for a in turn.apply(np.array(gravity, float))],
        "bodies": {
            "body": {
                "mass": mass,
                "com": list(com),
                "inertia": list(moments),
                "shapes": {"shape": {**shape, "surface": "wood"}},
            }
        },
        "ground": ground(turn, on),
        "joints": {
            "J": {
                "type": "free", "parent": "ground", "child": "body",
                "start": {
                    "r": [float(a) for a in x], "Q": quaternion(turn * own),
                    "v": [float(a) for a in turn.apply(np.array(v, float))],
                    "w": list(w), "fixed": True,
                },
            }
        },
        "forces": {
            "push": {"type": "wrench", "body": "body", "frame": "world", "input": True},
            **(forces or {}),
        },
        "contacts": {"floor": {"between": ["wood", "floor"], **law}},
    }  # fmt: skip


def poles(A: Array) -> Array:
    """Return the eigenvalues in ascending order of their real and imaginary parts."""
    found = np.linalg.eigvals(A)
    return np.asarray(found[np.lexsort((np.round(found.imag, 9), np.round(found.real, 9)))])
