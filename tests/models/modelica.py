# SPDX-License-Identifier: BSD-3-Clause
"""Examples of the Modelica Standard Library 4.0.0 (Mechanics.MultiBody.Examples, BSD-3-Clause) as scenes.

Gravity is Modelica's g_n = 9.80665 m/s2 along -y; boxes and cylinders have 7700 kg/m3. The published
curves are Dymola's at tolerance 1e-6; the library compares its own runs to them within 2e-3 of a range.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mechanisms import Scene, body, box, cylinder, frame, frame_sensor, joint, matrix, rotation, scene

G_N = 9.80665
EXCERPTS = Path(__file__).parent / "published" / "msl"
RESULTS = Path(__file__).resolve().parents[3] / "shared" / "reference" / "msl"
ABOUT_Z = {"axis": [0, 0, 1]}


def published(name: str) -> dict[str, np.ndarray]:
    """Return the published curve, or seven rows of it if the file is not available.
    Rows at events are dropped.
    """
    path = RESULTS / f"{name}.csv"
    if not path.is_file():
        path = EXCERPTS / f"{name}.csv"
    table = np.genfromtxt(path, delimiter=",", names=True, deletechars="")
    _, rows = np.unique(table["time"], return_index=True)
    kept = rows[:: max(1, len(rows) // 250)]
    return {key.strip('"'): table[key][kept] for key in table.dtype.names or ()}


def pendulum() -> Scene:
    """Elementary.Pendulum: 1 kg at 0.5 m with Modelica's default inertia, damper 0.1 N m s/rad."""
    return scene(
        {"body": body(1.0, (0.5, 0, 0), (0.001, 0.001, 0.001))},
        {
            "rev": joint(
                "revolute",
                frame("ground"),
                frame("body"),
                **ABOUT_Z,
                damping=0.1,
                start={"phi": 0.0, "w": 0.0, "fixed": True},
            )
        },
        gravity=[0, -G_N, 0],
    )


def double_pendulum() -> Scene:
    """Elementary.DoublePendulum: two boxes of 0.5 x 0.06 x 0.06 m, damper 0.1 at the first revolute joint."""
    return scene(
        {"boxBody1": box((0.5, 0, 0), 0.06, 0.06), "boxBody2": box((0.5, 0, 0), 0.06, 0.06)},
        {
            "revolute1": joint("revolute", frame("ground"), frame("boxBody1"), **ABOUT_Z, damping=0.1),
            "revolute2": joint("revolute", frame("boxBody1", (0.5, 0, 0)), frame("boxBody2"), **ABOUT_Z),
        },
        gravity=[0, -G_N, 0],
    )


def planar_four_bar() -> Scene:
    """Loops.PlanarFourbar: body1 from the origin, body2 on it, body4 from body3's end at (-0.15, 1) in the
    world; boxes 0.05 m wide; all angles are zero at the start.
    """
    ends = {"body1": (0.4, 0, 0), "body2": (0.1, 1.1, 0), "body4": (0.65, 0.1, 0)}
    return scene(
        {name: box(end, 0.05, 0.05) for name, end in ends.items()},
        {
            "revolute1": joint(
                "revolute",
                frame("ground"),
                frame("body1"),
                **ABOUT_Z,
                damping=0.1,
                start={"phi": 0.0, "w": 0.0, "fixed": True},
            ),
            "revolute2": joint("revolute", frame("body1", ends["body1"]), frame("body2"), **ABOUT_Z),
            "revolute3": joint("revolute", frame("ground", (-0.15, 1, 0)), frame("body4"), **ABOUT_Z),
            "revolute4": joint(
                "revolute", frame("body4", ends["body4"]), frame("body2", ends["body2"]), **ABOUT_Z
            ),
        },
        gravity=[0, -G_N, 0],
    )


def fourbar1(chain: bool = False) -> Scene:
    """Loops.Fourbar1: see spatial_loops.ModelicaFourbar1.

    chain: as in Modelica, with three and two revolute joints through massless bodies for the spherical and
    the universal joint.
    """
    start = {"phi": 0.0, "w": 5.235987755982989, "fixed": True}  # 300 deg/s
    bodies = {
        "b1": cylinder((0, 0.5, 0.1), 0.05),
        "b2": cylinder((0, 0.2, 0), 0.05),
        "b3": cylinder((-1, 0.3, 0.1), 0.05),
    }
    joints = {
        "j1": joint("revolute", frame("ground"), frame("b1"), axis=[1, 0, 0], start=start),
        "j2": joint(
            "prismatic", frame("ground", (1.2, 0, 0)), frame("b2"), axis=[1, 0, 0], start={"s": -0.2}
        ),
    }
    top, bottom, tip = frame("b1", (0, 0.5, 0.1)), frame("b2", (0, 0.2, 0)), frame("b3", (-1, 0.3, 0.1))
    if chain:
        bodies.update(x=body(0.0), y=body(0.0), c=body(0.0))
        joints["j3"] = joint("revolute", top, frame("x"), axis=[1, 0, 0])
        joints["j4"] = joint("revolute", frame("x"), frame("y"), axis=[0, 1, 0])
        joints["j5"] = joint("revolute", frame("y"), tip, axis=[0, 0, 1])
        joints["rev"] = joint("revolute", bottom, frame("c"), axis=[0, 1, 0])
        joints["rev1"] = joint("revolute", frame("c"), frame("b3"), axis=[0, 0, 1])
    else:
        joints["ball"] = joint("spherical", top, tip)
        joints["cross"] = joint("universal", bottom, frame("b3"), axes=[[0, 1, 0], [0, 0, 1]])
    return scene(bodies, joints, gravity=[0, -G_N, 0])


TURNED = (
    rotation([1, 0, 0], np.radians(10))
    @ rotation([0, 1, 0], np.radians(55))
    @ rotation([0, 0, 1], np.radians(68))
)
FOOT = frame("ground", (0.2, -0.3, 0.2), TURNED)
PULL = {"type": "spring_damper", "from": frame("ground", (0.8, 0, 0.3)), "stiffness": 20.0, "length": 0.0}


def sprung(joints: Scene, massless: tuple[str, ...] = ()) -> Scene:
    """Constraints: 1 kg, 1 kg m2 about each axis, held at its frame,
    with a spring at its end (no free length).
    """
    bodies = {"body": body(1.0, (0.2, 0, 0), (1, 1, 1))} | {name: body(0.0) for name in massless}
    spring = PULL | {"to": frame("body", (0.4, 0, 0))}
    return scene(bodies, joints, gravity=[0, -G_N, 0], forces={"spring": spring})


def spherical_constraint() -> Scene:
    """Constraints.SphericalConstraint, one of its two bodies, which move equally."""
    return sprung({"ball": joint("spherical", FOOT, frame("body"))})


def prismatic_constraint() -> Scene:
    """Constraints.PrismaticConstraint: two prismatic joints, and a free joint that outputs the motion."""
    joints = {
        "x": joint("prismatic", FOOT, frame("slide"), axis=[1, 0, 0]),
        "y": joint("prismatic", frame("slide"), frame("body"), axis=[0, 1, 0]),
    }
    start = {"r": [0.2, -0.3, 0.2], "rotation": matrix(TURNED)}
    joints["body_moves"] = joint("free", frame("ground"), frame("body"), start=start)
    return sprung(joints, ("slide",))


def spring_damper_system() -> Scene:
    """Elementary.SpringDamperSystem: a body suspended from a spring-damper, and one on a prismatic joint."""
    spring = {"type": "spring_damper", "stiffness": 30.0, "length": 0.1}
    return scene(
        {
            "body1": body(1.0, (0, -0.2, 0), (0.1, 0.1, 0.1)),
            "body2": body(1.0, (0, 0, 0), (0.001, 0.001, 0.001)),
        },
        {
            "free": joint(
                "free",
                frame("ground"),
                frame("body1"),
                start={"r": [0.3, -0.2, 0], "w": [0, 0, 0.03490658503988659]},
            ),
            "p2": joint(
                "prismatic", frame("ground", (0.9, 0, 0)), frame("body2"), axis=[0, -1, 0], start={"s": 0.1}
            ),
        },
        gravity=[0, -G_N, 0],
        forces={
            "spring1": spring | {"from": frame("ground", (0.3, 0, 0)), "to": frame("body1"), "damping": 2.0},
            "spring2": spring | {"from": frame("ground", (0.9, 0, 0)), "to": frame("body2")},
        },
    )


def three_springs(node: float) -> Scene:
    """Elementary.ThreeSprings: three springs connected at a node; node: its mass [kg], 0 in Modelica."""
    spring = {"type": "spring_damper", "length": 0.1}
    at_node = {"to": frame("node"), "stiffness": 20.0}
    return scene(
        {"body1": body(0.8, (0, -0.2, 0), (0.1, 0.1, 0.1)), "node": body(node, inertia=(node, node, node))},
        {
            "free": joint("free", frame("ground"), frame("body1"), start={"r": [0.5, -0.3, 0]}),
            "n": joint("free", frame("ground"), frame("node"), start={"r": [0.1, -0.2, 0.2]}),
        },
        gravity=[0, -G_N, 0],
        forces={
            "spring1": spring | at_node | {"from": frame("ground", (0.3, 0, 0))},
            "spring2": spring | {"from": frame("node"), "to": frame("body1"), "stiffness": 40.0},
            "spring3": spring | at_node | {"from": frame("ground", (0, 0, 0.3))},
        },
    )


def engine1a() -> Scene:
    """Loops.Engine1a: a crank of four pieces with a flywheel of 1 kg m2, rod and piston, in the y-z plane."""
    crank = {
        "crank1": (cylinder((0.1, 0, 0), 0.05), (0, 0, 0)),
        "crank2": (box((0, 0.1, 0), 0.02, 0.05), (0.1, 0, 0)),
        "crank3": (cylinder((0.1, 0, 0), 0.03), (0.1, 0.1, 0)),
        "crank4": (box((0, -0.1, 0), 0.02, 0.05), (0.2, 0.1, 0)),
    }
    about_x = {"axis": [1, 0, 0]}
    start = {"phi": 0.0, "w": 10.0, "fixed": True}
    return scene(
        {name: part for name, (part, _) in crank.items()}
        | {
            "inertia": body(1.0, inertia=(1.0, 0.5, 0.5)),
            "rod": box((0, -0.2, 0), 0.02, 0.06),
            "piston": cylinder((0, -0.1, 0), 0.1),
        },
        {
            f"at_{name}": joint("weld", frame("inertia", place), frame(name))
            for name, (_, place) in crank.items()
        }
        | {
            "bearing": joint("revolute", frame("ground"), frame("inertia"), **about_x, start=start),
            "b1": joint("revolute", frame("inertia", (0.15, 0.1, 0)), frame("rod", (0, -0.2, 0)), **about_x),
            "b2": joint("revolute", frame("piston", (0, -0.1, 0)), frame("rod"), **about_x),
            "cylinder": joint(
                "prismatic",
                frame("ground", (0.15, 0.45, 0)),
                frame("piston"),
                axis=[0, -1, 0],
                start={"s": 0.05},
            ),
        },
        gravity=[0, -G_N, 0],
    )


def gyroscopic_effects() -> Scene:
    """Rotational3DEffects.GyroscopicEffects: an oblique rotor on an arm suspended from a ball joint."""
    slant = frame("arm", (0.25, 0, 0), rotation([0, 1, 0], np.radians(45)))
    start = {"phi": 0.0, "w": 10.0, "fixed": True}
    return scene(
        {"arm": cylinder((0.25, 0, 0), 0.05), "rotor": cylinder((0.2, 0, 0), 0.1)},
        {
            "ball": joint("spherical", frame("ground"), frame("arm")),
            "revolute": joint("revolute", slant, frame("rotor", (0.1, 0, 0)), axis=[1, 0, 0], start=start),
        },
        gravity=[0, -G_N, 0],
        sensors={"rotor": frame_sensor("rotor"), "arm": frame_sensor("arm")},
    )


def rolling_wheel() -> Scene:
    """Elementary.RollingWheel: a thin wheel on the plane z = 0, its axis initially along y."""
    start = {"r": [0.2, 0.2, 0.3], "v": [1.5, -0.3, 0], "w": [1, 5, 0], "fixed": True}
    return scene(
        {"wheel": body(2.0, (0, 0, 0), (0.12, 0.06, 0.12))},
        {"free": joint("free", frame("ground"), frame("wheel"), start=start)},
        gravity=[0, 0, -G_N],
        constraints={"contact": {"type": "rolling", "body": "wheel", "radius": 0.3, "axis": [0, 1, 0]}},
    )
