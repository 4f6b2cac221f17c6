# SPDX-License-Identifier: BSD-3-Clause
"""Single bodies on a joint as modeled in ADAMS/Solver: the cases with which Project Chrono tests its joints.

Model data (ADAMS decks; where they lack it, the constants of the tests) and curves: projectchrono/chrono,
data/testing/joints and src/tests/unit_tests/joints, BSD-3-Clause, by Mike Taylor and Radu Serban. A body of
1 kg, gravity along -z, initially at rest. Body frames initially coincide with the ground frame, so that
the position QP of a marker in its part is its position in the ground.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mechanisms import Array, Scene, body, frame, general_body, joint, matrix, reaction, rotation, scene
from scipy.spatial.transform import Rotation

from models.running import Recording

G_N = 9.80665
EXCERPTS = Path(__file__).parent / "published" / "adams"
CURVES = Path(__file__).resolve().parents[3] / "shared" / "reference" / "adams"
KINDS = {  # of quantities in ground axes: prefix and suffix of the column names
    "position": ("Pos", "Pos"),
    "velocity": ("Vel", "Vel"),
    "acceleration": ("Acc", "Acc"),
    "turning": ("Avel", "AngVel"),
    "angular acceleration": ("Aacc", "AngAcc"),
    "force": ("Rforce", "Force"),
    "torque": ("Rtorque", "Torque"),
}
FIRST = {"RevSpherical_Case01": "_Body1", "LinActuator_Case01": "P"}  # of two reactions, that of joint J


def published(name: str) -> tuple[Array, dict[str, Array]]:
    """Return times and the ADAMS table by kind, or selected rows of it if the file is not available."""
    path = CURVES / f"{name}.csv"
    if not path.is_file():
        path = EXCERPTS / f"{name}.csv"
    table = np.genfromtxt(path, delimiter=",", names=True, deletechars="")
    out = {}
    for kind, (begin, end) in KINDS.items():
        begin += FIRST.get(name, "") if begin.startswith("R") else ""
        out[kind] = np.array([table[f"{begin}.{x}_{end}"] for x in "XYZ"]).T
    out["quaternion"] = np.array([table[f"Quat.e{i}"] for i in range(4)]).T
    return table["time"], out


def shown(found: Recording, source: Scene) -> dict[str, Array]:
    """Return the same quantities of a run: in ground axes;
    force and torque that the joint exerts on the ground.
    """
    R = Rotation.from_quat(found.vector("CM.Q"))
    out = {
        "position": found.vector("CM.r"),
        "velocity": found.vector("CM.v"),
        "acceleration": found.vector("CM.a"),
        "turning": R.apply(found.vector("CM.w")),
        "angular acceleration": R.apply(found.vector("CM.z")),
        "quaternion": found.vector("CM.Q")[:, [3, 0, 1, 2]],
    }
    if "J" in source["joints"]:
        F = np.array(source["joints"]["J"]["parent"].get("rotation", {"matrix": np.eye(3)})["matrix"])
        out["force"] = -found.vector("on_J.f") @ F.T
        out["torque"] = -found.vector("on_J.t") @ F.T
    else:  # a spring and its force law: the motion is straight
        law = source["forces"]["S"]
        out["force"] = law["stiffness"] * out["position"] + law["damping"] * out["velocity"]
        out["torque"] = 0 * out["force"]
    return out


def euler(psi: float, theta: float, phi: float) -> Array:
    """Axes of a marker by REULER [deg]: rotations about its z, its x and its z again."""
    z, x = [0, 0, 1], [1, 0, 0]
    a, b, c = np.radians([psi, theta, phi])
    return rotation(z, a) @ rotation(x, b) @ rotation(z, c)


ALONG = euler(0, 0, 0)
Z_TO_Y = euler(180, 90, 180)
Z_TO_MINUS_Y = euler(0, 90, 0)


def pendulum(
    joints: Mapping[str, Any],
    com: tuple[float, float, float],
    axes: Array = ALONG,
    inertia: tuple[float, float, float] = (0.04, 0.1, 0.1),
    **fields: Any,
) -> Scene:
    """com, axes: position and axes of the marker CM, whose principal moments are `inertia` (IP).

    Besides the joints that hold the body, a free joint from the ground to CM outputs its motion, including
    accelerations. A rod is massless.
    """
    J = axes @ np.diag(inertia) @ axes.T
    start = {"r": list(com), "rotation": matrix(axes)}
    bodies = {"part": general_body(1.0, np.array(com), J)}
    if any(j["child"]["body"] == "rod" for j in joints.values()):
        bodies["rod"] = body(0.0)
    return scene(
        bodies,
        {**joints, "CM": joint("free", frame("ground"), frame("part", com, axes), start=start)},
        gravity=[0, 0, -G_N],
        sensors={f"on_{name}": reaction(name) for name in joints},
        **fields,
    )


def hung(kind: str, com: tuple[float, float, float], R: Array = ALONG, **fields: Any) -> Scene:
    """A body at the ground origin on a joint between markers with the axes R;
    the CM marker has the same axes.
    """
    own = {k: fields.pop(k) for k in ("axis", "axes", "stiffness", "damping", "start") if k in fields}
    J = joint(kind, frame("ground", R=R), frame("part", R=R), **own)
    return pendulum({"J": J}, com, axes=R, **fields)


def universal() -> Scene:
    """HOOKE: the cross has the x of marker I and the y of marker J."""
    cross = [[1, 0, 0], [0, 1, 0]]
    return hung("universal", (0, 2, 0), Z_TO_MINUS_Y, axes=cross, inertia=(0.1, 0.1, 0.04))


def distance() -> Scene:
    """GCON: the center of mass remains 2 m away from the origin; here by a rod between two joints."""
    J = joint("universal", frame("ground"), frame("rod"), axes=[[1, 0, 0], [0, 0, 1]])
    K = joint("spherical", frame("rod", (0, 2, 0)), frame("part", (0, 2, 0)))
    return pendulum({"J": J, "K": K}, (0, 2, 0))


def revolute_spherical() -> Scene:
    """A rod of 2 m that rotates about the vertical z carries the body,
    whose center is 2 m aside, on a ball joint.
    """
    J = joint("revolute", frame("ground"), frame("rod"), axis=[0, 0, 1])
    K = joint("spherical", frame("rod", (2, 0, 0)), frame("part", (2, 0, 0)))
    return pendulum({"J": J, "K": K}, (2, 2, 0), inertia=(0.1, 0.04, 0.1))


def on_a_spring() -> Scene:
    """A translational spring-damper without free length,
    from the origin to the initial position of the center of mass.
    """
    ends = {"from": frame("ground"), "to": frame("part")}
    return pendulum(
        {},
        (0, 0, 0),
        forces={"S": {"type": "spring_damper", **ends, "stiffness": 10.0, "damping": 0.5, "length": 0.0}},
    )


def linear_actuator() -> Scene:
    """A plate on a vertical prismatic joint that moves at 1 m/s, prescribed by an actuator."""
    return hung(
        "prismatic",
        (0, 0, 0),
        axis=[0, 0, 1],
        inertia=(1, 1, 1),
        start={"s": 0.0, "v": 1.0},
        constraints={"actuator": {"type": "motion", "joint": "J", "speed": 1.0}},
    )


SCENES: dict[str, Callable[[], Scene]] = {
    "Cylindrical_Case01": lambda: hung("cylindrical", (2, 0, 0), axis=[0, 0, 1]),
    "Distance_Case01": distance,
    "Prismatic_Case01": lambda: hung("prismatic", (2, 0, 0), axis=[0, 0, 1]),
    "RevSpherical_Case01": revolute_spherical,
    "Revolute_Case01": lambda: hung("revolute", (2, 0, 0), Z_TO_Y),
    # 200 N m/rad, 10 N m s/rad as in Chrono's test; a deck with other values is stored beside the table.
    "RotSpring_Case01": lambda: hung("revolute", (2, 0, 0), Z_TO_Y, stiffness=200.0, damping=10.0),
    "Spherical_Case01": lambda: hung("spherical", (2, 0, 0)),
    "TranSpring_Case01": on_a_spring,  # 10 N/m, 0.5 N s/m, as in Chrono's test
    "TranSpringCB_Case01": on_a_spring,  # the same numbers in another of Chrono's links
    "Universal_Case01": universal,
}
