# SPDX-License-Identifier: BSD-3-Clause
"""The DAE formulations `index3` and `stabilized-index2`, whose multipliers are unknowns of the integrator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warned
from models.running import Array, assert_close

import gelenk
from physics.loops.test_bricard import bricard
from physics.loops.test_parallelograms import four_bar_chain

pytestmark = warned.TIGHT

ROOT = Path(__file__).parents[3]
FORMS = ("index3", "stabilized-index2")
# s; a few milliseconds for Andrews' mechanism, in which its fast crank makes half a turn.
STOPS = {"four_bar": 2.0, "slider_crank": 2.0, "stewart": 1.0, "andrews": 0.008, "double_pendulum": 1.0}


def plant(name: str, **solver: Any) -> gelenk.Simulation:
    source = bricard() if name == "bricard" else gelenk.load(ROOT / "scenes" / f"{name}.yaml").to_dict()
    source["solver"] = solver
    return gelenk.Simulation(gelenk.load(source))


def run(simulation: gelenk.Simulation, stop: float, tolerance: float, count: int = 40) -> dict[str, Array]:
    """Return coordinates "q", velocities "v" and the diagnostics of the run at
    `count` times after the start.
    """
    simulation.initialize(0.0, tolerance)
    level = [[i for i, s in enumerate(simulation.outputs) if s.level == k] for k in (0, 1)]
    rows, health = [], []
    for t in np.linspace(0, stop, count + 1)[1:]:
        simulation.step_to(float(t))
        rows.append(simulation.values())
        health.append(dict(simulation.diagnostics))
    values = np.array(rows)
    return {
        "q": values[:, level[0]],
        "v": values[:, level[1]],
        **{k: np.array([h[k] for h in health]) for k in health[0]},
    }


@pytest.fixture(scope="module")
def reference() -> dict[str, dict[str, Array]]:
    return {n: run(plant(n, integrator="erk"), stop, 1e-12) for n, stop in STOPS.items()}


# Largest ratio of the error of q to the tolerance, by formulation, and of the velocity error to that of q, by
# scene (Andrews' crank is fast). At least three times the observed values, because BDF errors accumulate over
# a run. For index 3 the error of velocities may be the tolerance divided by the step, and positions follow
# them.
FACTORS = {"index3": 3000.0, "stabilized-index2": 30.0}
RATES = {"four_bar": 10.0, "slider_crank": 20.0, "stewart": 100.0, "andrews": 1000.0, "double_pendulum": 20.0}


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize("name", STOPS)
@pytest.mark.parametrize("form", FORMS)
def test_same_motion_as_projection(
    reference: dict[str, dict[str, Array]], form: str, name: str, tolerance: float
) -> None:
    found = run(plant(name, integrator="ida", formulation=form), STOPS[name], tolerance)
    bound = FACTORS[form] * tolerance
    assert_close("q", found["q"], reference[name]["q"], bound, "see FACTORS")
    assert_close("v", found["v"], reference[name]["v"], RATES[name] * bound, "see FACTORS, RATES")


@pytest.mark.parametrize("form", FORMS)
def test_runs_finish_at_tight_tolerances(reference: dict[str, dict[str, Array]], form: str) -> None:
    """Runs at 1e-10 finish, also with a communication step of a millisecond;
    below 5e-12 errors decrease no further.
    """
    for count in (40, 2000):
        found = run(plant("four_bar", integrator="ida", formulation=form), 2.0, 1e-10, count)
        assert_close(
            "q", found["q"][-1], reference["four_bar"]["q"][-1], FACTORS[form] * 1e-10, "see FACTORS"
        )
    run(plant("andrews", integrator="ida", formulation=form), 0.008, 1e-14)


def test_velocity_constraint_errors_are_as_predicted() -> None:
    """Both formulations close the loops in every step. The velocities of index 3 follow from q alone, so J v
    is as large as the tolerance divided by the step; those of index 2 also satisfy J v = 0, to Newton's share
    of the tolerance.
    """
    tolerance = 1e-8
    third, second, without = (
        run(plant("four_bar", integrator="ida", formulation=form), 10.0, tolerance)
        for form in (*FORMS, "udwadia-kalaba")
    )
    for found in (third, second):
        assert found["constraints.position"].max() < tolerance / 50
    assert second["constraints.velocity"].max() < tolerance / 10
    assert tolerance < third["constraints.velocity"].max() < 1000 * tolerance
    assert without["constraints.position"][-1] > 10 * third["constraints.position"].max()
    # The closure error does not grow.
    halves = np.split(third["constraints.velocity"], 2)
    assert halves[1].max() < 5 * halves[0].max()


@pytest.mark.parametrize("name", ["four_bar", "stewart", "double_pendulum"])
@pytest.mark.parametrize("form", FORMS)
def test_jacobians_of_the_residual_are_exact(name: str, form: str) -> None:
    """Jacobians of the residual, at a moving state and rates close to those of the motion,
    against central differences.
    """
    simulation = plant(name, integrator="ida", formulation=form)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.3)
    core = simulation._core
    x, xdot = np.split(np.array(core._consistent(0)), 2)
    assert_close("F", residual(core, x, xdot), 0, 1e-4 * np.abs(xdot).max(), "consistent; the state to 1e-8")
    n = len(x)
    xdot = xdot * (1 + 0.1 * np.cos(np.arange(n)))
    jacobians = np.array(core._residual(0, x.tolist(), xdot.tolist(), True)).reshape(2, n, n)
    exact = jacobians[0].T, jacobians[1].T
    h = 1e-5
    for way, scale in zip(np.eye(n), np.maximum(1, np.abs(x)), strict=True):
        s = h * scale
        by_x = (residual(core, x + s * way, xdot) - residual(core, x - s * way, xdot)) / (2 * s)
        by_xdot = (residual(core, x, xdot + s * way) - residual(core, x, xdot - s * way)) / (2 * s)
        bound = 1e-7 * max(1, float(np.abs(exact[0]).max()))
        assert_close("dF/dx", exact[0] @ way, by_x, bound, "finite differences: round-off / h, h^2")
        assert_close("dF/dxdot", exact[1] @ way, by_xdot, bound, "finite differences: round-off / h")


def residual(core: Any, x: Array, xdot: Array) -> Array:
    return np.array(core._residual(0, x.tolist(), xdot.tolist(), False))


@pytest.mark.parametrize("form", FORMS)
def test_redundant_constraints_are_refused(form: str) -> None:
    simulation = plant("bricard", integrator="ida", formulation=form)
    simulation.initialize(0.0, 1e-8)
    before = simulation.values()
    with pytest.raises(
        gelenk.StepError, match=rf"t = 0 s: .*5 constraint equations of rank 4.*{form}.*projection"
    ):
        simulation.step_to(0.1)
    assert simulation.time == 0.0
    assert np.array_equal(simulation.values(), before)


@pytest.mark.parametrize("n", [1, 2])
def test_short_steps_end_beside_a_singular_configuration(n: int) -> None:
    """All bars of the N-four-bar are in line after 0.71 s (test_singular_crossings.py). At 1e-9 the steps are
    too short to cross that configuration.
    """
    source = four_bar_chain(n, 0.0, 1.0)
    source["solver"] = {"integrator": "ida", "formulation": "stabilized-index2"}
    simulation = gelenk.Simulation(gelenk.load(source))
    simulation.initialize(0.0, 1e-9)
    with pytest.raises(gelenk.StepError, match=r"t = 0\.7\d+ s: close to a singular configuration"):
        simulation.step_to(2.0)
    assert simulation.time == 0.0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("integrator", ["erk", "rk4", "euler", "cvode", "cvode-adams", "dirk"])
def test_integrators_for_odes_are_refused(form: str, integrator: str) -> None:
    with pytest.raises(
        gelenk.SceneError, match=f"'{integrator}' with the formulation {form}, expected one of"
    ):
        plant("four_bar", formulation=form, integrator=integrator)
    scene = gelenk.load(ROOT / "scenes" / "four_bar.yaml")
    with pytest.raises(
        gelenk.SceneError, match=f"'{integrator}' with the formulation {form}, expected one of"
    ):
        gelenk.simulate(scene, stop=0.1, formulation=form, integrator=integrator)


@pytest.mark.parametrize("form", FORMS)
def test_auto_selects_ida(form: str) -> None:
    chosen, named = (
        run(plant("four_bar", formulation=form, integrator=integrator), 0.5, 1e-6)
        for integrator in ("auto", "ida")
    )
    assert np.array_equal(chosen["q"], named["q"])


@pytest.mark.parametrize("form", FORMS)
def test_input_jumps_are_integrated_accurately(form: str) -> None:
    """The torque changes every tenth of a second, 2 s; compared with projection at the tolerance squared."""

    def final_angles(tolerance: float, **solver: Any) -> Array:
        simulation = plant("four_bar", **solver)
        simulation.initialize(0.0, tolerance)
        rows = []
        for k in range(20):
            simulation.set_input("drive.tau", 3.0 * (-1) ** k)
            simulation.step_to(0.1 * (k + 1))
            rows.append(simulation.values()[:2])
        return np.array(rows)

    expected = final_angles(1e-12, integrator="erk")
    found = final_angles(1e-7, integrator="ida", formulation=form)
    assert_close("A", found, expected, 10 * FACTORS[form] * 1e-7, "see FACTORS; jumps cost")
