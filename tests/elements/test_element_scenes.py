# SPDX-License-Identifier: BSD-3-Clause
"""Forces of every kind in scenes: in the plane as in space, in a tree as in a loop, saved and restored."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import Scene
from models.running import assert_close, run
from test_saved_runs import goes_on_to_the_bit

import gelenk

from .scenes import Given, all_given, on_gantry, planar_arm, with_force, with_sensors

FORCES = list(all_given("forces"))
every_force = pytest.mark.parametrize("force", FORCES, ids=str)
ON_GROUND = [f for f in FORCES if len(f.kind["ports"]) == 1 or f.kind["ports"][0].get("on_ground", True)]
between = pytest.mark.parametrize(
    ("first", "force"),
    [
        pytest.param(first, force, id=f"{first}-{force}")
        for first in ("ground", "link")
        for force in (ON_GROUND if first == "ground" else FORCES)
    ],
)
TIMES = np.linspace(0, 1, 6)
RTOL = 1e-10


def inputs(source: Scene) -> dict[str, float]:
    names = [signal.name for signal in gelenk.Simulation(source).inputs]
    return {name: 0.3 + 0.2 * i for i, name in enumerate(names)}


def size(source: Scene) -> gelenk._core.ModelSize:
    plant = gelenk.Simulation(source)
    plant.initialize()
    return plant.size


@between
def test_in_the_plane_as_in_space(force: Given, first: str) -> None:
    """Coordinates, speeds, accelerations and whatever is measured."""
    source = with_sensors(with_force(planar_arm(), force, first), on_joints=False)
    assert size(source).planar
    plane = run(source, TIMES, tolerance=RTOL, inputs=inputs(source))
    space = run(source, TIMES, tolerance=RTOL, inputs=inputs(source), reductions={"planar": False})
    assert not size({**source, "solver": {"reductions": {"planar": False}}}).planar
    for name in plane.units:
        bound = 1000 * RTOL * (1 + float(np.abs(space[name]).max()))
        assert_close(name, plane[name], space[name], bound, "1000 rtol: accelerations follow from the states")


@between
def test_in_a_tree_as_in_a_loop(force: Given, first: str) -> None:
    """Motion and energy of the arm alone and on a gantry."""
    source = with_sensors(with_force(planar_arm(), force, first))
    looped = on_gantry(source)
    assert size(looped).constraint_equations > 0
    tree = run(source, TIMES, tolerance=RTOL, inputs=inputs(source))
    loop = run(looped, TIMES, tolerance=RTOL, inputs=inputs(source))
    sensors = [name for name in tree.units if name.startswith(("frame_of", "energy_of"))]
    assert sensors
    for name in [*tree.joint_states(source), *sensors]:
        bound = 1000 * RTOL * (1 + float(np.abs(tree[name]).max()))
        assert_close(name, loop[name], tree[name], bound, "1000 rtol: accelerations follow from the states")


@every_force
@pytest.mark.parametrize("integrator", ["auto", "ida", "generalized-alpha"])
def test_goes_on_to_the_bit(force: Given, integrator: str) -> None:
    """From what was saved, in the run itself and in another one."""
    goes_on_to_the_bit(
        with_sensors(on_gantry(with_force(planar_arm(), force, "link"))), 6, 8, 1e-2, integrator=integrator
    )
