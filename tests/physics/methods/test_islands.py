# SPDX-License-Identifier: BSD-3-Clause
"""Islands (uncoupled parts of a scene) are integrated separately: each moves as if it were alone."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from mechanisms import GRAVITY, Array, Scene, body, four_bar, frame, joint, rod, scene
from models.reducible import joined, pendulum_on, two_mechanisms
from models.running import INTEGRATORS

import gelenk
from gelenk.model.inspection import evaluation_cost

STEP = 0.02  # s


def plain_four_bar() -> Scene:
    return four_bar(1.1)


def spatial_pendulum() -> Scene:
    return pendulum_on(frame("ground", (5, 0, 1)))


def started(source: Scene, integrator: str = "erk", tolerance: float = 1e-8) -> gelenk.Simulation:
    chosen = copy.deepcopy(source)
    chosen.setdefault("solver", {})["integrator"] = integrator
    plant = gelenk.Simulation(gelenk.load(chosen))
    plant.initialize(0.0, tolerance)
    return plant


def driven(
    plant: gelenk.Simulation, names: list[str], steps: int = 50, jumping: str = ""
) -> dict[str, Array]:
    """The outputs of these joints at every step; the input `jumping` takes another value at each."""
    rows = []
    for k in range(steps):
        if jumping:
            plant.set_input(jumping, 2.0 if k % 2 else -1.0)
        plant.step_to((k + 1) * STEP)
        rows.append(plant.values(names))
    return dict(zip(names, np.array(rows).T, strict=True))


def outputs_of(source: Scene) -> list[str]:
    return [s.name for s in gelenk.Simulation(gelenk.load(source)).outputs]


@pytest.mark.parametrize("integrator", [*INTEGRATORS, "rk4"])
def test_island_moves_as_if_it_were_alone(integrator: str) -> None:
    """Bitwise equal results, with the same total number of evaluations."""
    together = started(two_mechanisms(), integrator)
    assert (together.size.islands, together.size.planar_islands) == (2, 1)
    alone = [started(make(), integrator) for make in (plain_four_bar, spatial_pendulum)]
    names = [outputs_of(make()) for make in (plain_four_bar, spatial_pendulum)]
    found = driven(together, [*names[0], *names[1]])
    for plant, own in zip(alone, names, strict=True):
        for name, values in driven(plant, own).items():
            assert np.array_equal(found[name], values), name
    for count in ("solver.evaluations", "solver.steps"):
        assert together.diagnostics[count] == sum(plant.diagnostics[count] for plant in alone) > 0


def test_islands_cost_as_much_as_alone() -> None:
    """CPU time of an evaluation, the least of up to 20 measurements;
    15 % are allowed for memory placement.
    """
    least = [math.inf] * 3
    for _ in range(20):
        for i, source in enumerate((two_mechanisms(), plain_four_bar(), spatial_pendulum())):
            least[i] = min(least[i], evaluation_cost(source).seconds or math.inf)
        if least[0] <= 1.15 * (least[1] + least[2]):
            break
    assert least[0] <= 1.15 * (least[1] + least[2])


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_input_of_one_island_does_not_restart_the_other(integrator: str) -> None:
    """A torque that jumps at every step restarts the integrator of the four-bar, not that of the pendulum."""
    together, calm, busy = (
        started(source, integrator) for source in (two_mechanisms(), spatial_pendulum(), plain_four_bar())
    )
    own = outputs_of(spatial_pendulum())
    found = driven(together, own, jumping="drive.tau")
    for name, values in driven(calm, own).items():
        assert np.array_equal(found[name], values), name
    driven(busy, ["A.phi"], jumping="drive.tau")
    steps = [plant.diagnostics["solver.steps"] for plant in (together, calm, busy)]
    assert steps[0] == steps[1] + steps[2]


def test_energies_and_closure_errors_include_all_islands() -> None:
    together = started(two_mechanisms())
    alone = [started(make()) for make in (plain_four_bar, spatial_pendulum)]
    for plant in (together, *alone):
        plant.step_to(0.5)
    for name in ("energy.kinetic", "energy.potential", "energy.total"):
        parts = [plant.diagnostics[name] for plant in alone]
        assert together.diagnostics[name] == pytest.approx(sum(parts), rel=1e-14)
    for name in ("constraints.position", "constraints.velocity"):
        assert together.diagnostics[name] == max(plant.diagnostics[name] for plant in alone)


def test_spring_between_two_mechanisms_couples_them() -> None:
    source = two_mechanisms()
    source["forces"] = {
        "tie": {
            "type": "spring_damper",
            "from": frame("rocker", (1, 0, 0)),
            "to": frame("lower"),
            "stiffness": 30.0,
            "damping": 1.0,
            "length": 2.0,
        }
    }
    assert started(source).size.islands == 1


def test_spring_to_the_ground_does_not_couple_islands() -> None:
    source = two_mechanisms()
    for name in ("rocker", "lower"):
        source.setdefault("forces", {})[f"tie_{name}"] = {
            "type": "spring_damper",
            "from": frame("ground"),
            "to": frame(name),
            "stiffness": 30.0,
            "length": 2.0,
        }
    assert started(source).size.islands == 2


def test_bodies_connected_by_a_joint_form_one_island() -> None:
    """The same two mechanisms, with the pendulum on the rocker instead of the ground."""
    source = joined(plain_four_bar(), pendulum_on(frame("rocker", (1, 0, 0))))
    assert started(source).size.islands == 1


@pytest.mark.parametrize("failing_first", [True, False])
def test_refused_step_restores_all_islands(failing_first: bool) -> None:
    """A torque of 1e100 N m acts on one island. The other may have advanced already, but must be restored."""
    fling, calm = plain_four_bar(), spatial_pendulum()
    source = joined(fling, calm) if failing_first else joined(calm, fling)
    plant = started(source)
    plant.step_to(0.1)
    before = plant.values()
    plant.set_input("drive.tau", 1e100)
    with pytest.raises(gelenk.StepError, match=r"state is unchanged at t = 0\.1 s"):
        plant.step_to(0.2)
    assert plant.time == 0.1
    plant.set_input("drive.tau", 0.0)
    assert np.array_equal(plant.values(), before)
    # And both continue.
    expected = started(source)
    expected.step_to(0.1)
    for each in (plant, expected):
        each.step_to(0.5)
    assert plant.values() == pytest.approx(expected.values(), rel=1e-5, abs=1e-5)


def test_islands_in_different_planes_are_each_planar() -> None:
    """Pendulums about x, about y and about an oblique axis: no common plane, but three planes."""
    axes = {"a": [1, 0, 0], "b": [0, 1, 0], "c": [0.3, -0.5, 0.8]}
    source = scene(
        {name: rod(1.0, 0.5) if name == "b" else body(1.0, (0, 0.2, 0.3), (0.1, 0.1, 0.1)) for name in axes},
        {
            f"pin_{name}": joint(
                "revolute", frame("ground"), frame(name), axis=axis, start={"phi": 0.4, "w": 1.0}
            )
            for name, axis in axes.items()
        },
        gravity=[0.2, 0.1, -GRAVITY],
    )
    plant = started(source)
    assert (plant.size.islands, plant.size.planar_islands) == (3, 3)
    in_space = started({**source, "solver": {"reductions": {"planar": False, "islands": False}}})
    assert (in_space.size.islands, in_space.size.planar_islands) == (1, 0)
    for each in (plant, in_space):
        each.step_to(1.0)
    assert plant.values() == pytest.approx(in_space.values(), abs=1e-6)  # 100 rtol
