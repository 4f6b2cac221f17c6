# SPDX-License-Identifier: BSD-3-Clause
"""What a lane computes is what a simulation computes alone, with the same method, step and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gelenk
from gelenk import Batch, Scene, _core
from gelenk.errors import AssemblyError, SceneError
from gelenk.model.settable import with_listed

ROOT = Path(__file__).resolve().parents[2]
STEP = 1e-3  # s
FAST = {"andrews": 1e-4}  # s: of mechanisms that turn several times in 0.01 s
SCENES = {path.stem: path for path in sorted(ROOT.glob("scenes/*.yaml"))}
GALLERY = {
    name: ROOT / "docs/gallery" / name / "scene.yaml" for name in ("gears", "mast_arm_disc", "rolling_disc")
}
OVERCONSTRAINED = {"bricard": ROOT / "docs/gallery/bricard/scene.yaml"}  # its dimensions depend on each other
# Both compute the same operations in another order; errors of some thousand roundings, which motions magnify.
ROUNDING = 1e-12


def alone(
    scene: Scene, steps: int, inputs: Mapping[str, float] | None = None, step: float = STEP
) -> dict[str, float]:
    """The state after some steps, of one simulation."""
    result = gelenk.simulate(
        scene.with_parameters({"solver.step": step}),
        stop=steps * step,
        step=step,
        integrator="rk4",
        formulation="projection",
        inputs=dict(inputs or {}),
    )
    return {name: float(np.asarray(result[name])[-1]) for name in result}


def difference(batch: Batch, lane: int, expected: Mapping[str, float]) -> float:
    """The largest one, relative to the largest number of the state or 1."""
    sizes = [abs(expected[name]) for name in batch.states]
    errors = [abs(row[lane] - expected[name]) for name, row in batch.states.items()]
    return float(max(errors) / max(1.0, *sizes))


@pytest.mark.filterwarnings("ignore::gelenk.errors.StartWarning")
@pytest.mark.parametrize("name", [*SCENES, *GALLERY, *OVERCONSTRAINED])
def test_a_lane_moves_as_the_scene_does(name: str) -> None:
    """All smooth scenes that are shipped: trees, loops, quaternions, rolling, redundant equations, gears."""
    path = (SCENES | GALLERY | OVERCONSTRAINED)[name]
    steps, step = 100, FAST.get(name, STEP)
    batch = gelenk.batch(path, 3, step=step)
    batch.step(steps)
    assert not batch.errors
    assert difference(batch, 1, alone(gelenk.load(path), steps, step=step)) < ROUNDING


def numbers_of(scene: Scene) -> dict[str, float]:
    """All numbers of a scene that can be set and are not 0, by their paths, and their values."""
    names: list[str] = []
    for path, size in _core.list_settables(scene._core):
        names += [path] if size == 1 else [f"{path}[{i + 1}]" for i in range(size)]
    listed, renamed = with_listed(scene, names)
    values = {name: listed.parameters[renamed.get(name, name)] for name in names}
    return {name: float(value) for name, value in values.items() if isinstance(value, float) and value != 0}


def changed(scene: Scene, name: str, value: float) -> Scene | None:
    """The scene with another value; None if it contradicts others, such as those of a thin rod."""
    listed, renamed = with_listed(scene, [name])
    try:
        other = listed.with_parameters({renamed.get(name, name): value})
        gelenk.Simulation(other)
    except (SceneError, AssemblyError):
        return None
    return other


@pytest.mark.filterwarnings("ignore::gelenk.errors.StartWarning", "ignore::gelenk.errors.SceneWarning")
@pytest.mark.parametrize("name", [*(name for name in SCENES if name != "stewart"), *GALLERY])
def test_every_number_of_a_scene_may_differ_from_lane_to_lane(name: str) -> None:
    """Each is 3 % larger in a lane of its own: masses, inertias, dimensions, laws, gravity. A number that is
    lost on the way to the equations, or that is computed with before, makes a lane differ by 1e-4 and more.
    """
    scene = gelenk.load((SCENES | GALLERY)[name])
    values = numbers_of(scene)
    others = {of: changed(scene, of, 1.03 * value) for of, value in values.items()}
    possible = [of for of, other in others.items() if other is not None and runs(other)]
    assert len(possible) >= 3
    table = {of: np.full(len(possible), values[of]) for of in possible}
    for lane, of in enumerate(possible):
        table[of][lane] *= 1.03
    steps, step = 20, FAST.get(name, STEP)
    batch = gelenk.batch(scene, len(possible), table, step=step)
    batch.step(steps)
    assert not batch.errors
    for lane, of in enumerate(possible):
        other = others[of]
        assert other is not None
        assert difference(batch, lane, alone(other, steps, step=step)) < ROUNDING, of


def runs(scene: Scene) -> bool:
    """Whether a changed scene has a start."""
    try:
        alone(scene, 1)
    except (AssemblyError, SceneError):
        return False
    return True


def test_masses_of_an_overconstrained_mechanism_may_differ() -> None:
    scene = gelenk.load(OVERCONSTRAINED["bricard"])
    batch = gelenk.batch(scene, 2, {"rod2.mass": [1.0, 1.7]}, step=STEP)
    batch.step(50)
    listed, renamed = with_listed(scene, ["rod2.mass"])
    assert difference(batch, 1, alone(listed.with_parameters({renamed["rod2.mass"]: 1.7}), 50)) < ROUNDING


def test_inputs_and_starts_are_those_of_each_lane() -> None:
    torques = np.array([0.5, 3.0, -2.0])  # N m
    scene = gelenk.load(SCENES["four_bar"])
    angles = [1.1, 1.3, 1.6]  # rad
    batch = gelenk.batch(scene, 3, {"A.phi_start": angles}, step=STEP)
    batch.inputs["drive.tau"] = torques
    batch.step(200)
    for lane in range(3):
        other = scene.with_parameters({"A.phi_start": angles[lane]})
        expected = alone(other, 200, {"drive.tau": float(torques[lane])})
        assert difference(batch, lane, expected) < ROUNDING


def test_inputs_are_held_until_they_are_changed() -> None:
    scene = gelenk.load(SCENES["cart_pole"])
    batch = gelenk.batch(scene, 2, step=STEP)
    name = next(iter(batch.inputs))
    batch.inputs[name][:] = 1.0
    batch.step(50)
    batch.inputs[name][:] = [-2.0, 0.5]
    batch.run(0.1)
    for lane, later in enumerate([-2.0, 0.5]):

        def force(t: float, later: float = later) -> float:
            return 1.0 if t < 0.05 - 1e-9 else later

        fixed = scene.with_parameters({"solver.step": STEP})
        result = gelenk.simulate(
            fixed, stop=0.1, step=STEP, integrator="rk4", formulation="projection",
            inputs={name: force},
        )  # fmt: skip
        expected = {of: float(np.asarray(result[of])[-1]) for of in result}
        assert difference(batch, lane, expected) < ROUNDING


def varying(effort: str, k: float) -> dict[str, Any]:
    """A lever of 0.1 kg m2 under a law with a constant k, from rest at 1 rad, with an input u of 1."""
    joint = {"type": "revolute", "parent": "ground", "child": "lever", "law": {"effort": effort}}
    return {
        "gelenk": 1,
        "bodies": {"lever": {"mass": 0, "inertia": [0.1, 0.1, 0.1]}},
        "constants": {"k": k},
        "parameters": ["k"],
        "inputs": {"u": {"start": 1.0}},
        "joints": {"A": {**joint, "start": {"phi": 1.0, "fixed": True}}},
    }


@pytest.mark.parametrize(
    "effort", ["-k*phi", "k*u", "-0.1*phi - k*phi", "exp(-k*t)", "sin(k*t)", "-phi/(2 + k)"]
)
@pytest.mark.parametrize("k", [0.0, 1.0, -1.0, 0.7])
def test_values_with_which_terms_vanish_are_as_good_as_others(effort: str, k: float) -> None:
    """0 and 1 are left out of equations: in the scene and in lanes."""
    scene, lanes = gelenk.load(varying(effort, k)), [0.0, 1.0, -1.0, 2.0, 5.0]
    batch = gelenk.batch(scene, len(lanes), {"k": lanes}, step=STEP)
    batch.inputs["u"] = 0.25
    batch.step(500)
    for lane, value in enumerate(lanes):
        expected = alone(scene.with_parameters({"k": value}), 500, {"u": 0.25})
        assert difference(batch, lane, expected) < ROUNDING


def test_an_oscillation_whose_stiffness_is_0_in_the_scene() -> None:
    """The closed form cos(sqrt(k/J) t), with an error of (w h)^4 w t / 120: 7e-11."""
    lanes = np.array([0.0, 2.0, 5.0])
    batch = gelenk.batch(varying("-k*phi", 0.0), 3, {"k": lanes}, step=STEP)
    batch.step(500)
    assert batch.states["A.phi"] == pytest.approx(np.cos(np.sqrt(lanes / 0.1) * 0.5), abs=1e-10)


TOGETHER = {
    "damping of the joint that closes the loop": ("four_bar", {"C.damping": [0.0, 0.05, 0.2]}),
    "its stiffness": ("four_bar", {"C.stiffness": [0.3, 0.0, 0.1]}),
    "of a pin": ("slider_crank", {"piston_pin.damping": [0.05, 0.0, 0.01]}),
    "moments of a rod": ("double_pendulum", {f"upper.inertia[{i}]": [0.05, 0.04, 0.06] for i in (2, 3)}),
    "plane of the loop": ("four_bar", {f"{n}.parent.position[2]": [0.01, 0.0, 0.2] for n in "AD"}),
    "mass": ("four_bar", {"rocker.mass": [0.0, 1.0, 2.0]}),
}


@pytest.mark.filterwarnings("ignore::gelenk.errors.StartWarning", "ignore::gelenk.errors.SceneWarning")
@pytest.mark.parametrize("name", TOGETHER)
def test_parameters_that_choose_the_tree_or_are_possible_together(name: str) -> None:
    """Another joint is cut where one has no damping; moments of a thin rod are equal."""
    file, parameters = TOGETHER[name]
    scene = gelenk.load(SCENES[file])
    batch = gelenk.batch(scene, 3, parameters, step=STEP)
    batch.step(100)
    for lane in range(3):
        listed, renamed = with_listed(scene, list(parameters))
        values = {renamed.get(of, of): row[lane] for of, row in parameters.items()}
        result = alone(listed.with_parameters(values), 100)
        assert difference(batch, lane, result) < 1e-10  # another tree: other rounding
