# SPDX-License-Identifier: BSD-3-Clause
"""Towers, walls and heaps: nothing creeps, no point of contact is lost, and what falls comes to rest."""

from __future__ import annotations

import numpy as np
import pytest
from models.touching import SceneData, heap, stack, wall

import gelenk

STEP = 1e-3


def run(scene: SceneData, steps: int) -> gelenk.Simulation:
    simulation = gelenk.Simulation(scene)
    simulation.initialize()
    for k in range(steps):
        simulation.step_to((k + 1) * STEP)
    return simulation


def test_a_tower_of_a_hundred_boxes_stands() -> None:
    """400 points of contact, 1.6 times as many rows as velocities; a millisecond of free fall is 1e-2 m/s."""
    scene = stack(100)
    simulation = run(scene, 100)
    heights = np.array([simulation.output(f"j{i}.r[3]") for i in range(100)])
    speeds = np.array([simulation.output(f"j{i}.v[{k}]") for i in range(100) for k in (1, 2, 3)])
    assert np.abs(heights - 0.1 * (np.arange(100) + 0.5)).max() < 1e-9  # m
    assert np.abs(speeds).max() < 1e-10  # m/s: the residual of 1e-13, which 100 interfaces add up
    assert simulation.diagnostic("solver.contact_points") == 400
    assert simulation.diagnostic("solver.cone_residual") < 1e-12


def test_a_wall_stands() -> None:
    """Ten layers of twenty bricks, each on two others: points at the ends, too, remain in contact."""
    scene = wall(20, 10)
    simulation = run(scene, 50)
    names = [f"j{row}_{column}" for row in range(10) for column in range(20)]
    speeds = np.array([simulation.output(f"{name}.v[{k}]") for name in names for k in (1, 2, 3)])
    assert np.abs(speeds).max() < 1e-10
    # Four points below each brick of the lowest layer and in each face between two bricks, of which there are
    # 20 * 2 - 1 between two layers. End bricks of odd layers overhang by half: inner points may be free.
    points = simulation.diagnostic("solver.contact_points")
    assert 80 + 9 * 39 * 4 - 5 * 2 <= points <= 80 + 9 * 39 * 4


def test_a_wall_without_joints_stands_cheaply() -> None:
    """Bricks whose ends touch, too: rounding of each step adds up to the tolerance of 1e-13 m/s.

    What is then solved again changes no impulse by much: it takes a few factorizations, from nothing 30.
    """
    simulation = gelenk.Simulation(wall(10, 10, pitch=1.0))
    simulation.initialize()
    iterations = []
    for k in range(150):
        simulation.step_to((k + 1) * STEP)
        iterations.append(simulation.diagnostic("solver.cone_iterations"))
    names = [f"j{row}_{column}" for row in range(10) for column in range(10)]
    heights = np.array([simulation.output(f"{name}.r[3]") for name in names])
    assert np.abs(heights - np.repeat(0.1 * (np.arange(10) + 0.5), 10)).max() < 1e-12
    assert simulation.diagnostic("solver.cone_residual") < 2e-13
    assert np.count_nonzero(iterations[20:]) > 0
    assert max(iterations[20:]) <= 8


def test_a_heap_of_spheres_loses_its_energy() -> None:
    """Sixty spheres fall into a box: what sticks, slides and rolls is solved, and energy never grows."""
    names = ["energy.total", "solver.cone_residual", "solver.contact_points"]
    result = gelenk.simulate(heap(60), stop=0.4, step=STEP, outputs=names)
    energy = result["energy.total"]
    # Up to the residual of single steps, and positions that are corrected.
    assert np.diff(energy).max() < 1e-6 * np.ptp(energy)
    assert result["solver.contact_points"].max() > 67  # more than 200 rows: sparse factors
    # Coulomb's law need not have a solution in each step.
    assert (result["solver.cone_residual"] > 1e-6).mean() < 0.02


def test_the_residual_follows_its_tolerance() -> None:
    """Sweeps end at the tolerance, relative to velocities of 1 to 3 m/s; overlaps follow them."""
    median, most = [], []
    for tolerance in (1e-3, 1e-6):
        scene = heap(80)
        scene["solver"] = {**scene.get("solver", {}), "cone_tolerance": tolerance}
        simulation = gelenk.Simulation(scene)
        simulation.initialize()
        found = []
        for k in range(250):
            simulation.step_to((k + 1) * STEP)
            found.append(
                [simulation.diagnostic(f"solver.cone_{name}") for name in ("residual", "iterations")]
            )
        residuals, iterations = np.array(found[100:]).T
        assert residuals.max() < 10 * tolerance
        median.append(np.median(residuals))
        most.append(iterations.mean())
    assert median[1] < 1e-2 * median[0]
    assert most[0] < 0.8 * most[1]


def test_a_tolerance_of_contacts_needs_contacts() -> None:
    scene = heap(2)
    scene["solver"] = {"integrator": "rk4", "cone_tolerance": 1e-6}
    message = (
        r"solver\.cone_tolerance: found 1e-06 with the integrator rk4, expected the integrator moreau-jean"
    )
    with pytest.raises(gelenk.SceneError, match=message):
        gelenk.Simulation(scene)


def tumbling_boxes() -> SceneData:
    """Thirty boxes that fall on the ground, far from each other, and come to rest by 0.8 s."""
    random = np.random.default_rng(0)
    edge, apart = 0.2, 0.4
    bodies, joints = {}, {}
    for i in range(30):
        axis = random.normal(size=3)
        place = [apart * (i % 6), apart * (i // 6), 0.3]
        turn = {"axis": (axis / np.linalg.norm(axis)).tolist(), "angle": float(random.uniform(0, 3))}
        bodies[f"box{i}"] = {
            "mass": 1,
            "inertia": [edge**2 / 6] * 3,
            "shapes": {"all": {"box": [edge] * 3, "surface": "wood"}},
        }
        joints[f"free{i}"] = {
            "type": "free",
            "parent": "ground",
            "child": f"box{i}",
            "start": {"r": place, "rotation": turn, "w": random.normal(size=3).tolist(), "fixed": True},
        }
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "bodies": bodies,
        "joints": joints,
        "contacts": {"drop": {"between": ["wood", "floor"], "friction": 0.5}},
    }


def test_steps_are_not_shortened_for_errors_of_the_past() -> None:
    """Two runs part after impacts of tumbling boxes, by velocities that no shorter step amends.

    Otherwise, there are twice as many steps, most of them of 8 microseconds.
    """
    plant = gelenk.Simulation(tumbling_boxes())
    plant.initialize(0.0)
    plant.step_to(0.3)
    before = plant.diagnostic("solver.steps")
    for k in range(4, 9):
        plant.step_to(k / 10)
    assert plant.diagnostic("solver.scheme") == 1
    assert plant.diagnostic("solver.steps") - before < 2500  # 1,454; of 1 ms: 1,000
    heights = [plant.output(f"free{i}.r[3]") for i in range(30)]
    assert heights == pytest.approx([0.1] * 30, abs=2e-3)
