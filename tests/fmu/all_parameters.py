# SPDX-License-Identifier: BSD-3-Clause
"""Scenes that offer as a parameter whatever can be one."""

from __future__ import annotations

import copy

from mechanisms import Scene

SPRUNG = {
    "revolute",
    "prismatic",
    "universal",
    "cylindrical",
    "planar",
}  # their coordinates are no quaternions
TURNS = {
    "weld": 0,
    "revolute": 1,
    "prismatic": 1,
    "universal": 2,
    "cylindrical": 2,
    "spherical": 3,
    "planar": 3,
}


# Of constraints; a sine's are numbers in a mapping.
NUMBERS = {
    "motion": ("polynomial", "speed"),
    "gear": ("ratio", "offset"),
    "rack": ("radius", "offset"),
    "rolling": ("radius",),
}


def settable_paths(source: Scene) -> list[str]:
    """Paths of everything in a scene that `parameters` may list, gravity aside."""
    paths = [f"{name}.{key}" for name in source["bodies"] for key in ("mass", "com", "inertia")]
    for name, joint in source["joints"].items():
        if joint["type"] != "weld":
            paths.append(f"{name}.damping")
        if joint["type"] in SPRUNG:
            paths += [f"{name}.stiffness", f"{name}.spring_reference"]
        stop = joint.get("stop", {})
        paths += [f"{name}.stop.{key}" for key in ("lower", "upper") if key in stop]
        paths += [f"{name}.stop.{key}" for key in ("stiffness", "damping") if stop]
        paths += [f"{name}.parent.position", f"{name}.child.position"]
    for name in source.get("motors", {}):
        paths += [f"{name}.gear_ratio", f"{name}.rotor_inertia"]
    for name, force in source.get("forces", {}).items():
        keys = ("force", "torque") if force["type"] == "wrench" else ("stiffness", "damping", "length")
        paths += [f"{name}.{key}" for key in keys]
    for name, constraint in source.get("constraints", {}).items():
        paths += [f"{name}.{key}" for key in NUMBERS.get(constraint["type"], ()) if key in constraint]
        paths += [f"{name}.sine.{key}" for key in ("amplitude", "frequency", "phase") if "sine" in constraint]
    return paths


def offering_all(source: Scene) -> Scene:
    """The same scene with all of them as parameters."""
    out = copy.deepcopy(source)
    out["parameters"] = settable_paths(source)
    return out


def observed(source: Scene) -> Scene:
    """The same scene with a sensor on every joint and body."""
    out = copy.deepcopy(source)
    sensors = out.setdefault("sensors", {})
    sensors["all_energy"] = {"type": "energy"}
    for name in out["bodies"]:
        sensors[f"frame_of_{name}"] = {"type": "frame", "body": name}
    for name in out["joints"]:
        sensors[f"reaction_of_{name}"] = {"type": "reaction", "joint": name}
    return out
