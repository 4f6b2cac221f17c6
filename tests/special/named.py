# SPDX-License-Identifier: BSD-3-Clause
"""Linkages with one degree of freedom, as scenes and as functions of the crank angle:
references at special positions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from mechanisms import GRAVITY, Array, Scene, body, four_bar, frame, joint, rod, scene
from models.one_dof import Geometry, Jet, Moving, OneDofMechanism, atan2, cos, jet, sin, sqrt
from models.planar_loops import FourBar, place, uniform

Z = {"axis": [0, 0, 1]}
DOWN = (0.0, -GRAVITY, 0.0)
Angles = Callable[[Jet], dict[str, Jet]]
LEVELS = {"phi": ("phi", "w", "a"), "s": ("s", "v", "a")}


@dataclass(frozen=True)
class Linkage:
    """The scene at a crank angle and speed; bodies and joint coordinates as functions of that angle.

    The crank joint is A; its motor is `drive`.
    """

    source: Callable[[float, float], Scene]
    geometry: Geometry
    coordinates: Angles
    friction: float = 0.0  # N m s/rad at the crank

    def acceleration(self, phi: float, w: float) -> float:
        motion = OneDofMechanism(self.geometry, DOWN, lambda _t, _phi, rate: -self.friction * rate)
        return motion.acceleration(0.0, phi, w)

    def outputs(self, phi: float, w: float) -> dict[str, float]:
        """All coordinates, velocities and accelerations."""
        a = self.acceleration(phi, w)
        out: dict[str, float] = {}
        for name, x in self.coordinates(Jet(phi, 1.0)).items():
            joint_name, _, q = name.partition(".")
            levels = (x.x, x.d * w, x.d * a + x.dd * w * w)
            out |= {f"{joint_name}.{n}": v for n, v in zip(LEVELS[q], levels, strict=True)}
        return out

    def derivatives(self, phi: float, w: float) -> dict[str, Array]:
        """Derivatives of all outputs with respect to phi and w: central differences of sixth order."""

        def along(dphi: float, dw: float) -> dict[str, float]:
            sides = {k: self.outputs(phi + k * dphi, w + k * dw) for k in (-3, -2, -1, 1, 2, 3)}
            weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
            return {
                n: sum(c * (sides[k][n] - sides[-k][n]) for k, c in weights.items()) / max(dphi, dw)
                for n in sides[1]
            }

        by_phi, by_w = along(1e-3, 0.0), along(0.0, 1e-3)
        return {n: np.array([by_phi[n], by_w[n]]) for n in by_phi}

    def inertia(self, phi: float) -> float:
        return sum(moving.reduced()[0] for moving in self.geometry(Jet(phi, 1.0)))


def _started(source: Scene, coordinates: Angles, phi: float, w: float) -> Scene:
    """Coordinates and velocities of all joints as guesses, those of the crank fixed."""
    for name, x in coordinates(Jet(phi, 1.0)).items():
        joint_name, _, q = name.partition(".")
        start = {q: x.x, LEVELS[q][1]: x.d * w}
        source["joints"][joint_name]["start"] = start | ({"fixed": True} if joint_name == "A" else {})
    return source


def crank_slider(r: float, length: float, offset: float = 0.0) -> Linkage:
    """Crank and rod of uniform bars of 2 kg/m, a slider of 1.5 kg on the line y = offset, to the right."""
    crank, connecting = uniform(2, r), uniform(2, length)

    def rod_angle(phi: Jet) -> Jet:
        rise = offset - r * sin(phi)
        return atan2(rise, sqrt(length * length - rise * rise))

    def coordinates(phi: Jet) -> dict[str, Jet]:
        theta = rod_angle(phi)
        s = r * cos(phi) + length * cos(theta)
        return {"A.phi": phi, "B.phi": theta - phi, "C.phi": -theta, "P.s": s}

    def geometry(phi: Jet) -> Iterator[Moving]:
        yield place(crank, jet(0), jet(0), phi)
        yield place(connecting, r * cos(phi), r * sin(phi), rod_angle(phi))
        yield Moving(1.5, (coordinates(phi)["P.s"], jet(offset), jet(0)), jet(0), 0.01)

    def source(phi: float, w: float) -> Scene:
        bodies = {
            "crank": rod(2 * r, r),
            "rod": rod(2 * length, length),
            "slider": body(1.5, inertia=[0.01] * 3),
        }
        joints = {
            "A": joint("revolute", frame("ground"), frame("crank"), **Z),
            "B": joint("revolute", frame("crank", (r, 0, 0)), frame("rod"), **Z),
            "C": joint("revolute", frame("rod", (length, 0, 0)), frame("slider"), **Z),
            "P": joint("prismatic", frame("ground", (0, offset, 0)), frame("slider"), axis=[1, 0, 0]),
        }
        out = scene(bodies, joints, gravity=list(DOWN), motors={"drive": {"joint": "A"}})
        return _started(out, coordinates, phi, w)

    return Linkage(source, geometry, coordinates)


def four_bar_linkage(links: tuple[float, float, float, float], branch: int = 1) -> Linkage:
    """Bars of 2 kg/m, `mechanisms.four_bar`; branch -1: the coupler turned to the right."""
    crank, coupler, rocker, ground = links
    bars = FourBar(uniform(2, crank), uniform(2, coupler), uniform(2, rocker), ground, branch)

    def coordinates(phi: Jet) -> dict[str, Jet]:
        theta, psi = bars.angles(phi)
        return {"A.phi": phi, "B.phi": theta - phi, "C.phi": psi - theta, "D.phi": psi}

    def source(phi: float, w: float) -> Scene:
        return _started(four_bar(phi, links), coordinates, phi, w)

    return Linkage(source, bars.geometry(), coordinates, friction=0.1)


def scotch_yoke(r: float) -> Linkage:
    """Crank, a block of 0.5 kg on its pin in the slot along y of a yoke of 1.5 kg that slides along x."""
    crank = uniform(2, r)

    def coordinates(phi: Jet) -> dict[str, Jet]:
        return {"A.phi": phi, "B.phi": -phi, "S.s": r * sin(phi), "P.s": r * cos(phi)}

    def geometry(phi: Jet) -> Iterator[Moving]:
        yield place(crank, jet(0), jet(0), phi)
        yield Moving(0.5, (r * cos(phi), r * sin(phi), jet(0)), jet(0), 0.01)
        yield Moving(1.5, (r * cos(phi), jet(0), jet(0)), jet(0), 0.01)

    def source(phi: float, w: float) -> Scene:
        bodies = {
            "crank": rod(2 * r, r),
            "block": body(0.5, inertia=[0.01] * 3),
            "yoke": body(1.5, inertia=[0.01] * 3),
        }
        joints = {
            "A": joint("revolute", frame("ground"), frame("crank"), **Z),
            "B": joint("revolute", frame("crank", (r, 0, 0)), frame("block"), **Z),
            "S": joint("prismatic", frame("yoke"), frame("block"), axis=[0, 1, 0]),
            "P": joint("prismatic", frame("ground"), frame("yoke"), axis=[1, 0, 0]),
        }
        out = scene(bodies, joints, gravity=list(DOWN), motors={"drive": {"joint": "A"}})
        return _started(out, coordinates, phi, w)

    return Linkage(source, geometry, coordinates)


def turning_block(r: float, ground: float) -> Linkage:
    """Inverted slider-crank: a rod of 3 m slides through a block that rotates about (ground, 0)."""
    crank, gliding = uniform(2, r), uniform(2, 3.0)

    def rod_vector(phi: Jet) -> tuple[Jet, Jet]:
        return ground - r * cos(phi), -(r * sin(phi))

    def coordinates(phi: Jet) -> dict[str, Jet]:
        x, y = rod_vector(phi)
        theta = atan2(y, x)
        return {"A.phi": phi, "B.phi": theta - phi, "D.phi": theta, "P.s": -sqrt(x * x + y * y)}

    def geometry(phi: Jet) -> Iterator[Moving]:
        theta = coordinates(phi)["D.phi"]
        yield place(crank, jet(0), jet(0), phi)
        yield place(gliding, r * cos(phi), r * sin(phi), theta)
        yield Moving(0.5, (jet(ground), jet(0), jet(0)), theta, 0.02)

    def source(phi: float, w: float) -> Scene:
        bodies = {"crank": rod(2 * r, r), "rod": rod(6.0, 3.0), "block": body(0.5, inertia=[0.02] * 3)}
        joints = {
            "A": joint("revolute", frame("ground"), frame("crank"), **Z),
            "B": joint("revolute", frame("crank", (r, 0, 0)), frame("rod"), **Z),
            "D": joint("revolute", frame("ground", (ground, 0, 0)), frame("block"), **Z),
            "P": joint("prismatic", frame("block"), frame("rod"), axis=[1, 0, 0]),
        }
        out = scene(bodies, joints, gravity=list(DOWN), motors={"drive": {"joint": "A"}})
        return _started(out, coordinates, phi, w)

    return Linkage(source, geometry, coordinates)
