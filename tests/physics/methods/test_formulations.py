# SPDX-License-Identifier: BSD-3-Clause
"""The alternatives to projection: each is as accurate as expected,
with its own drift, and has exact Jacobians.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models.running import Array, assert_close
from samples import sampled

import gelenk
from physics.loops.test_bricard import bricard

ROOT = Path(__file__).parents[3]
ALTERNATIVES = ("baumgarte", "udwadia-kalaba", "penalty", "augmented-lagrangian", "independent")
STOP = 2.0


def plant(name: str, formulation: str, **solver: Any) -> gelenk.Simulation:
    source = bricard() if name == "bricard" else gelenk.load(ROOT / "scenes" / f"{name}.yaml").to_dict()
    source["solver"] = {"integrator": "erk", "formulation": formulation, **solver}
    return gelenk.Simulation(gelenk.load(source))


def run(simulation: gelenk.Simulation, stop: float, tolerance: float, count: int = 40) -> dict[str, Array]:
    """Return the values of all outputs ("values")
    and the diagnostics of the run at `count` times after the start.
    """
    simulation.initialize(0.0, tolerance)
    rows, health = [], []
    for t in np.linspace(0, stop, count + 1)[1:]:
        simulation.step_to(float(t))
        rows.append(simulation.values())
        health.append(dict(simulation.diagnostics))
    return {"values": np.array(rows), **{k: np.array([h[k] for h in health]) for k in health[0]}}


def coordinates(simulation: gelenk.Simulation) -> list[int]:
    return [i for i, s in enumerate(simulation.outputs) if s.level in (0, 1)]


@pytest.fixture(scope="module")
def reference() -> dict[str, dict[str, Array]]:
    return {
        name: run(plant(name, "projection"), STOP, 1e-11) for name in ("four_bar", "slider_crank", "bricard")
    }


# Of q and v, absolute, after 2 s at rtol 1e-10. `penalty`: its own Phi = lambda / (a Omega^2), about 1e-8 of
# a meter, and half of all digits in vdot. `udwadia-kalaba`: drift adds to the error.
BOUNDS = {
    "baumgarte": 1e-6,
    "udwadia-kalaba": 1e-6,
    "penalty": 1e-4,
    "augmented-lagrangian": 1e-6,
    "independent": 1e-7,
}


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "bricard"])
@pytest.mark.parametrize("formulation", sampled(ALTERNATIVES, [x for x in ALTERNATIVES if x != "penalty"]))
def test_alternatives_agree_with_projection(
    reference: dict[str, dict[str, Array]], name: str, formulation: str
) -> None:
    simulation = plant(name, formulation)
    if (name, formulation) == ("bricard", "augmented-lagrangian"):
        with pytest.raises(gelenk.StepError):  # its iteration does not converge with redundant constraints
            run(simulation, STOP, 1e-10)
        return
    found = run(simulation, STOP, 1e-10)
    chosen = coordinates(simulation)
    expected = reference[name]["values"][:, chosen]
    assert_close(name, found["values"][:, chosen], expected, BOUNDS[formulation], "see BOUNDS")


def test_loops_drift_apart_without_stabilization() -> None:
    """At rtol 1e-6 projection keeps the error at round-off,
    whereas the error of the pseudo-inverse grows over the run.
    """
    held = run(plant("four_bar", "projection"), 10.0, 1e-6)["constraints.position"]
    loose = run(plant("four_bar", "udwadia-kalaba"), 10.0, 1e-6)["constraints.position"]
    assert held.max() < 1e-12
    assert loose[-10:].max() > 3 * loose[:10].max() > 1e-10


def test_baumgarte_stabilization_bounds_the_errors() -> None:
    """The error of each step decays within 1/alpha:
    it is no larger in the second half of the run than in the first.
    """
    held = run(plant("four_bar", "baumgarte", baumgarte_alpha=20, baumgarte_beta=20), 10.0, 1e-6)
    loose = run(plant("four_bar", "udwadia-kalaba"), 10.0, 1e-6)
    gap = held["constraints.position"]
    assert gap[20:].max() < 3 * gap[:20].max()
    assert gap.max() < 0.2 * loose["constraints.position"].max()


@pytest.mark.parametrize("name", ["four_bar", "bricard"])
def test_independent_conserves_energy_across_changes_of_partition(name: str) -> None:
    """Full turns of the crank, or oscillations of the closed loop:
    no single choice of coordinates is valid throughout.
    """
    found = run(plant(name, "independent"), 5.0, 1e-10)
    total = run(plant(name, "projection"), 5.0, 1e-11)["energy.total"]  # the four-bar has a damper
    assert found["constraints.position"].max() < 1e-12
    assert_close("energy", found["energy.total"], total, 1e-6, "rtol 1e-10 over 5 s")


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "stewart"])
@pytest.mark.parametrize("formulation", ["projection", *ALTERNATIVES])
def test_jacobians_are_exact(name: str, formulation: str) -> None:
    """Compared with central differences of the integrator's right-hand side, at a moving state."""
    simulation = plant(name, formulation)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.3)
    core = simulation._core
    y = np.array(core._state(0))
    n = len(y)
    exact = np.array(core._state_jacobian(0, y.tolist(), True)).reshape(n, n).T
    found = np.array([directional_derivative(core, y, e, 1e-5) for e in np.eye(n)]).T
    # Penalty loses half of all digits in vdot; a finite difference divides those by h.
    share = 1e-3 if formulation == "penalty" else 1e-6
    assert_close("df/dy", exact, found, share * np.abs(exact).max(), "finite differences: round-off / h, h^4")


@pytest.mark.parametrize(
    "formulation", ["projection", *(r for r in ALTERNATIVES if r != "augmented-lagrangian")]
)
def test_jacobians_with_redundant_constraints_are_exact_along_the_motion(formulation: str) -> None:
    """Off the constraint manifold redundant constraints contradict each other, and the pivots decide which
    are used; on it they agree. The direction is therefore that in which the loop moves.
    """
    simulation = plant("bricard", formulation)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.3)
    core = simulation._core
    y = np.array(core._state(0))
    exact = np.array(core._state_jacobian(0, y.tolist(), True)).reshape(len(y), len(y)).T
    direction = np.array(core._state_jacobian(0, y.tolist(), False))
    direction /= np.linalg.norm(direction)
    expected = exact @ direction
    share = 1e-3 if formulation == "penalty" else 1e-5
    bound = share * np.abs(exact).max()
    assert_close(
        "df",
        directional_derivative(core, y, direction, 1e-5),
        expected,
        bound,
        "finite differences; h^2 off the constraints",
    )


def directional_derivative(core: Any, y: Array, direction: Array, h: float) -> Array:
    """Derivative of the integrator's right-hand side, by two central differences, error of order h^4."""

    def difference(s: float) -> Array:
        ahead = np.array(core._state_jacobian(0, (y + s * direction).tolist(), False))
        behind = np.array(core._state_jacobian(0, (y - s * direction).tolist(), False))
        quotient: Array = (ahead - behind) / (2 * s)
        return quotient

    return (4 * difference(h) - difference(2 * h)) / 3


def test_gains_are_accepted_only_by_baumgarte(four_bar: gelenk.Scene) -> None:
    with pytest.raises(
        gelenk.SceneError, match="with the formulation projection, expected the formulation baumg"
    ):
        gelenk.simulate(four_bar, stop=0.1, parameters={"solver.baumgarte_beta": 3})


def test_formulation_is_an_argument_of_simulate(four_bar: gelenk.Scene) -> None:
    usual = gelenk.simulate(four_bar, stop=0.1)
    other = gelenk.simulate(four_bar, stop=0.1, formulation="independent")
    assert_close("A.phi", other["A.phi"], usual["A.phi"], 1e-5, "rtol 1e-6")
    with pytest.raises(
        gelenk.UsageError, match=r"solver\.formulation: found 'best', expected one of projection"
    ):
        gelenk.simulate(four_bar, stop=0.1, formulation="best")
