# SPDX-License-Identifier: BSD-3-Clause
"""The rivals of projection: each to its own accuracy, with its own drift, and with exact Jacobians."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models.running import Array, assert_close

import gelenk
from physics.loops.test_bricard import bricard

ROOT = Path(__file__).parents[3]
RIVALS = ("baumgarte", "udwadia-kalaba", "penalty", "augmented-lagrangian", "independent")
STOP = 2.0


def plant(name: str, formulation: str, **solver: Any) -> gelenk.Simulation:
    source = bricard() if name == "bricard" else gelenk.load(ROOT / "scenes" / f"{name}.yaml").to_dict()
    source["solver"] = {"integrator": "erk", "formulation": formulation, **solver}
    return gelenk.Simulation(gelenk.load(source))


def run(simulation: gelenk.Simulation, stop: float, tolerance: float, count: int = 40) -> dict[str, Array]:
    """Values of all outputs ("values") and the run's health at `count` times after the start."""
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


# Of q and v, absolute, after 2 s at rtol 1e-10. `penalty`: its own Phi = lambda / (a Omega^2), some 1e-8 of a
# metre, and half of all digits in vdot. `udwadia-kalaba`: drift adds to the error.
BOUNDS = {
    "baumgarte": 1e-6,
    "udwadia-kalaba": 1e-6,
    "penalty": 1e-4,
    "augmented-lagrangian": 1e-6,
    "independent": 1e-7,
}


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "bricard"])
@pytest.mark.parametrize("formulation", RIVALS)
def test_rivals_move_as_projection_does(
    reference: dict[str, dict[str, Array]], name: str, formulation: str
) -> None:
    simulation = plant(name, formulation)
    if (name, formulation) == ("bricard", "augmented-lagrangian"):
        with pytest.raises(gelenk.StepError):  # its iteration does not settle on rows that repeat others
            run(simulation, STOP, 1e-10)
        return
    found = run(simulation, STOP, 1e-10)
    chosen = coordinates(simulation)
    expected = reference[name]["values"][:, chosen]
    assert_close(name, found["values"][:, chosen], expected, BOUNDS[formulation], "see BOUNDS")


def test_without_stabilisation_loops_drift_apart() -> None:
    """At rtol 1e-6; projection stays at rounding, the pseudo-inverse's errors grow over the run."""
    held = run(plant("four_bar", "projection"), 10.0, 1e-6)["constraints.position"]
    loose = run(plant("four_bar", "udwadia-kalaba"), 10.0, 1e-6)["constraints.position"]
    assert held.max() < 1e-12
    assert loose[-10:].max() > 3 * loose[:10].max() > 1e-10


def test_baumgarte_keeps_errors_bounded() -> None:
    """What a step adds decays within 1/alpha: the second half of the run shows no more than the first."""
    held = run(plant("four_bar", "baumgarte", baumgarte_alpha=20, baumgarte_beta=20), 10.0, 1e-6)
    loose = run(plant("four_bar", "udwadia-kalaba"), 10.0, 1e-6)
    gap = held["constraints.position"]
    assert gap[20:].max() < 3 * gap[:20].max()
    assert gap.max() < 0.2 * loose["constraints.position"].max()


@pytest.mark.parametrize("name", ["four_bar", "bricard"])
def test_independent_keeps_energy_through_repartitions(name: str) -> None:
    """Full turns of the crank, or swings of the ring: no one choice of coordinates serves all along."""
    found = run(plant(name, "independent"), 5.0, 1e-10)
    total = run(plant(name, "projection"), 5.0, 1e-11)["energy.total"]  # the four-bar has a damper
    assert found["constraints.position"].max() < 1e-12
    assert_close("energy", found["energy.total"], total, 1e-6, "rtol 1e-10 over 5 s")


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "stewart"])
@pytest.mark.parametrize("formulation", ["projection", *RIVALS])
def test_jacobians_are_exact(name: str, formulation: str) -> None:
    """Against central differences of what the integrator sees, at a moving state."""
    simulation = plant(name, formulation)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.3)
    core = simulation._core
    y = np.array(core._state(0))
    n = len(y)
    exact = np.array(core._state_jacobian(0, y.tolist(), True)).reshape(n, n).T
    found = np.array([slope(core, y, e, 1e-5) for e in np.eye(n)]).T
    # Penalty loses half of all digits in vdot; a difference quotient divides those by h.
    share = 1e-3 if formulation == "penalty" else 1e-6
    assert_close("df/dy", exact, found, share * np.abs(exact).max(), "differences: rounding / h, h^4")


@pytest.mark.parametrize("formulation", ["projection", *(r for r in RIVALS if r != "augmented-lagrangian")])
def test_jacobians_are_exact_along_the_motion_of_redundant_rows(formulation: str) -> None:
    """Off the constraints repeated rows contradict each other, and which count is up to pivots;
    along the constraints they do not. So: the direction in which the ring moves.
    """
    simulation = plant("bricard", formulation)
    simulation.initialize(0.0, 1e-8)
    simulation.step_to(0.3)
    core = simulation._core
    y = np.array(core._state(0))
    exact = np.array(core._state_jacobian(0, y.tolist(), True)).reshape(len(y), len(y)).T
    way = np.array(core._state_jacobian(0, y.tolist(), False))
    way /= np.linalg.norm(way)
    expected = exact @ way
    share = 1e-3 if formulation == "penalty" else 1e-5
    bound = share * np.abs(exact).max()
    assert_close("df", slope(core, y, way, 1e-5), expected, bound, "differences; h^2 off the constraints")


def slope(core: Any, y: Array, way: Array, h: float) -> Array:
    """Of what the integrator sees, by two central differences, error of order h^4."""

    def difference(s: float) -> Array:
        ahead = np.array(core._state_jacobian(0, (y + s * way).tolist(), False))
        behind = np.array(core._state_jacobian(0, (y - s * way).tolist(), False))
        quotient: Array = (ahead - behind) / (2 * s)
        return quotient

    return (4 * difference(h) - difference(2 * h)) / 3


def test_gains_belong_to_baumgarte(four_bar: gelenk.Scene) -> None:
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
