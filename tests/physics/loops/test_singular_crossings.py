# SPDX-License-Identifier: BSD-3-Clause
"""Motion through singular configurations: change points at which other branches open.

The N-four-bar (IFToMM A02, test_parallelograms.py) falls like one pendulum and crosses its change points,
all bars in line, twice per turn. Each four-bar could change branches there, which energy alone would not
reveal.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import warned
from mechanisms import GRAVITY
from models import reducible
from models.running import assert_close, run
from scipy.integrate import solve_ivp

import gelenk
from physics.loops.test_parallelograms import falling, four_bar_chain
from physics.loops.test_singular_starts import parallelogram, pendulum_acceleration

ROOT = Path(__file__).parents[3]


def tip(phi: np.ndarray) -> np.ndarray:
    return np.array([np.sin(phi), np.cos(phi)]).T


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize(("n", "stop"), [(1, 20.0), (2, 20.0), (10, 20.0), (40, 2.0)])
def test_n_four_bar_stays_on_its_branch(n: int, stop: float, tolerance: float) -> None:
    """With 100 communication points per second, at arbitrary distances from the 56 crossings in 20 s.

    Each crossing adds the error of accelerations extrapolated over some hundredths of a second, less than
    1e-8 m; the falling pendulum amplifies it to some tens of that over the run.
    """
    times = np.linspace(0, stop, round(100 * stop) + 1)
    found = run(four_bar_chain(n, 0.0, 1.0), times, tolerance=tolerance, integrator="erk")
    expected = tip(falling(n, 0.0, 1.0, times))
    assert_close("B0", found.vector("tip.r")[:, :2], expected, 1e-5, "of a four-bar, at any tolerance")


@pytest.mark.parametrize("integrator", ["erk", "ida"])
@pytest.mark.parametrize("n", [1, 2])
def test_change_points_are_crossed_with_long_steps(n: int, integrator: str) -> None:
    """Without communication points the steps are ten times as long."""
    times = np.array([0.0, 20.0])
    found = run(four_bar_chain(n, 0.0, 1.0), times, tolerance=1e-8, integrator=integrator)
    expected = tip(falling(n, 0.0, 1.0, times))
    assert_close("B0", found.vector("tip.r")[:, :2], expected, 5e-5, "5000 rtol: as anywhere over 14 turns")


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("coupler_is_parent", [False, True])
def test_redundant_third_crank_does_not_affect_the_crossing(
    coupler_is_parent: bool, tolerance: float
) -> None:
    """One constraint equation is redundant at every position; at the change points one more is."""
    source = reducible.triple_crank(coupler_is_parent)
    times = np.linspace(0, 5, 501)
    found = run(source, times, tolerance=tolerance, integrator="erk")
    total = found["energy.total"]
    assert_close(
        "energy",
        total,
        total[0],
        2000 * tolerance * 20 + 1e-7,
        "of about 20 J, plus a contribution per crossing",
    )
    turned = found["A0.phi"] - found["A0.phi"][0]
    for k in (1, 2):
        assert_close(
            f"A{k}.phi", found[f"A{k}.phi"] - found[f"A{k}.phi"][0], turned, 1e-6, "bars remain parallel"
        )


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
@pytest.mark.parametrize(("n", "step"), [(1, 0.01), (2, 0.1), (10, 0.01)])
def test_torque_may_jump_near_change_points(n: int, step: float, tolerance: float) -> None:
    """The torque on the first crank changes in every communication step,
    many of them beside a change point.
    """
    source = four_bar_chain(n, 0.0, 1.0)
    source["motors"] = {"drive": {"joint": "A0"}}
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, tolerance)
    inertia, pull = (n + 1) / 3 + n, GRAVITY * ((n + 1) / 2 + n)
    y, tip_error, a_error = np.array([0.0, 1.0]), 0.0, 0.0
    for k in range(round(5 / step)):
        tau = 5 * math.sin(2.1 * k * k + 0.3)
        plant.set_input("drive.tau", tau)
        plant.step_to((k + 1) * step)

        def fall(_t: float, y: np.ndarray, tau: float = tau) -> list[float]:
            return [y[1], (pull * math.sin(y[0]) - tau) / inertia]

        y = solve_ivp(fall, (0, step), y, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        tip_error = max(tip_error, np.abs(plant.values(["tip.r[1]", "tip.r[2]"]) - tip(y[0])).max())
        a_error = max(a_error, abs(plant.output("A0.a") + fall(0, y)[1]))
    assert tip_error < max(1e-5, 100 * tolerance), "steps of 0.1 s reach 7e-6 m in 10 s at 1e-6"
    # There the constraint equations divide an error of the state by a distance that vanishes.
    assert a_error < 5e-3, "1e-3 rad/s2 with ten four-bars, of some 20"


@warned.TIGHT
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("integrator", ["erk", "dirk", "cvode", "ida"])
@pytest.mark.parametrize("step", [1e-2, 1e-3, 1e-4])
def test_accelerations_are_accurate_near_change_points(
    step: float, integrator: str, tolerance: float
) -> None:
    """Cranks that move in parallel are one pendulum, whose acceleration is known at any angle.

    Errors were 1e-5 rad/s2 in the past, and more with tighter tolerances, whose short steps left little to
    extrapolate from. The error from the constraint equations is 1e-14 / ratio^3, that of extrapolation from
    0.1 of the largest pivot 1e-9: usually at most 1e-7, and 6e-6 with `cvode` and `ida` at 1e-4.
    """
    start = {"phi": 0.7, "w": -6.0}
    source = parallelogram({**start, "fixed": True}, start)
    source["solver"] = {"integrator": integrator}
    plant = gelenk.Simulation(source)
    plant.initialize(0.0, tolerance)
    worst = 0.0
    for k in range(1, round(0.3 / step) + 1):
        plant.step_to(k * step)
        exact = pendulum_acceleration(plant.output("A.phi"))
        worst = max(worst, *(abs(plant.output(f"{crank}.a") - exact) for crank in "AD"))
    assert plant.output("A.phi") < -0.5, "the change point was crossed"
    assert worst < max(2e-6, 0.1 * tolerance), "of 37 rad/s2"


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize(("n", "points"), [(1, 40), (1, 2000), (2, 200), (10, 2000)])
def test_every_crossing_is_reported(n: int, points: int, tolerance: float) -> None:
    """The cranks of a falling N-four-bar are horizontal, all bars in line, where cos(phi) = 0."""
    source = four_bar_chain(n, 0.0, 1.0) | {
        "experiment": {"stop": 10, "step": 10 / points, "tolerance": tolerance}
    }
    found = gelenk.simulate(source, outputs=["tip.r[1]", "solver.singular_positions"])
    fine = np.linspace(0, 10, 100001)
    flat = fine[1:][np.diff(np.sign(np.cos(falling(n, 0.0, 1.0, fine)))) != 0]
    assert found["solver.singular_positions"][-1] == len(flat) > 5
    if points > 40:  # at most one between two of them
        assert_close(
            "times",
            np.array(found.singular_positions),
            flat,
            2.5 * 10 / points,
            "resolution of the next points",
        )


def test_parallelogram_stays_on_its_branch_through_twenty_crossings() -> None:
    """Full turns of one four-bar: the energy of 3 rad/s at the top carries it through 20 change points."""
    times = np.linspace(0, 20, 2001)
    found = run(four_bar_chain(1, 0.0, 1.0), times, tolerance=1e-8)
    assert found["solver.singular_positions"][-1] >= 20
    assert_close(
        "couple", found["A0.phi"] - found["A1.phi"], np.zeros(len(times)), 1e-7, "bars remain parallel"
    )


@warned.STILL
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "five_bar", "andrews"])
def test_regular_motion_reports_no_singular_configurations(name: str) -> None:
    assert gelenk.simulate(ROOT / "scenes" / f"{name}.yaml").singular_positions == ()
