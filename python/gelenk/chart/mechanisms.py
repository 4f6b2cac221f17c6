# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms of the studies as scenes; SI units, angles in radians."""

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
    """Return a body: mass [kg], center of mass [m], moments of inertia about it [kg m²]."""
    return {"mass": mass, "com": list(com), "inertia": list(inertia)}


def rod(length: float, mass: float = 1.0) -> Scene:
    """Return a slender rod of this length [m] and mass [kg] along x, starting at the origin of its frame."""
    across = mass * length**2 / 12
    return body(mass, (length / 2, 0, 0), (0, across, across))


def at(name: str, x: float, y: float = 0.0, z: float = 0.0) -> Scene:
    """Return a frame at a point [m] of a body, parallel to the body's frame."""
    return {"body": name, "position": [x, y, z]}


def hinge(parent: Any, child: Any, **fields: Any) -> Scene:
    """Return a revolute joint; its axis is z unless `fields` has `axis`."""
    return {"type": "revolute", "parent": parent, "child": child, **fields}


def slide(parent: Any, child: Any, **fields: Any) -> Scene:
    """Return a prismatic joint; its axis is x unless `fields` has `axis`."""
    return {"type": "prismatic", "axis": [1, 0, 0], "parent": parent, "child": child, **fields}


def scene(bodies: Scene, joints: Scene, **fields: Any) -> Scene:
    """Return a scene; it has no gravity unless `fields` has `gravity`."""
    return {"gelenk": 1, "bodies": bodies, "joints": joints, **fields}


def shipped(name: str) -> Scene:
    """Return one of the example scenes of the package."""
    return gelenk.load(Path(str(resources.files("gelenk") / f"scenes/{name}.yaml"))).to_dict()


def four_bar_chain(n: int, upright: float = 0.0, rate: float = 1.0) -> Scene:
    """Return the N-four-bar (IFToMM benchmark A02; Gonzalez et al. 2006), a chain of n four-bars.

    It has n + 1 cranks of 1 m and 1 kg from (0, 0) to (n, 0), and n couplers between their tips.

    Args:
        n: Number of four-bars.
        upright: Angle of the cranks from the vertical to the right [rad].
        rate: Angular rate of the cranks to the right [rad/s].
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
    """Return a parallelogram: cranks of 0.3 m and 0.5 kg, 0.37 m apart; the center of mass of the coupler
    (0.8 kg) is not on the line of its pins. phi [rad] and rate [rad/s] are those of the cranks.
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
    """Return a slider-crank with crank and rod of 1 m and 1 kg, a slider of 1 kg and no gravity (after Bayo &
    Avello 1994). When the crank is normal to the slide, the slider is at the crank's pin, and both bars could
    also rotate together. phi [rad] and rate [rad/s] are those of the crank.
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
    """Return the rectangular Bricard linkage (IFToMM benchmark A04): six hinges in a ring along the edges of
    a cube, rods of 1 m, 1 kg and 0.1 m x 0.1 m. It moves although its counted degrees of freedom are 0.
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
    """Return the stiff flyball governor (IFToMM benchmark A05): 8e5 N/m, 4e4 N s/m to the collar."""
    mass, ball = 0.3, 5.0  # kg: rod, and point mass at its tip
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
    """Return a pole of 1 m with 1 kg at its tip on a cart of 1 mg (N. Parsons 2026,
    light-cartpole-benchmark), released from the horizontal; phi is measured from the downward vertical. The
    rate peaks at 4429 rad/s for a microsecond.
    """
    joints = {
        "track": slide("ground", "cart", start={"s": 0, "v": 0, "fixed": True}),
        "hinge": hinge("cart", "pole", axis=[0, -1, 0], start={"phi": math.pi / 2, "w": 0, "fixed": True}),
    }
    return scene({"cart": body(1e-6), "pole": body(1, (0, 0, -1))}, joints, gravity=DOWN_Z)


def heavy_top(spin: float) -> Scene:
    """Return the fast heavy top (Brüls & Cardona 2010) with this spin [rad/s] about its axis."""
    top = shipped("heavy_top")
    (joint,) = top["joints"].values()
    joint["start"]["w"] = [0, spin, -4.61538]
    return top


def four_bar(**start: Any) -> Scene:
    """Return the four-bar scene without its damper; `start` replaces start values of the crank."""
    out = shipped("four_bar")
    out["joints"]["A"]["damping"] = 0
    out["joints"]["A"]["start"].update(start)
    return out


def uneven_four_bar(ratio: float) -> Scene:
    """Return the undamped four-bar whose coupler is `ratio` times as heavy as the crank and as the rocker."""
    out = four_bar()
    for name in ("crank", "rocker"):
        given = out["bodies"][name]
        factor = out["bodies"]["coupler"]["mass"] / ratio / given["mass"]
        given["mass"] *= factor
        given["inertia"] = [factor * x for x in given["inertia"]]
    return out


def blocked_crank() -> Scene:
    """Return a slider-crank at its dead center: crank of 0.3 m and rod of 0.9 m in line.

    1000 N pull the slider along that line; 5 N m at the crank turn it by only 0.025 rad. The idle motor of
    the slider suggests its position as independent coordinate.
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
    """Return the four-bar scene with a stop of 1e6 N m/rad that limits the swing of the rocker."""
    out = shipped("four_bar")
    out["joints"]["D"]["stop"] = {"lower": 1.0, "upper": 2.3, "stiffness": 1e6, "damping": 1e3}
    return out


def contradictory_four_bar(fixed: bool) -> Scene:
    """Return the undamped four-bar with start speeds of 1 rad/s of crank and rocker, which violate its loop.

    Args:
        fixed: The speeds are fixed values; otherwise they are initial guesses.
    """
    out = four_bar(w=1.0, fixed=["phi", "w"] if fixed else ["phi"])
    out["joints"]["D"]["start"].update({"w": 1.0, "fixed": ["w"] if fixed else []})
    return out
