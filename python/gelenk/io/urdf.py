# SPDX-License-Identifier: BSD-3-Clause
"""Import of URDF robot descriptions as scenes (requires the extra `urdf`).

A link becomes a body in the link's own frame, a joint keeps its name, frame, axis, viscous damping, dry
friction and, on request, limits of position, and every joint that can be driven gets a motor `JOINT_motor`.
Everything that is not converted is listed in the scene's report.
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
from gelenk.file_reading import read_bytes, usable_name
from gelenk.io.urdf_ignored import ignored
from gelenk.io.urdf_inertia import impossible_inertias, notes_on_missing, repaired
from gelenk.io.urdf_limits import bounds_of, limit_notes, start_within
from gelenk.io.urdf_mimic import DRIVEN, KINDS, coupling_of, mimicry
from gelenk.model import other_formats
from gelenk.model.scene import Scene, from_dict
from gelenk.model.values import is_number

MAX_BYTES = 16_000_000  # of a file; robots have up to 1 MB
GRAVITY = 9.81  # m/s2 along -z; URDF does not specify gravity, its tools assume this value


def import_urdf(
    path: str | PathLike[str],
    *,
    floating: bool = False,
    repair_inertia: bool = False,
    limits: bool = True,
    assembly_tolerance: float | None = None,
) -> Scene:
    """Convert a URDF file to a scene; meshes and shapes are ignored.

    Args:
        path: the .urdf file. Its root link is welded to the ground with aligned frames.
        floating: whether the root link moves freely instead.
        repair_inertia: whether to replace the physically impossible inertia of a movable link by the nearest
            possible one: negative second moments about the center of mass are raised to a millionth of the
            largest. A movable link without mass and inertia gets a millionth of those of its carrier. All
            other masses and inertias are unchanged.
        limits: whether the limits of position of revolute and prismatic joints become hard limits, without
            restitution. A joint of which the limits do not contain 0 then starts in the middle between them.
        assembly_tolerance: the scene's `assembly.tolerance`, for loops that are closed by joints added to it.

    Returns:
        Scene: its `report` lists, line by line, what was not converted, which joints have dry friction, and
            what was repaired by how much.

    Raises:
        SceneError: the file is not URDF, or its robot is invalid.
        UsageError: the URDF reader is not installed.
        OSError: the file cannot be read.
    """
    file = usable_name(path)
    root = _check(file)
    scene, name, notes = _convert(file, _read(file), floating, limits)
    notes += ignored(root)
    if assembly_tolerance is not None:
        scene["assembly"] = {"tolerance": assembly_tolerance}
    if repair_inertia:
        return repaired(scene, name, notes)
    try:
        return from_dict(scene, name, [*notes, *notes_on_missing(scene)])
    except SceneError as e:
        if not impossible_inertias(e):
            raise
        advice = (
            "--repair-inertia (repair_inertia=True) replaces impossible inertias by the nearest possible ones"
        )
        raise SceneError([*e.lines, f"{file}: {advice}"]) from None


def _check(file: Path) -> ET.Element:
    """Return the element <robot>; report faults that the URDF reader ignores or does not explain."""
    content = read_bytes(file, MAX_BYTES)
    if b"<!ENTITY" in content or b"\0" in content:
        raise SceneError(f"{file}: found entities or zero bytes, expected plain XML in UTF-8")
    try:
        root = ET.fromstring(content)
    except ET.ParseError as e:
        line, column = e.position
        raise SceneError(f"{file}:{line}:{column + 1}: not XML: {str(e).split(':')[0]}") from None
    except (ValueError, LookupError) as e:  # encodings
        raise SceneError(f"{file}: not XML in UTF-8: {e}") from None
    if root.tag != "robot":
        other_formats.refuse_content(content, str(file), "a URDF robot description (<robot>)")
        raise SceneError(f"{file}: found <{root.tag}>, expected <robot>")
    if any(element.tag.startswith("{http://www.ros.org/wiki/xacro}") for element in root.iter()):
        raise SceneError(f"{file}: contains xacro macros; expand it with xacro first")
    faults = _name_faults(file, root)
    links = [e.get("name") for e in root.findall("link")]
    for joint in root.findall("joint"):
        faults += _joint_faults(f"{file}: joint {joint.get('name')}", joint, links)
    for body in root.findall("link"):
        faults += _inertial_faults(f"{file}: link {body.get('name')}", body.find("inertial"))
    if not links:
        faults.append(f"{file}: found no links, expected at least one")
    if faults:
        raise SceneError(faults)
    return root


def _name_faults(file: Path, root: ET.Element) -> list[str]:
    faults = [
        f"{file}: {e.tag}: found no name, expected one"
        for e in root
        if e.tag in ("link", "joint") and not e.get("name")
    ]
    for tag in ("link", "joint"):
        names = [e.get("name") for e in root.findall(tag)]
        faults += [
            f"{file}: {tag} {n}: found twice, expected once"
            for n in dict.fromkeys(names)
            if names.count(n) > 1
        ]
    return faults


def _joint_faults(where: str, joint: ET.Element, links: Sequence[str | None]) -> list[str]:
    faults = []
    if joint.get("type") not in KINDS:
        faults.append(f"{where}: found type {joint.get('type')!r}, expected one of {', '.join(KINDS)}")
    for role in ("parent", "child"):
        element = joint.find(role)
        link = None if element is None else element.get("link")
        if link not in links:
            faults.append(f"{where}: {role}: found {link!r}, expected the name of a link")
    dynamics = joint.find("dynamics")
    for name, value in () if dynamics is None else dynamics.items():
        if name in ("damping", "friction") and not is_number(value):
            faults.append(f"{where}: dynamics: {name}: found {value!r}, expected a number")
    return faults


def _inertial_faults(where: str, inertial: ET.Element | None) -> list[str]:
    if inertial is None:
        return []
    faults = []
    mass = inertial.find("mass")
    if mass is None or mass.get("value") is None:
        faults.append(f"{where}: inertial: found no mass value, expected one")
    inertia = inertial.find("inertia")
    if inertia is not None:
        missing = [name for name in ("ixx", "iyy", "izz") if inertia.get(name) is None]
        faults += [f"{where}: inertia: found no {name}, expected one" for name in missing]
    return faults


def _read(file: Path) -> Any:
    yourdfpy = extra("yourdfpy", "importing URDF needs yourdfpy")
    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)  # its errors are reported as SceneError
    try:
        return yourdfpy.URDF.load(
            str(file), build_scene_graph=False, load_meshes=False, load_collision_meshes=False
        ).robot
    except Exception as e:  # exceptions of the reader, and ValueError for invalid numbers
        raise SceneError(f"{file}: {' '.join(str(e).split()) or type(e).__name__}") from e


def _convert(file: Path, robot: Any, floating: bool, limits: bool) -> tuple[dict[str, Any], str, list[str]]:
    notes: list[str] = []
    names = _Names(notes)
    bodies = {link.name: names.take("link", link.name, "link") for link in robot.links}
    joints = {joint.name: names.take("joint", joint.name, "joint") for joint in robot.joints}
    root = _root(file, robot)
    attach = names.take("joint", "base" if floating else f"{root}_to_ground", "joint", noted=False)
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
    scene["joints"] |= {joints[j.name]: _joint(j, bodies, limits) for j in robot.joints}
    by_name = {joint.name: joint for joint in robot.joints}
    couplings = {
        names.take("constraint", f"{joints[j.name]}_mimic", "constraint", noted=False): coupling
        for j in robot.joints
        if (coupling := coupling_of(j, by_name, joints)) is not None
    }
    driven = [j for j in robot.joints if KINDS[j.type] in DRIVEN and coupling_of(j, by_name, joints) is None]
    scene["motors"] = {
        names.take("motor", f"{joints[j.name]}_motor", "motor"): {"joint": joints[j.name]} for j in driven
    }
    if couplings:
        scene["constraints"] = couplings
    notes += _remarks(robot, limits)
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
            f"{file}: found the root links {found}, expected exactly one "
            "(a link that is not the child of a joint)"
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
    R = origin[:3, :3]  # orientation of the inertial frame in the link frame
    if origin[:3, 3].any():
        body["com"] = _numbers(origin[:3, 3])
    if inertial.inertia is not None and inertial.inertia.any():
        J = inertial.inertia if np.array_equal(R, np.eye(3)) else R @ inertial.inertia @ R.T
        body["inertia"] = _numbers([J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]])
    return body


def _joint(joint: Any, bodies: dict[str, str], limits: bool) -> dict[str, Any]:
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
    friction = _loss(joint, "friction")
    if friction and kind in DRIVEN:
        entry["friction"] = {"coulomb": friction}
    if limits and (bounds := bounds_of(joint)):
        entry["limit"] = {"lower": bounds[0], "upper": bounds[1]}
        if (start := start_within(bounds)) != 0:
            entry["start"] = {"phi" if kind == "revolute" else "s": start}
    return entry


def _rotation(R: NDArray[np.float64]) -> dict[str, Any]:
    """Return roll, pitch and yaw of a rotation if they reproduce it to rounding, else its matrix."""
    if np.array_equal(R, np.eye(3)):
        return {}
    rpy = [
        float(np.arctan2(R[2, 1], R[2, 2])),
        float(np.arctan2(-R[2, 0], np.hypot(R[2, 1], R[2, 2]))),
        float(np.arctan2(R[1, 0], R[0, 0])),
    ]
    if np.abs(_rpy_matrix(rpy) - R).max() <= 1e-15:  # a few rounding errors of numbers up to 1
        return {"rpy": _numbers(rpy)}
    return {"matrix": [_numbers(row) for row in R]}


def _rpy_matrix(rpy: list[float]) -> NDArray[np.float64]:
    """Return the matrix of rotations about the fixed axes x, y, z in this order."""
    (a, b, c), (p, q, r) = np.cos(rpy), np.sin(rpy)
    x = np.array([[1, 0, 0], [0, a, -p], [0, p, a]])
    y = np.array([[b, 0, q], [0, 1, 0], [-q, 0, b]])
    z = np.array([[c, -r, 0], [r, c, 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def _remarks(robot: Any, limits: bool) -> list[str]:
    """Return the notes on what the scene does not contain, and on what limits its use."""
    movable = [j for j in robot.joints if j.type != "fixed"]
    by_name = {joint.name: joint for joint in robot.joints}
    notes = [mimicry(j, by_name) for j in movable if j.mimic is not None]
    notes += _losses(movable)
    rubbing = [j.name for j in movable if KINDS[j.type] in DRIVEN and _loss(j, "friction")]
    if rubbing:
        notes.append(
            f"joints with dry friction: {_list(rubbing)}; "
            "linear models at rest are those of locked joints, and equilibria are those without friction; "
            "gelenk.equilibrium(..., friction='present') determines whether it holds a pose"
        )
    notes += limit_notes(movable, limits)
    massless = [link.name for link in robot.links if link.inertial is None or not link.inertial.mass]
    if massless:
        notes.append(f"links without mass: {_list(massless)}")
    shapes = sum(len(link.visuals) + len(link.collisions) for link in robot.links)
    if shapes:
        notes.append(f"shapes and meshes are not converted: {shapes}")
    if robot.transmission:
        notes.append("transmissions are not converted: every motor has gear ratio 1")
    return notes


def _losses(movable: Sequence[Any]) -> list[str]:
    return [
        f"joint {j.name}: its {what} of {_loss(j, name):g} is not modeled"
        for what, name in (("dry friction", "friction"), ("damping", "damping"))
        for j in movable
        if KINDS[j.type] not in DRIVEN and _loss(j, name)
    ]


def _loss(joint: Any, name: str) -> float:
    """Return friction or damping of a joint; 0 if the file contains none."""
    return float((joint.dynamics and getattr(joint.dynamics, name)) or 0.0)


def _list(names: list[str]) -> str:
    return ", ".join(names)


def _numbers(values: Iterable[float]) -> list[float]:
    return [float(x) + 0.0 for x in values]  # + 0.0 turns -0.0 into 0.0


def _identifier(name: str) -> str:
    """Return a name with letters, digits and underscores only, which does not begin with a digit."""
    word = re.sub(r"[^A-Za-z0-9_]+", "_", name)
    return word if re.match(r"[A-Za-z_]", word) else f"_{word}"


class _Names:
    """Unique identifiers for bodies, joints and motors; changes of names are noted."""

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
        }  # the first parts of FMU variable names

    def take(self, what: str, wanted: str, ending: str, *, noted: bool = True) -> str:
        """Return an unused identifier for a name.

        Args:
            what: what is named, for the note: "joint".
            wanted: the name in the URDF file.
            ending: appended to names that are used already or reserved.
            noted: whether a change is noted.
        """
        name = _identifier(wanted)
        if name in self._taken:
            name = f"{name}_{ending}"
        base, n = name, 2
        while name in self._taken:
            name, n = f"{base}{n}", n + 1
        self._taken.add(name)
        if name != wanted and noted:
            self._notes.append(f"{what} {wanted}: renamed to {name}")
        return name
