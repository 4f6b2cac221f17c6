# SPDX-License-Identifier: BSD-3-Clause
"""Immobile bodies are removed from the equations of motion; their outputs,
energies and reactions remain correct.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY, Scene, body, frame, joint, reaction, rod, scene, with_sensors
from models.reducible import ABOUT_Z, APEX, DOWN_Y, FEET, joined, pendulum_on, triangle, tripod, without
from models.running import assert_close

import gelenk

pytestmark = warned.GUESSES

BASE, LEFT, RIGHT = 1.2, 1.0, 0.8
# By the law of cosines: angles of the rods from x, and the apex.
PHI_LEFT = math.acos((BASE**2 + LEFT**2 - RIGHT**2) / (2 * BASE * LEFT))
PHI_RIGHT = math.pi - math.acos((BASE**2 + RIGHT**2 - LEFT**2) / (2 * BASE * RIGHT))
TOP = LEFT * np.array([math.cos(PHI_LEFT), math.sin(PHI_LEFT), 0.0])


def started(source: Scene, *off: str) -> gelenk.Simulation:
    plant = gelenk.Simulation(gelenk.load(source).without(off))
    plant.initialize(0.0, 1e-11)
    return plant


def all_of(plant: gelenk.Simulation) -> dict[str, float]:
    return {signal.name: plant.output(signal.name) for signal in plant.outputs}


def assert_same_values(found: dict[str, float], expected: dict[str, float], bound: float, why: str) -> None:
    for name, value in expected.items():
        assert_close(name, found[name], value, bound * max(1.0, abs(value)), why)


# --- trusses ---


def test_planar_truss_has_the_geometric_position() -> None:
    """Two rods pinned to the ground and to each other; the initial guesses are 0.05 and 0.1 rad off."""
    plant = started(triangle())
    size = plant.size
    assert (
        size.bodies,
        size.coordinates,
        size.constraint_equations,
        size.degrees_of_freedom,
        size.islands,
    ) == (0, 0, 0, 0, 0)
    springs = 40.0 / 2 * (PHI_LEFT - 0.2) ** 2 + 25.0 / 2 * (PHI_RIGHT - PHI_LEFT) ** 2
    energy = springs + (2.0 + 1.5) * GRAVITY * TOP[1] / 2
    expected = {
        "L.phi": PHI_LEFT, "R.phi": PHI_RIGHT, "T.phi": PHI_RIGHT - PHI_LEFT,
        "apex.r[1]": TOP[0], "apex.r[2]": TOP[1], "apex.r[3]": 0.0,
        "apex.Q[3]": math.sin(PHI_LEFT / 2), "apex.Q[4]": math.cos(PHI_LEFT / 2),
        "E.kinetic": 0.0, "E.potential": energy, "E.total": energy,
    }  # fmt: skip
    expected |= {s.name: 0.0 for s in plant.outputs if s.unit in ("rad/s", "rad/s2", "m/s")}
    for _ in range(3):
        found = all_of(plant)
        for name, value in expected.items():
            assert_close(
                name, found[name], value, 1e-12 * max(1.0, abs(value)), "triangle; closure, round-off"
            )
        assert plant.diagnostics["energy.total"] == found["E.total"]
        plant.step_to(plant.time + 0.4)


def test_spatial_truss_is_immobile() -> None:
    """The rods have universal joints at their feet and ball joints at the top."""
    plant = started(tripod("universal"))
    assert (plant.size.bodies, plant.size.degrees_of_freedom, plant.size.islands) == (0, 0, 0)
    span = APEX - FEET[1]
    middle = FEET[1] + 0.3 * span / np.linalg.norm(span)
    for i in range(3):
        assert_close(f"middle.r[{i + 1}]", plant.output(f"middle.r[{i + 1}]"), middle[i], 1e-12, "closure")
    heights = (FEET[:, 2] + APEX[2]) / 2
    weight = np.array([1.0, 2.0, 3.0]) * GRAVITY
    assert_close("potential", plant.output("E.potential"), weight @ heights, 1e-11, "rods' midpoints")


@pytest.mark.parametrize("off", ["static", "all"])
@pytest.mark.parametrize("name", ["triangle", "tripod"])
def test_truss_without_reduction_gives_the_same_results(name: str, off: str) -> None:
    """With its bodies kept in the equations nothing can move either, and the results are the same."""
    source = triangle() if name == "triangle" else tripod("universal")
    dropped, computed = started(source), started(source, off)
    assert computed.size.bodies == len(source["bodies"])
    assert computed.size.degrees_of_freedom == 0
    for plant in (dropped, computed):
        plant.step_to(1.0)
    assert_same_values(all_of(computed), all_of(dropped), 1e-11, "closure")


def test_rods_that_can_spin_are_not_removed() -> None:
    """On ball joints at both ends each rod can rotate about its own axis,
    although the truss is otherwise immobile.
    """
    source = tripod("spherical")
    source["joints"]["foot2"]["start"] = {"w": [4.0, 0, 0], "fixed": ["w"]}
    plants = [started(source), started(source, "static")]
    for plant in plants:
        assert (plant.size.bodies, plant.size.degrees_of_freedom) == (3, 3)
        plant.step_to(0.5)
    assert_close("spin", plants[0].output("foot2.w[1]"), 4.0, 1e-9, "its axis is one of symmetry")
    assert_same_values(all_of(plants[0]), all_of(plants[1]), 1e-9, "same motion")


def test_truss_with_reaction_outputs_is_not_removed() -> None:
    """The reactions of the truss carry the weight of its two rods and are compared
    with values calculated by hand.
    """
    source = triangle()
    for j in source["joints"].values():
        j.pop("stiffness", None)
    plant = started(with_sensors(source, load=reaction("L")))
    assert plant.size.bodies == 2
    plant.step_to(0.5)
    # Moments of both about R's foot, of the right rod about the apex.
    weight = np.array([2.0, 1.5]) * GRAVITY
    foot = np.array([BASE, 0.0])
    apex = TOP[:2]
    # f at the left foot: [x, y]; moments on the left rod about the apex, then all moments about the right
    # foot
    A = np.array([[-(0 - apex[1]), 0 - apex[0]], [0.0, -BASE]])
    b = np.array([weight[0] * (apex[0] / 2 - apex[0]), 0.0])
    b[1] = -(weight[0] * (BASE - apex[0] / 2) + weight[1] * (BASE - (apex[0] + foot[0]) / 2))
    force = np.linalg.solve(A, b)
    for i in (0, 1):
        assert_close(f"load.f[{i + 1}]", plant.output(f"load.f[{i + 1}]"), force[i], 1e-9, "statics, 20 N")


# --- trusses that carry a mechanism ---


@pytest.mark.parametrize("off", [(), ("static",), ("all",)], ids=["dropped", "computed", "all computed"])
def test_mechanism_on_a_truss_moves_like_one_on_the_ground(off: tuple[str, ...]) -> None:
    """A pendulum in space at the apex of the triangle is compared with one at the
    same position on the ground.
    """
    on_truss = started(joined(triangle(), pendulum_on(frame("left", (LEFT, 0, 0)))), *off)
    c, s = math.cos(PHI_LEFT), math.sin(PHI_LEFT)
    turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    on_ground = started(pendulum_on(frame("ground", TOP, turned)))
    if not off:
        assert (on_truss.size.bodies, on_truss.size.coordinates, on_truss.size.constraint_equations) == (
            2,
            3,
            0,
        )
    assert on_truss.size.degrees_of_freedom == 3
    for plant in (on_truss, on_ground):
        plant.set_input("arm.tau", 0.2)
        plant.step_to(1.0)
    assert_same_values(all_of(on_truss), all_of(on_ground), 1e-9, "same motion")
    assert_close("L.phi", on_truss.output("L.phi"), PHI_LEFT, 1e-11, "closure")


def hung_triangle() -> Scene:
    """Three rods pinned into a triangle that hangs on a pin: a rigid body as a whole."""
    alpha = math.pi / 3
    joints = {
        "pin": joint("revolute", frame("ground"), frame("a"), **ABOUT_Z, start={"phi": -1.0, "fixed": True}),
        "AB": joint("revolute", frame("a", (1, 0, 0)), frame("b"), **ABOUT_Z, start={"phi": 2 * alpha}),
        "BC": joint("revolute", frame("b", (1, 0, 0)), frame("c"), **ABOUT_Z, start={"phi": 2 * alpha}),
        "CA": joint("revolute", frame("c", (1, 0, 0)), frame("a"), **ABOUT_Z, start={"phi": 2 * alpha}),
    }
    return scene({name: rod(1.0, 1.0) for name in "abc"}, joints, gravity=DOWN_Y)


def test_joints_inside_a_moving_rigid_group_are_at_rest() -> None:
    """An equilateral triangle of rods swings about a corner: I = (1/3 + 1/3 + (1/12 + 3/4)) m L2."""
    plant, computed = started(hung_triangle()), started(hung_triangle(), "all")
    assert (plant.size.bodies, plant.size.coordinates, plant.size.constraint_equations) == (1, 1, 0)
    assert (computed.size.bodies, computed.size.degrees_of_freedom) == (3, 1)
    torque = -3 * GRAVITY * math.cos(-1.0 + math.pi / 6) / math.sqrt(3)
    assert_close("pin.a", plant.output("pin.a"), torque / 1.5, 1e-11, "by hand")
    for each in (plant, computed):
        each.step_to(1.0)
    assert_same_values(all_of(plant), all_of(computed), 1e-9, "same motion")
    assert_close("BC.phi", plant.output("BC.phi"), 2 * math.pi / 3, 1e-12, "closure")


# --- bodies welded to the ground ---


def with_stand() -> Scene:
    """A pendulum on a stand that is welded to the ground, and a spring between stand and beam."""
    return scene(
        {
            "stand": body(12.0, (0, 0, 0.6), (1.0, 1.0, 0.2)),
            "beam": body(3.0, (0.5, 0, 0), (0.01, 0.3, 0.3)),
            "arm": body(1.0, (0.2, 0, 0), (0.001, 0.02, 0.02)),
        },
        {
            "base": joint("weld", frame("ground", (0, 0, 0.1)), frame("stand")),
            "bracket": joint("weld", frame("stand", (0, 0, 1.2)), frame("beam")),
            "pin": joint(
                "revolute", frame("beam", (1, 0, 0)), frame("arm"), axis=[0, 1, 0], start={"phi": 0.3}
            ),
        },
        gravity=[0, 0, -GRAVITY],
        forces={
            "prop": {
                "type": "spring_damper",
                "from": frame("stand"),
                "to": frame("beam", (1, 0, 0)),
                "stiffness": 100.0,
                "length": 1.0,
            }
        },
        sensors={"E": {"type": "energy"}, "tip": {"type": "frame", **frame("beam", (1, 0, 0))}},
    )


@pytest.mark.parametrize(
    "off", [(), ("weld",), ("static",), ("weld", "static"), ("islands",), ("all",)], ids="-".join
)
def test_bodies_welded_to_the_ground_contribute_to_the_energy(off: tuple[str, ...]) -> None:
    """12 kg at 0.7 m, 3 kg at 1.3 m, 1 kg at 1.3 - 0.2 sin 0.3 m, and a stretched spring."""
    plant = started(with_stand(), *off)
    stretch = math.hypot(1.0, 1.2) - 1.0
    potential = GRAVITY * (12 * 0.7 + 3 * 1.3 + 1.3 - 0.2 * math.sin(0.3)) + 50.0 * stretch**2
    assert_close("potential", plant.output("E.potential"), potential, 1e-11, "round-off of 130 J")
    assert_close("total", plant.diagnostics["energy.total"], potential, 1e-11, "round-off of 130 J")
    plant.step_to(1.0)
    assert_close("total", plant.output("E.total"), potential, 1e-8, "conserved: 10 rtol of 130 J")
    assert_close("tip", [plant.output(f"tip.r[{i}]") for i in (1, 2, 3)], (1.0, 0.0, 1.3), 1e-12, "at rest")


# --- scenes without moving bodies ---


@warned.STILL
@pytest.mark.parametrize("off", [(), ("static",), ("all",)], ids=["dropped", "computed", "all computed"])
def test_immobile_scene_can_be_simulated_and_exported(off: tuple[str, ...], tmp_path: Path) -> None:
    """Steps, energy and outputs are correct, also in the FMU."""
    source = {**without(triangle(), *off), "name": "Truss", "experiment": {"stop": 0.1, "step": 0.01}}
    direct = gelenk.simulate(source)
    assert direct["L.phi"] == pytest.approx(PHI_LEFT, abs=1e-12)
    fmu = gelenk.export_fmu(gelenk.load(source), tmp_path / "Truss.fmu")
    through = gelenk.simulate(fmu)
    assert through.names == direct.names
    assert np.array_equal(through.table, direct.table)
    report = gelenk.inspect(source)
    assert report.degrees_of_freedom == 0
    assert str(report)


@pytest.mark.parametrize("off", [(), ("weld",), ("static",), ("all",)], ids="-".join)
def test_scene_with_only_weld_joints_can_be_simulated(off: tuple[str, ...]) -> None:
    source = scene(
        {"a": body(1.0), "b": body(2.0, (0, 0, 0.5))},
        {
            "A": joint("weld", frame("ground"), frame("a")),
            "B": joint("weld", frame("a", (0, 0, 1)), frame("b")),
        },
        gravity=[0, 0, -GRAVITY],
        sensors={"E": {"type": "energy"}},
    )
    plant = started(source, *off)
    plant.step_to(1.0)
    assert plant.time == 1.0
    assert plant.output("E.total") == pytest.approx(2 * GRAVITY * 1.5, rel=1e-14)
