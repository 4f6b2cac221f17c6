# SPDX-License-Identifier: BSD-3-Clause
"""Forces and torques that act in a recorded run: those of springs, loads, motors and joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.model.skeleton import GROUND, Data, axis_of, frame_rotation, point, turned
from gelenk.simulation.touching import contact_arrows
from gelenk.viewer.arrows import Arrow

type Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """The motion of the bodies of a scene.

    Attributes:
        scene: the scene as plain data.
        poses: of the bodies in the world: positions [m] and quaternions (x, y, z, w), shape (frames, bodies,
            7).
        velocities: of the bodies' frames: velocity in the world [m/s], angular velocity in the body frame
            [rad/s], shape (frames, bodies, 6).
        signals: inputs and outputs over time, by name; inputs that are not in it are 0.
    """

    scene: Data
    poses: Array
    velocities: Array
    signals: Mapping[str, Array]

    def vector(self, body: str, v: Array) -> Array:
        """Return vectors that are resolved in the frame of a body in the world, shape (frames, 3)."""
        v = np.broadcast_to(v, (len(self.poses), 3))
        return v if body == GROUND else turned(self._pose(body), v)

    def in_body(self, body: str, v: Array) -> Array:
        """Return vectors in the world in the frame of a body, shape (frames, 3)."""
        back = self._pose(body) * [1, 1, 1, -1, -1, -1, 1]
        return turned(back, v)

    def place(self, body: str, p: Array) -> Array:
        """Return a point of a body in the world [m], shape (frames, 3)."""
        moved = self.vector(body, p)
        return moved if body == GROUND else moved + self._pose(body)[:, :3]

    def velocity(self, body: str, p: Array) -> Array:
        """Return the velocity of a point of a body in the world [m/s], shape (frames, 3)."""
        if body == GROUND:
            return np.zeros((len(self.poses), 3))
        own = self.velocities[:, self._number(body)]
        out: Array = own[:, :3] + self.vector(body, np.cross(own[:, 3:], p))
        return out

    def signal(self, name: str) -> Array:
        """Return a signal, shape (frames,)."""
        return self.signals.get(name, np.zeros(len(self.poses)))

    def signal_vector(self, name: str) -> Array:
        """Return the signals NAME[1..3], shape (frames, 3)."""
        return np.column_stack([self.signal(f"{name}[{k}]") for k in (1, 2, 3)])

    def _number(self, body: str) -> int:
        return [*self.scene["bodies"]].index(body)

    def _pose(self, body: str) -> Array:
        out: Array = self.poses[:, self._number(body)]
        return out


def arrows_of(motion: Motion, reactions: Mapping[str, str]) -> list[Arrow]:
    """Return forces and torques that are not 0 during the whole run.

    Args:
        motion: the motion of the scene.
        reactions: joints by the names of the sensors of their reactions, whose signals the motion contains.
    """
    found: list[Arrow] = []
    for name, force in motion.scene.get("forces", {}).items():
        # What an element is can be seen from its fields.
        if {"from", "to", "length"} <= {*force}:
            found += _pull(motion, name, force)
        elif {"body", "force", "torque"} <= {*force}:
            found += _load(motion, name, force)
        elif {"body", "position", "coefficient"} <= {*force}:
            found.append(_drag(motion, name, force))
    for name, motor in motion.scene.get("motors", {}).items():
        found += _drive(motion, name, motor)
    found += contact_arrows(motion)
    for sensor, joint in reactions.items():
        found += _reaction(motion, sensor, joint)
    return [arrow for arrow in found if np.nan_to_num(arrow.vectors).any()]


def _pull(motion: Motion, name: str, force: Data) -> Iterator[Arrow]:
    """Yield the forces of a spring and damper on the bodies at both ends."""
    (a, p), (b, q) = point(force["from"]), point(force["to"])
    between = motion.place(b, q) - motion.place(a, p)
    length = np.linalg.norm(between, axis=1, keepdims=True)
    along = np.divide(between, length, out=np.zeros_like(between), where=length > 0)
    rate = np.einsum("ij,ij->i", motion.velocity(b, q) - motion.velocity(a, p), along)[:, None]
    pull = (force["stiffness"] * (length - force["length"]) + force["damping"] * rate) * along
    if a != GROUND:
        yield Arrow(name, "load", "N", a, p, pull)
    if b != GROUND:
        yield Arrow(name, "load", "N", b, q, -pull)


def _load(motion: Motion, name: str, force: Data) -> Iterator[Arrow]:
    """Yield the force and the torque of a load."""
    body, p = point(force)
    for unit, key, letter in (("N", "force", "f"), ("N.m", "torque", "t")):
        vectors = np.array(force[key], float) + motion.signal_vector(f"{name}.{letter}")
        if force["frame"] != "world":
            vectors = motion.vector(body, vectors @ frame_rotation(force).T)
        yield Arrow(name, "load", unit, body, p, vectors)  # type: ignore[arg-type]


def _drag(motion: Motion, name: str, force: Data) -> Arrow:
    body, p = point(force)
    v = motion.velocity(body, p)
    speed = np.linalg.norm(v, axis=1, keepdims=True)
    return Arrow(name, "load", "N", body, p, -(force["damping"] + force["coefficient"] * speed) * v)


def _drive(motion: Motion, name: str, motor: Data) -> Iterator[Arrow]:
    """Yield the torque, or the force, of a motor on the child body of its joint."""
    joint = motion.scene["joints"][motor["joint"]]
    parent, child = point(joint["parent"])[0], point(joint["child"])
    axis = motion.vector(parent, axis_of(joint))
    for unit, letter in (("N.m", "tau"), ("N", "f")):
        value = motor["gear_ratio"] * motion.signal(f"{name}.{letter}")
        yield Arrow(name, "load", unit, *child, value[:, None] * axis)  # type: ignore[arg-type]


def _reaction(motion: Motion, sensor: str, name: str) -> Iterator[Arrow]:
    """Yield the force and the torque of a joint on its child body, which sensors resolve in its frame F."""
    joint: Mapping[str, Any] = motion.scene["joints"][name]
    R = frame_rotation(joint["parent"])
    child = point(joint["child"])
    for unit, letter in (("N", "f"), ("N.m", "t")):
        vectors = motion.vector(point(joint["parent"])[0], motion.signal_vector(f"{sensor}.{letter}") @ R.T)
        yield Arrow(name, "reaction", unit, *child, vectors)  # type: ignore[arg-type]
