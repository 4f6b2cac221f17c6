# SPDX-License-Identifier: BSD-3-Clause
"""Scenes from URDF robot descriptions (needs the extra `urdf`).

A link becomes a body in the link's own frame, a joint keeps its name, frame, axis and viscous damping, and
every joint that can be driven gets a motor `JOINT_motor`. What is not taken over is told in words.
"""

from __future__ import annotations

import logging
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gelenk.errors import SceneError
from gelenk.extras import extra
from gelenk.io.urdf_inertia import impossible_inertias, repaired
from gelenk.model import foreign
from gelenk.model.scene import Scene, from_dict

KINDS = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "weld",
    "floating": "free",
    "planar": "planar",
}
DRIVEN = ("revolute", "prismatic")
GRAVITY = 9.81  # m/s2 along -z: URDF says nothing of it, its tools mean this


def import_urdf(
    path: str | PathLike[str],
    *,
    floating: bool = False,
    repair_inertia: bool = False,
    assembly_tolerance: float | None = None,
) -> Scene:
    """A scene from a URDF file; meshes and shapes are not needed and not looked for.

    Args:
        path: the .urdf file. Its root link is welded to the ground with the frames in line.
        floating: let the root link move freely instead.
        repair_inertia: take the nearest physical inertia where a link that can move has one that no rigid
            body has: negative second moments about the centre of mass are raised to a millionth of the
            largest. A link that moves without mass and inertia gets a millionth of its carrier's. All other
            masses and inertias stay as they are to the bit.
        assembly_tolerance: the scene's `assembly.tolerance`, for loops that are closed by joints added to it.

    Returns:
        Scene: its `report` tells, line by line, what was not taken over, and what was repaired by how much.

    Raises:
        SceneError: the file is no URDF, or describes what no robot can be.
        UsageError: the reader is not installed.
        OSError: the file cannot be read.
    """
    file = Path(path)
    _check(file)
    scene, name, notes = _convert(file, _read(file), floating)
    if assembly_tolerance is not None:
        scene["assembly"] = {"tolerance": assembly_tolerance}
    if repair_inertia:
        return repaired(scene, name, notes)
    try:
        return from_dict(scene, name, notes)
    except SceneError as e:
        if not impossible_inertias(e):
            raise
        advice = "--repair-inertia (repair_inertia=True) takes the nearest moments that one has"
        raise SceneError([*e.lines, f"{file}: {advice}"]) from None


def _check(file: Path) -> None:
    """What the reader of URDF would pass over in silence or stumble over without a word for the user."""
    try:
        root = ET.fromstring(file.read_bytes())
    except ET.ParseError as e:
        line, column = e.position
        raise SceneError(f"{file}:{line}:{column + 1}: no XML: {str(e).split(':')[0]}") from None
    if root.tag != "robot":
        foreign.refuse_content(file.read_bytes(), str(file), "a URDF robot description (<robot>)")
        raise SceneError(f"{file}: found <{root.tag}>, expected <robot>")
    if any(element.tag.startswith("{http://www.ros.org/wiki/xacro}") for element in root.iter()):
        raise SceneError(f"{file}: holds xacro macros; expand it with xacro first")
    faults = _name_faults(file, root)
    links = [e.get("name") for e in root.findall("link")]
    for joint in root.findall("joint"):
        faults += _joint_faults(f"{file}: joint {joint.get('name')}", joint, links)
    for body in root.findall("link"):
        faults += _inertial_faults(f"{file}: link {body.get('name')}", body.find("inertial"))
    if not links:
        faults.append(f"{file}: has no links")
    if faults:
        raise SceneError(faults)


def _name_faults(file: Path, root: ET.Element) -> list[str]:
    faults = [
        f"{file}: {e.tag}: has no name" for e in root if e.tag in ("link", "joint") and not e.get("name")
    ]
    for tag in ("link", "joint"):
        names = [e.get("name") for e in root.findall(tag)]
        faults += [f"{file}: {tag} {n}: is there twice" for n in dict.fromkeys(names) if names.count(n) > 1]
    return faults


def _joint_faults(where: str, joint: ET.Element, links: Sequence[str | None]) -> list[str]:
    faults = []
    if joint.get("type") not in KINDS:
        faults.append(f"{where}: found type {joint.get('type')!r}, expected one of {', '.join(KINDS)}")
    for role in ("parent", "child"):
        element = joint.find(role)
        link = None if element is None else element.get("link")
        if link not in links:
            faults.append(f"{where}: {role}: found {link!r}, which is no link")
    return faults


def _inertial_faults(where: str, inertial: ET.Element | None) -> list[str]:
    if inertial is None:
        return []
    faults = []
    mass = inertial.find("mass")
    if mass is None or mass.get("value") is None:
        faults.append(f"{where}: inertial: has no mass value")
    inertia = inertial.find("inertia")
    if inertia is not None:
        missing = [name for name in ("ixx", "iyy", "izz") if inertia.get(name) is None]
        faults += [f"{where}: inertia: has no {name}" for name in missing]
    return faults


def _read(file: Path) -> Any:
    yourdfpy = extra("yourdfpy", "importing URDF needs yourdfpy")
    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)  # its errors reach the user as ours
    try:
        return yourdfpy.URDF.load(
            str(file), build_scene_graph=False, load_meshes=False, load_collision_meshes=False
        ).robot
    except Exception as e:  # the reader's own, and ValueError for numbers that are none
        raise SceneError(f"{file}: {' '.join(str(e).split()) or type(e).__name__}") from e


def _convert(file: Path, robot: Any, floating: bool) -> tuple[dict[str, Any], str, list[str]]:
    notes: list[str] = []
    names = _Names(notes)
    bodies = {link.name: names.take("link", link.name, "link") for link in robot.links}
    joints = {joint.name: names.take("joint", joint.name, "joint") for joint in robot.joints}
    root = _root(file, robot)
    attach = names.take("joint", "base" if floating else f"{root}_to_ground", "joint", told=False)
    scene: dict[str, Any] = {
        "gelenk": 1,
        "name": _identifier(robot.name or file.stem),
        "gravity": [0.0, 0.0, -GRAVITY],
        "bodies": {bodies[link.name]: _body(link) for link in robot.links},
        "joints": {
            attach: {
                "type": "free" if floating else "weld",
                "parent": {"body": "ground"},
                "child": {"body": bodies[root]},
            }
        },
    }
    scene["joints"] |= {joints[j.name]: _joint(j, bodies) for j in robot.joints}
    driven = [joints[j.name] for j in robot.joints if KINDS[j.type] in DRIVEN]
    scene["motors"] = {names.take("motor", f"{name}_motor", "motor"): {"joint": name} for name in driven}
    notes += _left_out(robot)
    return scene, str(file), notes


def _root(file: Path, robot: Any) -> str:
    children = [joint.child for joint in robot.joints]
    faults = [
        f"{file}: link {name}: is the child of {children.count(name)} joints, expected at most one"
        for name in dict.fromkeys(children)
        if children.count(name) > 1
    ]
    roots = [link.name for link in robot.links if link.name not in children]
    if len(roots) != 1:
        found = ", ".join(roots) or "none"
        faults.append(
            f"{file}: found the root links {found}, expected exactly one (a link that is no joint's child)"
        )
    if faults:
        raise SceneError(faults)
    return str(roots[0])


def _body(link: Any) -> dict[str, Any]:
    inertial = link.inertial
    if inertial is None:
        return {"mass": 0.0}
    body: dict[str, Any] = {"mass": float(inertial.mass)}
    origin = np.eye(4) if inertial.origin is None else inertial.origin
    R = origin[:3, :3]  # the inertial frame in the link's
    if origin[:3, 3].any():
        body["com"] = _numbers(origin[:3, 3])
    if inertial.inertia is not None and inertial.inertia.any():
        J = inertial.inertia if np.array_equal(R, np.eye(3)) else R @ inertial.inertia @ R.T
        body["inertia"] = _numbers([J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]])
    return body


def _joint(joint: Any, bodies: dict[str, str]) -> dict[str, Any]:
    kind = KINDS[joint.type]
    entry: dict[str, Any] = {"type": kind}
    if kind in ("revolute", "prismatic", "planar"):
        axis = np.asarray(joint.axis, float)
        entry["axis"] = _numbers(axis)
    parent: dict[str, Any] = {"body": bodies[joint.parent]}
    if joint.origin is not None:
        if joint.origin[:3, 3].any():
            parent["position"] = _numbers(joint.origin[:3, 3])
        rotation = _rotation(joint.origin[:3, :3])
        if rotation:
            parent["rotation"] = rotation
    entry["parent"] = parent
    entry["child"] = {"body": bodies[joint.child]}
    damping = _loss(joint, "damping")
    if damping and kind in DRIVEN:
        entry["damping"] = damping
    return entry


def _rotation(R: NDArray[np.float64]) -> dict[str, Any]:
    """Roll, pitch and yaw, as people write them, where they give the matrix back to rounding."""
    if np.array_equal(R, np.eye(3)):
        return {}
    rpy = [
        float(np.arctan2(R[2, 1], R[2, 2])),
        float(np.arctan2(-R[2, 0], np.hypot(R[2, 1], R[2, 2]))),
        float(np.arctan2(R[1, 0], R[0, 0])),
    ]
    if np.abs(_rpy_matrix(rpy) - R).max() <= 1e-15:  # a few roundings of numbers up to 1
        return {"rpy": _numbers(rpy)}
    return {"matrix": [_numbers(row) for row in R]}


def _rpy_matrix(rpy: list[float]) -> NDArray[np.float64]:
    """Turns about the fixed axes x, y, z in this order."""
    (a, b, c), (p, q, r) = np.cos(rpy), np.sin(rpy)
    x = np.array([[1, 0, 0], [0, a, -p], [0, p, a]])
    y = np.array([[b, 0, q], [0, 1, 0], [-q, 0, b]])
    z = np.array([[c, -r, 0], [r, c, 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def _left_out(robot: Any) -> list[str]:
    """One line per kind of thing that the scene does not hold."""
    movable = [j for j in robot.joints if j.type != "fixed"]
    notes = [_mimicry(j) for j in movable if j.mimic is not None]
    notes += _losses(movable)
    limited = [j.name for j in movable if j.limit is not None]
    if limited:
        notes.append(
            f"limits of position, speed and effort are not modelled: {_list(limited)}; "
            "a joint's `stop` in the scene holds a position, with a stiffness that URDF does not tell"
        )
    massless = [link.name for link in robot.links if link.inertial is None or not link.inertial.mass]
    if massless:
        notes.append(f"links without mass: {_list(massless)}")
    shapes = sum(len(link.visuals) + len(link.collisions) for link in robot.links)
    if shapes:
        notes.append(f"shapes and meshes are not taken over: {shapes}")
    if robot.transmission:
        notes.append("transmissions are not taken over: every motor has gear ratio 1")
    return notes


def _mimicry(joint: Any) -> str:
    free = "here it moves freely" + (" and has a motor" if KINDS[joint.type] in DRIVEN else "")
    return f"joint {joint.name}: follows {joint.mimic.joint} in the file (mimic); {free}"


def _losses(movable: Sequence[Any]) -> list[str]:
    frictions = {j.name: _loss(j, "friction") for j in movable}
    dampings = {j.name: _loss(j, "damping") for j in movable if KINDS[j.type] not in DRIVEN}
    return [
        f"joint {name}: its {what} of {number:g} is not modelled"
        for what, losses in (("dry friction", frictions), ("damping", dampings))
        for name, number in losses.items()
        if number
    ]


def _loss(joint: Any, name: str) -> float:
    """Friction or damping of a joint; 0 where the file tells none."""
    return float((joint.dynamics and getattr(joint.dynamics, name)) or 0.0)


def _list(names: list[str]) -> str:
    return ", ".join(names)


def _numbers(values: Iterable[float]) -> list[float]:
    return [float(x) + 0.0 for x in values]  # + 0.0: no minus zeros


def _identifier(name: str) -> str:
    """Letters, digits and underscores, not beginning with a digit."""
    word = re.sub(r"[^A-Za-z0-9_]+", "_", name)
    return word if re.match(r"[A-Za-z_]", word) else f"_{word}"


class _Names:
    """Names of bodies, joints and motors: identifiers, each used once. A change is noted."""

    def __init__(self, notes: list[str]) -> None:
        self._notes = notes
        self._taken = {
            "ground",
            "gravity",
            "assembly",
            "solver",
            "constraints",
            "energy",
            "time",
        }  # FMU variables begin so

    def take(self, what: str, wanted: str, ending: str, *, told: bool = True) -> str:
        name = _identifier(wanted)
        if name in self._taken:
            name = f"{name}_{ending}"
        base, n = name, 2
        while name in self._taken:
            name, n = f"{base}{n}", n + 1
        self._taken.add(name)
        if name != wanted and told:
            self._notes.append(f"{what} {wanted}: is called {name} here")
        return name
