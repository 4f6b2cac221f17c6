# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the joint laws share: cases over the whole registry, and awkward coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk._core import joints

Array = NDArray[np.float64]

EPS = float(np.finfo(float).eps)
# Central differences with h = eps^(1/3) err by h^2 (third derivatives, up to some units here) and eps/h:
# both eps^(2/3) = 4e-11; ten times that is the bound, per unit of scale.
STEP = EPS ** (1 / 3)
QUOTIENT = 10 * EPS ** (2 / 3)
# A chain of some ten products and sums of numbers of the scale: 50 eps.
ROUND_OFF = 50 * EPS


@dataclass(frozen=True)
class Case:
    """A kind of joint in one algebra, with axes as a user would give them."""

    kind: dict[str, Any]
    axes: tuple[tuple[float, float, float], ...]
    planar: bool

    def __str__(self) -> str:
        return f"{self.kind['name']}-{'planar' if self.planar else 'spatial'}"

    def unit_axes(self) -> list[Array]:
        return [np.array(axis) / np.linalg.norm(axis) for axis in self.axes]

    def joint(self) -> Any:
        return joints.Joint(self.kind["name"], self.unit_axes(), self.planar, self.numbers)

    @property
    def numbers(self) -> dict[str, float]:
        """A general value of each of its fields."""
        names: list[str] = []
        for field in self.kind["fields"]:
            inner = [
                f"{field['name']}.{each['name']}" for each in field["fields"] if each["type"] == "number"
            ]
            names += inner if field["type"] == "group" else [field["name"]]
        return {name: 0.37 + 0.1 * k for k, name in enumerate(names)}

    @property
    def directions(self) -> list[int]:
        """Which of the six directions the algebra knows."""
        return [2, 3, 4] if self.planar else [0, 1, 2, 3, 4, 5]


def all_cases() -> list[Case]:
    some_axes = ((0.3, -0.5, 0.8), (-0.6, 0.7, 0.25))  # neither along z nor at right angles
    found = []
    for kind in joints.kinds():
        axes = some_axes[: kind["axes"]]
        found.append(Case(kind, axes, planar=False))
        if kind["planar"] != "never":
            found.append(Case(kind, axes, planar=True))
    return found


def coordinates(case: Case) -> list[Array]:
    """Random q, and the ones that break naive formulas: 0, pi, negative, many turns, Q and -Q."""
    rng = np.random.default_rng(20261121)
    nq = case.kind["nq"]
    plain = [np.zeros(nq), np.full(nq, np.pi), np.full(nq, -np.pi / 2), np.full(nq, -0.7), np.full(nq, 1e-9)]
    plain += [np.full(nq, 40.3 * np.pi), np.full(nq, -200.25 * np.pi), np.full(nq, 1e-4)]
    plain += [rng.uniform(-4, 4, nq) for _ in range(12)]
    if not case.kind["quaternion"]:
        return plain if nq else [np.zeros(0)]
    turns: list[list[float]] = [[0, 0, 0, 1], [0, 0, 0, -1], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0]]
    turns += [[0.6, 0, -0.8, 0], [1e-9, 0, 0, 1], [0, 1e-4, 0, -1], [1, 0, 0, 1e-9]]
    turns += [list(rng.normal(size=4)) for _ in range(len(plain) - len(turns))]
    out = []
    for q, Q in zip(plain, turns, strict=True):
        out.append(np.concatenate([q[: nq - 4], np.array(Q) / np.linalg.norm(Q)]))
    return out


def kinds() -> list[dict[str, Any]]:
    """The registry: every kind's name, sizes and names of quantities."""
    return list(joints.kinds())


def skew(a: Array) -> Array:
    """K with K b = a x b."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def unskew(K: Array) -> Array:
    return 0.5 * np.array([K[2, 1] - K[1, 2], K[0, 2] - K[2, 0], K[1, 0] - K[0, 1]])


def inverse(X: Array) -> Array:
    out = np.eye(4)
    out[:3, :3] = X[:3, :3].T
    out[:3, 3] = -X[:3, :3].T @ X[:3, 3]
    return out


def rotated(R: Array) -> Array:
    """The pose with that rotation alone."""
    out = np.eye(4)
    out[:3, :3] = R
    return out


def written_in_F(X_FM: Array, V_M: Array) -> Array:
    """(angular velocity, rate of p_FM) in F, from V_FM written in M."""
    return np.concatenate([X_FM[:3, :3] @ V_M[:3], X_FM[:3, :3] @ V_M[3:]])


def moved(X_FM: Array, V_F: Array, dt: float) -> Array:
    """X_FM after a short time dt at V_F = (angular velocity, rate of p), both written in F."""
    turn = V_F[:3] * dt
    angle = float(np.linalg.norm(turn))
    out = X_FM.copy()
    if angle > 0:
        K = skew(turn / angle)
        out[:3, :3] = (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K) @ X_FM[:3, :3]
    out[:3, 3] = X_FM[:3, 3] + V_F[3:] * dt
    return out


def motion_space(joint: Any, q: Array) -> Array:
    """S(q), 6 x nv, written in M."""
    columns = [joint.V_FM(q, unit) for unit in np.eye(joint.nv)]
    return np.array(columns).T.reshape(6, joint.nv)


def quotient(function: Any, q: Array, qdot: Array) -> Array:
    """D function(q) / dt by central differences, coordinate by coordinate.

    Each is divided by the step that was really made, q + h being rounded: with many turns in q
    the rounding would otherwise be the largest error.
    """
    total: Array = np.zeros_like(function(q))
    for i in range(len(q)):
        up, down = q.copy(), q.copy()
        up[i] += STEP
        down[i] -= STEP
        total = total + qdot[i] * (function(up) - function(down)) / (up[i] - down[i])
    return total
