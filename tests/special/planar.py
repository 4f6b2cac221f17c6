# SPDX-License-Identifier: BSD-3-Clause
"""Planar linkages generated at special positions, deliberately with round and symmetric dimensions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from mechanisms import Array

from .sketch import Sketch, meeting, snapped

ROUND = (0.1, 0.25, 0.3, 0.4, 0.5, 0.75, 1.0, 1.5, 1.75, 2.0)
GRID = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0)
RIGHT_ANGLES = (0.0, math.pi / 2, math.pi, -math.pi / 2)
SPECIAL = (*RIGHT_ANGLES, math.pi / 3, math.pi / 4, -math.pi / 6)
ORIGIN = np.zeros(2)


def pick(rng: np.random.Generator, values: Sequence[float]) -> float:
    return float(values[int(rng.integers(len(values)))])


def angle(rng: np.random.Generator) -> float:
    """An angle, in most cases a special one."""
    return pick(rng, SPECIAL) if rng.random() < 0.85 else float(rng.uniform(-3, 3))


def sizes(rng: np.random.Generator, n: int) -> list[float]:
    """Lengths [m]: round, equal, or arbitrary ones."""
    style = rng.integers(4)
    if style == 0:
        return [pick(rng, ROUND)] * n
    if style == 1:
        return [float(x) for x in rng.uniform(0.2, 2, n)]
    return [pick(rng, ROUND) for _ in range(n)]


def at(p: Array, length: float, phi: float) -> Array:
    return snapped(p + length * np.array([math.cos(phi), math.sin(phi)]))


def mass_of(rng: np.random.Generator) -> float:
    return pick(rng, (0.5, 1.0, 2.0, 1.3))


def chain_of(sketch: Sketch, rng: np.random.Generator, names: Sequence[str], points: Sequence[Array]) -> None:
    """Bodies between consecutive points, connected to each other and, at the first point,
    to the ground by revolute joints.
    """
    before = "ground"
    for i, name in enumerate(names):
        sketch.body(name, points[i], points[i + 1], mass_of(rng))
        sketch.hinge(f"J{len(sketch.joints)}", before, name, points[i])
        before = name


def dyad(
    sketch: Sketch, rng: np.random.Generator, names: tuple[str, str], ends: tuple[str, str],
    points: tuple[Array, Array, Array],
) -> None:  # fmt: skip
    """Two bars connected by a revolute joint, from a point of one body to one of another."""
    first, second = names
    a, middle, b = points
    sketch.body(first, a, middle, mass_of(rng))
    sketch.hinge(f"J{len(sketch.joints)}", ends[0], first, a)
    sketch.body(second, b, middle, mass_of(rng))
    sketch.hinge(f"J{len(sketch.joints)}", ends[1], second, b)
    sketch.hinge(f"J{len(sketch.joints)}", first, second, middle)


def spot(rng: np.random.Generator, *others: Array) -> Array:
    """A point of the grid that differs from the others."""
    while True:
        p = np.array([pick(rng, GRID), pick(rng, GRID)])
        if rng.random() < 0.1:
            p = p + rng.uniform(-0.2, 0.2, 2)
        if all(np.linalg.norm(p - q) > 0.1 for q in others):
            return p


def four_bar(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Four-bars of all Grashof types; with crank in line with the ground,
    dead centers and change points among them.
    """
    a, b, c, d = sizes(rng, 4)
    shape = rng.integers(8)
    if shape == 0:
        a, c, b, d = a, a, b, b  # a parallelogram
    elif shape == 1:
        a, d, b, c = a, a, b, b  # a kite
    elif shape == 2:
        d = a + b - c if a + b > c else d  # a change point
    elif shape == 3:
        a, b, c, d = 0.5, 1.75, 1.5, 2.0
    P3 = at(ORIGIN, d, 0.0)
    branch = int(rng.choice([-1, 1]))
    reach = rng.integers(6)
    if reach < 2:  # crank and coupler in line: the rocker's dead centers
        P2 = meeting(ORIGIN, a + b if reach == 0 else abs(b - a), P3, c, branch)
        if P2 is None or np.linalg.norm(P2) < 1e-6:
            return None
        P1 = snapped(P2 / np.linalg.norm(P2) * a * (1 if reach == 0 or a > b else -1))
    else:
        P1 = at(ORIGIN, a, angle(rng))
        found = meeting(P1, b, P3, c, branch)
        if found is None:
            return None
        P2 = found
    return ring(rng, natural, [ORIGIN, P1, P2, P3])


def ring(rng: np.random.Generator, natural: bool, points: Sequence[Array]) -> Sketch:
    """Bars from point to point, first and last on the ground; the last bar starts there."""
    sketch = Sketch(natural)
    names = [f"bar{i}" for i in range(1, len(points) - 1)]
    chain_of(sketch, rng, names, points[:-1])
    sketch.body("rocker", points[-1], points[-2], mass_of(rng))
    sketch.hinge("D", "ground", "rocker", points[-1])
    sketch.hinge("C", names[-1], "rocker", points[-2])
    return sketch


def four_bar_on_grid(rng: np.random.Generator, natural: bool) -> Sketch | None:
    P1 = spot(rng, ORIGIN)
    P2 = spot(rng, P1)
    return ring(rng, natural, [ORIGIN, P1, P2, spot(rng, P2)])


def five_bar(rng: np.random.Generator, natural: bool) -> Sketch | None:
    a, b, c, e, d = sizes(rng, 5)
    P1, P4 = at(ORIGIN, a, angle(rng)), at(ORIGIN, d, 0.0)
    P3 = at(P4, e, angle(rng))
    P2 = meeting(P1, b, P3, c, int(rng.choice([-1, 1])))
    return None if P2 is None else ring(rng, natural, [ORIGIN, P1, P2, P3, P4])


def ring_on_grid(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Five or six bars in a loop, two or three degrees of freedom."""
    points = [ORIGIN]
    for _ in range(int(rng.integers(4, 6))):
        points.append(spot(rng, points[-1]))
    return ring(rng, natural, points)


def six_bar(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Watt's and Stephenson's: a four-bar, and a dyad from one of its bars to another one or the ground."""
    base = four_bar(rng, natural) if rng.random() < 0.5 else four_bar_on_grid(rng, natural)
    if base is None:
        return None
    first = str(rng.choice(["bar1", "bar2"]))
    second = str(rng.choice([n for n in ("ground", "rocker", "bar1") if n != first]))
    a = spot(rng)
    middle = spot(rng, a)
    dyad(base, rng, ("arm", "link"), (first, second), (a, middle, spot(rng, middle)))
    return base


def slider_crank(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """With and without offset; dead centers, rod perpendicular to the slide, equal lengths."""
    r, length = sizes(rng, 2)
    if rng.random() < 0.3:
        r, length = 0.1, 0.4
    offset = 0.0 if rng.random() < 0.6 else pick(rng, (0.1, 0.05, 0.25, -0.1))
    P1 = at(ORIGIN, r, angle(rng))
    rise = offset - P1[1]
    if abs(rise) > length + 1e-12:
        return None
    side = 1 if rng.random() < 0.7 else -1
    P2 = snapped(np.array([P1[0] + side * math.sqrt(max(length**2 - rise**2, 0.0)), offset]))
    return with_slider(rng, natural, P1, P2, np.array([1.0, 0.0]))


def with_slider(rng: np.random.Generator, natural: bool, P1: Array, P2: Array, along: Array) -> Sketch:
    sketch = Sketch(natural)
    chain_of(sketch, rng, ["crank", "rod"], [ORIGIN, P1, P2])
    sketch.body("slider", P2 if rng.random() < 0.7 else ORIGIN, mass=mass_of(rng))
    sketch.slide("P", "ground", "slider", sketch.poses["slider"][1], along, q=[float(rng.choice([0, P2[0]]))])
    sketch.hinge("C", "rod", "slider", P2)
    return sketch


def slider_on_grid(rng: np.random.Generator, natural: bool) -> Sketch | None:
    P1 = spot(rng, ORIGIN)
    phi = angle(rng)
    return with_slider(rng, natural, P1, spot(rng, P1), snapped(np.array([math.cos(phi), math.sin(phi)])))


def turning_block(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Inverted slider-crank: the rod slides through a block pivoted on the ground."""
    r, d = sizes(rng, 2)
    P1, P3 = at(ORIGIN, r, angle(rng)), at(ORIGIN, d, 0.0)
    way = P3 - P1
    if np.linalg.norm(way) < 1e-6:
        return None
    along = snapped(way / np.linalg.norm(way))
    sketch = Sketch(natural)
    chain_of(sketch, rng, ["crank", "rod"], [ORIGIN, P1, P1 + 2 * way])
    sketch.body("block", P3, P3 + along if rng.random() < 0.5 else None, mass_of(rng))
    sketch.hinge("D", "ground", "block", P3)
    sketch.slide("P", "block", "rod", P3 if rng.random() < 0.5 else P1, along)
    return sketch


def scotch_yoke(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """Crank, block on its pin, yoke across, slide; not always at right angles."""
    r = pick(rng, ROUND)
    P1 = at(ORIGIN, r, angle(rng))
    slot = pick(rng, (math.pi / 2, math.pi / 2, math.pi / 3))
    sketch = Sketch(natural)
    chain_of(sketch, rng, ["crank"], [ORIGIN, P1])
    sketch.body("block", P1, mass=mass_of(rng))
    sketch.hinge("B", "crank", "block", P1)
    foot = np.array([P1[0], 0.0]) if rng.random() < 0.5 else ORIGIN
    sketch.body("yoke", foot, mass=mass_of(rng))
    sketch.slide(
        "S", "yoke", "block", P1, [math.cos(slot), math.sin(slot)], q=[float(rng.choice([0, P1[1]]))]
    )
    sketch.slide("P", "ground", "yoke", foot, [1.0, 0.0], q=[float(rng.choice([0, P1[0]]))])
    return sketch


def trammel(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A bar whose ends slide along two lines (Cardan's circles)."""
    length, phi = pick(rng, ROUND), angle(rng)
    across = pick(rng, (math.pi / 2, math.pi / 2, math.pi / 3))
    P, Q = np.array([length * math.cos(phi), 0.0]), np.array([0.0, length * math.sin(phi)])
    direction = np.array([0.0, 1.0])
    if across != math.pi / 2:  # the second end on a line through the position of the first
        direction = np.array([math.cos(across), math.sin(across)])
    P, Q = snapped(P), snapped(Q)
    sketch = Sketch(natural)
    sketch.body("first", P, mass=mass_of(rng))
    sketch.slide("X", "ground", "first", P, [1.0, 0.0], q=[float(P[0])])
    sketch.body("bar", P, Q, mass_of(rng))
    sketch.hinge("A", "first", "bar", P)
    sketch.body("second", Q, mass=mass_of(rng))
    sketch.hinge("B", "bar", "second", Q)
    sketch.slide("Y", "ground", "second", Q, direction)
    return sketch


def parallel_cranks(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A coupler on two or three equal cranks: with redundant constraints, and bars in line."""
    r, phi = pick(rng, ROUND), angle(rng)
    gaps = sizes(rng, int(rng.integers(1, 3)))
    feet = [np.array([x, 0.0]) for x in np.cumsum([0.0, *gaps])]
    sketch = Sketch(natural)
    tips = [at(foot, r, phi) for foot in feet]
    for i, (foot, tip) in enumerate(zip(feet, tips, strict=True)):
        sketch.body(f"crank{i}", foot, tip, mass_of(rng))
        sketch.hinge(f"A{i}", "ground", f"crank{i}", foot)
    sketch.body("coupler", tips[0], tips[-1], mass_of(rng))
    for i, tip in enumerate(tips):
        sketch.hinge(f"B{i}", f"crank{i}", "coupler", tip)
    return sketch


def windows(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """N-four-bar: a chain of squares or parallelograms."""
    n, r, d, phi = int(rng.integers(2, 4)), pick(rng, ROUND), pick(rng, ROUND), angle(rng)
    sketch = Sketch(natural)
    feet = [np.array([i * d, 0.0]) for i in range(n + 1)]
    tips = [at(foot, r, phi) for foot in feet]
    for i in range(n + 1):
        sketch.body(f"crank{i}", feet[i], tips[i], mass_of(rng))
        sketch.hinge(f"A{i}", "ground", f"crank{i}", feet[i])
    for i in range(n):
        sketch.body(f"bar{i}", tips[i], tips[i + 1], mass_of(rng))
        sketch.hinge(f"B{i}", f"crank{i}", f"bar{i}", tips[i])
        sketch.hinge(f"C{i}", f"crank{i + 1}", f"bar{i}", tips[i + 1])
    return sketch


def on_a_truss(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A linkage on a truss of two bars, with its foot among the immobile bodies."""
    base, height = pick(rng, (1.0, 2.0)), pick(rng, (0.5, 1.0))
    apex = np.array([base / 2, height])
    sketch = Sketch(natural)
    dyad(sketch, rng, ("left", "right"), ("ground", "ground"), (ORIGIN, apex, np.array([base, 0.0])))
    tip = at(apex, pick(rng, ROUND), angle(rng))
    sketch.body("bob", apex, tip, mass_of(rng))
    sketch.hinge("pin", "left", "bob", apex)
    if rng.random() < 0.6:
        end = spot(rng, tip)
        sketch.body("rod", tip, end, mass_of(rng))
        sketch.hinge("knee", "bob", "rod", tip)
        sketch.body("slider", end, mass=mass_of(rng))
        sketch.hinge("wrist", "rod", "slider", end)
        sketch.slide("track", "ground", "slider", end, [1.0, 0.0])
    return sketch


def random_graph(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A random tree of bars on the grid, with loops closed by revolute and
    prismatic joints where bodies happen to be.
    """
    sketch = Sketch(natural)
    n = int(rng.integers(3, 8))
    places: dict[str, list[Array]] = {"ground": [ORIGIN, spot(rng), spot(rng)]}
    for i in range(n):
        parent = str(rng.choice(list(places)))
        foot = places[parent][int(rng.integers(len(places[parent])))]
        tip = spot(rng, foot)
        sketch.body(f"b{i}", foot, tip, mass_of(rng))
        if rng.random() < 0.8:
            sketch.hinge(f"J{i}", parent, f"b{i}", foot)
        else:
            phi = angle(rng)
            sketch.slide(f"J{i}", parent, f"b{i}", foot, snapped(np.array([math.cos(phi), math.sin(phi)])))
        places[f"b{i}"] = [tip, spot(rng)]
    for k in range(int(rng.integers(1, n // 2 + 1))):
        first, second = (str(x) for x in rng.choice(list(places), 2, replace=False))
        where = places[first][0] if rng.random() < 0.7 else spot(rng)
        if second == "ground":
            first, second = second, first
        if rng.random() < 0.8:
            sketch.hinge(f"L{k}", first, second, where)
        else:
            phi = angle(rng)
            sketch.slide(f"L{k}", first, second, where, snapped(np.array([math.cos(phi), math.sin(phi)])))
    return sketch


def rack_and_pinion(rng: np.random.Generator, natural: bool) -> Sketch | None:
    """A slider-crank whose slider is a rack that drives a gear, with a bar attached to it."""
    sketch = slider_crank(rng, natural)
    if sketch is None:
        return None
    sketch.body("wheel", (0.0, -1.0), (0.0, -1.5), mass_of(rng))
    sketch.hinge("axle", "ground", "wheel", (0.0, -1.0))
    start = sketch.joints["P"]["start"]["s"] - 0.2 * sketch.joints["axle"]["start"]["phi"]
    sketch.extra["constraints"] = {
        "drive": {"type": "rack", "rack": "P", "pinion": "axle", "radius": 0.2, "offset": float(start)}
    }
    return sketch


def geared_five_bar(rng: np.random.Generator, natural: bool) -> Sketch | None:
    sketch = five_bar(rng, natural)
    if sketch is None:
        return None
    ratio = pick(rng, (-1.0, 1.0, 2.0, -2.0))
    phi, psi = (sketch.joints[n]["start"]["phi"] for n in ("J0", "D"))
    sketch.extra["constraints"] = {
        "mesh": {
            "type": "gear",
            "joint": "D",
            "with": "J0",
            "ratio": ratio,
            "offset": float(psi - ratio * phi),
        }
    }
    return sketch


PLANAR = (
    four_bar, four_bar_on_grid, five_bar, ring_on_grid, six_bar, slider_crank, slider_on_grid,
    turning_block, scotch_yoke, trammel, parallel_cranks, windows, on_a_truss, random_graph,
    rack_and_pinion, geared_five_bar,
)  # fmt: skip
