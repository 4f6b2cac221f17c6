# SPDX-License-Identifier: BSD-3-Clause
"""Contacts that cannot close, how their steps were solved, and steps that are too large."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
import warned
from models.touching import SceneData, inertia_of_box, on_plane, stack

import gelenk

CUBE = {"box": [0.1, 0.1, 0.1], "surface": "wood"}


def two_cubes(joint: dict[str, Any], law: dict[str, Any]) -> SceneData:
    """A cube on a slide and another one that this joint connects to it."""
    cube = {"mass": 1, "inertia": inertia_of_box(1, [0.1] * 3), "shapes": {"cube": CUBE}}
    return {
        "gelenk": 1,
        "bodies": {"a": cube, "b": copy.deepcopy(cube)},
        "joints": {
            "A": {"type": "prismatic", "axis": [1, 0, 0], "parent": "ground", "child": "a"},
            "B": {"parent": {"body": "a", "position": [0.2, 0, 0]}, "child": "b", **joint},
        },
        "contacts": {"c": {"between": ["wood", "wood"], **law}},
    }


SLIDE = {"type": "prismatic", "axis": [1, 0, 0]}


@warned.STILL
@pytest.mark.parametrize("law", [{}, {"adjacent": True}])
def test_contact_of_bodies_that_share_a_joint(law: dict[str, Any]) -> None:
    """Refused, since it has no gap, unless such bodies may touch: the cubes are 0.1 m apart."""
    scene = two_cubes(SLIDE, law)
    if law:
        assert gelenk.simulate(scene, stop=0.01)["c.gap"][0] == pytest.approx(0.1, abs=1e-12)
        return
    with pytest.raises(
        gelenk.SceneError, match=r"contacts\.c\.between: found no shape .*'wood'.* expected two bodies"
    ):
        gelenk.Simulation(scene).initialize()


def test_contact_of_bodies_that_are_welded_is_refused() -> None:
    with pytest.raises(gelenk.SceneError, match=r"contacts\.c\.between: found no shape"):
        gelenk.Simulation(two_cubes({"type": "weld"}, {"adjacent": True})).initialize()


def test_contact_of_a_surface_of_one_body_with_itself_is_refused_by_name() -> None:
    """The other contact of the scene is not in the message."""
    scene = on_plane({"sphere": 0.1}, 1, [0.004] * 3, {"r": [0, 0, 0.2]}, {})
    scene["contacts"]["alone"] = {"between": ["wood", "wood"]}
    with pytest.raises(gelenk.SceneError) as found:
        gelenk.export_fmu(scene, "unused.fmu")
    assert "contacts.alone.between" in str(found.value)
    assert "floor" not in str(found.value)


def box(height: float, speed: float = 0.0) -> gelenk.Simulation:
    """A cube of 0.1 m at this height above the floor [m]."""
    start = {"r": [0, 0, 0.05 + height], "v": [0, 0, speed]}
    simulation = gelenk.Simulation(
        on_plane({"box": [0.1] * 3}, 1, inertia_of_box(1, [0.1] * 3), start, {"friction": 0.5})
    )
    simulation.initialize()
    return simulation


def solved(simulation: gelenk.Simulation) -> tuple[float, float, float]:
    residual, iterations, points = (
        simulation.diagnostic(f"solver.{name}")
        for name in ("cone_residual", "cone_iterations", "contact_points")
    )
    return residual, iterations, points


def test_diagnostics_are_of_the_last_communication_step() -> None:
    """In the air there is nothing to solve; on the floor the four corners carry; thrown up, none does."""
    flying = box(0.5)
    assert solved(flying) == (0, 0, 0)
    flying.step_to(0.1)
    assert solved(flying) == (0, 0, 0)
    flying.step_to(0.5)  # it lands after 0.32 s
    residual, iterations, points = solved(flying)
    assert points == 4
    assert 1 <= iterations <= 200
    assert residual <= 1e-11 * 3.2  # the tolerance of velocities up to that of the impact
    resting = box(0.0)
    resting.step_to(0.1)
    assert solved(resting)[2] == 4
    leaving = box(0.0, 1.0)
    leaving.step_to(0.1)
    leaving.step_to(0.15)
    assert solved(leaving) == (0, 0, 0)


def test_diagnostics_are_outputs_and_saved() -> None:
    names = [f"solver.{name}" for name in ("cone_residual", "cone_iterations", "contact_points")]
    run = gelenk.simulate(stack(3), stop=0.05, step=0.01, outputs=names)
    assert run["solver.contact_points"][-1] == 12
    assert run.units["solver.cone_residual"] == "m/s"
    first, second = box(0.5), box(0.5)
    first.step_to(0.5)
    second.restore(first.save())
    assert solved(second) == solved(first)
    assert solved(first)[1] >= 1


def spinning(rate: float) -> SceneData:
    """A plate without weight that tumbles, far above the floor, in steps of 10 ms."""
    scene = on_plane(
        {"box": [0.1, 0.2, 0.01]},
        1,
        inertia_of_box(1, [0.1, 0.2, 0.01]),
        {"r": [0, 0, 50], "w": [0.8 * rate, 0.5 * rate, 0.3 * rate]},
        {},
        step=1e-2,
    )
    scene["gravity"] = [0, 0, 0]
    return scene


@pytest.mark.parametrize(
    ("rate", "least", "most"),
    [(1, 0.9999, 1.0001), (10, 0.99, 1.001), (30, 0.9, 1.001), (300, 0.4, 3), (1000, 0.4, 3)],
)
def test_energy_of_a_fast_body_is_bounded(rate: float, least: float, most: float) -> None:
    """At 30 rad/s it turns by 0.3 rad per step and loses energy by the third evaluation.

    From 100 rad/s on, where two evaluations multiply the energy by 50 within a second and by more at higher
    rates, steps are divided.
    """
    run = gelenk.simulate(spinning(rate), stop=1, step=0.01, outputs=["energy.kinetic"])
    assert run["energy.kinetic"].max() <= most * run["energy.kinetic"][0]
    assert run["energy.kinetic"].min() >= least * run["energy.kinetic"][0]


def test_steps_that_do_not_converge_are_refused() -> None:
    """10 ms at 1e5 rad/s: 1000 rad per step. The state remains that before the step."""
    simulation = gelenk.Simulation(spinning(1e5))
    simulation.initialize()
    before = simulation.values(), solved(simulation)
    with pytest.raises(gelenk.StepError, match=r"do not converge, expected a smaller solver\.step"):
        simulation.step_to(0.01)
    assert np.array_equal(simulation.values(), before[0])
    assert solved(simulation)[2] == before[1][2]
