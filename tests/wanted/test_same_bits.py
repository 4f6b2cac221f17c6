# SPDX-License-Identifier: BSD-3-Clause
"""The part of a scene required for the requested outputs gives results bitwise
identical to those of the whole scene.

Comparisons are exact (`==`): the islands share no numbers, so round-off must be identical.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import warned
from many_islands import many_islands
from mechanisms import Array, frame, joint, rod

import gelenk
from gelenk import _core

pytestmark = warned.GUESSES

COUNT = 200
KEPT = (0, 1, 2, 3, 4, 5, 6, 113, 154)  # all kinds, among them a truss (5, 113), and some twice
INTEGRATORS = ("auto", "erk", "ida", "cvode", "dirk", "rk4")
STEPS, STEP = 20, 0.01  # s


def pattern(k: int) -> str:
    return f"i{k}_*"


def torque(name: str, t: float) -> float:
    return math.sin(5 * t + len(name))


def run(plant: gelenk.Simulation) -> Array:
    """All outputs at the start and at every step, with inputs that jump, as set by a co-simulation master."""

    def set_inputs(step: int) -> None:
        for signal in plant.inputs:
            plant.set_input(signal.name, torque(signal.name, step * STEP))

    set_inputs(0)
    plant.initialize()
    rows = [plant.values()]
    for step in range(STEPS):
        set_inputs(step)
        plant.step_to((step + 1) * STEP)
        rows.append(plant.values())
    return np.array(rows)


def columns(plant: gelenk.Simulation) -> dict[str, int]:
    return {signal.name: i for i, signal in enumerate(plant.outputs)}


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_each_of_two_hundred_islands_moves_as_in_the_whole_scene(integrator: str) -> None:
    scene = gelenk.load(many_islands(COUNT, solver={"integrator": integrator}))
    whole = gelenk.Simulation(scene)
    at = columns(whole)
    expected = run(whole)
    assert whole.size.islands == COUNT
    for k in KEPT:
        plant = gelenk.Simulation(scene.with_outputs([pattern(k)]))
        found = run(plant)
        names = [s.name for s in plant.outputs]
        assert plant.size.islands == 1
        assert names == [name for name in at if name.startswith(f"i{k}_")]
        assert np.array_equal(found, expected[:, [at[name] for name in names]])


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_fmu_of_some_islands_moves_like_the_whole_scene(integrator: str, tmp_path: Path) -> None:
    scene = gelenk.load(many_islands(COUNT, solver={"integrator": integrator}))
    wanted = [pattern(k) for k in KEPT]
    whole = gelenk.Simulation(scene)
    at = columns(whole)
    expected = run(whole)
    fmu = gelenk.export_fmu(scene, tmp_path / "some.fmu", outputs=wanted)
    known = [s.name for s in gelenk.Simulation(scene.with_outputs(wanted)).inputs]
    inputs = {name: (lambda t, name=name: torque(name, round(t / STEP) * STEP)) for name in known}
    result = gelenk.simulate(fmu, stop=STEPS * STEP, step=STEP, inputs=inputs)
    assert list(result.names) == [n for n in at if n.split("_")[0] in {f"i{k}" for k in KEPT}]
    found = np.column_stack([result[name] for name in result.names])
    assert np.array_equal(found, expected[:, [at[name] for name in result.names]])


def test_truss_beside_the_selected_part_does_not_change_results() -> None:
    """The truss is welded by a second assembly, which does not affect the other bodies."""
    scene = gelenk.load(many_islands(6))
    whole = gelenk.Simulation(scene)
    whole.initialize()
    for wanted in ("i5_T.phi", "i5_L.phi", "i0_D.phi"):
        plant = gelenk.Simulation(scene.with_outputs([wanted]))
        plant.initialize()
        assert plant.values() == whole.values([wanted])


@pytest.mark.parametrize("size", [40.0, 3e-4])
def test_natural_units_are_those_of_the_whole_scene(size: float) -> None:
    """Absolute tolerances are relative to them: in a scene with a body of 40 m, one of 0.3 m is small."""
    data = many_islands(4)
    data["bodies"]["giant"] = rod(5000.0, size)
    data["joints"]["G"] = joint("revolute", frame("ground"), frame("giant"), axis=[0, 1, 0])
    if size < 1:  # then the whole scene is small
        data = many_islands(1, only=1)
        data["bodies"] = {name: {**b, "com": [0, 0, -size / 9]} for name, b in data["bodies"].items()}
        for entry in data["bodies"].values():
            entry["inertia"] = [1e-9, 1e-9, 1e-9, 0, 0, 0]
        for entry in data["joints"].values():
            for end in ("parent", "child"):
                entry[end] = {"body": entry[end]["body"], "position": [0, 0, 0]}
        data["bodies"]["other"] = rod(1e-6, size)
        data["joints"]["G"] = joint("revolute", frame("ground"), frame("other"), axis=[0, 1, 0])
        data.pop("sensors")
    scene = gelenk.load(data)
    wanted = scene.with_outputs(["i1_*"])
    part = _core.wanted_part(wanted._core)
    assert part.scales[:2] == scene._core.scales[:2] != [1.0, 1.0]
    again = gelenk.load(_core.write_scene_json(part))  # as stored in an FMU
    assert again._core.scales == part.scales
    whole = gelenk.Simulation(scene)
    expected = run(whole)
    at = columns(whole)
    for source in (wanted, again):
        plant = gelenk.Simulation(source)
        assert np.array_equal(run(plant), expected[:, [at[s.name] for s in plant.outputs]])


@warned.MOVING
def test_linear_model_of_a_part_is_a_block_of_the_whole_model() -> None:
    scene = gelenk.load(many_islands(12))
    whole = gelenk.linearize(scene)
    part = gelenk.linearize(scene.with_outputs(["i5_L.phi", "i5_R.w_a"]))
    x = [whole.state_labels.index(name) for name in part.state_labels]
    y = [whole.output_labels.index(name) for name in part.output_labels]
    assert part.output_labels == ["i5_L_phi", "i5_R_w_a"]
    assert len(x) == 6  # one revolute joint, two angles of a universal joint, and their velocities
    assert np.array_equal(part.A, whole.A[np.ix_(x, x)])
    assert np.array_equal(part.C, whole.C[np.ix_(y, x)])
    assert not whole.A[np.ix_(x, [i for i in range(len(whole.A)) if i not in x])].any()
