# SPDX-License-Identifier: BSD-3-Clause
"""Scenes for tests, built as plain dictionaries in the scene format: SI units, angles in radians."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk._core import elements

Array = NDArray[np.float64]
Scene = dict[str, Any]
Numbers = Sequence[float] | Array

GRAVITY = 9.81  # m/s2, unless a test requires another value

# Axis fields of joints that permit rotation about z; the other axis of a universal joint is x.
HINGE_AXES: dict[str, dict[str, Any]] = {
    "revolute": {"axis": [0, 0, 1]},
    "cylindrical": {"axis": [0, 0, 1]},
    "universal": {"axes": [[0, 0, 1], [1, 0, 0]]},
}


def numbers(values: Numbers) -> list[float]:
    return [float(x) for x in values]


def matrix(R: Array) -> dict[str, Any]:
    """A rotation in scene format from a 3x3 matrix whose columns are the axes of the frame."""
    return {"matrix": [numbers(row) for row in R]}


def rotation(axis: Numbers, angle: float) -> Array:
    """3x3 matrix of the rotation by angle [rad] about axis."""
    n = np.asarray(axis, float) / np.linalg.norm(axis)
    K = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    R: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return R


def frame(body: str, position: Numbers = (0, 0, 0), R: Array | None = None) -> dict[str, Any]:
    """A frame fixed in a body: position [m] and, if not aligned with the body axes, rotation."""
    out: dict[str, Any] = {"body": body, "position": numbers(position)}
    if R is not None:
        out["rotation"] = matrix(R)
    return out


def body(mass: float, com: Numbers = (0, 0, 0), inertia: Numbers = (0, 0, 0)) -> dict[str, Any]:
    """Mass [kg], center of mass [m], inertia about it [kg m2]: 3 or 6 numbers xx yy zz (xy xz yz)."""
    moments = numbers(inertia)
    return {"mass": mass, "com": numbers(com), "inertia": moments + [0.0] * (6 - len(moments))}


def rod(mass: float, length: float) -> dict[str, Any]:
    """A slender uniform rod along x, with its frame at one end."""
    transverse = mass * length**2 / 12
    return body(mass, (length / 2, 0, 0), (0, transverse, transverse))


def box(end: Numbers, width: float, height: float, density: float = 7700.0) -> dict[str, Any]:
    """A box between the frame origin and `end` in the x-y plane; width is in the plane, height along z."""
    r = np.asarray(end, float)
    length = float(np.linalg.norm(r))
    mass = density * length * width * height
    along = np.array([height**2 + width**2, length**2 + height**2, length**2 + width**2]) * mass / 12
    R = rotation([0, 0, 1], float(np.arctan2(r[1], r[0])))
    return general_body(mass, r / 2, R @ np.diag(along) @ R.T)


def cylinder(end: Numbers, diameter: float, density: float = 7700.0) -> dict[str, Any]:
    """A solid cylinder between the frame origin and `end`."""
    r = np.asarray(end, float)
    length = float(np.linalg.norm(r))
    mass = density * np.pi * diameter**2 / 4 * length
    n = r / length
    radius = diameter / 2
    axial, transverse = mass * radius**2 / 2, mass * (3 * radius**2 + length**2) / 12
    return general_body(mass, r / 2, transverse * np.eye(3) + (axial - transverse) * np.outer(n, n))


def general_body(mass: float, com: Array, J: Array) -> dict[str, Any]:
    """A body from its 3x3 inertia about the center of mass."""
    return body(mass, com, [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]])


def inertia_matrix(entry: Mapping[str, Any]) -> Array:
    """3x3 inertia about the center of mass of a body in scene format."""
    xx, yy, zz, xy, xz, yz = entry["inertia"]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def joint(kind: str, parent: dict[str, Any], child: dict[str, Any], **fields: Any) -> dict[str, Any]:
    """A joint between two frames; fields as in the scene format (axis, start, damping, ...)."""
    return {"type": kind, "parent": parent, "child": child, **fields}


def scene(bodies: Mapping[str, Any], joints: Mapping[str, Any], **fields: Any) -> Scene:
    """A scene without gravity unless `gravity` is among the fields."""
    return {"gelenk": 1, "bodies": dict(bodies), "joints": dict(joints), **fields}


def four_bar(
    phi: float = 1.1,
    links: tuple[float, float, float, float] = (0.5, 1.75, 1.5, 2.0),
    line_density: float = 2.0,
    damping: float = 0.1,
    torque: float | None = None,
    gravity: Numbers = (0, -GRAVITY, 0),
) -> Scene:
    """A planar four-bar of uniform rods in the x-y plane, at rest with its crank at phi [rad].

    links: crank, coupler, rocker, ground [m]; line_density [kg/m]; damping of the crank [N m s/rad].
    Joints A (ground-crank), B (crank-coupler), C (coupler-rocker), D (ground-rocker), all about z; the
    coupler is above the line between the tip of the crank and D. The motor `drive` turns A; if
    `torque` [N m] is given, a constant wrench on the crank replaces the motor.
    """
    crank, coupler, rocker, ground = links
    theta, psi = four_bar_angles(phi, links)
    about_z = {"axis": [0, 0, 1]}
    out = scene(
        {
            name: rod(line_density * length, length)
            for name, length in (("crank", crank), ("coupler", coupler), ("rocker", rocker))
        },
        {
            "A": joint(
                "revolute",
                frame("ground"),
                frame("crank"),
                **about_z,
                damping=damping,
                start={"phi": phi, "w": 0.0, "fixed": True},
            ),
            "B": joint(
                "revolute",
                frame("crank", (crank, 0, 0)),
                frame("coupler"),
                **about_z,
                start={"phi": theta - phi},
            ),
            "C": joint(
                "revolute",
                frame("coupler", (coupler, 0, 0)),
                frame("rocker", (rocker, 0, 0)),
                **about_z,
                start={"phi": psi - theta},
            ),
            "D": joint(
                "revolute", frame("ground", (ground, 0, 0)), frame("rocker"), **about_z, start={"phi": psi}
            ),
        },
        gravity=numbers(gravity),
        name="FourBar",
    )
    if torque is None:
        out["motors"] = {"drive": {"joint": "A"}}
    else:
        out["forces"] = {"drive": {"type": "wrench", "body": "crank", "torque": [0.0, 0.0, torque]}}
    return out


def four_bar_angles(phi: float, links: tuple[float, float, float, float]) -> tuple[float, float]:
    """Absolute angles (coupler, rocker) [rad] at the crank angle phi,
    on the open branch above the diagonal.
    """
    crank, coupler, rocker, ground = links
    x, y = ground - crank * np.cos(phi), -crank * np.sin(phi)
    diagonal = np.hypot(x, y)
    opening = np.arccos((coupler**2 + diagonal**2 - rocker**2) / (2 * coupler * diagonal))
    theta = np.arctan2(y, x) + opening
    psi = np.arctan2(coupler * np.sin(theta) - y, coupler * np.cos(theta) - x)
    return float(theta), float(psi)


def placed(source: Scene, R: Array, p: Numbers = (0, 0, 0)) -> Scene:
    """The same scene rotated by R and moved by p [m] as a whole: ground frames, gravity, world wrenches.

    Start values of joints on the ground do not change, because they are relative to the joint frames.
    """
    out = copy.deepcopy(source)

    def place(place_of: dict[str, Any], point: bool = False) -> None:
        if place_of["body"] == "ground":
            R_old = np.array(place_of.get("rotation", {"matrix": np.eye(3)})["matrix"])
            place_of["position"] = numbers(R @ np.array(place_of["position"]) + np.asarray(p))
            if not point:
                place_of["rotation"] = matrix(R @ R_old)

    for entry in out["joints"].values():
        place(entry["parent"])
        place(entry["child"])
    kinds = {kind["name"]: kind for kind in elements.kinds()["forces"]}
    for force in out.get("forces", {}).values():
        kind = kinds[force["type"]]
        for port in kind["ports"]:
            place(force[port["name"]] if port["name"] else force, point=port["kind"] == "point")
        words = {f["name"]: f["words"][f["default"]] for f in kind["fields"] if "world" in f["words"]}
        if any(force.get(name, otherwise) == "world" for name, otherwise in words.items()):
            for key in (f["name"] for f in kind["fields"] if f["type"] == "vector" and f["name"] in force):
                force[key] = numbers(R @ np.array(force[key]))
    out["gravity"] = numbers(R @ np.array(source.get("gravity", [0, 0, 0])))
    return out


def reordered(source: Scene, seed: int) -> Scene:
    """The same scene with its bodies and joints listed in another order."""
    rng = np.random.default_rng(seed)
    out = copy.deepcopy(source)
    for section in ("bodies", "joints"):
        names = list(out[section])
        out[section] = {names[i]: out[section][names[i]] for i in rng.permutation(len(names))}
    return out


def with_sensors(source: Scene, **sensors: dict[str, Any]) -> Scene:
    """The same scene with these sensors added to its own."""
    out = copy.deepcopy(source)
    out.setdefault("sensors", {}).update(sensors)
    return out


def reaction(joint_name: str) -> dict[str, Any]:
    return {"type": "reaction", "joint": joint_name}


def frame_sensor(body_name: str, position: Numbers = (0, 0, 0), R: Array | None = None) -> dict[str, Any]:
    return {"type": "frame", **frame(body_name, position, R)}
