# SPDX-License-Identifier: BSD-3-Clause
"""Spatial loops generated at special positions: axes along the world axes, right angles, equal bars."""

from __future__ import annotations

import math

import numpy as np
from mechanisms import Array, rotation

from .planar import ROUND, angle, mass_of, pick
from .sketch import Sketch, displacement, snapped

CUBE = (0.0, 0.5, 1.0)
AXES = np.eye(3)
O = np.zeros(3)  # noqa: E741


def direction(rng: np.random.Generator) -> Array:
    """A world axis, a direction halfway between two of them, or an arbitrary one."""
    style = rng.random()
    if style < 0.6:
        return np.array(AXES[rng.integers(3)])
    if style < 0.8:
        i, j = rng.choice(3, 2, replace=False)
        out = AXES[i] + float(rng.choice([-1, 1])) * AXES[j]
    else:
        out = rng.normal(size=3)
    return np.asarray(out / np.linalg.norm(out))


def across(rng: np.random.Generator, a: Array) -> Array:
    """A unit vector perpendicular to a, along a world axis if possible."""
    for i in rng.permutation(3):
        if abs(AXES[i] @ a) < 1e-12:
            return np.array(AXES[i])
    out = np.cross(a, AXES[int(np.argmin(np.abs(a)))])
    return np.asarray(out / np.linalg.norm(out))


def spot(rng: np.random.Generator, *others: Array) -> Array:
    while True:
        p = np.array([pick(rng, CUBE) for _ in range(3)])
        if rng.random() < 0.1:
            p = p + rng.uniform(-0.2, 0.2, 3)
        if all(np.linalg.norm(p - q) > 0.1 for q in others):
            return p


def ball_or_cross(sketch: Sketch, rng: np.random.Generator, name: str, parent: str, child: str, p: Array,
                  along: Array) -> None:  # fmt: skip
    """A universal joint whose axes are perpendicular to the rod."""
    a = across(rng, along)
    b = np.cross(along, a)
    sketch.joint(name, "universal", parent, child, p, [a, b], q=coordinates(rng, 2, False))


def coordinates(rng: np.random.Generator, n: int, singular: bool = True) -> list[float]:
    """Coordinates of a joint at this position: zeros, right angles, arbitrary.
    Universal joints avoid gimbal lock.
    """
    del singular
    style = rng.integers(3)
    if style == 0:
        return [0.0] * n
    if style == 1:
        return [pick(rng, (0.0, math.pi / 2, math.pi, -math.pi / 2)) for _ in range(n)]
    return [float(x) for x in rng.uniform(-2, 2, n)]


def crank_rod(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Crank, rod on a universal and a ball joint, and a rocker, a slider or a collar: RUSR, RUSP, RUSC."""
    sketch = Sketch(natural)
    axis = direction(rng)
    P1 = pick(rng, ROUND) * across(rng, axis)
    P2 = spot(rng, P1)
    sketch.body("crank", O, P1, mass_of(rng))
    sketch.joint("A", "revolute", "ground", "crank", O, [axis], q=coordinates(rng, 1))
    sketch.body("rod", P1, P2, mass_of(rng))
    along = (P2 - P1) / np.linalg.norm(P2 - P1)
    other = direction(rng)
    sketch.body("last", P2 if rng.random() < 0.5 else spot(rng, P2), P2 + across(rng, other), mass_of(rng))
    if rng.random() < 0.5:
        ball_or_cross(sketch, rng, "B", "crank", "rod", P1, along)
        sketch.joint("C", "spherical", "rod", "last", P2, q=coordinates(rng, 3))
    else:
        sketch.joint("B", "spherical", "crank", "rod", P1, q=coordinates(rng, 3))
        ball_or_cross(sketch, rng, "C", "last", "rod", P2, along)
    kind = str(rng.choice(["revolute", "prismatic", "cylindrical"], p=[0.45, 0.45, 0.1]))
    foot = P2 if kind == "prismatic" else spot(rng, P2)
    sketch.joint(
        "D", kind, "ground", "last", foot, [other], q=coordinates(rng, 2 if kind == "cylindrical" else 1)
    )
    return sketch


def rod_on_balls(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """RSSR, RSSP with a massless rod, or one that can spin about its axis."""
    sketch = Sketch(natural)
    axis, other = direction(rng), direction(rng)
    P1 = pick(rng, ROUND) * across(rng, axis)
    P2 = spot(rng, P1)
    mass = 0.0 if rng.random() < 0.6 else mass_of(rng)
    sketch.body("crank", O, P1, mass_of(rng))
    sketch.joint("A", "revolute", "ground", "crank", O, [axis], q=coordinates(rng, 1))
    sketch.body("rod", P1, P2, mass)
    foot = P2 + pick(rng, ROUND) * across(rng, other)
    sketch.body("last", foot, P2, mass_of(rng))
    for name, parent, p in (("B", "crank", P1), ("C", "last", P2)):
        sketch.joint(name, "spherical", parent, "rod", p)
    kind = str(rng.choice(["revolute", "prismatic"]))
    sketch.joint("D", kind, "ground", "last", foot, [other], q=coordinates(rng, 1))
    return sketch


def bennett(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Bennett's linkage: four revolute joints in space, opposite bars equal, a / sin alpha = b / sin beta."""
    a, b = pick(rng, ROUND), pick(rng, ROUND)
    alpha = pick(rng, (math.pi / 2, math.pi / 3, math.pi / 6, 0.7))
    if b * math.sin(alpha) / a > 1:
        return None
    beta = math.asin(b * math.sin(alpha) / a) * float(rng.choice([1, -1]))
    if abs(alpha - beta) < 1e-9:
        return None
    # tan(theta1/2) tan(theta2/2) = sin((beta+alpha)/2) / sin((beta-alpha)/2)
    first = angle(rng)
    if abs(first) < 1e-9 or abs(abs(first) - math.pi) < 1e-9:
        second = math.pi - first
    else:
        k = math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2)
        second = 2 * math.atan(k / math.tan(first / 2))
    sketch = Sketch(natural)
    R, p = np.eye(3), np.zeros(3)
    places = []
    for theta, length, twist in (
        (first, a, alpha),
        (second, b, beta),
        (-first, a, alpha),
        (-second, b, beta),
    ):
        places.append((p, R[:, 2]))
        R = R @ rotation([0, 0, 1], theta)
        p = p + R @ np.array([length, 0, 0])
        R = R @ rotation([1, 0, 0], twist)
    if np.abs(p).max() > 1e-9 or np.abs(R - np.eye(3)).max() > 1e-9:
        return None
    before = "ground"
    for i in range(3):
        sketch.body(f"bar{i}", places[i][0], places[i + 1][0], mass_of(rng))
        sketch.joint(
            f"J{i}", "revolute", before, f"bar{i}", places[i][0], [places[i][1]], q=coordinates(rng, 1)
        )
        before = f"bar{i}"
    sketch.joint("J3", "revolute", "ground", before, places[3][0], [places[3][1]], q=coordinates(rng, 1))
    return sketch


def sarrus(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A table on two or three pairs of plates, each in a plane of its own: it moves vertically."""
    phi, r = angle(rng), pick(rng, ROUND)
    sketch = Sketch(natural)
    lean = np.array([math.cos(phi), 0.0, math.sin(phi)])
    top = np.array([0.0, 0.0, 2 * r * math.sin(phi)])
    sketch.body("table", top, top + AXES[0], mass_of(rng))
    for i, turn in enumerate((0.0, math.pi / 2, math.pi)[: int(rng.integers(2, 4))]):
        R = snapped(rotation([0, 0, 1], turn))
        foot, axis = R @ np.array([1.0, 0.0, 0.0]), R @ AXES[1]
        knee = snapped(foot + r * R @ lean)
        hip = foot + top
        if np.linalg.norm(knee - hip) < 1e-9:
            return None
        sketch.body(f"low{i}", foot, knee, mass_of(rng))
        sketch.body(f"high{i}", hip, knee, mass_of(rng))
        for name, parent, child, p in (("A", "ground", f"low{i}", foot), ("B", f"low{i}", f"high{i}", knee),
                                       ("C", "table", f"high{i}", hip)):  # fmt: skip
            sketch.joint(f"{name}{i}", "revolute", parent, child, p, [axis], q=coordinates(rng, 1))
    return sketch


def spherical_four_bar(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Four revolute joints whose axes meet in a point, deliberately with right angles between them."""
    axes = [direction(rng) for _ in range(4)]
    sketch = Sketch(natural)
    before = "ground"
    for i in range(3):
        sketch.body(f"bar{i}", axes[i], axes[i + 1] if np.linalg.norm(axes[i + 1] - axes[i]) > 1e-9 else None,
                    mass_of(rng))  # fmt: skip
        sketch.joint(f"J{i}", "revolute", before, f"bar{i}", O, [axes[i]], q=coordinates(rng, 1))
        before = f"bar{i}"
    sketch.joint("J3", "revolute", "ground", before, O, [axes[3]], q=coordinates(rng, 1))
    return sketch


def cardan_shafts(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Two shafts in bearings, a universal joint between them, or two with a third shaft."""
    bend = pick(rng, (math.pi / 4, math.pi / 6, math.pi / 3, 0.4))
    second = snapped(np.array([math.cos(bend), math.sin(bend), 0.0]))
    yoke = pick(rng, (0.0, math.pi / 2, 0.5))
    a = snapped(rotation(AXES[0], yoke) @ AXES[2])  # perpendicular to the first shaft
    b = np.cross(second, a)
    b /= np.linalg.norm(b)
    sketch = Sketch(natural)
    sketch.body("first", -AXES[0], O, mass_of(rng))
    sketch.joint("A", "revolute", "ground", "first", -AXES[0], [AXES[0]], q=coordinates(rng, 1))
    sketch.body("second", O, second, mass_of(rng))
    sketch.joint("U", "universal", "first", "second", O, [a, b], q=coordinates(rng, 2))
    if rng.random() < 0.5:
        sketch.joint("B", str(rng.choice(["revolute", "cylindrical"])), "ground", "second", second, [second])
        return sketch
    sketch.body("third", second, second + AXES[0], mass_of(rng))
    c = np.cross(second, b) if rng.random() < 0.5 else b
    d = np.cross(AXES[0], c)
    if np.linalg.norm(d) < 1e-9:
        return None
    sketch.joint(
        "V", "universal", "second", "third", second, [c, d / np.linalg.norm(d)], q=coordinates(rng, 2)
    )
    sketch.joint("B", "revolute", "ground", "third", second + AXES[0], [AXES[0]], q=coordinates(rng, 1))
    return sketch


def held_twice(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A door on two hinges or a carriage on two rails, and an attached body."""
    axis = direction(rng)
    kind = str(rng.choice(["revolute", "prismatic"]))
    q = coordinates(rng, 1)
    place = pick(rng, ROUND) * axis
    sketch = Sketch(natural)
    sketch.body("door", O, place + across(rng, axis), mass_of(rng))
    for name, p in (("low", O), ("high", place if rng.random() < 0.7 or kind == "revolute" else spot(rng))):
        sketch.joint(name, kind, "ground", "door", p, [axis], q=q)
    p = spot(rng)
    sketch.body("bob", p, p + AXES[rng.integers(3)], mass_of(rng))
    sketch.joint("pin", str(rng.choice(["revolute", "spherical", "universal"])), "door", "bob", p,
                 [AXES[0], AXES[1]])  # fmt: skip
    return sketch


def random_loops(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A random tree in space, with loops closed by random joints where bodies happen to be."""
    sketch = Sketch(natural)
    kinds = ("revolute", "prismatic", "cylindrical", "universal", "spherical", "planar")
    n = int(rng.integers(2, 6))
    tips: dict[str, Array] = {"ground": O}

    def add(name: str, parent: str, child: str, p: Array, share: tuple[float, ...]) -> None:
        kind = str(rng.choice(kinds, p=share))
        a = direction(rng)
        axes = [a, across(rng, a)] if kind == "universal" else [a]
        if kind == "planar" and not np.allclose(displacement("planar", axes, [0, 0, 0])[0], np.eye(3)):
            return
        count = {"universal": 2, "cylindrical": 2, "spherical": 3, "planar": 3}.get(kind, 1)
        sketch.joint(name, kind, parent, child, p, axes, q=coordinates(rng, count))

    for i in range(n):
        parent = str(rng.choice(list(tips)))
        foot = tips[parent]
        tip = spot(rng, foot)
        sketch.body(f"b{i}", foot, tip, mass_of(rng))
        add(f"J{i}", parent, f"b{i}", foot, (0.5, 0.15, 0.1, 0.15, 0.1, 0.0))
        tips[f"b{i}"] = tip
    for k in range(int(rng.integers(1, 3))):
        first, second = (str(x) for x in rng.choice(list(tips), 2, replace=False))
        if second == "ground":
            first, second = second, first
        add(f"L{k}", first, second, tips[second], (0.2, 0.1, 0.15, 0.2, 0.25, 0.1))
    return sketch


SPATIAL = (
    crank_rod, rod_on_balls, bennett, sarrus, spherical_four_bar, cardan_shafts, held_twice, random_loops,
)  # fmt: skip
