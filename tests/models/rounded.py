# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms with redundant constraints, from closed forms, with numbers rounded to significant digits.

Each is a list of joints in the world at a closed position: (name, type, parent, child, point, axis or axes).
Body frames are random, so that all positions and rotations of the scene are numbers without symmetry.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mechanisms import Array, Scene, rotation

type Placed = tuple[str, str, str, str, Array, Any]

X, Y, Z = np.eye(3)
TILT = rotation([0.3, -0.7, 0.5], 0.77)
ORIGIN = np.array([0.11, 0.23, -0.17])


def _plane(*xy: float, z: float = 0.0) -> Array:
    return np.array([*xy, z])


def tilted(joints: Sequence[Placed]) -> list[Placed]:
    """The mechanism rotated and displaced, so that its plane is not aligned with the world axes."""

    def turned(axis: Any) -> Any:
        return tuple(TILT @ a for a in axis) if isinstance(axis, tuple) else TILT @ axis

    return [(n, t, a, b, TILT @ p + ORIGIN, turned(axis)) for n, t, a, b, p, axis in joints]


def circles(B: Array, r: float, D: Array, s: float, side: float = 1.0) -> Array:
    """Intersection of circles about B and D in the plane."""
    d = D - B
    length = float(np.linalg.norm(d))
    a = (r**2 - s**2 + length**2) / (2 * length)
    h = math.sqrt(r**2 - a**2)
    out: Array = B + a * d / length + side * h * np.array([-d[1], d[0]]) / length
    return out


def four_bar(phi: float = 1.1, ground: float = 0.6, crank: float = 0.21, coupler: float = 0.53,
             rocker: float = 0.43) -> list[Placed]:  # fmt: skip
    """A planar four-bar; its joint frames have different heights, as in a CAD drawing."""
    B = crank * np.array([math.cos(phi), math.sin(phi)])
    C = circles(B, coupler, np.array([ground, 0.0]), rocker)
    return [
        ("A", "revolute", "ground", "b1", _plane(0, 0), Z),
        ("B", "revolute", "b1", "b2", _plane(*B, z=0.03), Z),
        ("C", "revolute", "b2", "b3", _plane(*C, z=-0.02), Z),
        ("D", "revolute", "ground", "b3", _plane(ground, 0, z=0.05), Z),
    ]


def six_bar() -> list[Placed]:
    """Watt's six-bar, the second type: a four-bar whose rocker drives another one."""
    joints = four_bar()
    C, D = joints[2][4][:2], joints[3][4][:2]
    E = C + 0.2 * (C - D) / np.linalg.norm(C - D) + np.array([0.07, 0.02])
    F = circles(E, 0.45, np.array([1.0, 0.1]), 0.5)
    return [
        *joints,
        ("E", "revolute", "b3", "b4", _plane(*E, z=0.02), Z),
        ("F", "revolute", "b4", "b5", _plane(*F, z=0.01), Z),
        ("G", "revolute", "ground", "b5", _plane(1.0, 0.1, z=0.04), Z),
    ]


def slider_crank() -> list[Placed]:
    """Three revolute joints and one prismatic joint, in the plane."""
    B = 0.2 * np.array([math.cos(0.8), math.sin(0.8)])
    s = B[0] + math.sqrt(0.5**2 - (B[1] - 0.05) ** 2)
    return [
        ("A", "revolute", "ground", "b1", _plane(0, 0), Z),
        ("B", "revolute", "b1", "b2", _plane(*B, z=0.02), Z),
        ("C", "revolute", "b2", "b3", _plane(s, 0.05, z=0.02), Z),
        ("D", "prismatic", "ground", "b3", _plane(0.3, 0.05, z=0.01), X),
    ]


def spherical_four_bar() -> list[Placed]:
    """Four revolute joints whose axes meet in one point."""
    axes = [[0.1, 0.05, 1], [0.6, 0.3, 0.8], [0.2, 1.0, 0.5], [-0.7, 0.5, 0.9]]
    bodies = [("ground", "b1"), ("b1", "b2"), ("b2", "b3"), ("ground", "b3")]
    out: list[Placed] = []
    for name, (a, b), axis, r in zip("ABCD", bodies, axes, (0.4, 0.5, 0.45, 0.6), strict=True):
        n = np.array(axis) / np.linalg.norm(axis)
        out.append((name, "revolute", a, b, r * n + ORIGIN, n))
    return out


def three_cranks() -> list[Placed]:
    """A parallelogram with a third crank, which is redundant even in its plane."""
    r = 0.25 * np.array([math.cos(0.9), math.sin(0.9)])
    out: list[Placed] = []
    for i, b in enumerate(np.array([[0.0, 0.0], [0.4, 0.07], [0.9, -0.1]])):
        out.append((f"A{i}", "revolute", "ground", f"c{i}", _plane(*b, z=0.01 * i), Z))
        out.append((f"B{i}", "revolute", f"c{i}", "coupler", _plane(*(b + r), z=0.02 * i), Z))
    return out


def three_cranks_in_line() -> list[Placed]:
    """The same with all pivots on one line, at the change point."""
    r = np.array([0.25, 0.0])
    out: list[Placed] = []
    for i, b in enumerate(np.array([[0.0, 0.0], [0.4, 0.0], [0.9, 0.0]])):
        out.append((f"A{i}", "revolute", "ground", f"c{i}", _plane(*b), Z))
        out.append((f"B{i}", "revolute", f"c{i}", "coupler", _plane(*(b + r)), Z))
    return out


def double_parallelogram() -> list[Placed]:
    """One parallelogram on another: two degrees of freedom."""
    r = 0.25 * np.array([math.cos(0.9), math.sin(0.9)])
    s = 0.3 * np.array([math.cos(1.9), math.sin(1.9)])
    base = np.array([[0.0, 0.0], [0.4, 0.07]])
    on = base + r + np.array([[0.05, 0.02], [0.05, 0.02]])
    out: list[Placed] = []
    for i in range(2):
        out.append((f"A{i}", "revolute", "ground", f"c{i}", _plane(*base[i]), Z))
        out.append((f"B{i}", "revolute", f"c{i}", "middle", _plane(*(base[i] + r)), Z))
    for i in range(2):
        out.append((f"E{i}", "revolute", "middle", f"d{i}", _plane(*on[i]), Z))
        out.append((f"F{i}", "revolute", f"d{i}", "top", _plane(*(on[i] + s)), Z))
    return out


def sarrus() -> list[Placed]:
    """Two groups of three parallel revolute joints: the top moves vertically."""
    out: list[Placed] = []
    for names, bodies, angle in (("ABC", ("b1", "b2"), 0.0), ("DEF", ("b3", "b4"), 2.1)):
        outwards = np.array([math.cos(angle), math.sin(angle), 0])
        axis = np.cross(Z, outwards)
        foot = 0.4 * outwards
        points = [foot, foot + 0.3 * outwards + 0.35 * Z + 0.02 * axis, foot + 0.7 * Z - 0.03 * axis]
        chain = [("ground", bodies[0]), bodies, (bodies[1], "top")]
        out += [
            (name, "revolute", a, b, point, axis)
            for name, (a, b), point in zip(names, chain, points, strict=True)
        ]
    return out


def double_cardan() -> list[Placed]:
    """Two universal joints, with equal angles of the shaft between them to both
    others, yokes in one plane.
    """
    bend = 0.5
    u, v = (np.array([math.cos(k * bend), math.sin(k * bend), 0]) for k in (1, 2))
    across = np.cross(Z, u)
    return [
        ("A", "revolute", "ground", "b1", _plane(-0.3, 0), X),
        ("U", "universal", "b1", "b2", _plane(0, 0), (Z, across)),
        ("V", "universal", "b2", "b3", 0.6 * u, (across, Z)),
        ("D", "revolute", "ground", "b3", 0.6 * u + 0.3 * v, v),
    ]


def stewart() -> list[Placed]:
    """Six legs with a universal joint, a prismatic joint and a ball joint: no constraint is redundant."""
    out: list[Placed] = []
    for i in range(6):
        foot = np.array([*(0.5 * np.array([math.cos(a := 1.05 * i + 0.12 * (-1) ** i), math.sin(a)])), 0.0])
        head = np.array([*(0.3 * np.array([math.cos(b := 1.05 * i - 0.2 * (-1) ** i), math.sin(b)])), 0.6])
        n = (head - foot) / np.linalg.norm(head - foot)
        across = np.cross(Z, n) / np.linalg.norm(np.cross(Z, n))
        out.append((f"U{i}", "universal", "ground", f"l{i}", foot, (across, np.cross(n, across))))
        out.append((f"P{i}", "prismatic", f"l{i}", f"u{i}", (foot + head) / 2, n))
        out.append((f"S{i}", "spherical", f"u{i}", "platform", head, Z))
    return out


def _transform(R: Array, p: Any) -> Array:
    out = np.eye(4)
    out[:3, :3] = R
    out[:3, 3] = p
    return out


def ring(a: Sequence[float], alpha: Sequence[float], s: Sequence[float], theta: Any) -> list[Placed]:
    """Revolute joints in a closed loop by Denavit-Hartenberg lengths, twists and offsets,
    closed near the angles theta.

    Raises ValueError if the loop does not close.
    """
    n = len(a)
    angles = np.array(theta, float)

    def chain(t: Array) -> list[Array]:
        out = [np.eye(4)]
        for i in range(n):
            turn = _transform(rotation(Z, t[i]), [0, 0, s[i]])
            out.append(out[-1] @ turn @ _transform(rotation(X, alpha[i]), [a[i], 0, 0]))
        return out

    def gap(t: Array) -> Array:
        end = chain(t)[-1]
        R = end[:3, :3]
        skew = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
        return np.concatenate([end[:3, 3], skew, 0.3 * (np.diag(R) - 1)])

    h = 1e-6  # central differences: sufficient for Gauss-Newton steps, whose fixed point does not depend on
    # it
    for _ in range(300):
        J = np.array([(gap(angles + h * e) - gap(angles - h * e)) / (2 * h) for e in np.eye(n)[1:]]).T
        step = np.linalg.lstsq(J, -gap(angles), rcond=1e-7)[0]
        angles[1:] += step / max(1.0, float(np.abs(step).max()) / 0.3)
        if np.abs(step).max() < 1e-15:
            break
    if np.abs(gap(angles)).max() > 1e-13:
        raise ValueError("this ring does not close from here")
    poses = chain(angles)
    bodies = ["ground", *(f"b{i}" for i in range(1, n))]
    out: list[Placed] = [("A", "revolute", "ground", bodies[-1], poses[0][:3, 3], poses[0][:3, 2])]
    for i in range(1, n):
        out.append(("ABCDEF"[i], "revolute", bodies[i - 1], bodies[i], poses[i][:3, 3], poses[i][:3, 2]))
    return out


def _closed_ring(a: Sequence[float], alpha: Sequence[float], s: Sequence[float], seed: int,
                 symmetric: bool = False) -> list[Placed]:  # fmt: skip
    """Try random angles, the same ones each time, until the loop closes."""
    rng = np.random.default_rng(seed)
    while True:
        theta = rng.uniform(-2.5, 2.5, len(a) // 2 if symmetric else len(a))
        try:
            return ring(a, alpha, s, [*theta, *theta] if symmetric else theta)
        except ValueError:
            continue


@functools.cache
def bennett() -> list[Placed]:
    """Bennett (1903): opposite sides are equal, a / sin(alpha) is the same for both."""
    alpha, beta, a = 0.7, 1.3, 0.3
    b = a * math.sin(beta) / math.sin(alpha)
    return _closed_ring([a, b, a, b], [alpha, beta, alpha, beta], [0] * 4, seed=1)


@functools.cache
def goldberg() -> list[Placed]:
    """Goldberg's 5R (1943), the sum of two Bennett linkages with a common side."""
    alpha, beta, gamma, a = 0.7, 1.3, 0.5, 0.3
    b, c = (a * math.sin(x) / math.sin(alpha) for x in (beta, gamma))
    return _closed_ring([a, b, a, c, b + c], [alpha, beta, alpha, gamma, beta + gamma], [0] * 5, seed=2)


@functools.cache
def trihedral_bricard() -> list[Placed]:
    """Bricard (1927): right angles, no offsets, a1² + a3² + a5² = a2² + a4² + a6²."""
    a = [0.3, 0.4, 0.35, 0.45, 0.5]
    last = math.sqrt(a[0] ** 2 + a[2] ** 2 + a[4] ** 2 - a[1] ** 2 - a[3] ** 2)
    return _closed_ring([*a, last], [math.pi / 2, -math.pi / 2] * 3, [0] * 6, seed=1)


@functools.cache
def line_symmetric_bricard() -> list[Placed]:
    """Bricard (1927): opposite sides, twists and offsets are equal."""
    return _closed_ring(
        [0.3, 0.45, 0.37] * 2, [0.8, 1.3, -0.9] * 2, [0.1, -0.15, 0.2] * 2, seed=5, symmetric=True
    )


MECHANISMS: dict[str, Callable[[], list[Placed]]] = {
    "four_bar": lambda: tilted(four_bar()),
    "six_bar": lambda: tilted(six_bar()),
    "slider_crank": lambda: tilted(slider_crank()),
    "spherical_four_bar": spherical_four_bar,
    "three_cranks": lambda: tilted(three_cranks()),
    "double_parallelogram": lambda: tilted(double_parallelogram()),
    "sarrus": lambda: tilted(sarrus()),
    "double_cardan": lambda: tilted(double_cardan()),
    "stewart": lambda: tilted(stewart()),
    "bennett": bennett,
    "goldberg": goldberg,
    "trihedral_bricard": trihedral_bricard,
    "line_symmetric_bricard": line_symmetric_bricard,
}
DEGREES_OF_FREEDOM = dict.fromkeys(MECHANISMS, 1) | {"double_parallelogram": 2, "stewart": 6}


def rounded(x: float, digits: int | None) -> float:
    """Round to this number of significant digits; None: no rounding."""
    return float(x) if digits is None else float(f"{x:.{digits - 1}e}")


def _along(axis: Array) -> Array:
    """A rotation whose z column is the axis."""
    a = axis / np.linalg.norm(axis)
    x = np.cross(Y if abs(a[0]) > 0.7 else X, a)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(a, x), a])


def _rpy(R: Array) -> list[float]:
    return [
        math.atan2(R[2, 1], R[2, 2]),
        -math.asin(max(-1.0, min(1.0, R[2, 0]))),
        math.atan2(R[1, 0], R[0, 0]),
    ]


def scene(
    placed: Sequence[Placed],
    digits: int | None = None,
    seed: int = 3,
    fields: Scene | None = None,
    **sections: Any,
) -> Scene:
    """The scene with all its numbers rounded; joints are at zero in the given position.

    fields: additional fields of the joints, by name; sections: additional sections of the scene.
    """
    rng = np.random.default_rng(seed)

    def short(values: Any) -> list[float]:
        return [rounded(x, digits) for x in np.ravel(values)]

    points: dict[str, list[Array]] = {}
    for _, _, a, b, point, _ in placed:
        for body in (a, b):
            points.setdefault(body, []).append(point)
    poses = {"ground": np.eye(4)}
    bodies: Scene = {}
    for name, at in points.items():
        if name == "ground":
            continue
        R = rotation(rng.normal(size=3), rng.uniform(0.3, 2.5))
        poses[name] = _transform(R, at[0])
        middle = np.mean(at, axis=0)
        size = 0.1 + max(float(np.linalg.norm(p - middle)) for p in at)
        inertia = size**2 * np.array([0.3, 0.4, 0.35])
        bodies[name] = {"mass": 1.0, "com": short(R.T @ (middle - at[0])), "inertia": short(inertia)}
    data: Scene = {}
    for name, kind, a, b, point, axis in placed:
        data[name] = {"type": kind}
        if kind == "universal":  # its axes: x of F and y of M
            R = np.column_stack([*axis, np.cross(*axis)])
        else:
            R = _along(axis) @ rotation(Z, rng.uniform(0, 6))
        for half, body in (("parent", a), ("child", b)):
            pose = np.linalg.inv(poses[body]) @ _transform(R, point)
            rpy = short(_rpy(pose[:3, :3]))
            data[name][half] = {"body": body, "position": short(pose[:3, 3]), "rotation": {"rpy": rpy}}
    for name, more in (fields or {}).items():
        data[name].update(more)
    return {"gelenk": 1, "gravity": [0.3, -9.81, 0.7], "bodies": bodies, "joints": data, **sections}
