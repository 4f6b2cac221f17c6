# SPDX-License-Identifier: BSD-3-Clause
"""A joint gives the same motion and the same reactions as a tree joint and as a loop-closing joint.

An arm turns on a pin; the joint under test connects a body to the arm. In the second scene the body is also
connected to the ground through a gantry: three prismatic and three revolute joints with massless links, which
constrain nothing and add no inertia. Joints with a drive that has a rotor remain in the tree, so idle drives
on the gantry and on the pin cause the joint under test to be cut: only its constraint equations hold the
body. Their rotor inertias of 1e-13 kg m2 (kg) are too small to have an effect at rtol 1e-10.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mechanisms import GRAVITY, Array, Scene, body, frame, joint, reaction, rotation, scene
from models.running import assert_close, run

import gelenk
from gelenk._core import joints as registry

TIMES = np.linspace(0, 1, 11)
PIN_ANGLE, PIN_PLACE = 0.6, np.array([0.3, -0.2, 0.5])
R_PIN = rotation([0.3, 1, -0.2], 0.7)
# F on the arm and M on the body, both offset from the body frames.
P_F, R_F = np.array([0.4, 0.1, -0.15]), rotation([1, -0.4, 0.5], 1.1)
P_M, R_M = np.array([-0.1, 0.15, 0.05]), rotation([0.2, 0.7, -0.9], -0.8)

UNIT_Q = [0.1, -0.3, 0.3, 0.9]  # rotated by 0.9 rad
# Start values of the joint under test, within reach of the gantry's revolute joints (no gimbal lock in 1 s),
# and axes.
STARTS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "revolute": ({"axis": [0.3, -0.5, 0.8]}, {"phi": 0.3, "w": -0.8}),
    "prismatic": ({"axis": [0.3, -0.5, 0.8]}, {"s": 0.2, "v": 0.5}),
    "screw": ({"axis": [0.3, -0.5, 0.8], "pitch": 0.15}, {"phi": 0.3, "w": -0.8}),
    "cylindrical": ({"axis": [0.3, -0.5, 0.8]}, {"s": 0.2, "phi": 0.3, "v": 0.5, "w": -0.8}),
    "universal": (
        {"axes": [[1, 0.2, 0], [0.1, 0.5, 0.9]]},
        {"phi_a": 0.2, "phi_b": -0.3, "w_a": 0.6, "w_b": 0.4},
    ),
    "spherical": ({}, {"Q": UNIT_Q, "w": [0.4, -0.5, 0.7]}),
    "planar": (
        {"axis": [0.3, -0.5, 0.8]},
        {"s_x": 0.1, "s_y": -0.2, "phi": 0.3, "v_x": 0.4, "v_y": 0.3, "w": 0.5},
    ),
    "free": ({}, {"r": [0.05, -0.1, 0.08], "Q": UNIT_Q, "v": [0.3, -0.2, 0.1], "w": [0.4, -0.5, 0.7]}),
    "weld": ({}, {}),
}
KINDS = [kind["name"] for kind in registry.kinds()]


def in_tree(kind: str) -> Scene:
    axes, start = STARTS[kind]
    tested = joint(kind, frame("arm", P_F, R_F), frame("load", P_M, R_M), **axes)
    if start:
        tested["start"] = {**start, "fixed": True}
    return scene(
        {
            "arm": body(1.2, (0.2, 0.05, -0.1), (0.03, 0.05, 0.04, 0.002, -0.003, 0.004)),
            "load": body(0.9, (0.05, -0.1, 0.08), (0.06, 0.05, 0.07, -0.004, 0.003, 0.002)),
        },
        {
            "pin": joint(
                "revolute",
                frame("ground", PIN_PLACE, R_PIN),
                frame("arm"),
                axis=[0, 0, 1],
                start={"phi": PIN_ANGLE, "w": 0.9, "fixed": True},
            ),
            "T": tested,
        },
        gravity=[0.5, -0.3, -GRAVITY],
        forces={
            "push": {
                "type": "wrench",
                "body": "load",
                "position": [0.1, 0.2, -0.05],
                "force": [0.7, -1.1, 0.9],
                "torque": [0.04, 0.02, -0.03],
            }
        },
        sensors={"R": reaction("T"), "R_pin": reaction("pin")},
    )


def in_loop(kind: str) -> Scene:
    """Return the scene above with the gantry: X, Y, Z translate, A, B, C rotate about x, y, z,
    close to zero at the start.
    """
    out = in_tree(kind)
    R_arm = R_PIN @ rotation([0, 0, 1], PIN_ANGLE)
    R_load: Array = R_arm @ R_F @ R_M.T
    p_load: Array = PIN_PLACE + R_arm @ (P_F - R_F @ R_M.T @ P_M)
    steps = [
        ("X", "prismatic", 0),
        ("Y", "prismatic", 1),
        ("Z", "prismatic", 2),
        ("A", "revolute", 0),
        ("B", "revolute", 1),
        ("C", "revolute", 2),
    ]
    holder = frame("ground", p_load, R_load)
    for name, slide_or_turn, axis in steps:
        part = "load" if name == "C" else f"part_{name}"
        if part not in out["bodies"]:
            out["bodies"][part] = body(0.0)
        out["joints"][name] = joint(slide_or_turn, holder, frame(part), axis=np.eye(3)[axis].tolist())
        holder = frame(part)
    driven = ("pin", "X", "Y", "Z", "A", "B", "C")
    out["motors"] = {f"m{name}": {"joint": name, "rotor_inertia": 1e-13} for name in driven}
    return out


def test_every_joint_type_is_tested() -> None:
    """A new joint type requires start values in the table above."""
    assert set(KINDS) == set(STARTS)


@pytest.mark.parametrize("kind", KINDS)
def test_tree_joint_and_loop_joint_give_equal_motion(kind: str) -> None:
    """Coordinates, velocities, accelerations and reactions of the joint and of the
    pin are compared, 1 s at rtol 1e-10.
    """
    tree = run(in_tree(kind), TIMES, tolerance=1e-10)
    loop = run(in_loop(kind), TIMES, tolerance=1e-10)
    names = [name for name in tree.units if name.split(".")[0] in ("T", "pin")]
    for name in names:
        # accelerations and reactions follow from the states: about 10 times their error
        bound = 1e-7 if tree.units[name].endswith("/s2") else 1e-8
        assert_close(name, loop[name], tree[name], bound, "100 rtol, 1 s")
    for name in [n for n in tree.units if n.split(".")[0] in ("R", "R_pin")]:
        assert_close(name, loop[name], tree[name], 1e-7, "1000 rtol: follows from the states, 30 N")
    assert_close("constraints.position", loop["constraints.position"], 0, 1e-10, "closure")
    assert_close("constraints.velocity", loop["constraints.velocity"], 0, 1e-9, "closure")


@pytest.mark.parametrize("kind", KINDS)
def test_joint_under_test_is_the_loop_closing_joint(kind: str) -> None:
    """The 6 - nv constrained directions are the constraint equations;
    the joint's own DOF and that of the pin remain.
    """
    degrees_of_freedom = next(k["nv"] for k in registry.kinds() if k["name"] == kind)
    simulation = gelenk.Simulation(gelenk.load(in_loop(kind)))
    simulation.initialize()
    assert simulation.size.constraint_equations == 6 - degrees_of_freedom
    assert simulation.size.degrees_of_freedom == 1 + degrees_of_freedom


@pytest.mark.parametrize("kind", KINDS)
def test_start_values_are_as_specified(kind: str) -> None:
    """fixed: true also holds for a joint that is cut: exactly in the tree,
    to the closure tolerance in a loop.
    """
    for source, bound in ((in_tree(kind), 1e-15), (in_loop(kind), 1e-9)):
        simulation = gelenk.Simulation(gelenk.load(source))
        simulation.initialize(0.0, 1e-10)
        for name, value in STARTS[kind][1].items():
            elements = enumerate(value, 1) if isinstance(value, list) else [("", value)]
            for i, x in elements:
                signal = f"T.{name}[{i}]" if i else f"T.{name}"
                assert_close(signal, simulation.output(signal), x, bound, "fixed start value")


@pytest.mark.parametrize("kind", KINDS)
def test_parallel_free_joint_does_not_change_the_motion(kind: str) -> None:
    """A free joint between ground and body constrains nothing, whichever of the two joints is cut."""
    source = in_tree(kind)
    source["joints"]["beside"] = joint("free", frame("ground"), frame("load"))
    plain = run(in_tree(kind), TIMES, tolerance=1e-10)
    found = run(source, TIMES, tolerance=1e-10)
    for name in plain.units:
        assert_close(name, found[name], plain[name], 1e-7, "1000 rtol")
