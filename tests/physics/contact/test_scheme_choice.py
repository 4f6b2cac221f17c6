# SPDX-License-Identifier: BSD-3-Clause
"""`auto` with contacts: located events while little touches and happens, otherwise steps with impulses.

Its thresholds themselves are tested in tests/native/test_scheme_watch.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from models.random_contacts import random_scene
from models.running import assert_restored_run_continues
from models.thrown import STEP, STEPS, TOLERANCE, thrown
from models.touching import free_cubes

import gelenk

SceneData = dict[str, Any]
EVENTS, STEPPING = 0, 1  # solver.scheme


def boxes(count: int, **start: Any) -> SceneData:
    """Return boxes next to each other on the ground, each with four points of contact."""
    starts = [{"r": [0, 0.3 * k, 0.05], "v": [1, 0, 0], "fixed": True, **start} for k in range(count)]
    return {
        **free_cubes(starts, [f"wood{k}" for k in range(count)]),
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "contacts": {f"c{k}": {"between": [f"wood{k}", "floor"], "friction": 0.3} for k in range(count)},
        "forces": {
            # Couples the bodies, which otherwise were solved apart.
            f"s{k}": {
                "type": "spring_damper", "from": f"b{k}", "to": f"b{k + 1}", "stiffness": 1, "length": 0.3,
            }
            for k in range(count - 1)
        },
    }  # fmt: skip


def ball(restitution: float, **solver: Any) -> SceneData:
    radius, mass = 0.1, 0.7
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "body": {
                "mass": mass,
                "inertia": [0.4 * mass * radius**2] * 3,
                "shapes": {"s": {"sphere": radius, "surface": "rubber"}},
            }
        },
        "ground": {"shapes": {"floor": {"plane": [0, 0, 1], "surface": "floor"}}},
        "joints": {
            "J": {
                "type": "free",
                "parent": "ground",
                "child": "body",
                "start": {"r": [0, 0, 1 + radius], "v": [1, 0, 0], "w": [0, 3, 0], "fixed": True},
            }
        },
        "contacts": {"floor": {"between": ["rubber", "floor"], "friction": 0.2, "restitution": restitution}},
        "solver": {"integrator": "auto", "step": 1e-3, **solver},
    }


def schemes(scene: SceneData, times: np.ndarray) -> list[int]:
    simulation = gelenk.Simulation(gelenk.load(scene))
    simulation.initialize(tolerance=1e-8)
    out = []
    for t in times:
        simulation.step_to(float(t))
        out.append(int(simulation.diagnostic("solver.scheme")))
    return out


@pytest.mark.parametrize(("count", "scheme"), [(1, EVENTS), (4, EVENTS), (5, STEPPING)])
def test_points_of_contact_decide(count: int, scheme: int) -> None:
    """Four boxes have 16 points, five have 20."""
    assert schemes(boxes(count), np.arange(1, 6) * 0.02)[-1] == scheme


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9])
def test_a_ball_that_comes_to_rest_is_located(restitution: float) -> None:
    """With a coefficient of 0.9 after 106 impacts, the last 70 of which come within 0.2 s."""
    scene = ball(restitution)
    times = np.arange(1, 101) * 0.1
    assert set(schemes(scene, times)) == {EVENTS}
    runs = [
        gelenk.simulate(scene, stop=10, step=0.1, tolerance=1e-8, integrator=integrator)
        for integrator in ("auto", "erk")
    ]
    # Both keep the tolerance; impacts multiply errors by up to a few tens.
    np.testing.assert_allclose(runs[0]["J.r[1]"], runs[1]["J.r[1]"], rtol=0, atol=1e-6)
    assert runs[0]["J.r[3]"][-1] == pytest.approx(0.1, abs=1e-12)


def test_too_many_events_are_gone_on_with() -> None:
    """Located events alone are refused (test_refused_located_contacts.py)."""
    run = gelenk.simulate(ball(0.9, max_events=5), stop=12, step=12, tolerance=1e-8)
    assert run["J.r[3]"][-1] == pytest.approx(0.1, abs=1e-9)


def test_rest_leads_back_to_events() -> None:
    """Five boxes are solved in steps until three of them are lifted from the ground, one after another."""
    scene = boxes(5)
    for k in range(3):
        scene["forces"][f"pull{k}"] = {"type": "wrench", "body": f"b{k}", "input": True}
    simulation = gelenk.Simulation(gelenk.load(scene))
    simulation.initialize(tolerance=1e-8)
    simulation.step_to(0.5)
    assert simulation.diagnostic("solver.scheme") == STEPPING
    for k in range(3):
        simulation.set_input(f"pull{k}.f[3]", 10.0)
    simulation.step_to(0.54)
    assert simulation.diagnostic("solver.scheme") == STEPPING
    simulation.step_to(0.6)
    assert simulation.diagnostic("solver.scheme") == EVENTS
    for k in range(3):
        simulation.set_input(f"pull{k}.f[3]", 0.0)
    simulation.step_to(2.0)
    simulation.step_to(2.01)  # a communication step ends in the scheme that has led to its end
    assert simulation.diagnostic("solver.scheme") == STEPPING
    heights = simulation.values([f"j{k}.r[3]" for k in range(5)])
    np.testing.assert_allclose(heights, 0.05, rtol=0, atol=1e-9)


def jammed_wheel() -> SceneData:
    """A cart at a stop, its wheel driven against a limit, where it rubs; a load on a locked hook."""
    return {
        "gelenk": 1,
        "gravity": [0, 0, -9.81],
        "bodies": {
            "load": {"mass": 2.0},
            "cart": {"mass": 0},
            "axle": {"mass": 4.7},
            "wheel": {
                "mass": 0.62,
                "inertia": [0.004464] * 3,
                "shapes": {
                    "tread": {
                        "wheel": {"radius": 0.12},
                        "rotation": {"axis": [1, 0, 0], "angle": np.pi / 2},
                        "surface": "rubber",
                    }
                },
            },
        },
        "ground": {"shapes": {"road": {"plane": [0, 0, 1], "surface": "road"}}},
        "joints": {
            "hook": {
                "type": "prismatic", "axis": [0, 0, 1], "parent": "ground", "child": "load",
                "lock": {"engaged": True},
            },
            "x": {
                "type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "cart",
                "start": {"s": 0, "v": 1, "fixed": True}, "limit": {"upper": 0.1, "restitution": 0},
            },
            "z": {
                "type": "prismatic", "axis": [0, 0, 1], "parent": "cart", "child": "axle",
                "start": {"s": 0.12, "fixed": True},
            },
            "hub": {
                "type": "revolute", "axis": [0, 1, 0], "parent": "axle", "child": "wheel",
                "start": {"phi": 0, "fixed": True},
                "limit": {"lower": -0.02, "upper": 0.02, "restitution": 1},
            },
        },
        "motors": {"motor": {"joint": "hub"}},
        "contacts": {"tread": {"between": ["rubber", "road"], "friction": 0.3, "restitution": 0}},
    }  # fmt: skip


@pytest.mark.parametrize("step", [0.02, 0.01, 0.001])
def test_what_holds_has_its_force_where_events_begin_again(step: float) -> None:
    """They begin with an impact on the limit, towards which steps with impulses have left a small speed."""
    simulation = gelenk.Simulation(jammed_wheel())
    simulation.initialize()
    simulation.set_input("motor.tau", 9.394056)
    seen = []
    for k in range(1, round(0.4 / step)):
        simulation.step_to(k * step)
        mode, force, torque = simulation.values(["hook.lock.mode", "hook.lock.f", "hub.limit.tau"])
        assert mode == 1
        assert force == pytest.approx(2 * 9.81, rel=1e-6)
        seen.append(int(simulation.diagnostic("solver.scheme")))
        if STEPPING in seen:
            assert torque < -5
    assert STEPPING in seen
    assert seen[-1] == EVENTS


@pytest.mark.parametrize("time", [0.2, 0.46, 0.9, 0.98])
def test_a_restored_run_continues_across_the_change(time: float) -> None:
    """After more than 3 impacts within a communication step, steps go on; rest leads back to events."""
    assert_restored_run_continues(ball(0.6, max_events=3), time, [0.3, 0.7, 1.1])


@pytest.mark.parametrize("first", [0, 40])
def test_thrown_bodies_are_as_by_events_alone(first: int) -> None:
    """As long as `auto` locates all events, it agrees; steps go on where events are refused."""
    located = stepped = 0
    for seed in range(first, first + 25):
        scene = thrown(seed)
        plants = []
        for integrator in ("auto", "erk"):
            scene["solver"]["integrator"] = integrator
            try:
                plants.append(gelenk.Simulation(gelenk.load(scene)))
                plants[-1].initialize(tolerance=TOLERANCE)
            except gelenk.SceneError:
                break
        if len(plants) < 2:
            continue
        auto, events = plants
        names = [s.name for s in auto.outputs if s.name.split(".")[-1].startswith(("r[", "phi", "s"))]
        apart = False
        for k in range(1, STEPS + 1):
            auto.step_to(k * STEP)
            apart = apart or auto.diagnostic("solver.scheme") == STEPPING
            if apart:
                stepped += 1
                continue
            try:
                events.step_to(k * STEP)
            except gelenk.StepError:
                break  # stiff sliding, for which auto has an implicit method
            np.testing.assert_allclose(auto.values(names), events.values(names), rtol=0, atol=1e-3)
            located += 1
    assert located > 10 * stepped


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::gelenk.StartWarning")
def test_extreme_scenes_end() -> None:
    """Of 1e-6 to 1e6 m, coincident, penetrating, with huge friction: numbers are finite, none is refused."""
    for seed in range(40):
        made = random_scene(seed)
        made.scene["solver"] = {"integrator": "auto"}
        simulation = gelenk.Simulation(made.scene)
        simulation.initialize()
        for k in range(1, 31):
            simulation.step_to(k * made.step)
            assert np.isfinite(simulation.values()).all(), seed
