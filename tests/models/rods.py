# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms with massless rods."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from mechanisms import GRAVITY, Numbers, Scene, body, four_bar, frame, joint, rotation, scene

import gelenk

LINKS = (0.5, 1.75, 1.5, 2.0)  # m, of the planar four-bar: crank, coupler, rocker, ground


def sizes(source: Scene, **reductions: bool) -> tuple[int, int, int]:
    """Numbers of velocities, constraint equations and degrees of freedom."""
    made = copy.deepcopy(source)
    made["solver"] = {"reductions": reductions}
    simulation = gelenk.Simulation(gelenk.load(made))
    simulation.initialize()
    size = simulation.size
    return size.velocities, size.constraint_equations, size.degrees_of_freedom


def planar_four_bar(**fields: Any) -> Scene:
    """The four-bar of tests/mechanisms.py, at a moderate speed, with a massless coupler."""
    out = four_bar(damping=0.0, gravity=(0, 0, 0), torque=0.0, **fields)
    del out["forces"]
    out["bodies"]["coupler"] = body(0)
    out["joints"]["A"]["start"]["w"] = 3.0
    return out


def spatial_four_bar(
    first: str = "universal",
    rod_is_child: tuple[bool, bool] = (True, False),
    axes: Numbers = (0.6, 0.8, 0.0),
    mass: float = 0.0,
) -> Scene:
    """R-(U rod S)-R in space, all frames oblique; the crank makes full turns. axes: a, b being z x a.

    rod_is_child: of the universal (spherical) joint U, and of the spherical joint S.
    """
    R_D, p_D = rotation([0.3, 1, 0.2], 1.1), np.array([1.0, 0.2, -0.1])
    crank_tip, rocker_tip = np.array([0.25, 0.0, 0.05]), np.array([0.5, 0.1, 0.0])
    R_A, R_rocker = rotation([0, 0, 1], 0.4), R_D @ rotation([0, 0, 1], 0.9)
    span = p_D + R_rocker @ rocker_tip - R_A @ crank_tip
    length = float(np.linalg.norm(span))
    e = R_A.T @ span / length
    # On the crank, U's z axis points approximately along the rod; on the rod, it is along it.
    upright = rotation(np.cross([0, 0, 1], e), np.arccos(e[2])) @ rotation([1, 0.4, 0], 0.35)
    R_rod = rotation([0.2, 0.5, -0.4], 0.8)
    halves = {
        "U": [frame("crank", crank_tip, upright), frame("rod", (0, 0, 0), R_rod)],
        "S": [
            frame("rocker", rocker_tip, rotation([1, 0.3, 0.2], 0.6)),
            frame("rod", R_rod @ [0, 0, length], rotation([1, 1, 0], 0.3)),
        ],
    }
    for name, child in zip("US", rod_is_child, strict=True):
        if not child:
            halves[name].reverse()
    a = np.array(axes, float)
    about: dict[str, Any] = (
        {"axes": [a.tolist(), np.cross([0, 0, 1], a).tolist()]} if first == "universal" else {}
    )
    inertia = [mass * 0.1] * 3
    return scene(
        {
            "crank": body(1.0, (0.1, 0.02, 0.01), (0.01, 0.02, 0.02)),
            "rod": body(mass, (0, 0, 0), inertia),
            "rocker": body(1.5, (0.2, 0.0, 0.05), (0.02, 0.05, 0.04)),
        },
        {
            "A": joint(
                "revolute",
                frame("ground"),
                frame("crank"),
                axis=[0, 0, 1],
                start={"phi": 0.4, "w": 6.0, "fixed": True},
            ),
            "D": joint(
                "revolute",
                frame("ground", p_D, R_D),
                frame("rocker"),
                axis=[0, 0, 1],
                start={"phi": 0.9, "fixed": True},
            ),
            "U": joint(first, *halves["U"], **about),
            "S": joint("spherical", *halves["S"]),
        },
        gravity=[0, -GRAVITY, 0],
    )


def hung_platform(
    rods: int, start: dict[str, Any], ends: tuple[str, str] = ("universal", "spherical")
) -> Scene:
    """A platform on equal vertical rods of 1.3 m, at the corners of a regular polygon (two: of a line)."""
    bodies: dict[str, Any] = {"platform": body(3.0, (0, 0, -0.2), (0.1, 0.1, 0.15))}
    joints: dict[str, Any] = {}
    for i in range(rods):
        angle = 2 * np.pi * i / rods
        corner = (0.4 * np.cos(angle), 0.4 * np.sin(angle), 0)
        bodies[f"rod{i}"] = body(0)
        about = {"axes": [[1, 0, 0], [0, 1, 0]]} if ends[0] == "universal" else {}
        joints[f"U{i}"] = joint(ends[0], frame("ground", corner), frame(f"rod{i}"), **about, start=start)
        joints[f"S{i}"] = joint(
            ends[1], frame(f"rod{i}", (0, 0, -1.3)), frame("platform", corner), start={"Q": [0, 0, 0, 1]}
        )
    return scene(bodies, joints, gravity=[0, 0, -GRAVITY])


def hung_plank(rods: int) -> Scene:
    """A plank on equal rods of 1 m with revolute joints about z; it translates without rotation."""
    about_z = {"axis": [0, 0, 1]}
    bodies: dict[str, Any] = {"plank": body(2.0, (0.5, -0.1, 0), (0.1, 0.1, 0.1))}
    joints: dict[str, Any] = {}
    for i in range(rods):
        place = (0.5 * i, 0, 0)
        bodies[f"rod{i}"] = body(0)
        start: dict[str, Any] = {"phi": 0.4, "w": 0.5, "fixed": True} if i == 0 else {"phi": 0.4}
        joints[f"A{i}"] = joint("revolute", frame("ground", place), frame(f"rod{i}"), **about_z, start=start)
        joints[f"B{i}"] = joint(
            "revolute",
            frame(f"rod{i}", (0, -1, 0)),
            frame("plank", place),
            **about_z,
            start={"phi": -0.4},
        )
    return scene(bodies, joints, gravity=[0, -GRAVITY, 0])
