# SPDX-License-Identifier: BSD-3-Clause
"""A description of mechanisms for all engines: a tree of hinges and slides, and loop closures at points."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

type Array = npt.NDArray[np.float64]


@dataclass
class Body:
    """A body and the joint that carries it; the frames of both coincide when the joint coordinate is 0.

    Force along the joint: tau + amplitude sin(omega t + phase) - damping v - stiffness (q - reference).
    """

    name: str
    parent: int  # -1: the ground
    slides: bool
    axis: Sequence[float]  # unit vector in the joint's frame
    position: Sequence[float]  # of the joint in the parent [m]
    mass: float
    com: Sequence[float]
    inertia: Any  # 3 x 3 about com, in the body's axes
    rotation: Any = None  # of the joint's frame in the parent; None: none
    q: float = 0.0
    v: float = 0.0
    tau: float = 0.0
    amplitude: float = 0.0
    omega: float = 0.0
    phase: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0
    reference: float = 0.0

    @property
    def driven(self) -> bool:
        """Whether the joint has a motor."""
        return self.tau != 0 or self.amplitude != 0

    @property
    def R(self) -> Array:
        """Rotation of the joint's frame in the parent."""
        return np.eye(3) if self.rotation is None else np.asarray(self.rotation, float)


@dataclass
class Closure:
    """Points of two bodies coincide in the directions `rows`, the axes of the second body."""

    first: int
    at_first: Sequence[float]
    second: int  # -1: the ground
    at_second: Sequence[float]
    rows: str  # of "xyz"


@dataclass
class Spring:
    """A spring and a damper in parallel between points of two bodies."""

    first: int
    at_first: Sequence[float]
    second: int  # -1: the ground
    at_second: Sequence[float]
    stiffness: float
    damping: float
    length: float


@dataclass
class Tree:
    """A mechanism, the duration of its run and the sampling interval."""

    name: str
    stop: float  # s
    sample: float  # s
    gravity: Sequence[float] = (0.0, -9.81, 0.0)
    bodies: list[Body] = field(default_factory=list)
    closures: list[Closure] = field(default_factory=list)
    springs: list[Spring] = field(default_factory=list)

    def add(self, body: Body) -> int:
        """Add a body and return its index."""
        self.bodies.append(body)
        return len(self.bodies) - 1

    def torque(self, i: int, t: float) -> float:
        """Return the torque or force of the motor of body i at time t [s]."""
        b = self.bodies[i]
        return float(b.tau + b.amplitude * np.sin(b.omega * t + b.phase))


# --- as a scene of Gelenk ---


def _frame(tree: Tree, body: int, position: Sequence[float], rotation: Any = None) -> dict[str, Any]:
    frame: dict[str, Any] = {
        "body": "ground" if body < 0 else tree.bodies[body].name,
        "position": [float(x) for x in position],
    }
    if rotation is not None:
        frame["rotation"] = {"matrix": np.asarray(rotation, float).tolist()}
    return frame


def _joint(tree: Tree, body: Body) -> dict[str, Any]:
    q, v = ("s", "v") if body.slides else ("phi", "w")
    joint: dict[str, Any] = {
        "type": "prismatic" if body.slides else "revolute",
        "axis": [float(x) for x in body.axis],
        "parent": _frame(tree, body.parent, body.position, body.rotation),
        "child": body.name,
        "start": {q: body.q, v: body.v, "fixed": not tree.closures},
    }
    if body.damping:
        joint["damping"] = body.damping
    if body.stiffness:
        joint |= {"stiffness": body.stiffness, "spring_reference": body.reference}
    return joint


def _closing_joint(tree: Tree, closures: Sequence[Closure]) -> dict[str, Any]:
    """Return one joint for the closures of a pair of bodies: a ball joint, a planar hinge, or a hinge about
    the line through two points.
    """
    first, rows = closures[0], [c.rows for c in closures]
    ends = {
        "parent": _frame(tree, first.second, first.at_second),
        "child": _frame(tree, first.first, first.at_first),
    }
    if rows == ["xy"]:
        return {"type": "revolute", "axis": [0, 0, 1], **ends}
    if rows == ["xyz"]:
        return {"type": "spherical", **ends}
    if rows == ["xyz", "yz"]:
        return {"type": "revolute", "axis": [1, 0, 0], **ends}
    raise ValueError(f"{tree.name}: there is no joint for the constraint directions {rows}")


def _pairs(closures: Iterable[Closure]) -> list[list[Closure]]:
    pairs: dict[tuple[int, int], list[Closure]] = {}
    for closure in closures:
        pairs.setdefault((closure.first, closure.second), []).append(closure)
    return list(pairs.values())


def to_scene(tree: Tree) -> dict[str, Any]:
    """Return the mechanism in the scene format; joint j_NAME carries body NAME, motor m_NAME drives it."""
    bodies, joints = {}, {}
    for b in tree.bodies:
        I = np.asarray(b.inertia, float)  # noqa: E741 (inertia)
        moments = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
        bodies[b.name] = {
            "mass": float(b.mass),
            "com": [float(x) for x in b.com],
            "inertia": [float(x) for x in moments],
        }
        joints[f"j_{b.name}"] = _joint(tree, b)
    for k, pair in enumerate(_pairs(tree.closures)):
        joints[f"closing{k}"] = _closing_joint(tree, pair)
    scene: dict[str, Any] = {
        "gelenk": 1,
        "name": tree.name,
        "gravity": [float(x) for x in tree.gravity],
        "bodies": bodies,
        "joints": joints,
        "experiment": {"stop": tree.stop, "step": tree.sample, "tolerance": 1e-6},
    }
    motors = {f"m_{b.name}": {"joint": f"j_{b.name}"} for b in tree.bodies if b.driven}
    springs = {
        f"spring{k}": {
            "type": "spring_damper",
            "from": _frame(tree, s.second, s.at_second),
            "to": _frame(tree, s.first, s.at_first),
            "stiffness": s.stiffness,
            "damping": s.damping,
            "length": s.length,
        }
        for k, s in enumerate(tree.springs)
    }
    if motors:
        scene["motors"] = motors
    if springs:
        scene["forces"] = springs
    return scene


# --- as plain numbers, for programs without a JSON parser ---


def _words(*parts: Any) -> str:
    flat: list[str] = []
    for part in parts:
        flat += [repr(float(x)) for x in np.asarray(part, float).reshape(-1)]
    return " ".join(flat)


def to_text(tree: Tree) -> str:
    """Return the text that benchmarks/speed/tree_file.h reads: a line for each body, closure and spring."""
    lines = [
        f"{tree.name} {len(tree.bodies)} {len(tree.closures)} {len(tree.springs)} "
        + _words(tree.stop, tree.sample, tree.gravity)
    ]
    for b in tree.bodies:
        numbers = _words(
            b.axis, b.position, b.R, b.mass, b.com, b.inertia, b.q, b.v, b.tau, b.amplitude, b.omega, b.phase,
            b.damping, b.stiffness, b.reference,
        )  # fmt: skip
        lines.append(f"{b.name} {b.parent} {int(b.slides)} {numbers}")
    lines += [f"{c.first} {c.second} {c.rows} {_words(c.at_first, c.at_second)}" for c in tree.closures]
    lines += [
        f"{s.first} {s.second} {_words(s.at_first, s.at_second, s.stiffness, s.damping, s.length)}"
        for s in tree.springs
    ]
    return "\n".join(lines) + "\n"
