# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms of this study only; SI units, angles in radians."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gelenk.chart.case import Array
from gelenk.chart.mechanisms import DOWN_Y, DOWN_Z, Scene, at, body, four_bar, hinge, rod, scene, slide

FIXED = {"fixed": True}


def driven(source: Scene, joint: str, **motor: Any) -> Scene:
    """Return the scene with a motor `drive` at a joint."""
    return source | {"motors": {"drive": {"joint": joint, **motor}}}


def torsion_spring(stiffness: float, damping: float, phi: float) -> Scene:
    """Return a disk of 0.02 kg m² on a torsional spring-damper, released at the angle `phi` [rad]."""
    start = {"phi": phi, "w": 0, **FIXED}
    joints = {"A": hinge("ground", "disc", stiffness=stiffness, damping=damping, start=start)}
    return driven(scene({"disc": body(1, inertia=(0.02, 0.02, 0.02))}, joints), "A")


def two_masses(stiff: float, soft: float, damping: float) -> Scene:
    """Return two masses of 1 kg, the first on a stiff spring and damper, the second on a soft spring."""
    joints = {
        "P": slide("ground", "first", stiffness=stiff, damping=damping, start={"s": 0, "v": 0, **FIXED}),
        "Q": slide("first", "second", stiffness=soft, start={"s": 0.1, "v": 1, **FIXED}),
    }
    bodies = {"first": body(1, inertia=(1, 1, 1)), "second": body(1, inertia=(1, 1, 1))}
    return driven(scene(bodies, joints), "Q")


class Linear:
    """Closed-form solution of x' = A x + b; `names` are the outputs of x."""

    def __init__(self, names: tuple[str, ...], A: Any, b: Any, x: Any) -> None:
        self.names = names
        self.A, self.b, self.x = (np.array(value, float) for value in (A, b, x))

    def __call__(self, times: Array) -> dict[str, Array]:
        """Return the joint states by output name at times [s], each of shape (times,)."""
        rest = -np.linalg.solve(self.A, self.b)
        rates, modes = np.linalg.eig(self.A.astype(complex))
        parts = np.linalg.solve(modes, self.x - rest)
        found = np.real(modes @ (parts[:, None] * np.exp(np.outer(rates, times)))) + rest[:, None]
        return dict(zip(self.names, found, strict=True))


def torsion_truth(stiffness: float, damping: float, phi: float) -> Linear:
    """Return the closed-form solution of `torsion_spring`."""
    A = [[0, 1], [-stiffness / 0.02, -damping / 0.02]]
    return Linear(("A.phi", "A.w"), A, [0, 0], [phi, 0])


def two_masses_truth(stiff: float, soft: float, damping: float) -> Linear:
    """Return the closed-form solution of `two_masses`; Q.s is relative to the first mass."""
    first = [-stiff, soft, -damping, 0]
    A = [[0, 0, 1, 0], [0, 0, 0, 1], first, [stiff, -2 * soft, damping, 0]]
    return Linear(("P.s", "Q.s", "P.v", "Q.v"), A, [0, 0, 0, 0], [0, 0.1, 0, 1])


def stiff_pendulum(stiffness: float) -> Scene:
    """Return a pendulum whose bob is on a stiff undamped spring along a light arm: fast and slow motion."""
    joints = {
        "A": hinge("ground", "arm", start={"phi": -0.4, "w": 0.3, **FIXED}),
        "S": slide(
            "arm", "bob", stiffness=stiffness, spring_reference=0.5, start={"s": 0.5, "v": 0, **FIXED}
        ),
    }
    bodies = {"arm": body(0.1, inertia=(1e-3, 1e-3, 1e-3)), "bob": body(1.0, inertia=(1e-3, 1e-3, 1e-3))}
    return driven(scene(bodies, joints, gravity=DOWN_Y), "A")


def slider_crank(rate: float) -> Scene:
    """Return a slider-crank that crosses its dead centers: crank 0.1 m, rod 0.4 m, slider 0.8 kg."""
    phi = 0.7
    lean = -math.asin(0.25 * math.sin(phi))
    joints = {
        "A": hinge("ground", "crank", damping=0.01, start={"phi": phi, "w": rate, **FIXED}),
        "B": hinge(at("crank", 0.1), "rod", start={"phi": lean - phi}),
        "C": hinge(at("rod", 0.4), "slider", start={"phi": -lean}),
        "P": slide("ground", "slider", start={"s": 0.1 * math.cos(phi) + 0.4 * math.cos(lean)}),
    }
    bodies = {"crank": rod(0.1, 2.0), "rod": rod(0.4, 0.5), "slider": body(0.8, inertia=(1e-3, 1e-3, 1e-3))}
    return driven(scene(bodies, joints, gravity=DOWN_Y), "A")


def v6(rate: float) -> Scene:
    """Return a 60-degree V6 engine: throws of 40 mm every 60 degrees, rods of 150 mm, six planar loops."""
    crank, length = 0.04, 0.15
    joints: Scene = {"main": hinge("ground", "shaft", damping=0.05, start={"phi": 0.0, "w": rate, **FIXED})}
    bodies = {"shaft": body(12, inertia=(0.05, 0.05, 0.06))}
    for i in range(6):
        bank = math.radians(60 if i % 2 else 120)
        throw = math.radians((0, 60, 240, 300, 120, 180)[i])
        across = crank * math.sin(throw - bank)
        along = crank * math.cos(throw - bank) + math.sqrt(length**2 - across**2)
        lean = bank - math.asin(across / length)
        line = [math.cos(bank), math.sin(bank), 0.0]
        place = (crank * math.cos(throw), crank * math.sin(throw))
        bodies[f"rod{i}"] = rod(length, 0.6)
        bodies[f"piston{i}"] = body(0.5, inertia=(5e-4, 5e-4, 5e-4))
        joints[f"big{i}"] = hinge(at("shaft", *place), f"rod{i}", start={"phi": lean})
        joints[f"small{i}"] = hinge(at(f"rod{i}", length), f"piston{i}", start={"phi": -lean})
        joints[f"bore{i}"] = slide("ground", f"piston{i}", axis=line, start={"s": along})
    return driven(scene(bodies, joints, gravity=DOWN_Y), "main")


def chain(n: int) -> Scene:
    """Return a chain of n rods of 0.4 m and 0.5 kg with light damping, released in a bent position."""
    joints = {}
    for i in range(n):
        parent: Any = at(f"rod{i - 1}", 0.4) if i else "ground"
        start = {"phi": -1.2 if i == 0 else 0.15, "w": 0, **FIXED}
        joints[f"J{i}"] = hinge(parent, f"rod{i}", damping=0.05, start=start)
    bodies = {f"rod{i}": rod(0.4, 0.5) for i in range(n)}
    return driven(scene(bodies, joints, gravity=DOWN_Y), "J0")


def arm() -> Scene:
    """Return a spatial arm of six hinges about alternating axes with dampers."""
    axes = ([0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0])
    joints = {}
    for i, axis in enumerate(axes):
        parent: Any = at(f"link{i - 1}", 0.3, 0.02, 0.01) if i else "ground"
        start = {"phi": 0.2 - 0.1 * i, "w": 0.3, **FIXED}
        joints[f"J{i}"] = hinge(parent, f"link{i}", axis=axis, damping=0.3, start=start)
    link = body(1.5, (0.15, 0.01, -0.02), (0.004, 0.013, 0.012))
    return driven(scene({f"link{i}": link for i in range(6)}, joints, gravity=DOWN_Z), "J1")


def gears() -> Scene:
    """Return a flywheel and a pendulum coupled by gears; the pendulum's shaft is a spring of 2e4 N m/rad."""
    joints = {
        "A": hinge("ground", "wheel", start={"phi": 0, "w": 2, **FIXED}),
        "B": hinge(at("ground", 0.3), "pinion"),
        "C": hinge("pinion", "bob", stiffness=2e4, damping=5, start={"phi": 0, "w": 0, **FIXED}),
    }
    bodies = {
        "wheel": body(3, inertia=(0.05, 0.05, 0.1)),
        "pinion": body(0.5, inertia=(1e-3, 1e-3, 1e-3)),
        "bob": rod(0.5, 1.2),
    }
    mesh = {"mesh": {"type": "gear", "joint": "B", "with": "A", "ratio": -2.5}}
    return driven(scene(bodies, joints, gravity=DOWN_Y, constraints=mesh), "A")


def rack() -> Scene:
    """Return a pinion with an eccentric mass that drives a rack against a spring."""
    joints = {
        "S": slide("ground", "bar", stiffness=300, start={"s": 0.05, "v": 0, **FIXED}),
        "R": hinge("ground", "pinion"),
    }
    bodies = {"bar": body(2, inertia=(0.1, 0.1, 0.1)), "pinion": body(1, (0.02, 0.01, 0), (1e-3, 1e-3, 2e-3))}
    drive = {"mesh": {"type": "rack", "rack": "S", "pinion": "R", "radius": 0.05}}
    return driven(scene(bodies, joints, gravity=DOWN_Y, constraints=drive), "S")


def given_crank(**motion: Any) -> Scene:
    """Return the four-bar scene with a prescribed motion of the crank instead of its motor."""
    out = four_bar()
    out["joints"]["A"].pop("start")
    out.pop("motors")
    out["joints"]["hang"] = hinge(at("coupler", 0.9, 0.1), "load", start={"phi": -1.0, "w": 0, **FIXED})
    out["bodies"]["load"] = rod(0.4, 0.3)
    return out | {"constraints": {"ramp": {"type": "motion", "joint": "A", **motion}}}


def rolling_disc() -> Scene:
    """Return a wobbling disk of 0.3 m that rolls on the ground: coordinates yaw, height, lean and spin."""
    joints = {
        "base": {"type": "planar", "parent": "ground", "child": "a",
                 "start": {"phi": 0.0, "w": 1.0, "fixed": ["phi", "w"]}},
        "height": slide("a", "b", axis=[0, 0, 1], start={"s": 0.3}),
        "lean": hinge("b", "c", axis=[1, 0, 0], start={"phi": 0.3, "w": 0.3, **FIXED}),
        "spin": hinge("c", "wheel", axis=[0, 1, 0], start={"w": 6.0, "fixed": ["w"]}),
    }  # fmt: skip
    bodies = {name: body(0) for name in "abc"} | {"wheel": body(2, inertia=(0.045, 0.09, 0.045))}
    tyre = {"tyre": {"type": "rolling", "body": "wheel", "radius": 0.3}}
    return scene(bodies, joints, gravity=DOWN_Z, constraints=tyre)


def sleigh() -> Scene:
    """Return Chaplygin's sleigh: its blade, behind the center of mass, does not slip sideways."""
    joints = {"P": {"type": "planar", "parent": "ground", "child": "sleigh",
                    "start": {"s_x": 0, "s_y": 0, "phi": 0.2, "w": 3.0,
                              "fixed": ["s_x", "s_y", "phi", "w"]}}}  # fmt: skip
    blade = {"blade": {"type": "knife_edge", "body": "sleigh", "position": [-0.5, 0, 0]}}
    return scene({"sleigh": body(2, inertia=(0.2, 0.3, 0.4))}, joints, constraints=blade)


def bouncing() -> Scene:
    """Return a mass that falls onto a stop of 1e5 N/m with light damping."""
    stop = {"lower": 0.0, "stiffness": 1e5, "damping": 20}
    joints = {"Z": slide("ground", "ball", axis=[0, 1, 0], stop=stop, start={"s": 0.5, "v": 0, **FIXED})}
    return scene({"ball": body(1.5, inertia=(0.1, 0.1, 0.1))}, joints, gravity=DOWN_Y)


def pendulum_at_stop() -> Scene:
    """Return a rod that swings against an elastic stop of 500 N m/rad."""
    stop = {"upper": -1.2, "stiffness": 500}
    joints = {"A": hinge("ground", "rod", stop=stop, start={"phi": -2.6, "w": 0, **FIXED})}
    return driven(scene({"rod": rod(0.6)}, joints, gravity=DOWN_Y), "A")


def spring_triangle() -> Scene:
    """Return two carts and a pendulum connected by springs between points, one of them stiff and damped."""
    joints = {
        "X": slide("ground", "cart", start={"s": 0, "v": 0.2, **FIXED}),
        "Y": slide("ground", "block", start={"s": 0.8, "v": 0, **FIXED}),
        "A": hinge("cart", "bob", start={"phi": -1.0, "w": 0, **FIXED}),
    }
    bodies = {"cart": body(1, inertia=(1, 1, 1)), "block": body(2, inertia=(1, 1, 1)), "bob": rod(0.4)}
    forces = {
        "stiff": {"from": "cart", "to": "block", "stiffness": 1e6, "damping": 300, "length": 0.8},
        "soft": {"from": at("bob", 0.4), "to": "block", "stiffness": 50, "length": 0.5},
    }
    forces = {name: {"type": "spring_damper", **spring} for name, spring in forces.items()}
    return driven(scene(bodies, joints, gravity=DOWN_Y, forces=forces), "X")
