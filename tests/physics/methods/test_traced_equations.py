# SPDX-License-Identifier: BSD-3-Clause
"""Runs by programs that are made for a scene (`solver.equations`) are those by the general kernels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from costs.jobs import chain
from mechanisms import four_bar
from special.drawn import drawn

import gelenk
from gelenk.errors import AssemblyError, SceneError, StepError
from physics.loops.test_parallelograms import four_bar_chain

ROOT = Path(__file__).resolve().parents[3]
SCENES = {path.stem: path for path in sorted(ROOT.glob("scenes/*.yaml"))}
SCENES |= {path.parent.name: path for path in sorted(ROOT.glob("docs/gallery/*/scene.yaml"))}
FAST = {"andrews": 1e-4}  # s: of mechanisms that turn several times in 0.01 s
# Both compute the same operations in another order; errors of some thousand roundings, which motions magnify.
ROUNDING = 1e-12
# In many random mechanisms, of which some turn at 100 rad/s or come near singular configurations in 20 steps.
MAGNIFIED = 2e-10
# Those of which all parts that move by forces are smooth.
TRACED = {
    "andrews", "balancing_robot", "bennett", "bicycle", "bricard", "cart_pole", "delta_robot", "differential",
    "double_pendulum", "double_wishbone", "excavator", "five_bar", "four_bar", "free_body", "gears",
    "heavy_top", "jansen_leg", "mast_arm_disc", "pendulum", "planetary_gear", "rolling_disc", "slider_crank",
    "stewart", "windscreen_wiper",
}  # fmt: skip


def plant_of(scene: Any, **solver: Any) -> gelenk.Simulation:
    plant = gelenk.Simulation(
        gelenk.load(scene).with_parameters({f"solver.{k}": v for k, v in solver.items()})
    )
    plant.initialize()
    return plant


def states(plant: gelenk.Simulation) -> dict[str, float]:
    return {s.name: plant.output(s.name) for s in plant.outputs if s.level <= 1}


def share(plant: gelenk.Simulation) -> float:
    """Of the evaluations, those by a program."""
    found = plant.diagnostics
    return float(found["solver.traced_evaluations"] / max(1, found["solver.evaluations"]))


def run(plant: gelenk.Simulation, first: int, steps: int, step: float) -> dict[str, float]:
    for k in range(first, first + steps):
        for i, signal in enumerate(plant.inputs):
            plant.set_input(signal.name, 0.2 * math.sin(0.9 * k + i))
        plant.step_to((k + 1) * step)
    return states(plant)


def difference(scene: Any, steps: int, step: float, **solver: Any) -> tuple[float, float]:
    """After some steps, relative to the largest number of the state or 1; and the share of the program."""
    plants = [plant_of(scene, step=step, equations=kind, **solver) for kind in ("general", "traced")]
    expected, found = (run(plant, 0, steps, step) for plant in plants)
    assert share(plants[0]) == 0
    size = max(1.0, *(abs(x) for x in expected.values()))
    return max(abs(found[name] - x) for name, x in expected.items()) / size, share(plants[1])


@pytest.mark.filterwarnings("ignore::gelenk.StartWarning")
@pytest.mark.parametrize("name", SCENES)
def test_shipped_scenes_move_alike(name: str) -> None:
    found, traced = difference(SCENES[name], 60, FAST.get(name, 1e-3), integrator="rk4")
    assert found < ROUNDING
    assert (traced > 0.99) == (name in TRACED), traced


@pytest.mark.filterwarnings("ignore::gelenk.StartWarning")
@pytest.mark.filterwarnings("ignore::gelenk.SceneWarning")
@pytest.mark.parametrize("reductions", [True, False])
@pytest.mark.parametrize(
    "first", [0, *(pytest.param(k, marks=pytest.mark.study) for k in range(60, 1200, 60))]
)
def test_random_mechanisms_move_alike(first: int, reductions: bool) -> None:
    """Many of them in special positions, where pivots are chosen nearby, or the kernels evaluate; without
    reductions, some constraint equations consist of rounding alone.
    """
    bound = ROUNDING if reductions and first == 0 else MAGNIFIED
    shares = []
    for seed in range(first, first + 60):
        source = drawn(seed).source
        source.setdefault("solver", {})["reductions"] = {"all": reductions}
        try:
            found, traced = difference(source, 20, 1e-3, integrator="rk4")
        except (SceneError, AssemblyError):
            continue  # at a start that is refused
        except StepError:
            assert words_of_refusal(source, "general") == words_of_refusal(source, "traced"), seed
        else:
            assert found < bound, seed
            shares.append(traced)
    assert len(shares) > 45
    assert np.mean(shares) > (0.6 if reductions else 0.25)


def words_of_refusal(source: Any, equations: str) -> str:
    plant = plant_of(source, step=1e-3, equations=equations, integrator="rk4")
    with pytest.raises(StepError) as error:
        run(plant, 0, 20, 1e-3)
    return str(error.value)


@pytest.mark.parametrize("integrator", ["auto", "erk", "cvode", "cvode-adams", "dirk", "ida", "euler"])
def test_all_integrators(integrator: str) -> None:
    """At a tolerance of 1e-8; a linkage that turns for five seconds."""
    found = []
    for kind in ("general", "traced"):
        plant = plant_of(SCENES["slider_crank"], equations=kind, integrator=integrator)
        plant.initialize(tolerance=1e-8)
        plant.set_input(plant.inputs[0].name, 0.3)
        for k in range(100):
            plant.step_to((k + 1) * 0.05)
        found.append((states(plant), share(plant), plant.diagnostics["solver.evaluations"]))
    (expected, _, general), (moved, traced, evaluations) = found
    assert traced > (0.5 if integrator in ("dirk", "ida", "cvode") else 0.95)
    assert evaluations == pytest.approx(general, rel=0.05)
    size = max(1.0, *(abs(x) for x in expected.values()))
    # Rounding decides on the iterations of implicit methods.
    assert max(abs(moved[name] - x) for name, x in expected.items()) < 1e-7 * size


def test_singular_positions_are_left_to_the_kernels() -> None:
    """Two parallelograms pass their change points: with all programs as without, and as often."""
    found = []
    for kind in ("general", "traced"):
        plant = plant_of(four_bar_chain(2, 0.0, 1.0), equations=kind, integrator="erk")
        plant.initialize(tolerance=1e-9)
        for k in range(100):
            plant.step_to((k + 1) * 0.04)
        found.append((states(plant), share(plant), plant.diagnostics["solver.singular_positions"]))
    (expected, _, crossed), (moved, traced, also) = found
    assert crossed == also > 3
    assert 0.2 < traced < 0.95
    assert max(abs(moved[name] - x) for name, x in expected.items()) < 1e-6


@pytest.mark.parametrize("name", ["five_bar", "stewart", "rolling_disc"])
def test_a_restored_run_has_the_same_bits(name: str) -> None:
    """In the same plant, and in another one."""
    scene = SCENES[name]
    plant = plant_of(scene, integrator="erk")
    run(plant, 0, 10, 0.01)
    saved = plant.save()
    expected = run(plant, 10, 10, 0.01)
    other = plant_of(scene, integrator="erk")
    run(other, 0, 3, 0.01)
    for again in (plant, other):
        again.restore(saved)
        assert run(again, 10, 10, 0.01) == expected
        assert share(again) > 0.9


def test_tuning_hands_over_to_the_kernels_and_restoring_back() -> None:
    """What a program was made for is gone with the first number that changes, until one is made again."""
    source = four_bar() | {"parameters": ["A.damping"]}
    before = gelenk.load(source).with_parameters({"solver.integrator": "rk4", "solver.step": 1e-3})
    after = before.with_parameters({"A.damping": 0.9})
    plant = gelenk.Simulation(before)
    plant.initialize()
    run(plant, 0, 20, 1e-3)
    saved = plant.save()
    expected = run(plant, 20, 20, 1e-3)
    traced = plant.diagnostics["solver.traced_evaluations"]
    assert share(plant) > 0.99
    plant._core.tune(after._core)
    run(plant, 40, 5, 1e-3)
    assert plant.diagnostics["solver.traced_evaluations"] == traced
    # With the new numbers, from the old state: by a new program, and by the kernels.
    plant.restore(saved)
    tuned = run(plant, 20, 20, 1e-3)
    assert plant.diagnostics["solver.traced_evaluations"] == traced
    general = plant_of(before, equations="general")
    run(general, 0, 20, 1e-3)
    general._core.tune(after._core)
    assert run(general, 20, 20, 1e-3) == pytest.approx(tuned, rel=1e-11, abs=1e-12)
    assert tuned != pytest.approx(expected, rel=1e-6)
    plant._core.tune(before._core)
    plant.restore(saved)
    assert run(plant, 20, 20, 1e-3) == expected
    assert plant.diagnostics["solver.traced_evaluations"] == traced


@pytest.mark.parametrize(("bodies", "traced"), [(1, True), (10, True), (30, False), (45, False)])
def test_large_mechanisms_are_left_to_the_kernels(bodies: int, traced: bool) -> None:
    """Operations of an elimination grow with the cube of the velocities, those of the kernels linearly."""
    found, part = difference(chain(bodies), 5, 1e-3, integrator="rk4")
    assert found < ROUNDING
    assert part == (1 if traced else 0)


def test_a_disc_that_falls_flat_is_left_to_the_kernels() -> None:
    """Where it lies flat it has no contact point: the last moments before."""
    source = gelenk.load(SCENES["rolling_disc"]).to_dict()
    source["joints"]["base"]["start"]["w"] = 0.0
    source["joints"]["spin"]["start"]["w"] = 0.0
    source["joints"]["lean"]["start"]["phi"] = -1.3
    source["joints"]["height"]["start"]["s"] = 0.3 * math.cos(1.3)
    ends = []
    counts: list[tuple[float, float]] = []
    for kind in ("general", "traced"):
        plant = plant_of(source, equations=kind, integrator="rk4", step=1e-4)
        counts.clear()
        tilt = math.pi / 2
        while tilt > 0.01:
            plant.step_to(plant.time + 1e-4)
            tilt = math.pi / 2 - abs(plant.output("lean.phi"))
            counts.append((tilt, plant.diagnostics["solver.traced_evaluations"]))
        ends.append(states(plant))
    upright = [count for tilt, count in counts if tilt > 0.25][-1]
    flat = [count for tilt, count in counts if tilt < 0.05]
    assert upright > 100
    assert flat[0] == flat[-1] >= upright
    assert ends[1] == pytest.approx(ends[0], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("joint", "law"),
    [
        ("A", {"friction": {"coulomb": 0.01, "bearing": {"coefficient": 0.1, "radius": 0.01}}}),
        ("A", {"law": {"effort": "if(phi > 1.2, -phi, 0)"}}),
        ("C", {"stiffness": 3.0}),
    ],
    ids=["friction by load", "a branch", "a spring in a joint that may close the loop"],
)
def test_laws_that_programs_do_not_have(joint: str, law: dict[str, Any]) -> None:
    source = four_bar()
    source["joints"][joint] |= law
    found, part = difference(source, 40, 1e-3, integrator="rk4")
    assert found < ROUNDING
    assert part in ((0, 1) if joint == "C" else (0,))
