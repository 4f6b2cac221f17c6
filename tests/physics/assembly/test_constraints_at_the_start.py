# SPDX-License-Identifier: BSD-3-Clause
"""Constraints at the start: written and read again, satisfied by assembly, or rejected with the reason."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from mechanisms import Scene, body, frame, joint, scene

import gelenk
from physics.constraints.test_driven_loops import driven
from physics.constraints.test_gears import disc, planetary, shafts, three_shafts


def of_all_kinds() -> Scene:
    """Every kind of constraint, each with all its keys."""
    about_z: dict[str, Any] = {"axis": [0, 0, 1]}
    on_table: dict[str, Any] = {"type": "motion", "joint": "T"}
    wheels = "abcde"
    sine = {"amplitude": 0.1, "frequency": 2.5, "phase": 0.3}
    table = {"time": [0, 0.4, 1.5], "value": [0.1, 0.3, 0.1], "periodic": True, "interpolation": "akima"}
    return scene(
        {name: disc(1.0, 0.1) for name in wheels}
        | {"bar": body(1.0), "table": disc(2.0, 0.1), "disc": disc(1.0, 0.2)}
        | {"sled": body(1.5, (0, 0, 0), (0.1, 0.1, 0.1))},
        {
            **{name.upper(): joint("revolute", frame("ground"), frame(name), **about_z) for name in wheels},
            "S": joint("prismatic", frame("ground"), frame("bar"), axis=[1, 0, 0]),
            "T": joint("planar", frame("ground"), frame("table")),
            "P": joint("planar", frame("ground", (0, 5, 0)), frame("sled")),
            "F": joint("free", frame("ground"), frame("disc"), start={"r": [0, 0, 0.3]}),
        },
        constraints={
            "both": on_table | {"coordinate": "s_x", "polynomial": [0.1, 1, -0.5], "sine": sine},
            "tabular": on_table | {"coordinate": "s_y", "table": table},
            "steady": {"type": "motion", "joint": "A", "speed": -2.5},
            "placed": {"type": "motion", "joint": "B", "input": "position"},
            "turned": on_table | {"coordinate": "phi", "input": "speed"},
            "mesh": {"type": "gear", "joint": "C", "with": "D", "carrier": "E", "ratio": -2.2, "offset": 0.7},
            "teeth": {"type": "rack", "rack": "S", "pinion": "D", "radius": -0.05, "offset": 0.01},
            "tyre": {"type": "rolling", "body": "disc", "axis": [0, 1, 0], "radius": 0.3},
            "blade": {
                "type": "knife_edge",
                "body": "sled",
                "position": [-0.5, 0, 0],
                "axis": [0, 1, 0],
                "on": {"body": "ground", "position": [0, 0, 0.1]},
            },
        },
    )  # fmt: skip


def test_constraints_are_written_as_they_are_read() -> None:
    source = gelenk.load(of_all_kinds())
    written = source.to_dict()
    again = gelenk.load(json.loads(json.dumps(written)))
    assert again.to_dict() == written
    for name, given in of_all_kinds()["constraints"].items():
        entry = written["constraints"][name]
        for key in given.keys() - {"on", "position"}:  # frames are written in full, or not at all
            assert entry[key] == given[key], (name, key)
    first, second = (gelenk.Simulation(s) for s in (source, again))
    for plant in (first, second):
        plant.initialize()
        plant.step_to(0.1)
    assert np.array_equal(first.values(), second.values())


def refusal(source: Scene, **inputs: float) -> str:
    plant = gelenk.Simulation(gelenk.load(source))
    for name, value in inputs.items():
        plant.set_input(name.replace("__", "."), value)
    with pytest.raises(gelenk.AssemblyError) as error:
        plant.initialize()
    return str(error.value)


def starting(source: Scene, joint_name: str, **start: Any) -> Scene:
    source["joints"][joint_name]["start"] = start
    return source


def test_fixed_angle_that_contradicts_a_motion_is_named_with_a_consistent_value() -> None:
    message = refusal(starting(driven(polynomial=[1.1, 2]), "A", phi=0.5, fixed=True))
    assert "constraints.drive cannot be satisfied at the start" in message
    assert "0.6 rad" in message
    assert "A.phi" in message
    assert "1.1 rad instead of 0.5 rad" in message


def test_fixed_velocity_that_contradicts_a_motion_is_named_with_a_consistent_value() -> None:
    message = refusal(starting(driven(polynomial=[1.1, 2]), "A", phi=1.1, w=0.0, fixed=True))
    assert "fixed start velocities of A" in message
    assert "2 rad/s instead of 0 rad/s" in message


def test_fixed_angle_elsewhere_in_the_loop_is_named() -> None:
    message = refusal(starting(driven(polynomial=[1.1, 2]), "D", phi=2.9, fixed=True))
    advice = re.search(r"D\.phi .* would then be ([0-9.]+) rad instead of 2\.9 rad", message)
    assert advice, message


def test_two_fixed_angles_that_contradict_a_gear_are_named() -> None:
    source = starting(starting(shafts(-2.0), "A", phi=1.0, fixed=True), "B", phi=1.0, fixed=True)
    message = refusal(source)
    assert "constraints.mesh cannot be satisfied at the start" in message
    assert "A.phi, B.phi contradict each other" in message
    assert "-0.5 rad instead of 1 rad" in message


def test_motion_that_the_loop_cannot_follow_is_rejected() -> None:
    """The rocker cannot reach this angle: the coupler is too short by 1.03 m."""
    for source, inputs in (
        (driven("D", polynomial=[0.1]), {}),
        (driven("D", input="position"), {"drive__phi_ref": 0.1}),
    ):
        assert re.search(r"cannot be closed: smallest closure error [0-9.]+ m", refusal(source, **inputs))


def test_motions_that_contradict_each_other_through_a_gear_are_rejected() -> None:
    for first, second in (({"polynomial": [1.0]}, {"polynomial": [1.0]}), ({"speed": 1.0}, {"speed": 1.0})):
        source = shafts(-2.0)
        source["constraints"] |= {
            "x": {"type": "motion", "joint": "A", **first},
            "y": {"type": "motion", "joint": "B", **second},
        }
        assert re.search(r"cannot be satisfied|have no consistent start velocities", refusal(source))


def test_motions_that_agree_through_a_gear_are_accepted() -> None:
    source = shafts(-2.0)
    source["constraints"] |= {
        "x": {"type": "motion", "joint": "A", "polynomial": [0, 2]},
        "y": {"type": "motion", "joint": "B", "polynomial": [0, -1]},
    }
    plant = gelenk.Simulation(gelenk.load(source))
    plant.initialize()
    plant.step_to(1.0)
    assert plant.values(["A.phi", "B.phi"]) == pytest.approx([2.0, -1.0], abs=1e-12)


def test_locked_ring_of_gears_has_a_single_position() -> None:
    message = refusal(starting(three_shafts(1 / 3), "A", phi=1.0, fixed=True))
    assert "would then be 0 rad instead of 1 rad" in message


def test_loop_in_which_every_joint_is_constrained_is_rejected() -> None:
    source = driven(speed=1.0)
    for name in "BCD":
        source["constraints"][name] = {"type": "motion", "joint": name, "speed": 0.0}
    with pytest.raises(gelenk.SceneError, match="in a loop in which every joint is constrained"):
        gelenk.Simulation(gelenk.load(source))


def test_wheel_that_is_not_on_its_carrier_is_rejected() -> None:
    source = planetary()
    source["bodies"]["far"] = disc(1.0, 0.1)
    source["joints"]["X"] = joint("revolute", frame("planet", (0, 0, 0.1)), frame("far"), axis=[0, 0, 1])
    source["constraints"]["inner"]["joint"] = "X"
    with pytest.raises(gelenk.SceneError, match="joint X neither on the carrier arm nor on ground"):
        gelenk.Simulation(gelenk.load(source))


def test_input_that_cannot_be_followed_fails_the_step_and_leaves_the_state_unchanged() -> None:
    plant = gelenk.Simulation(gelenk.load(driven("D", input="position")))
    plant.initialize()
    before = plant.values().tolist()
    plant.set_input("drive.phi_ref", 0.1)
    for _ in range(2):  # the input is not taken for one that is followed already
        with pytest.raises(gelenk.StepError, match="the motion prescribed by an input cannot be followed"):
            plant.step_to(0.01)
    plant.set_input("drive.phi_ref", plant.output("D.phi"))
    assert plant.values().tolist() == before
    plant.step_to(0.01)


def test_wheel_welded_to_its_plane_is_rejected() -> None:
    source = scene(
        {"wheel": body(1.0, (0, 0, 0), (0.1, 0.2, 0.1))},
        {"W": joint("weld", frame("ground"), frame("wheel"))},
        constraints={"tyre": {"type": "rolling", "body": "wheel", "radius": 0.3}},
    )
    with pytest.raises(
        gelenk.SceneError, match=r"constraints\.tyre: found wheel welded to ground; expected two bodies"
    ):
        gelenk.Simulation(gelenk.load(source))
