# SPDX-License-Identifier: BSD-3-Clause
"""The choice of loop-closing joints changes the number of constraint equations
and quaternions, but not the motion.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
import scene_files
from mechanisms import Scene, four_bar, reordered
from models.reducible import platform_on_balls
from models.running import assert_close

import gelenk
from physics.loops.test_spatial_slider_crank import slider_crank

JOINTS = ("main", "crank_pin", "piston_pin", "cylinder")


def started(source: Scene, *off: str, tolerance: float = 1e-11) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(source).without(off))
    plant.initialize(0.0, tolerance)
    return plant


def quaternions(plant: gelenk.Simulation) -> int:
    """Each quaternion adds one coordinate more than velocities."""
    return plant.size.coordinates - plant.size.velocities


def assert_same_motion(found: gelenk.Simulation, expected: gelenk.Simulation, stop: float) -> None:
    for t in np.linspace(0, stop, 11)[1:]:
        found.step_to(float(t))
        expected.step_to(float(t))
        for signal in expected.outputs:
            value = expected.output(signal.name)
            bound = 1e-9 * max(1.0, abs(value))
            assert_close(f"{signal.name} at {t} s", found.output(signal.name), value, bound, "same motion")


def test_cut_in_file_order_needs_one_more_constraint_equation_and_quaternion() -> None:
    """A ball joint is listed before a universal joint: if the order is kept, the universal joint is cut."""
    source = slider_crank()
    joints = source["joints"]
    source["joints"] = {name: joints[name] for name in ("S", "A", "P", "U")}
    chosen, by_file = started(source), started(source, "cut_choice")
    assert (chosen.size.constraint_equations, quaternions(chosen)) == (3, 0)
    assert (by_file.size.constraint_equations, quaternions(by_file)) == (4, 1)
    assert chosen.size.degrees_of_freedom == by_file.size.degrees_of_freedom == 1
    assert_same_motion(chosen, by_file, 0.5)


def test_platform_on_ball_joints_is_cut_at_all_but_one() -> None:
    """In the order of the file there are six quaternions and 20 constraint equations;
    with chosen cuts, one and 15.
    """
    source = platform_on_balls()
    chosen, by_file = started(source), started(source, "cut_choice")
    assert (chosen.size.constraint_equations, quaternions(chosen)) == (15, 1)
    assert (by_file.size.constraint_equations, quaternions(by_file)) == (20, 6)
    assert chosen.size.degrees_of_freedom == by_file.size.degrees_of_freedom == 6
    note = gelenk.inspect(source).reductions["cut_choice"].notes[-1]
    assert "20 constraint equations and 32 coordinates" in note
    assert "15 and 22" in note
    assert_same_motion(chosen, by_file, 0.3)


@pytest.mark.parametrize("seed", range(5))
def test_stewart_platform_has_one_quaternion_in_any_order(seed: int) -> None:
    """Six legs with universal, prismatic and ball joints: only one quaternion, at the platform, is needed."""
    ready = gelenk.load(scene_files.SCENES / "stewart.yaml").to_dict()
    plain, shuffled = started(ready), started(reordered(ready, seed))
    for plant in (plain, shuffled):
        assert (plant.size.constraint_equations, quaternions(plant), plant.size.degrees_of_freedom) == (
            15,
            1,
            6,
        )
    assert_same_motion(shuffled, plain, 0.2)


@pytest.mark.parametrize("cut", "ABCD")
def test_driven_joints_are_tree_joints(cut: str) -> None:
    source = four_bar(1.1)
    source["joints"]["A"].pop("damping")
    source["motors"] = {f"m{j}": {"joint": j} for j in "ABCD" if j != cut}
    source["joints"]["A"]["start"].pop("fixed")
    (note,) = gelenk.inspect(source).reductions["cut_choice"].notes
    assert f"cut at {cut} (revolute)" in note


# --- the same mechanism with other joint types ---


def planar_slider_crank(**kinds: dict[str, Any]) -> Scene:
    """The slider-crank scene with some of its joints replaced by other types; without reaction outputs and
    rotors, and with inertia about the longitudinal axes of the bars, which is irrelevant in the plane.
    """
    source = copy.deepcopy(gelenk.load(scene_files.SCENES / "slider_crank.yaml").to_dict())
    del source["sensors"]
    del source["motors"]
    source["forces"]["drive"] = {"type": "wrench", "body": "crank", "torque": [0, -5, 0]}
    for name in ("crank", "rod"):
        source["bodies"][name]["inertia"][0] = 0.002
    for name, fields in kinds.items():
        entry = source["joints"][name]
        for key in ("axis", "start", "damping", "stiffness", "spring_reference"):
            entry.pop(key, None)
        entry.update(copy.deepcopy(fields))
    return source


Y = [0.0, -1.0, 0.0]  # the axis of the revolute joints
BALL: dict[str, Any] = {"type": "spherical", "start": {"rotation": {"axis": Y, "angle": -0.9}}}
BALL_AT_PISTON: dict[str, Any] = {"type": "spherical", "start": {"rotation": {"axis": Y, "angle": 0.2}}}
# Its second axis is perpendicular to the rod, in the plane: the rod cannot spin.
CROSS: dict[str, Any] = {"type": "universal", "axes": [Y, [0, 0, 1]], "start": {"phi_a": -0.9}}
CROSS_AT_PISTON: dict[str, Any] = {"type": "universal", "axes": [[0, 0, 1], Y], "start": {"phi_b": 0.2}}
ROUND: dict[str, Any] = {"type": "cylindrical", "axis": [1, 0, 0], "start": {"s": 1.1}, "damping": [2, 0]}
SLEEVE: dict[str, Any] = {
    "type": "cylindrical",
    "axis": Y,
    "start": {"phi": 0.7, "w": 0, "s": 0, "fixed": ["phi", "w"]},
    "damping": [0, 0.05],
}

# Replaced joints, and the resulting number of degrees of freedom.
EXCHANGED: dict[str, tuple[dict[str, dict[str, Any]], int]] = {
    "R-S-R-P": ({"crank_pin": BALL}, 1),
    "R-R-S-P": ({"piston_pin": BALL_AT_PISTON}, 1),
    "R-S-U-P": ({"crank_pin": BALL, "piston_pin": CROSS_AT_PISTON}, 1),
    "R-U-S-P": ({"crank_pin": CROSS, "piston_pin": BALL_AT_PISTON}, 1),
    "R-U-R-P": ({"crank_pin": CROSS}, 1),
    "R-R-R-C": ({"cylinder": ROUND}, 1),
    "R-R-U-C": ({"piston_pin": CROSS_AT_PISTON, "cylinder": ROUND}, 1),
    "R-S-R-C": ({"crank_pin": BALL, "cylinder": ROUND}, 1),
    "C-R-R-P": ({"main": SLEEVE}, 1),
    # The rod can spin about its axis, the piston roll in its cylinder, the crank slide: nothing drives these
    # motions.
    "R-S-S-P": ({"crank_pin": BALL, "piston_pin": BALL_AT_PISTON}, 2),
    "C-S-U-P": ({"main": SLEEVE, "crank_pin": BALL, "piston_pin": CROSS_AT_PISTON}, 2),
    "R-R-S-C": ({"piston_pin": BALL_AT_PISTON, "cylinder": ROUND}, 2),
    "R-S-S-C": ({"crank_pin": BALL, "piston_pin": BALL_AT_PISTON, "cylinder": ROUND}, 3),
}
# s. At its dead centers rod and piston can roll about the slide axis, along which the rod then lies: stop
# before them.
STOPS = {"R-S-R-C": 0.35}


@pytest.mark.parametrize("off", [(), ("redundant_rows",), ("cut_choice",), ("all",)], ids="-".join)
@pytest.mark.parametrize("name", EXCHANGED)
def test_slider_crank_motion_does_not_depend_on_the_joint_types(name: str, off: tuple[str, ...]) -> None:
    """Revolute and prismatic joints are compared with joint types that permit more,
    where the rest of the loop prevents it.
    """
    kinds, degrees_of_freedom = EXCHANGED[name]
    plain, other = started(planar_slider_crank()), started(planar_slider_crank(**kinds), *off)
    assert other.size.degrees_of_freedom == degrees_of_freedom
    shared = [s.name for s in plain.outputs if s.name.split(".")[0] not in ("crank_pin", "piston_pin")]
    for plant in (plain, other):
        plant.set_input("gas.f[1]", -20.0)
    for t in np.linspace(0, STOPS.get(name, 1.0), 21)[1:]:
        plain.step_to(float(t))
        other.step_to(float(t))
        for output in shared:
            value = plain.output(output)
            # cylindrical joints name the angular acceleration wd
            same = output.replace(".a", ".wd") if output == "main.a" and "main" in kinds else output
            bound = 1e-9 * max(1.0, abs(value))
            assert_close(f"{output} at {t} s", other.output(same), value, bound, "same motion")
