# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms of the studies, in the scene format: SI units, angles in radians."""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import gelenk

type Scene = dict[str, Any]

GRAVITY = 9.81  # m/s2
DOWN_Y = [0.0, -GRAVITY, 0.0]
DOWN_Z = [0.0, 0.0, -GRAVITY]


def body(mass: float, com: Sequence[float] = (0, 0, 0), inertia: Sequence[float] = (0, 0, 0)) -> Scene:
    """Mass [kg], centre of mass [m], moments of inertia about it [kg m2]."""
    return {"mass": mass, "com": list(com), "inertia": list(inertia)}


def rod(length: float, mass: float = 1.0) -> Scene:
    """A slender rod along x from its frame's origin."""
    across = mass * length**2 / 12
    return body(mass, (length / 2, 0, 0), (0, across, across))


def at(name: str, x: float, y: float = 0.0, z: float = 0.0) -> Scene:
    """A point of a body, the frame in line with the body's."""
    return {"body": name, "position": [x, y, z]}


def hinge(parent: Any, child: Any, **fields: Any) -> Scene:
    """A revolute joint, about z unless `axis` is among the fields."""
    return {"type": "revolute", "parent": parent, "child": child, **fields}


def slide(parent: Any, child: Any, **fields: Any) -> Scene:
    """A prismatic joint, along x unless `axis` is among the fields."""
    return {"type": "prismatic", "axis": [1, 0, 0], "parent": parent, "child": child, **fields}


def scene(bodies: Scene, joints: Scene, **fields: Any) -> Scene:
    """Without gravity unless `gravity` is among the fields."""
    return {"gelenk": 1, "bodies": bodies, "joints": joints, **fields}


def shipped(name: str) -> Scene:
    """One of the scenes that come with the package."""
    return gelenk.load(Path(str(resources.files("gelenk") / f"scenes/{name}.yaml"))).to_dict()


def windows(n: int, upright: float = 0.0, rate: float = 1.0) -> Scene:
    """N-four-bar (IFToMM benchmark A02; Gonzalez et al. 2006): n + 1 cranks of 1 m, 1 kg from (0,0) .. (n,0),
    n couplers on their tips. Cranks lean `upright` from the vertical to the right, turn at `rate` to the
    right.
    """
    bodies = {f"crank{i}": rod(1) for i in range(n + 1)} | {f"coupler{i}": rod(1) for i in range(n)}
    phi = math.pi / 2 - upright
    joints: Scene = {}
    for i in range(n + 1):
        fixed = {"fixed": True} if i == 0 else {}
        joints[f"A{i}"] = hinge(at("ground", i), f"crank{i}", start={"phi": phi, "w": -rate, **fixed})
    for i in range(n):
        start = {"phi": -phi, "w": rate}
        joints[f"B{i}"] = hinge(at(f"crank{i}", 1), f"coupler{i}", start=start)
        joints[f"C{i}"] = hinge(at(f"crank{i + 1}", 1), at(f"coupler{i}", 1), start=start)
    return scene(bodies, joints, gravity=DOWN_Y)


def parallelogram(phi: float, rate: float) -> Scene:
    """Cranks of 0.3 m, 0.5 kg, 0.37 m apart; a coupler of 0.8 kg whose mass centre lies off its line of
    pins.
    """
    crank = body(0.5, (0.15, 0, 0), (0.001, 0.0195, 0.01875))
    start = {"phi": -phi, "w": -rate}
    joints = {
        "A": hinge("ground", "left", start={"phi": phi, "w": rate, "fixed": True}),
        "D": hinge(at("ground", 0.37), "right", start={"phi": phi, "w": rate}),
        "B": hinge(at("left", 0.3), "coupler", start=start),
        "C": hinge(at("right", 0.3), at("coupler", 0.37), start=start),
    }
    coupler = body(0.8, (0.11, -0.04, 0), (0.002, 0.01, 0.011))
    bodies = {"left": crank, "right": copy.deepcopy(crank), "coupler": coupler}
    return scene(bodies, joints, gravity=DOWN_Y)


def equal_slider_crank(phi: float, rate: float) -> Scene:
    """Crank and rod of 1 m and 1 kg each, a slider of 1 kg, no gravity (after Bayo & Avello 1994). With the
    crank across the slide the slider is at the crank's pin, and both bars may as well go round together.
    """
    joints = {
        "A": hinge("ground", "crank", start={"phi": phi, "w": rate, "fixed": True}),
        "B": hinge(at("crank", 1), "rod", start={"phi": -2 * phi, "w": -2 * rate}),
        "C": hinge(at("rod", 1), "slider", start={"phi": phi, "w": rate}),
        "P": slide("ground", "slider",
                   start={"s": 2 * math.cos(phi), "v": -2 * math.sin(phi) * rate}),
    }  # fmt: skip
    return scene({"crank": rod(1), "rod": rod(1), "slider": body(1, inertia=(0.1, 0.1, 0.1))}, joints)


def bricard() -> Scene:
    """Rectangular Bricard mechanism (IFToMM benchmark A04): six hinges in a ring along the edges of a cube,
    rods of 1 m, 1 kg and 0.1 m x 0.1 m; it moves although counting freedoms says that it is rigid.
    """
    points = [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]
    axes = [[0, 1, 0], [0, 0, 1], [1, 0, 0]] * 2
    spans = [[b - a for a, b in zip(p, q, strict=True)] for p, q in itertools.pairwise(points)]
    axial, across = 0.02 / 12, 1.01 / 12
    bodies = {
        f"rod{i}": body(1, [x / 2 for x in span], [axial if x else across for x in span])
        for i, span in enumerate(spans, 1)
    }
    joints = {"J1": hinge("ground", "rod1", axis=axes[0])}
    for i in range(1, 6):
        child = at("ground", *points[5]) if i == 5 else f"rod{i + 1}"
        joints[f"J{i + 1}"] = hinge(at(f"rod{i}", *spans[i - 1]), child, axis=axes[i])
    return scene(bodies, joints, gravity=DOWN_Y)


def governor() -> Scene:
    """Stiff flyball governor (IFToMM benchmark A05): 8e5 N/m and 4e4 N s/m between collar and rods."""
    mass, ball = 0.3, 5.0  # kg: rod, and point at its tip
    whole = mass + ball
    com = (mass * 0.5 + ball) / whole
    across = mass * (1 + 1e-4) / 12 + mass * (0.5 - com) ** 2 + ball * (1 - com) ** 2
    arm = body(whole, (com, 0, 0), (mass * 1e-4 / 6, across, across))
    start = {"phi": math.radians(30), "w": 0, "fixed": True}
    turned = {**at("shaft", -0.05, 0, 1), "rotation": {"axis": [0, 0, 1], "angle": math.pi}}
    joints = {
        "S": hinge("ground", "shaft", start={"phi": 0, "w": 2 * math.pi, "fixed": True}),
        "P": slide("shaft", "slider", axis=[0, 0, 1], start={"s": 0.5, "v": 0, "fixed": True}),
        "L": hinge(at("shaft", 0.05, 0, 1), "left", axis=[0, 1, 0], start=start),
        "R": hinge(turned, "right", axis=[0, 1, 0], start=start),
    }
    spring = {"type": "spring_damper", "stiffness": 8e5, "damping": 4e4, "length": 0.5}
    forces = {
        f"to_{name}": {**spring, "from": at("slider", x), "to": at(name, 0.5)}
        for name, x in (("left", 0.05), ("right", -0.05))
    }
    bodies = {
        "shaft": body(0.3, (0, 0, 0.5), (0.3 * (1 + 1e-4) / 12, 0.3 * (1 + 1e-4) / 12, 0.3 * 1e-4 / 6)),
        "slider": body(3, inertia=(0.005, 0.005, 0.005)),
        "left": arm,
        "right": copy.deepcopy(arm),
    }
    return scene(bodies, joints, gravity=DOWN_Z, forces=forces)


def light_cart_pole() -> Scene:
    """A pole of 1 m with 1 kg at its tip on a cart of 1 mg (N. Parsons 2026, light-cartpole-benchmark), let
    go from the horizontal; phi from the downward vertical. Rates peak at 4429 rad/s for a microsecond.
    """
    joints = {
        "track": slide("ground", "cart", start={"s": 0, "v": 0, "fixed": True}),
        "hinge": hinge("cart", "pole", axis=[0, -1, 0], start={"phi": math.pi / 2, "w": 0, "fixed": True}),
    }
    return scene({"cart": body(1e-6), "pole": body(1, (0, 0, -1))}, joints, gravity=DOWN_Z)


def heavy_top(spin: float) -> Scene:
    """The fast heavy top (Brüls & Cardona 2010) with this spin [rad/s] about its axis."""
    top = shipped("heavy_top")
    (joint,) = top["joints"].values()
    joint["start"]["w"] = [0, spin, -4.61538]
    return top


def four_bar(**start: Any) -> Scene:
    """The ready four-bar without its damper; fields of the crank's start."""
    out = shipped("four_bar")
    out["joints"]["A"]["damping"] = 0
    out["joints"]["A"]["start"].update(start)
    return out


def uneven_four_bar(ratio: float) -> Scene:
    """The ready four-bar, its coupler `ratio` times as heavy as crank and rocker each."""
    out = four_bar()
    for name in ("crank", "rocker"):
        given = out["bodies"][name]
        share = out["bodies"]["coupler"]["mass"] / ratio / given["mass"]
        given["mass"] *= share
        given["inertia"] = [share * x for x in given["inertia"]]
    return out


def blocked_crank() -> Scene:
    """A crank of 0.3 m and a rod of 0.9 m stand in line; 1000 N pull at the slider along that line, 5 N m
    turn the crank: it gets 0.025 rad far. The slider's motor, which idles, makes its position an inviting
    coordinate.
    """
    joints = {
        "A": hinge("ground", "crank", start={"phi": 0, "w": 0, "fixed": True}),
        "B": hinge(at("crank", 0.3), "rod", start={"phi": 0}),
        "C": hinge(at("rod", 0.9), "slider", start={"phi": 0}),
        "P": slide("ground", "slider", start={"s": 1.2}),
    }
    forces = {
        "load": {"type": "wrench", "body": "slider", "force": [1000, 0, 0]},
        "drive": {"type": "wrench", "body": "crank", "torque": [0, 0, 5]},
    }
    bodies = {"crank": rod(0.3), "rod": rod(0.9, 2), "slider": body(1.5, inertia=(0.002, 0.003, 0.003))}
    return scene(bodies, joints, forces=forces, motors={"idle": {"joint": "P"}})


def stopped_four_bar() -> Scene:
    """The ready four-bar, its rocker's swing cut short by a stop: a one-sided spring of 1e6 N m/rad."""
    out = shipped("four_bar")
    out["joints"]["D"]["stop"] = {"lower": 1.0, "upper": 2.3, "stiffness": 1e6, "damping": 1e3}
    return out


def contradictory_four_bar(fixed: bool) -> Scene:
    """The ready four-bar, started with crank and rocker at 1 rad/s each, which its loop does not allow.
    fixed: both are to be kept exactly; else they are guesses.
    """
    out = four_bar(w=1.0, fixed=["phi", "w"] if fixed else ["phi"])
    out["joints"]["D"]["start"].update({"w": 1.0, "fixed": ["w"] if fixed else []})
    return out
